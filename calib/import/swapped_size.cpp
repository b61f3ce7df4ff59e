// SPDX-License-Identifier: Apache-2.0
#include "calib/import/swapped_size.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace fringetwin::calib {
namespace {

constexpr double kOff = 0.1, kMuchNearer = 3.0;

/// Returns how far the principal point is from the middle of the image, in sides of it: the larger of both.
double off_middle(double cx_px, double cy_px, int width, int height) {
  return std::max(std::abs(cx_px - 0.5 * (width - 1)) / width, std::abs(cy_px - 0.5 * (height - 1)) / height);
}

}  // namespace

std::string swapped_size_doubt(const ImportedDevice& device) {
  if (device.intrinsics.size() < 4) return "";
  const double cx_px = device.intrinsics[2], cy_px = device.intrinsics[3];
  const auto [width, height] = device.imagersize_px;
  if (width < 1 || height < 1) return "";
  const double off = off_middle(cx_px, cy_px, width, height);
  if (!(off > kOff && kMuchNearer * off_middle(cx_px, cy_px, height, width) < off)) return "";
  return fmt::format(
      "{}: the principal point ({:.5g}, {:.5g}) px lies in the middle of {}x{}, not of {}x{}: are width and "
      "height swapped?",
      device.name, cx_px, cy_px, height, width, width, height);
}

}  // namespace fringetwin::calib
