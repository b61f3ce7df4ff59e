// SPDX-License-Identifier: Apache-2.0
#include "twin/lens/lens_name.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "twin/base/plain_text.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin {
namespace {

constexpr std::string_view kSplined = "LENSMODEL_SPLINED_STEREOGRAPHIC";
constexpr std::string_view kCahvore = "LENSMODEL_CAHVORE";
/// A knot on every second pixel of a camera of 2 megapixels; calibrations have some hundred knots.
constexpr double kMostKnots = 5e5;
constexpr int kMostOfSide = 65535;            // of 16 bits, in which libmrcal keeps it
constexpr std::size_t kShownCharacters = 80;  // the longest good name has 68

/// Takes "_key=" and the number behind it off the front of `rest`.
template <class Number>
std::optional<Number> number_behind(std::string_view& rest, std::string_view key) {
  if (!rest.starts_with(key)) return std::nullopt;
  rest.remove_prefix(key.size());
  const std::string_view number = rest.substr(0, rest.find('_'));
  rest.remove_prefix(number.size());
  return parse_number<Number>(number);
}

std::string splined_fault(std::string_view rest) {
  const auto order = number_behind<int>(rest, "_order="), nx = number_behind<int>(rest, "_Nx="),
             ny = number_behind<int>(rest, "_Ny="), fov_x_deg = number_behind<int>(rest, "_fov_x_deg=");
  if (!order || !nx || !ny || !fov_x_deg || !rest.empty())
    return "its name must end like _order=3_Nx=11_Ny=8_fov_x_deg=44, in whole numbers";
  if (*order != 2 && *order != 3) return fmt::format("its order must be 2 or 3, is {}", *order);
  if (std::min(*nx, *ny) <= *order || std::max(*nx, *ny) > kMostOfSide)
    return fmt::format("its Nx and Ny must be {} to {}, are {} and {}", *order + 1, kMostOfSide, *nx, *ny);
  if (static_cast<double>(*nx) * *ny > kMostKnots)
    return fmt::format("its Nx times Ny must be at most {:.0f}, they are {} and {}", kMostKnots, *nx, *ny);
  if (*fov_x_deg < 1 || *fov_x_deg > 359)  // its half is a stereographic radius, infinite at 360
    return fmt::format("its fov_x_deg must be 1 to 359, is {}", *fov_x_deg);
  return "";
}

/// -1 is orthographic, 0 a fisheye, 1 perspective.
std::string cahvore_fault(std::string_view rest) {
  const auto linearity = number_behind<double>(rest, "_linearity=");
  if (!linearity || !rest.empty()) return "its name must end like _linearity=0.34";
  return std::abs(*linearity) <= 1.0 ? "" : fmt::format("its linearity must be -1 to 1, is {}", *linearity);
}

}  // namespace

std::string lens_name_fault(std::string_view name) {
  // libmrcal would read it up to there.
  if (name.find('\0') != std::string_view::npos) return "its name has a byte of zero";
  for (const auto& [start, fault] :
       {std::pair{kSplined, &splined_fault}, std::pair{kCahvore, &cahvore_fault}})
    if (name.starts_with(start) && name.substr(start.size()).starts_with('_'))
      return fault(name.substr(start.size()));
  return "";
}

std::string shown_lens_name(std::string_view name) {
  return plain_text(name.substr(0, kShownCharacters)) + (name.size() > kShownCharacters ? "..." : "");
}

}  // namespace fringetwin
