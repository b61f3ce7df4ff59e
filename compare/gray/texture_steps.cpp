// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/texture_steps.hpp"

#include <algorithm>
#include <cmath>

namespace fringetwin::compare {
namespace {

constexpr double kClearStepSigmas = 3.0;  ///< of a difference between neighbours that is no noise
constexpr double kMatters = 0.1;          ///< of a gray value's noise

}  // namespace

TextureSteps::Weight TextureSteps::weight_of(std::size_t pixel) const {
  double real_dn = 0.0, predicted_dn = 0.0, variance_dn2 = 0.0;
  for (const int image : pair_.gain_images) {
    const double y = pair_.real_at(image, pixel);
    real_dn += y - usable_.black_level_dn;
    predicted_dn += usable_.gain_dn * pair_.irradiance_at(image, pixel);
    variance_dn2 += noise_.variance(y);
  }
  return {std::log(real_dn / predicted_dn), variance_dn2 / (real_dn * real_dn)};
}

bool TextureSteps::is_steep(std::size_t pixel) const {
  const auto width = static_cast<std::size_t>(pair_.width()), x = pixel % width, y = pixel / width;
  if (x == 0 || x + 1 == width || y == 0 || y + 1 == static_cast<std::size_t>(pair_.height())) return false;
  const Weight here = weight_of(pixel);
  double step[2] = {0.0, 0.0};  // the larger difference to the two neighbours along each axis
  for (const std::size_t axis : {0u, 1u})
    for (const std::size_t other : {pixel - (axis == 0 ? 1 : width), pixel + (axis == 0 ? 1 : width)}) {
      const Weight there = weight_of(other);
      const double difference = std::abs(there.log - here.log);
      if (difference * difference > kClearStepSigmas * kClearStepSigmas * (there.variance + here.variance))
        step[axis] = std::max(step[axis], difference);
    }
  if (step[0] == 0.0 && step[1] == 0.0) return false;
  const double factor = std::exp(here.log);
  return std::ranges::any_of(pair_.gain_images, [&](int image) {
    const auto slope = [&](std::size_t distance) {
      return 0.5 * std::abs(pair_.irradiance_at(image, pixel + distance) -
                            pair_.irradiance_at(image, pixel - distance));
    };
    const double wrong_dn = factor * usable_.gain_dn * (slope(1) * step[0] + slope(width) * step[1]) / 12.0;
    return wrong_dn > kMatters * std::sqrt(noise_.variance(pair_.real_at(image, pixel)));
  });
}

}  // namespace fringetwin::compare
