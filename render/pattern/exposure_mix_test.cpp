// SPDX-License-Identifier: Apache-2.0
// What exposures see, mixed by hand from plain images; and that images of a transport stay the same bits
// where no exposure reaches into another pattern.
//
// | check             | tolerance | origin                                                                |
// |-------------------|-----------|-----------------------------------------------------------------------|
// | mixed light       | 1e-5      | sums of three numbers below 100 in single precision, 6e-8 each         |
// | place in time     | 1e-6      | the same of numbers of the size of 1                                   |
// | blur in time      | 1e-12     | closed forms in double precision                                       |
// | off               | 0         | bitwise the same                                                       |
#include "render/pattern/exposure_mix.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/pattern/camera_effects.hpp"
#include "render/pattern/form_images.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::render::exposure_mix_test {
namespace {

constexpr int kWidth = 6, kHeight = 10, kSteps = 4;

Camera camera_with(const ExposureTiming& timing) {
  Camera camera{"left", Lens("LENSMODEL_PINHOLE", {100.0, 100.0, 2.5, 4.5}, {kWidth, kHeight}, "test"),
                Pose{}, Sensor{}, std::nullopt};
  camera.timing = timing;
  return camera;
}

double light_of(double image, int x, int y) { return 10.0 + 7.0 * std::sin(2.0 * image + x) + 0.5 * y; }
ImageF image_of(double image) {
  ImageF out(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) out(x, y) = static_cast<float>(light_of(image, x, y));
  return out;
}
std::vector<ImageF> sequence() {
  std::vector<ImageF> images;
  for (int k = 0; k < kSteps; ++k) images.push_back(image_of(k));
  return images;
}

// Late by 0.1 with a read-out of 0.3: the first row begins 0.035 early, the last one 0.235 late.
TEST(ExposureMix, RowsOfARollingShutter) {
  const Camera camera = camera_with({.exposure = 1.0, .read_out = 0.3, .late = {0.1, 0.1, 0.1, 0.1}});
  const std::vector<ImageF> images = sequence();
  const ImageRange all{0, kSteps};
  EXPECT_TRUE(mixes_patterns(camera, all));
  for (std::size_t k = 0; k < kSteps; ++k) {
    const ImageF seen = exposed(camera, k, seen_patterns(images, all, k));
    const double before = k > 0 ? static_cast<double>(k) - 1.0 : 0.0,  // the first is its own one before
        after = k + 1 < kSteps ? static_cast<double>(k) + 1.0 : static_cast<double>(k);
    for (int y = 0; y < kHeight; ++y) {
      const double begin = 0.1 + 0.3 * ((y + 0.5) / kHeight - 0.5);
      for (int x = 0; x < kWidth; ++x) {
        const double own = light_of(static_cast<double>(k), x, y),
                     other = light_of(begin < 0.0 ? before : after, x, y);
        ASSERT_NEAR(static_cast<double>(seen(x, y)), own + std::abs(begin) * (other - own), 1e-5)
            << k << ' ' << y;
      }
    }
  }
}

TEST(ExposureMix, AShortExposureSeesMoreOfWhatItReachesInto) {
  Camera camera = camera_with({.exposure = 0.25, .read_out = 0.0, .late = {0.0, 0.8, 0.75, -0.1}});
  camera.exposure_factors = {1.0, 2.0, 1.0, 0.5};
  const std::vector<ImageF> images = sequence();
  const ImageRange all{0, kSteps};
  const auto seen = [&](std::size_t k) {
    return static_cast<double>(exposed(camera, k, seen_patterns(images, all, k))(3, 5));
  };
  EXPECT_NEAR(seen(0), light_of(0, 3, 5), 1e-5);
  EXPECT_NEAR(seen(1), 2.0 * (0.8 * light_of(1, 3, 5) + 0.2 * light_of(2, 3, 5)), 1e-5);
  EXPECT_NEAR(seen(2), light_of(2, 3, 5), 1e-5);  // ends with its pattern
  EXPECT_NEAR(seen(3), 0.5 * (0.4 * light_of(2, 3, 5) + 0.6 * light_of(3, 3, 5)), 1e-5);
  EXPECT_FALSE(mixes_patterns(camera, {0, 1}));
  EXPECT_TRUE(mixes_patterns(camera, {0, 2}));
}

TEST(ExposureMix, NeighboursOfARange) {
  const auto range = [](std::size_t first, std::size_t count) {
    const ImageRange r = with_neighbours({first, count}, 12);
    return std::pair{r.first, r.count};
  };
  EXPECT_EQ(range(0, 12), std::pair(std::size_t{0}, std::size_t{12}));
  EXPECT_EQ(range(0, 1), std::pair(std::size_t{0}, std::size_t{2}));
  EXPECT_EQ(range(5, 1), std::pair(std::size_t{4}, std::size_t{3}));
  EXPECT_EQ(range(11, 1), std::pair(std::size_t{10}, std::size_t{2}));
}

// Light that is straight over time, seen by all three patterns at once: every row's mean is that of the
// middle of its exposure. What bends over time is blurred: the mean square of the two times is that of a
// row's exposure, and of the rows together.
TEST(ExposureMix, MovingThingsAreWhereTheyAreMeanwhile) {
  const ExposureTiming timing{.exposure = 0.75, .read_out = 0.5, .late = {0.0, 0.2}};
  const Camera camera = camera_with(timing);
  const ExposureTimes times = exposure_times(timing, 1);
  EXPECT_NEAR(times.middle, 0.2 - 0.125, 1e-12);
  EXPECT_NEAR(times.apart * times.apart, (0.75 * 0.75 + 0.5 * 0.5) / 12.0, 1e-12);
  const ImageF earlier(kWidth, kHeight, static_cast<float>(5.0 + times.middle - times.apart)),
      later(kWidth, kHeight, static_cast<float>(5.0 + times.middle + times.apart));
  const ImageF seen = exposed_moving(camera, 1, {&earlier, &earlier, &earlier}, {&later, &later, &later});
  for (int y = 0; y < kHeight; ++y)
    ASSERT_NEAR(static_cast<double>(seen(2, y)), 5.0 + times.middle + 0.5 * ((y + 0.5) / kHeight - 0.5), 1e-6)
        << y;
}

// A pattern that is seen at the end of an exposure is seen with things where they are then.
TEST(ExposureMix, EachPatternIsSeenWhenItIsShown) {
  const ExposureTiming timing{.exposure = 1.0, .read_out = 0.0, .late = {0.25}};
  const Camera camera = camera_with(timing);
  const ExposureTimes times = exposure_times(timing, 0);
  const auto at = [](double time) { return ImageF(kWidth, kHeight, static_cast<float>(20.0 + 3.0 * time)); };
  const ImageF dark(kWidth, kHeight, 0.0F), earlier = at(times.middle - times.apart),
                                            later = at(times.middle + times.apart);
  // the next pattern alone is bright: from 1 to 1.25, whose middle is 0.625 after that of the image's pattern
  const ImageF seen = exposed_moving(camera, 0, {&dark, &dark, &earlier}, {&dark, &dark, &later});
  EXPECT_NEAR(static_cast<double>(seen(0, 0)), 0.25 * (20.0 + 3.0 * 0.625), 1e-5);
}

TEST(ExposureMix, RowsOfALongReadOutAreNotExtrapolated) {
  const ExposureTiming timing{.exposure = 0.1, .read_out = 0.9, .late = {0.45}};
  EXPECT_EQ(exposure_times(timing, 0).apart, 0.45);
}

/// Light and fringes of some pixels, as a trace leaves them.
Transport made_up_transport() {
  Transport transport;
  const auto filled = [](double factor) {
    ImageF image(kWidth, kHeight);
    for (std::size_t i = 0; i < image.size(); ++i)
      image.data[i] = static_cast<float>(factor * (1.0 + 0.3 * std::sin(static_cast<double>(i))));
    return image;
  };
  transport.mean = filled(8.0);
  transport.ambient = filled(0.5);
  transport.cosine = {{filled(3.0), filled(-2.0), filled(1.0)}};
  transport.sine = {{filled(-1.0), filled(2.5), filled(3.5)}};
  transport.harmonics = {{{}, {}, {}}};
  transport.series.assign(1, std::vector<PhaseSeries>(3, PhaseSeries{{0.5, 0.5}}));
  return transport;
}

Twin small_twin() {
  Twin twin = testing::only_camera(testing::paper_rig(), 0);
  twin.cameras[0].lens = camera_with({}).lens;
  return twin;
}

void expect_same_bits(const RenderedCamera& a, const RenderedCamera& b) {
  ASSERT_EQ(a.irradiance.size(), b.irradiance.size());
  for (std::size_t k = 0; k < a.irradiance.size(); ++k)
    EXPECT_EQ(a.irradiance[k].data, b.irradiance[k].data) << k;
}

TEST(ExposureMix, ExposuresWithinTheirPatternsAreTheSameBits) {
  Twin twin = small_twin();
  twin.cameras[0].psf_px = 0.6;
  twin.projector->light_factors.assign(12, 1.25);
  const Transport transport = made_up_transport();
  const RenderedCamera before = form_camera(twin, 0, transport, true);
  twin.cameras[0].timing = ExposureTiming{};
  expect_same_bits(before, form_camera(twin, 0, transport, true));
  twin.cameras[0].timing = ExposureTiming{.exposure = 0.5, .read_out = 0.25, .late = {0.25}};
  expect_same_bits(before, form_camera(twin, 0, transport, true));
  twin.cameras[0].timing->late = {0.45};
  const RenderedCamera mixed = form_camera(twin, 0, transport, true);
  EXPECT_NE(before.irradiance[3].data, mixed.irradiance[3].data);
  EXPECT_EQ(before.white->data, mixed.white->data);  // references stand still
  EXPECT_EQ(before.black->data, mixed.black->data);
}

// The lamp's factor is that of the pattern, the exposure's factor that of the image; the lens comes before
// the rows are exposed, and one image alone is the same as among all.
TEST(ExposureMix, FactorsAndPointSpreadInTheirOrder) {
  Twin twin = small_twin();
  Camera& camera = twin.cameras[0];
  for (int k = 0; k < 12; ++k) {
    twin.projector->light_factors.push_back(1.0 + 0.1 * std::sin(k));
    twin.projector->ambient_factors.push_back(1.0 + 0.2 * std::cos(k));
    camera.exposure_factors.push_back(1.0 - 0.03 * k);
  }
  camera.psf_px = 0.8;
  camera.vignetting = {Vignetting::Kind::polynomial, {-0.2, 0.0, 0.0}, {0.05, 0.1}};
  const Transport transport = made_up_transport();
  Twin plain = twin;
  plain.cameras[0].exposure_factors.clear();
  const RenderedCamera patterns = form_camera(plain, 0, transport);
  camera.timing = ExposureTiming{.exposure = 1.0, .read_out = 0.4, .late = {0.1}};
  const RenderedCamera mixed = form_camera(twin, 0, transport);
  for (std::size_t k = 1; k < 11; ++k) {
    EXPECT_EQ(form_camera(twin, 0, transport, false, k).irradiance.at(0).data, mixed.irradiance[k].data);
    for (int y = 0; y < kHeight; ++y) {
      const double begin = 0.1 + 0.4 * ((y + 0.5) / kHeight - 0.5);
      const auto of = [&](std::size_t image) {
        return static_cast<double>(patterns.irradiance[image](2, y));
      };
      const double share = std::abs(begin), other = of(begin < 0.0 ? k - 1 : k + 1);
      ASSERT_NEAR(static_cast<double>(mixed.irradiance[k](2, y)),
                  camera.exposure_factors[k] * ((1.0 - share) * of(k) + share * other), 1e-5)
          << k << ' ' << y;
    }
  }
}

}  // namespace
}  // namespace fringetwin::render::exposure_mix_test
