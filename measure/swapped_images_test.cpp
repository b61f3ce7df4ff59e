// SPDX-License-Identifier: Apache-2.0
// Images that are exchanged, mirrored or upside down are named as that; right ones and a wrong pose are not.
// The maps are those of rays cast at a ball before a tilted wall.
//
// | check                        | tolerance | origin                                                       |
// |------------------------------|-----------|--------------------------------------------------------------|
// | points of pixels, 30 % seen  | 0.1...0.4 | a turn by 70 % of the view's angle, of cameras that have not |
// | by both cameras              |           | quite all in common before; 0.5 is where readings were tried |
#include "measure/swapped_images.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tests/support/measure/measure_rig.hpp"

namespace fringetwin::measure::swapped_images_test {
namespace {

using namespace testing;
using ::testing::HasSubstr;

struct StereoRig {
  Twin twin = scaled_paper_rig(0.25);
  Measurement measured;

  /// `turn_of_second`: from where it looks in the paper, in its own frame.
  explicit StereoRig(const Eigen::AngleAxisd& turn_of_second = {0.0, Eigen::Vector3d::UnitX()}) {
    Pose& pose = twin.cameras[1].T_cam_world;
    pose.rotation = turn_of_second.toRotationMatrix() * pose.rotation;
    pose.translation_mm = turn_of_second.toRotationMatrix() * pose.translation_mm;
    const RaySurface scene =
        nearest({sphere_surface({-8, 12, 240}, 20),
                 plane_surface({0, 0, 290}, Eigen::Vector3d(0.1, 0.2, -1).normalized())});
    for (const std::size_t camera : {0u, 1u}) measured.cameras.push_back(ideal_decode(twin, camera, scene));
  }
  /// Turns the map of a camera's coordinates.
  void turn(std::size_t camera, bool sideways, bool upside_down) {
    for (DirectionDecode& d : measured.cameras[camera].directions) {
      const ImageD coordinate = d.coordinate_px;
      const ImageF sigma = d.coordinate_sigma_px;
      for (int y = 0; y < coordinate.height; ++y)
        for (int x = 0; x < coordinate.width; ++x) {
          const int u = sideways ? coordinate.width - 1 - x : x,
                    v = upside_down ? coordinate.height - 1 - y : y;
          d.coordinate_px(x, y) = coordinate(u, v);
          d.coordinate_sigma_px(x, y) = sigma(u, v);
        }
    }
  }
  std::string told() {
    triangulate_stereo(twin, measured.cameras[0], measured.cameras[1], &measured.triangulation);
    return swapped_images(twin, measured).value_or("");
  }
};

TEST(SwappedImages, NothingOfRightOnes) {
  StereoRig rig;
  EXPECT_EQ(rig.told(), "");
  EXPECT_LT(rejected_share(rig.measured.triangulation), 0.05);
  EXPECT_FALSE(rays_miss_each_other(rig.twin, rig.measured)) << "no reading was tried";
}

/// Returns the angle between the rays of two pixels.
double angle_between(const Lens& lens, const Eigen::Vector2d& a_px, const Eigen::Vector2d& b_px) {
  return std::acos(lens.unproject(a_px).value().dot(lens.unproject(b_px).value()));
}

// Cameras that have some 30 % of their images in common, beside or below each other: most pixels have no
// match, and no reading of the images is tried.
TEST(SwappedImages, LittleOverlapIsNoDoubt) {
  const Lens lens = StereoRig().twin.cameras[1].lens;
  const double w = lens.width() - 1, h = lens.height() - 1;
  const double across = angle_between(lens, {0, h / 2}, {w, h / 2}),
               down = angle_between(lens, {w / 2, 0}, {w / 2, h});
  for (const Eigen::AngleAxisd& turn : {Eigen::AngleAxisd(0.7 * across, Eigen::Vector3d::UnitY()),
                                        Eigen::AngleAxisd(-0.7 * across, Eigen::Vector3d::UnitY()),
                                        Eigen::AngleAxisd(0.7 * down, Eigen::Vector3d::UnitX()),
                                        Eigen::AngleAxisd(-0.7 * down, Eigen::Vector3d::UnitX())}) {
    StereoRig rig(turn);
    EXPECT_EQ(rig.told(), "");
    const TriangulationSummary& t = rig.measured.triangulation;
    const double points = static_cast<double>(t.n_points) / static_cast<double>(t.n_candidates);
    EXPECT_GT(points, 0.1);
    EXPECT_LT(points, 0.4);
    EXPECT_FALSE(rays_miss_each_other(rig.twin, rig.measured)) << turn.angle() << " " << points;
  }
}

// Both have no sigma as maps that somebody made, and no phases as Gray code alone: nothing else is read.
TEST(SwappedImages, CoordinatesAreAllThatIsNeeded) {
  StereoRig rig;
  std::swap(rig.measured.cameras[0], rig.measured.cameras[1]);
  for (CameraDecode& camera : rig.measured.cameras)
    for (DirectionDecode& d : camera.directions) {
      ASSERT_TRUE(d.wrapped_rad.empty() && d.amplitude_dn.empty() && d.mean_dn.empty());
      d.coordinate_sigma_px = {};
    }
  EXPECT_THAT(rig.told(), HasSubstr("\" exchanged it would be"));
}

TEST(SwappedImages, ExchangedCameras) {
  StereoRig rig;
  std::swap(rig.measured.cameras[0], rig.measured.cameras[1]);
  EXPECT_THAT(rig.told(), HasSubstr("\" exchanged it would be"))
      << rejected_share(rig.measured.triangulation) << " " << rig.measured.triangulation.n_points << " of "
      << rig.measured.triangulation.n_candidates;
}

TEST(SwappedImages, OneThatIsMirrored) {
  for (const std::size_t camera : {0u, 1u}) {
    StereoRig rig;
    rig.turn(camera, true, false);
    EXPECT_THAT(rig.told(),
                HasSubstr("the images of \"" + rig.twin.cameras[camera].name + "\" mirrored left to"))
        << rejected_share(rig.measured.triangulation);
  }
}

TEST(SwappedImages, OneThatIsUpsideDown) {
  for (const std::size_t camera : {0u, 1u}) {
    StereoRig rig;
    rig.turn(camera, false, true);
    EXPECT_THAT(rig.told(), HasSubstr("the images of \"" + rig.twin.cameras[camera].name + "\" upside down"))
        << rejected_share(rig.measured.triangulation);
  }
}

TEST(SwappedImages, BothTurnedBy180Degrees) {
  StereoRig rig;
  rig.turn(0, true, true);
  rig.turn(1, true, true);
  EXPECT_THAT(rig.told(), HasSubstr("the images of both cameras turned by 180 degrees"))
      << rejected_share(rig.measured.triangulation);
}

// A second camera that looks 3 or 6 degrees elsewhere than the twin says: its pixels are rejected, readings
// are tried, and none is better.
TEST(SwappedImages, NothingOfAWrongPose) {
  for (const Eigen::AngleAxisd& turn :
       {Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()), Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()),
        Eigen::AngleAxisd(-0.05, Eigen::Vector3d::UnitZ()),
        Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ())}) {
    StereoRig rig;
    Pose& pose = rig.twin.cameras[1].T_cam_world;
    pose.rotation = turn.toRotationMatrix() * pose.rotation;
    EXPECT_EQ(rig.told(), "");
    EXPECT_TRUE(rays_miss_each_other(rig.twin, rig.measured))
        << "this pose tells nothing: " << rejected_share(rig.measured.triangulation);
  }
}

}  // namespace
}  // namespace fringetwin::measure::swapped_images_test
