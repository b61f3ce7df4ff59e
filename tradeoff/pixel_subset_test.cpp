// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit | origin                                     |
// |-----------|------|--------------------------------------------|
// | 1e-9      | px   | a shifted principal point, double rounding |
// | 1e-9      | 1    | sums of weights, double rounding           |
#include "tradeoff/pixel_subset.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::tradeoff::pixel_subset_test {
namespace {

/// 200 x 120 px: object 0 fills x < 150 but for a square of object 1; object 0 is dark where y >= 90.
render::RenderedCamera scene() {
  render::RenderedCamera r;
  r.object = Image<std::int32_t>(200, 120, -1);
  r.irradiance.assign(2, ImageF(200, 120));
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 150; ++x) {
      const bool square = x >= 48 && x < 104 && y >= 24 && y < 72;
      r.object(x, y) = square ? 1 : 0;
      r.irradiance[1](x, y) = square || y < 90 ? 10.0F : 0.0F;
    }
  return r;
}

TEST(Subset, ClassesOfPixels) {
  const auto classes = classify_pixels(scene());
  EXPECT_EQ(classes(10, 10), PixelClass::interior);
  EXPECT_EQ(classes(60, 40), PixelClass::interior) << "inside the square";
  EXPECT_EQ(classes(47, 40), PixelClass::edge);
  EXPECT_EQ(classes(48, 40), PixelClass::edge) << "both sides of a silhouette";
  EXPECT_EQ(classes(46, 40), PixelClass::interior);
  EXPECT_EQ(classes(10, 89), PixelClass::edge) << "border of light";
  EXPECT_EQ(classes(10, 90), PixelClass::edge);
  EXPECT_EQ(classes(10, 100), PixelClass::interior) << "dark, but all alike";
  EXPECT_EQ(classes(150, 40), PixelClass::edge) << "the background beside an object";
  EXPECT_EQ(classes(151, 40), PixelClass::background);
}

TEST(Subset, CoversObjectsSilhouettesAndBordersOfLight) {
  SubsetOptions options;
  options.windows_per_camera = 5;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    options.seed = seed;
    const auto s = scene();
    const CameraSubset subset = choose_subset(s, options);
    ASSERT_EQ(subset.windows.size(), 5u);
    bool inside0 = false, inside1 = false, silhouette0 = false, silhouette1 = false, border = false;
    for (const SubsetPixel& p : subset.pixels) {
      const int object = s.object(p.x, p.y);
      inside0 |= !p.edge && object == 0 && s.irradiance[1](p.x, p.y) > 0;
      inside1 |= !p.edge && object == 1;
      silhouette0 |= p.edge && object == 0 && p.y < 88;
      silhouette1 |= p.edge && object == 1;
      border |= p.edge && object == 0 && (p.y == 89 || p.y == 90) && p.x < 149;
    }
    EXPECT_TRUE(inside0 && inside1 && silhouette0 && silhouette1 && border) << "seed " << seed;
  }
}

TEST(Subset, WeightsStandForTheWholeImage) {
  const CameraSubset subset = choose_subset(scene(), {});
  double interior = 0.0, edge = 0.0;
  for (const SubsetPixel& p : subset.pixels) (p.edge ? edge : interior) += p.weight;
  EXPECT_NEAR(interior / static_cast<double>(subset.n_interior_image), 1.0, 1e-9);
  EXPECT_NEAR(edge / static_cast<double>(subset.n_edge_image), 1.0, 1e-9);
  std::set<std::pair<int, int>> seen;
  for (const SubsetPixel& p : subset.pixels) EXPECT_TRUE(seen.insert({p.x, p.y}).second) << "a pixel twice";
}

TEST(Subset, TheSeedDecides) {
  const auto places = [](const CameraSubset& s) {
    std::vector<std::pair<int, int>> out;
    for (const SubsetWindow& w : s.windows) out.emplace_back(w.x0, w.y0);
    return out;
  };
  SubsetOptions a, b;
  b.seed = 1;
  EXPECT_EQ(places(choose_subset(scene(), a)), places(choose_subset(scene(), a)));
  EXPECT_NE(places(choose_subset(scene(), a)), places(choose_subset(scene(), b)));
}

TEST(Subset, NothingSeenIsNoPixel) {
  render::RenderedCamera r;
  r.object = Image<std::int32_t>(64, 64, -1);
  r.irradiance.assign(1, ImageF(64, 64));
  EXPECT_TRUE(choose_subset(r, {}).pixels.empty());
}

TEST(Subset, AWindowSeesWhatItsCameraSeesThere) {
  const Twin twin = testing::with_object(testing::paper_rig(), "ball", testing::physical_sphere());
  PixelSubset subset;
  subset.cameras.resize(2);
  subset.cameras[0].windows = {{640, 512, 16, 16}};
  subset.cameras[1].windows = {{320, 256, 16, 8}, {0, 0, 16, 16}};
  const Twin windows = window_twin(twin, subset);
  ASSERT_EQ(windows.cameras.size(), 3u);
  EXPECT_EQ(windows.cameras[1].lens.height(), 8);
  const Eigen::Vector3d p_world_mm(6, -5, 255);
  const auto whole = twin.cameras[1].lens.project(twin.cameras[1].T_cam_world * p_world_mm);
  const auto local = windows.cameras[1].lens.project(windows.cameras[1].T_cam_world * p_world_mm);
  ASSERT_TRUE(whole && local);
  EXPECT_NEAR((*whole - *local - Eigen::Vector2d(320, 256)).norm(), 0.0, 1e-9);
}

}  // namespace
}  // namespace fringetwin::tradeoff::pixel_subset_test
