// SPDX-License-Identifier: Apache-2.0
// Images that are exchanged, mirrored or upside down are named as that; right ones and a wrong pose are not.
// The maps are those of rays cast at a ball before a tilted wall.
#include "measure/swapped_images.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "tests/support/measure/measure_rig.hpp"

namespace fringetwin::measure::swapped_images_test {
namespace {

using namespace testing;
using ::testing::HasSubstr;

struct StereoRig {
  Twin twin = scaled_paper_rig(0.25);
  Measurement measured;

  StereoRig() {
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

TEST(SwappedImages, BothTurnedBy180Degrees) {
  StereoRig rig;
  rig.turn(0, true, true);
  rig.turn(1, true, true);
  EXPECT_THAT(rig.told(), HasSubstr("the images of both cameras turned by 180 degrees"))
      << rejected_share(rig.measured.triangulation);
}

// A second camera that looks 3 degrees elsewhere: its pixels are rejected, and no reading is better.
TEST(SwappedImages, NothingOfAWrongPose) {
  StereoRig rig;
  Pose& pose = rig.twin.cameras[1].T_cam_world;
  pose.rotation = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()).toRotationMatrix() * pose.rotation;
  EXPECT_EQ(rig.told(), "") << rejected_share(rig.measured.triangulation);
}

}  // namespace
}  // namespace fringetwin::measure::swapped_images_test
