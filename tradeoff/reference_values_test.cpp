// SPDX-License-Identifier: Apache-2.0
// No tolerances: the same pixels, taken from whole images and from windows of them, and the same samples.
#include "tradeoff/reference_values.hpp"

#include <gtest/gtest.h>

#include "render/reference/reference.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::tradeoff::reference_values_test {
namespace {

/// Returns what pixel (x, y) of an image receives: a different whole number for each, exact in single
/// precision.
float light(std::size_t camera, int image, int x, int y) {
  return static_cast<float>(1 + x + 100 * y + 10'000 * image + 100'000 * static_cast<int>(camera));
}

/// Renders two images of a window of a camera.
render::RenderedCamera rendered(std::size_t camera, const SubsetWindow& window) {
  render::RenderedCamera out;
  for (int image = 0; image < 2; ++image) {
    ImageF irradiance(window.width, window.height);
    for (int y = 0; y < window.height; ++y)
      for (int x = 0; x < window.width; ++x)
        irradiance(x, y) = light(camera, image, window.x0 + x, window.y0 + y);
    out.irradiance.push_back(std::move(irradiance));
  }
  return out;
}

/// Two cameras of unlike sensors, seen in windows of unlike places and sizes: at the image's first pixel,
/// beside each other, and with pixels left out.
struct Scene {
  Scene() {
    twin.cameras[0].sensor.gain_dn = 2.0, twin.cameras[0].sensor.black_level_dn = 0.5;
    twin.cameras[1].sensor.gain_dn = 4.0, twin.cameras[1].sensor.black_level_dn = 0.25;
    subset.cameras.resize(2);
    subset.cameras[0].windows = {{16, 40, 3, 5}, {0, 0, 4, 2}};
    subset.cameras[1].windows = {{8, 24, 2, 2}, {10, 24, 5, 3}, {32, 8, 2, 4}};
    for (std::size_t c = 0; c < 2; ++c) {
      whole.push_back(rendered(c, {0, 0, 48, 48}));
      for (const SubsetWindow& w : subset.cameras[c].windows) {
        windows.push_back(rendered(c, w));
        for (int y = w.y0; y < w.y0 + w.height; ++y)
          for (int x = w.x0; x < w.x0 + w.width; ++x)
            if ((x + y) % 3 != 1) subset.cameras[c].pixels.push_back({x, y, x % 2 == 0, 1.0});
      }
    }
  }
  Twin twin = testing::paper_rig();
  PixelSubset subset;
  std::vector<render::RenderedCamera> whole, windows;
};

// Gain E + black level at the pixel's own place of the whole image, whichever of both was rendered.
TEST(ReferenceValues, WindowsGiveThePixelsOfTheWholeImages) {
  const Scene scene;
  const auto from_whole = dn_from_images(scene.twin, scene.subset, scene.whole);
  const auto from_windows = dn_from_windows(scene.twin, scene.subset, scene.windows);
  ASSERT_EQ(from_whole.size(), 2u);
  ASSERT_EQ(from_windows.size(), 2u);
  for (std::size_t c = 0; c < 2; ++c) {
    const Sensor& sensor = scene.twin.cameras[c].sensor;
    PixelValues truth;
    for (const SubsetPixel& p : scene.subset.cameras[c].pixels) {
      truth.emplace_back();
      for (int image = 0; image < 2; ++image)
        truth.back().push_back(sensor.gain_dn * static_cast<double>(light(c, image, p.x, p.y)) +
                               sensor.black_level_dn);
    }
    EXPECT_EQ(from_whole[c], truth) << "camera " << c;
    EXPECT_EQ(from_windows[c], truth) << "camera " << c;
  }
}

/// Returns what the reference renderer gives for these samples a side, DN.
std::vector<double> sampled(const render::Reference& reference, const SubsetPixel& p, int gauss_n) {
  const Sensor& sensor = reference.twin().cameras[0].sensor;
  std::vector<double> dn;
  for (const double e : reference.pixel(0, p.x, p.y, {.gauss_n = gauss_n}).irradiance)
    dn.push_back(sensor.gain_dn * e + sensor.black_level_dn);
  return dn;
}

// Interior pixels, silhouettes and what is neither have a rule of their own; with a lens silhouettes have
// that of the rest. The left half of the window sees a sphere, the right half nothing.
TEST(ReferenceValues, EveryClassOfPixelsHasItsOwnSamples) {
  const ReferenceOptions options{.gauss_interior = 2, .gauss_facet = 3, .gauss_edge = 5};
  for (const bool with_lens : {false, true}) {
    Twin twin = testing::with_object(testing::left_window({5.0, 0.0, 250.0}, 40, 12), "ball",
                                     testing::ideal_sphere());
    if (with_lens) twin.cameras[0].optics = Optics{8.0, 10.0, 250.0};
    const render::Reference reference(twin);
    int edge_x = 2;
    while (edge_x < 37 && reference.is_whole(0, edge_x + 1, 6)) ++edge_x;
    ASSERT_GT(edge_x, 4);
    ASSERT_LT(edge_x, 37);
    PixelSubset subset;
    subset.cameras.resize(1);
    subset.cameras[0].pixels = {{3, 6, false, 1.0}, {edge_x + 1, 6, true, 1.0}, {edge_x + 1, 6, false, 1.0}};
    const ReferenceValues values = reference_values(twin, subset, options);
    const auto& p = subset.cameras[0].pixels;
    ASSERT_EQ(values.interior.at(0), (std::vector<bool>{true, false, false}));
    EXPECT_EQ(values.dn.at(0)[0], sampled(reference, p[0], 2));
    EXPECT_EQ(values.dn[0][1], sampled(reference, p[1], with_lens ? 3 : 5));
    EXPECT_EQ(values.dn[0][2], sampled(reference, p[2], 3));
    EXPECT_NE(sampled(reference, p[1], 3), sampled(reference, p[1], 5));
  }
}

}  // namespace
}  // namespace fringetwin::tradeoff::reference_values_test
