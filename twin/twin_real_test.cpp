// SPDX-License-Identifier: Apache-2.0
// Real files as they are found in the wild: the Stanford bunny and four foreign capture sets, through
// the twins in datasets/.
//
// | check                      | tolerance | origin                                                     |
// |----------------------------|-----------|------------------------------------------------------------|
// | bunny counts, image counts | exact     | README of each set                                         |
// | bunny width                | 0.001 mm  | "about 0.155 m" in its README; 155.70 mm from its file     |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "twin/captures/capture_set.hpp"
#include "twin/mesh/mesh.hpp"
#include "twin/twin.hpp"

namespace fringetwin::twin_real_test {
namespace {
namespace fs = std::filesystem;

fs::path dataset(const std::string& name) {
  const char* source = std::getenv("FRINGETWIN_SOURCE");
  return fs::path(source != nullptr ? source : ".") / "datasets" / name / "twin.toml";
}

#define SKIP_WITHOUT(set)                                                      \
  if (!fs::is_directory(captures_root() / (set)) || !fs::exists(dataset(set))) \
  GTEST_SKIP() << "real captures absent: " << (captures_root() / (set)) << " (FRINGETWIN_CAPTURES)"

TEST(RealFiles, StanfordBunny) {
  const fs::path file = captures_root() / "mesh-stanford-bunny" / "bun_zipper.ply";
  if (!fs::exists(file)) GTEST_SKIP() << "real captures absent: " << file << " (FRINGETWIN_CAPTURES)";
  const auto mesh = load_mesh(file, "m");
  EXPECT_EQ(mesh->vertices_mm.size(), 35947u);
  EXPECT_EQ(mesh->triangles.size(), 69451u);
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& v : mesh->vertices_mm) box.extend(v);
  EXPECT_NEAR(box.sizes().x(), 155.70f, 0.01f);
}

struct Expected {
  std::string set, camera;
  int images, width, height;
  bool white;
};
void PrintTo(const Expected& expected, std::ostream* os) { *os << expected.set << " " << expected.camera; }

class RealCaptures : public ::testing::TestWithParam<Expected> {};

TEST_P(RealCaptures, LoadThroughTheirTwin) {
  const Expected& expected = GetParam();
  SKIP_WITHOUT(expected.set);
  const Twin twin = load_twin(dataset(expected.set));
  ASSERT_TRUE(twin.real.captures);
  const CaptureSet set =
      read_capture_set(*twin.real.captures, static_cast<int>(expand_sequence(twin.fringes).size()));
  const auto camera = std::find_if(twin.cameras.begin(), twin.cameras.end(),
                                   [&](const Camera& c) { return c.name == expected.camera; });
  ASSERT_NE(camera, twin.cameras.end());
  const CameraImages images = load_camera_images(set, *camera, twin.fringes);
  EXPECT_EQ(images.images.size(), static_cast<std::size_t>(expected.images));
  EXPECT_EQ(images.images.front().width, expected.width);
  EXPECT_EQ(images.images.back().height, expected.height);
  EXPECT_EQ(images.white.has_value(), expected.white);
  EXPECT_FALSE(images.radiance);
  EXPECT_EQ(images.saturation_dn(), 255.0);
  EXPECT_FALSE(set.provenance.at("source").empty());
}

INSTANTIATE_TEST_SUITE_P(Sets, RealCaptures,
                         ::testing::Values(Expected{"cpsd-plane-4freq12step", "camera", 48, 900, 700, false},
                                           Expected{"kamino-procam-board", "camera", 40, 1280, 1024, true},
                                           Expected{"slmaster-mono-relief", "camera", 18, 1280, 1024, false},
                                           Expected{"slsdk-stereo-statue", "left", 10, 2048, 1536, false},
                                           Expected{"slsdk-stereo-statue", "right", 10, 2048, 1536, false}));

TEST(RealFiles, StereoBaselineOfTheStatueSet) {
  SKIP_WITHOUT("slsdk-stereo-statue");
  const Twin twin = load_twin(dataset("slsdk-stereo-statue"));
  const double baseline_mm = (twin.cameras[1].center_world_mm() - twin.cameras[0].center_world_mm()).norm();
  EXPECT_NEAR(baseline_mm, 301.735, 5e-4);  // its README, 3 decimals
}

}  // namespace
}  // namespace fringetwin::twin_real_test
