// SPDX-License-Identifier: Apache-2.0
#include "capture/record/exposure_merge.hpp"

#include <algorithm>
#include <cstdint>

#include "twin/base/errors.hpp"

namespace fringetwin::capture {
namespace {

constexpr std::uint8_t kSaturated = 255;

/// Index of the exposure (longest first) that each pixel is taken from.
std::vector<std::uint8_t> choose(const std::vector<BracketExposure>& longest_first, std::size_t n_images,
                                 double max_dn) {
  std::vector<std::uint8_t> choice;
  for (std::size_t e = 0; e < longest_first.size(); ++e) {
    std::vector<std::uint8_t> clipped;
    for (std::size_t k = 0; k < n_images; ++k) {
      const ImageF image = longest_first[e].load(k);
      clipped.resize(image.size(), 0);
      for (std::size_t i = 0; i < image.size(); ++i)
        clipped[i] |= static_cast<std::uint8_t>(static_cast<double>(image.data[i]) >= max_dn);
    }
    choice.resize(clipped.size(), kSaturated);
    for (std::size_t i = 0; i < clipped.size(); ++i)
      if (choice[i] == kSaturated && clipped[i] == 0) choice[i] = static_cast<std::uint8_t>(e);
  }
  return choice;
}

}  // namespace

void merge_exposures(std::vector<BracketExposure> exposures, std::size_t n_images, double black_level_dn,
                     double max_dn, const std::function<void(std::size_t, const ImageF&)>& store) {
  FT_CHECK(!exposures.empty() && exposures.size() < kSaturated, "one to 254 exposures");
  std::ranges::sort(exposures, [](const auto& a, const auto& b) { return a.exposure_ms > b.exposure_ms; });
  const double shortest_ms = exposures.back().exposure_ms;
  const std::vector<std::uint8_t> choice = choose(exposures, n_images, max_dn);
  for (std::size_t k = 0; k < n_images; ++k) {
    ImageF merged;
    for (std::size_t e = 0; e < exposures.size(); ++e) {
      const ImageF image = exposures[e].load(k);
      if (merged.empty()) merged = ImageF(image.width, image.height, static_cast<float>(max_dn));
      const double scale = shortest_ms / exposures[e].exposure_ms;
      for (std::size_t i = 0; i < image.size(); ++i) {
        if (choice[i] != e) continue;
        const double dn = black_level_dn + (static_cast<double>(image.data[i]) - black_level_dn) * scale;
        merged.data[i] = static_cast<float>(std::clamp(dn, 0.0, max_dn));
      }
    }
    store(k, merged);
  }
}

}  // namespace fringetwin::capture
