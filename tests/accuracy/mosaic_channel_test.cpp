// SPDX-License-Identifier: Apache-2.0
// One colour of a colour sensor. Truth: the image of the whole sensor, pixel by pixel, and the reference.
//
// | check                        | tolerance          | origin |
// |------------------------------|--------------------|-------------------------------------------------------|
// | the whole sensor's pixels    | 2e-6 of the mean   | float32: places twice as coarse round another way |
// | reference                    | expect_agreement() | shapes_test.cpp | | with a point spread          |
// exact              | the same trace, convolved, of which pixels are taken  |
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::mosaic_channel_test {
namespace {

constexpr MosaicColour kColours[] = {MosaicColour::red, MosaicColour::green, MosaicColour::green2,
                                     MosaicColour::blue};

Twin sphere_on_sensor(int width, int height) {
  return with_object(left_window(physical_sphere().center_mm, width, height), "ball", physical_sphere());
}

/// The same rig with one colour of its sensor as the image.
Twin of_colour(Twin twin, MosaicColour colour) {
  Camera& camera = twin.cameras[0];
  camera.channel = MosaicChannel{"GRBG", colour, {camera.lens.width(), camera.lens.height()}};
  camera.lens = image_lens(camera.lens, *camera.channel, "test");
  return twin;
}

/// Returns the rms difference of all images' pixels over the mean of the truth.
double difference(const std::vector<ImageF>& sensor, const std::vector<ImageF>& images,
                  const MosaicChannel& c) {
  double squares = 0.0, sum = 0.0, n = 0.0;
  EXPECT_EQ(sensor.size(), images.size());
  for (std::size_t k = 0; k < images.size(); ++k) {
    const ImageF truth = channel_image(sensor[k], c);
    EXPECT_TRUE(truth.same_size(images[k]));
    for (std::size_t i = 0; i < truth.size(); ++i) {
      squares += std::pow(static_cast<double>(truth.data[i]) - images[k].data[i], 2);
      sum += static_cast<double>(truth.data[i]);
      n += 1.0;
    }
  }
  return std::sqrt(squares / n) / (sum / n);
}

TEST(MosaicChannel, IsTheWholeSensorsPixels) {
  REQUIRE_RENDERER();
  Twin sensor = sphere_on_sensor(61, 40);
  sensor.cameras[0].vignetting = {Vignetting::Kind::polynomial, {-0.2, 0.03, 0.0}, {0.1, -0.05}};
  const auto whole = shared_renderer()->render(sensor, 0, {Sampler::gauss, 9}).irradiance;
  for (const MosaicColour colour : kColours) {
    const Twin twin = of_colour(sensor, colour);
    const auto images = shared_renderer()->render(twin, 0, {Sampler::gauss, 9}).irradiance;
    const double rms = difference(whole, images, *twin.cameras[0].channel);
    std::cout << name_of(colour) << ": rms " << rms << " of the mean\n";
    EXPECT_LT(rms, 2e-6);
  }
}

// Adaptive, a curved surface and its outline.
TEST(MosaicChannel, AgreesWithTheReference) {
  REQUIRE_RENDERER();
  const Twin sensor = sphere_on_sensor(80, 60);
  expect_agreement(of_colour(sensor, MosaicColour::red), "red of a mosaic", 100);
  expect_agreement(of_colour(sensor, MosaicColour::green2), "second green of a mosaic", 100);
}

TEST(MosaicChannel, PointSpreadGoesOverPixelsOfOtherColours) {
  REQUIRE_RENDERER();
  Twin sensor = sphere_on_sensor(60, 40);
  sensor.cameras[0].psf_px = 0.8;
  sensor.cameras[0].vignetting = {Vignetting::Kind::polynomial, {-0.2, 0.03, 0.0}, {0.1, -0.05}};
  sensor.cameras[0].exposure_factors.assign(expand_sequence(sensor.fringes).size(), 1.1);
  const auto whole = shared_renderer()->render(sensor, 0, {Sampler::gauss, 9});
  Twin twin = of_colour(sensor, MosaicColour::blue);
  const auto image = shared_renderer()->render(twin, 0, {Sampler::gauss, 9});
  EXPECT_EQ(difference(whole.irradiance, image.irradiance, *twin.cameras[0].channel), 0.0);
  EXPECT_EQ(image.object.data, channel_image(whole.object, *twin.cameras[0].channel).data);

  // a texture is of the image's pixels and comes after: factor * light + exposure * offset
  PixelTexture texture{ImageF(30, 20, 0.5F), ImageF(30, 20, 2.0F)};
  twin.cameras[0].texture = std::make_shared<const PixelTexture>(texture);
  const auto textured = shared_renderer()->render(twin, 0, {Sampler::gauss, 9});
  for (std::size_t i = 0; i < textured.irradiance[0].size(); ++i)
    EXPECT_FLOAT_EQ(textured.irradiance[0].data[i], 0.5F * image.irradiance[0].data[i] + 2.2F);
}

}  // namespace
}  // namespace fringetwin::testing::mosaic_channel_test
