// SPDX-License-Identifier: Apache-2.0
// Arbitrary pattern images: the projector's pixels, averaged over the camera's, against the reference.
// | tolerance | unit           | origin                                                                |
// |-----------|----------------|-----------------------------------------------------------------------|
// | 3e-3      | full scale rms | pixels with sharp borders: the truth's 40x40 Gauss points, 1/40 of a    |
// |           |                | border's step in one pixel of five, and the separable footprint        |
// | 2e-4      | full scale rms | borders blurred by 0.8 px: the footprint's sides as Gaussians           |
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::images_test {
namespace {

/// Random levels on tiles of 3 x 2 projector pixels.
std::shared_ptr<const ImageF> speckle(int seed) {
  ImageF image(1280, 720);
  std::mt19937 random(static_cast<unsigned>(seed));
  std::uniform_int_distribution<int> level(0, 255);
  std::vector<float> tiles(427 * 360);
  for (float& t : tiles) t = static_cast<float>(level(random)) / 255.0F;
  for (int y = 0; y < 720; ++y)
    for (int x = 0; x < 1280; ++x) image(x, y) = tiles[static_cast<std::size_t>(y / 2 * 427 + x / 3)];
  return std::make_shared<const ImageF>(std::move(image));
}

Twin speckle_twin() {
  Twin twin = with_object(left_window({0, 0, 300}, 160, 120), "plane", tilted_plane());
  twin.fringes.images = {{{}, speckle(1)}, {{}, speckle(2)}};
  return twin;
}

/// Rms error of the two images (full scale) over whole pixels; `contrast`: rms of the images themselves.
double image_error(const Twin& twin, int gauss_n, double* contrast) {
  const auto rendered = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  EXPECT_EQ(rendered.irradiance.size(), 14u);
  const render::Reference reference(twin);
  double sum = 0.0, n = 0.0, mean = 0.0, square = 0.0;
  for (const auto& p : reference_block(reference, 0, whole_image(twin, 0, 7), {.gauss_n = gauss_n}, true))
    for (std::size_t i : {12, 13}) {
      const double truth = p.pixel.irradiance[i] / 12.75,
                   e = rendered.irradiance[i](p.x, p.y) / 12.75 - truth;
      sum += e * e;
      mean += truth;
      square += truth * truth;
      n += 1.0;
    }
  EXPECT_GT(n, 400.0);
  *contrast = std::sqrt(square / n - mean * mean / n / n);
  return std::sqrt(sum / n);
}

TEST(PatternImages, SharpPixels) {
  REQUIRE_RENDERER();
  double contrast = 0.0;
  const double error = image_error(speckle_twin(), 40, &contrast);
  std::cout << "speckle: rms " << error << " of " << contrast << "\n";
  EXPECT_GT(contrast, 0.1);
  EXPECT_LE(error, 3e-3);
}

TEST(PatternImages, BlurredPixelsThroughAGamma) {
  REQUIRE_RENDERER();
  Twin twin = speckle_twin();
  twin.projector->blur_px = 0.8;
  twin.projector->response.kind = ProjectorResponse::Kind::gamma;
  twin.projector->response.gamma = 2.2;
  double contrast = 0.0;
  const double error = image_error(twin, 6, &contrast);
  std::cout << "blurred speckle: rms " << error << " of " << contrast << "\n";
  EXPECT_GT(contrast, 0.05);
  EXPECT_LE(error, 2e-4);
}

// An image of a fringe is the fringe, but for the projector's pixels: one level each. Their mean over the
// pixel of the pattern is sinc(1/pitch) of its contrast.
TEST(PatternImages, AnImageOfAFringe) {
  REQUIRE_RENDERER();
  Twin twin = speckle_twin();
  ImageF fringe(1280, 720);
  for (int y = 0; y < 720; ++y)
    for (int x = 0; x < 1280; ++x)
      fringe(x, y) = static_cast<float>(pattern_value(twin.fringes, expand_sequence(twin.fringes)[8], x));
  twin.fringes.images = {{{}, std::make_shared<const ImageF>(std::move(fringe))}};
  const auto r = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  double worst = 0.0, sum = 0.0;
  for (std::size_t k = 0; k < r.irradiance[8].size(); ++k) {
    const double d = r.irradiance[12].data[k] - r.irradiance[8].data[k];
    worst = std::max(worst, std::abs(d));
    sum += d;
  }
  std::cout << "image of a fringe: worst " << worst << " mean "
            << sum / static_cast<double>(r.irradiance[8].size()) << "\n";
  EXPECT_LE(worst, 10.0 * 0.5 * 3.1416 / 15);  // half a pixel of the steepest slope
  EXPECT_LE(std::abs(sum / static_cast<double>(r.irradiance[8].size())), 0.02);
}

// More images than one pass holds.
TEST(PatternImages, Twenty) {
  REQUIRE_RENDERER();
  Twin twin = speckle_twin();
  const auto two = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  while (twin.fringes.images.size() < 20) twin.fringes.images.push_back(twin.fringes.images[0]);
  const auto many = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  ASSERT_EQ(many.irradiance.size(), 32u);
  for (std::size_t k = 0; k < two.irradiance[12].size(); ++k) {
    EXPECT_NEAR(many.irradiance[13].data[k], two.irradiance[13].data[k], 1e-5);
    EXPECT_NEAR(many.irradiance[31].data[k], two.irradiance[12].data[k], 1e-5);
  }
}

}  // namespace
}  // namespace fringetwin::testing::images_test
