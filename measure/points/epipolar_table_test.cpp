// SPDX-License-Identifier: Apache-2.0
// Starts of stereo matching on a map whose coordinate is a formula, against the depth where two rays meet.
//
// | check | tolerance         | origin |
// |-------|-------------------|-------------------------------------------------------------------------------|
// | depth | 1 px of disparity | a bin begins half a step before its pixel's step, so that the one before may
// | |       |                   | stand for it: half a pixel; rays between grid points are bilinear: 1e-4 |
#include "measure/points/epipolar_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace fringetwin::measure::epipolar_table_test {
namespace {

constexpr int kAlong = 33, kAcross = 17;  ///< px; the grid of coarse rays ends in the last column and row
constexpr double kFocal = 400.0, kBaselineMm = 50.0;
constexpr double kFirst = 100.0, kStep = 2.0;  ///< projector px, and per camera px along the baseline

/// Two cameras side by side, or one above the other, which see a coordinate that grows along the baseline: it
/// is largest in the last column, or row.
struct Rig {
  bool upright;
  int width = upright ? kAcross : kAlong, height = upright ? kAlong : kAcross;
  Lens lens = Lens("LENSMODEL_PINHOLE", {kFocal, kFocal, 0.5 * (width - 1), 0.5 * (height - 1)},
                   {width, height}, "test");
  ImageD coordinate_px = ImageD(width, height);
  ImageF no_sigma = {};

  explicit Rig(bool is_upright) : upright(is_upright) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) coordinate_px(x, y) = kFirst + kStep * (upright ? y : x);
  }
  /// Returns the ray of camera 0 in an epipolar plane, `along_px` from the first column (row) of its image.
  Eigen::Vector3d ray(double along_px, double across_px) const {
    const double along = (along_px - 0.5 * (kAlong - 1)) / kFocal,
                 across = (across_px - 0.5 * (kAcross - 1)) / kFocal;
    return upright ? Eigen::Vector3d(across, along, 1.0) : Eigen::Vector3d(along, across, 1.0);
  }
};

/// Expects for every epipolar plane and coordinate the one depth there is, within the image and nowhere else.
void expect_one_depth_each(const Rig& rig) {
  constexpr double kFarPx = -100.0;  // of camera 0's ray: left of all that camera 1 sees, at every depth
  Pose T_cam1_cam0;
  T_cam1_cam0.translation_mm[rig.upright ? 1 : 0] = kBaselineMm;
  const CoordinateMap map(rig.coordinate_px, rig.no_sigma);
  const EpipolarTable table(rig.lens, T_cam1_cam0, map);
  for (int across = 0; across < kAcross; ++across)
    for (double along = 0.25; along < kAlong - 1; along += 0.5) {
      const Eigen::Vector3d d = rig.ray(kFarPx, across);
      double depth_mm[EpipolarTable::kMostCandidates] = {};
      const int n = table.candidates(d.normalized(), kFirst + kStep * along, depth_mm);
      ASSERT_EQ(n, 1) << "line " << across << ", " << along << " px along it";
      const double disparity_px = along - kFarPx, truth_mm = d.norm() * kBaselineMm * kFocal / disparity_px;
      ASSERT_NEAR(depth_mm[0] / truth_mm, 1.0, 1.0 / disparity_px) << across << " " << along;
    }
}

// Bins that end before the step into the last column leave it to the next line's first bin, and that of the
// last line to none.
TEST(EpipolarTable, TheLargestCoordinateMayLieInTheLastColumn) { expect_one_depth_each(Rig(false)); }

TEST(EpipolarTable, TheLargestCoordinateMayLieInTheLastRow) { expect_one_depth_each(Rig(true)); }

}  // namespace
}  // namespace fringetwin::measure::epipolar_table_test
