// SPDX-License-Identifier: Apache-2.0
// Expects of GoogleTest what the effects of the renderer have in common: agreement with the reference, no bit
// changed by what is off, twice the image from twice the light; and tells how far two renderings differ.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>

#include "tests/support/agreement.hpp"

namespace fringetwin::testing {

/// Where these limits come from is told in shapes_test.cpp.
inline constexpr double kPhaseLimit_rad = 4e-5;
inline constexpr double kGrayLimit = 5e-5;  ///< of full scale

/// Compares every `stride`th pixel of the first camera, `at_least` of them interior ones, with the reference.
inline Agreement expect_agreement(const Twin& twin, const std::string& what, int at_least, int stride = 3,
                                  double phase_limit_rad = kPhaseLimit_rad) {
  const Agreement a = agreement(twin, 0, render::choose_sampling(twin), whole_image(twin, 0, stride));
  std::cout << what << ": " << a.text() << "\n";
  EXPECT_GE(a.n, at_least) << what;
  EXPECT_LE(a.worst_phase_rms_rad(), phase_limit_rad) << what;
  EXPECT_LE(a.gray_rms, kGrayLimit) << what;
  return a;
}

/// Renders the first camera by a fixed rule: what the adaptive trace leaves to an estimate may differ between
/// two scenes.
inline render::RenderedCamera render_fixed(const Twin& twin) {
  return shared_renderer()->render(twin, 0, render::without_adaptation(render::choose_sampling(twin)));
}

inline void expect_same_bits(const render::RenderedCamera& a, const render::RenderedCamera& b) {
  ASSERT_EQ(a.irradiance.size(), b.irradiance.size());
  for (std::size_t i = 0; i < a.irradiance.size(); ++i)
    EXPECT_EQ(a.irradiance[i].data, b.irradiance[i].data) << "image " << i;
}
inline void expect_same_bits(const Twin& a, const Twin& b) {
  expect_same_bits(render_fixed(a), render_fixed(b));
}

/// Expects the image to be linear in the projected intensity: twice the light, twice the image, to the bit.
inline void expect_linear_in_the_light(const Twin& twin) {
  Twin brighter = twin;
  brighter.projector->intensity *= 2.0;
  const auto one = render_fixed(twin), two = render_fixed(brighter);
  for (std::size_t i = 0; i < one.irradiance.size(); ++i)
    for (std::size_t p = 0; p < one.irradiance[i].size(); ++p)
      ASSERT_EQ(2.0F * one.irradiance[i].data[p], two.irradiance[i].data[p]);
}

/// Returns the rms of the relative change of the irradiance from `a` to `b`, over the pixels bright in `a`.
inline double relative_change(const render::RenderedCamera& a, const render::RenderedCamera& b) {
  double sum = 0.0, n = 0.0;
  for (std::size_t i = 0; i < a.irradiance.size(); ++i)
    for (std::size_t p = 0; p < a.irradiance[i].size(); ++p)
      if (a.irradiance[i].data[p] > 1.0F) {
        sum += std::pow(b.irradiance[i].data[p] / a.irradiance[i].data[p] - 1.0, 2);
        n += 1.0;
      }
  return std::sqrt(sum / n);
}

/// Returns the largest difference of irradiance at any pixel of any image.
inline double largest_difference(const render::RenderedCamera& a, const render::RenderedCamera& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.irradiance.size(); ++i)
    for (std::size_t p = 0; p < a.irradiance[i].size(); ++p)
      largest =
          std::max(largest, std::abs(static_cast<double>(a.irradiance[i].data[p]) - b.irradiance[i].data[p]));
  return largest;
}

}  // namespace fringetwin::testing
