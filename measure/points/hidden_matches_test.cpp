// SPDX-License-Identifier: Apache-2.0
// Points of plain numbers: a pinhole camera of 1000 px looks along z, another stands 80 mm beside it.
#include "measure/points/hidden_matches.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <random>

#include "twin/base/constants.hpp"

namespace fringetwin::measure::hidden_matches_test {
namespace {

constexpr int kSize = 60, kMiddle = 30;
constexpr double kFocalPx = 1000.0, kBaselineMm = 80.0, kNearMm = 290.0, kFarMm = 300.0;
const Eigen::Vector3d kBesideX(kBaselineMm, 0, 0);

using DepthAt = std::function<double(int x, int y)>;  ///< of pixels from the middle of the image
Image<Eigen::Vector3d> points_of(const DepthAt& z_mm, int width = kSize, int height = kSize) {
  Image<Eigen::Vector3d> points(width, height, Eigen::Vector3d::Constant(kNaN));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int u = x - kMiddle, v = y - kMiddle;
      points(x, y) = z_mm(u, v) * Eigen::Vector3d(u / kFocalPx, v / kFocalPx, 1.0);
    }
  return points;
}

ImageU8 hidden_of(const Image<Eigen::Vector3d>& points, double sigma_mm,
                  const Eigen::Vector3d& center1_mm = kBesideX) {
  return hidden_matches(points, ImageF(points.width, points.height, static_cast<float>(sigma_mm)), center1_mm,
                        1.0 / kFocalPx);
}

long count(const ImageU8& mask) {
  return std::ranges::count_if(mask.data, [](unsigned char m) { return m != 0; });
}

/// A plate on the right of column 0 hides 9 columns of the wall on its left from the second camera; their
/// points lie on its ray past the plate's edge (x = 0, z = kNearMm).
double slide_beside_plate(int x, int) {
  if (x >= 0) return kNearMm;
  const double on_ray_mm = kNearMm * kBaselineMm / (kBaselineMm + kNearMm * x / kFocalPx);
  return std::min(on_ray_mm, kFarMm);
}

TEST(HiddenMatches, ASlideBesideAPlateIsFoundAndNothingFarFromIt) {
  const ImageU8 hidden = hidden_of(points_of(slide_beside_plate), 0.0);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const int u = x - kMiddle;
      if (u >= -8 && u <= -1) {
        EXPECT_EQ(hidden(x, y), 1) << u << ' ' << y;
      } else if (u < -11 || u > 2) {
        EXPECT_EQ(hidden(x, y), 0) << u << ' ' << y;
      }
    }
}

TEST(HiddenMatches, AnyBaselineAndEitherSide) {
  const long expected = count(hidden_of(points_of(slide_beside_plate), 0.0));
  const auto turned = points_of([](int x, int y) { return slide_beside_plate(y, x); });
  EXPECT_EQ(count(hidden_of(turned, 0.0, {0, kBaselineMm, 0})), expected);
  const auto mirrored = points_of([](int x, int y) { return slide_beside_plate(-x, y); }, kSize + 1);
  EXPECT_NEAR(static_cast<double>(count(hidden_of(mirrored, 0.0, -kBesideX))), static_cast<double>(expected),
              kSize);  // the plate's own column lies on the other side of the edge
}

// Both cameras see both sides of a step along the baseline: planes about it are steep, and nothing is hidden.
TEST(HiddenMatches, AStepAlongTheBaselineLosesNothing) {
  for (const double z_mm : {299.0, 290.0, 260.0, 200.0})
    EXPECT_EQ(count(hidden_of(points_of([&](int, int y) { return y < 0 ? z_mm : kFarMm; }), 0.0)), 0) << z_mm;
}

// Nor of a round edge, parts of which lie along the baseline, also from a second camera that stands behind
// the first.
TEST(HiddenMatches, ARoundEdgeLosesNothingThatBothCamerasSee) {
  constexpr int kRadiusPx = 20;
  for (const Eigen::Vector3d& center1 : {kBesideX, Eigen::Vector3d(kBaselineMm, 0, 60)})
    for (const double near_mm : {290.0, 260.0}) {
      auto points =
          points_of([&](int x, int y) { return x * x + y * y < kRadiusPx * kRadiusPx ? near_mm : kFarMm; });
      for (Eigen::Vector3d& p : points.data) {  // what the disc hides from the second camera has no match
        const double t = (near_mm - center1.z()) / (p.z() - center1.z());
        const Eigen::Vector3d at_disc = center1 + t * (p - center1);
        if (p.z() > near_mm && at_disc.head<2>().norm() < kRadiusPx * near_mm / kFocalPx) p.setConstant(kNaN);
      }
      const long lost = count(hidden_of(points, 0.0, center1));
      std::printf("disc at %g mm: %ld points lost\n", near_mm, lost);
      EXPECT_LE(lost, 2 * kRadiusPx) << near_mm;  // a third of a pixel along its outline
    }
}

// Depths off by 20 times the distance of neighbouring pixels make slopes at random, which say nothing: also
// of the few pixels of a rod, 5 wide. 3 sigma leave a tenth of a percent; windows that end at the border, and
// the neighbours of what is found, a few times as much.
TEST(HiddenMatches, NoiseOfDepthsHidesNothing) {
  const double pitch_mm = kFarMm / kFocalPx;
  for (const double pitches : {2.0, 5.0, 20.0}) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> noise(0.0, pitches * pitch_mm);
    auto points = points_of([&](int, int) { return kFarMm + noise(random); });
    EXPECT_LE(count(hidden_of(points, pitches * pitch_mm)), kSize * kSize / 200) << pitches;
    if (pitches >= 20.0) {
      EXPECT_GT(count(hidden_of(points, 0.0)), kSize * kSize / 50) << "without sigma";
    }
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        if (std::abs(x - kMiddle) > 2) points(x, y).setConstant(kNaN);
    EXPECT_LE(count(hidden_of(points, pitches * pitch_mm)), 5 * kSize / 100) << pitches;
  }
}

TEST(HiddenMatches, ImagesWithoutNeighboursHideNothing) {
  EXPECT_EQ(count(hidden_of(Image<Eigen::Vector3d>(), 0.0)), 0);
  EXPECT_EQ(count(hidden_of(Image<Eigen::Vector3d>(9, 9, Eigen::Vector3d::Constant(kNaN)), 0.0)), 0);
  EXPECT_EQ(count(hidden_of(points_of(slide_beside_plate, kSize, 1), 0.0)), 0);
  EXPECT_EQ(count(hidden_of(points_of(slide_beside_plate, 1, kSize), 0.0)), 0);
}

}  // namespace
}  // namespace fringetwin::measure::hidden_matches_test
