// SPDX-License-Identifier: Apache-2.0
// What pixels have of their own: a line of the light that each would have without, and what a texture that
// changes within a pixel does to its fringes. Truth: the reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::pixel_texture_test {
namespace {

// Each pixel of the image is a line of what it would be without, to rounding, and that of the reference to
// three times the 4e-5 rad that phases agree to, of an amplitude of 4.
TEST(PixelTexture, IsALineOfEachPixel) {
  REQUIRE_RENDERER();
  Twin plain = with_object(left_window(ideal_sphere().center_mm, 24, 16), "ball", ideal_sphere());
  std::vector<double>& exposures = plain.cameras[0].exposure_factors;  // of the offsets, too
  for (std::size_t k = 0; k < expand_sequence(plain.fringes).size(); ++k)
    exposures.push_back(k % 2 == 0 ? 0.8 : 1.3);
  Twin twin = plain;
  PixelTexture texture{ImageF(24, 16), ImageF(24, 16)};
  for (std::size_t i = 0; i < texture.factor.size(); ++i) {
    texture.factor.data[i] = 0.5F + 0.003F * static_cast<float>(i);
    texture.offset.data[i] = 0.02F * static_cast<float>(i % 7) - 0.05F;
  }
  twin.cameras[0].texture = std::make_shared<const PixelTexture>(texture);
  const auto images = shared_renderer()->render(twin, 0, {Sampler::gauss, 9}, 0).irradiance,
             without = shared_renderer()->render(plain, 0, {Sampler::gauss, 9}, 0).irradiance;
  const render::Reference reference(twin);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 24; ++x) {
      const auto pixel = reference.pixel(0, x, y, {.gauss_n = 3});
      const std::size_t i = without[0].index(x, y);
      for (std::size_t k = 0; k < images.size(); ++k) {
        const double expected = static_cast<double>(texture.factor.data[i] * without[k].data[i]) +
                                exposures[k] * static_cast<double>(texture.offset.data[i]);
        EXPECT_NEAR(static_cast<double>(images[k].data[i]), expected, 1e-6 * (1.0 + expected));
        EXPECT_NEAR(static_cast<double>(images[k].data[i]), pixel.irradiance[k], 5e-4) << x << ' ' << y;
      }
    }
}

// A pixel of spread s takes s^2 (grad f . grad E) from its brighter side; the reference takes the slopes of
// its own pixels. Tolerance: that of the line of each pixel, above.
TEST(PixelTexture, MovesTheFringesWithinAPixel) {
  REQUIRE_RENDERER();
  Twin twin = with_object(left_window(ideal_sphere().center_mm, 24, 16), "ball", ideal_sphere());
  PixelTexture texture{ImageF(24, 16), ImageF()};
  for (std::size_t i = 0; i < texture.factor.size(); ++i)
    texture.factor.data[i] =
        0.6F + 0.2F * std::sin(0.9F * static_cast<float>(i % 24) + 0.05F * static_cast<float>(i));
  texture.factor(7, 7) = 0.0F;  // a pixel that tells nothing: its neighbours are flat along that axis
  twin.cameras[0].texture = std::make_shared<const PixelTexture>(texture);
  const auto plain = shared_renderer()->render(twin, 0, {Sampler::gauss, 9}, 0).irradiance;
  twin.cameras[0].texture_spread_px = 0.9;
  const auto images = shared_renderer()->render(twin, 0, {Sampler::gauss, 9}, 0).irradiance;
  const render::Reference reference(twin);
  double largest = 0.0;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 24; ++x) {
      const auto pixel = reference.pixel(0, x, y, {.gauss_n = 3});
      for (std::size_t k = 0; k < images.size(); ++k) {
        EXPECT_NEAR(static_cast<double>(images[k](x, y)), pixel.irradiance[k], 5e-4) << x << ' ' << y;
        largest = std::max(largest, std::abs(static_cast<double>(images[k](x, y) - plain[k](x, y))));
      }
    }
  EXPECT_GT(largest, 0.05);  // a hundred times the tolerance
}

}  // namespace
}  // namespace fringetwin::testing::pixel_texture_test
