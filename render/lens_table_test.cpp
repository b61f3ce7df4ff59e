// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit | origin                                                              |
// |-----------|------|---------------------------------------------------------------------|
// | 1e-6      | px   | interpolation against Lens::unproject, in double, off the grid nodes |
// | 1e-5      | px   | the same on the projector side, against Lens::project               |
#include "render/lens_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/paper_rig.hpp"
#include "twin/errors.hpp"

namespace fringetwin::render {
namespace {

TEST(LensTable, PinholeNeedsNone) {
  const LensTable t = make_lens_table(Lens("LENSMODEL_PINHOLE", {1000, 1001, 320, 240}, {640, 480}, "test"));
  EXPECT_EQ(t.kind, CAMERA_PINHOLE);
  EXPECT_TRUE(t.nodes.empty());
}

TEST(LensTable, PaperCamerasNeedACoarseGrid) {
  for (const Camera& c : test::paper_rig().cameras) {
    const LensTable t = make_lens_table(c.lens);
    EXPECT_EQ(t.kind, CAMERA_PERSPECTIVE);
    EXPECT_LE(t.max_error_px, 1e-6);
    EXPECT_GE(t.spacing_px, 8.0);
  }
}

TEST(LensTable, StrongBarrelDistortion) {
  const Lens lens("LENSMODEL_OPENCV5", {500, 502, 319.3, 241.1, -0.3, 0.1, 1e-3, -2e-3, -0.01}, {640, 480},
                  "t");
  const LensTable t = make_lens_table(lens);
  EXPECT_LE(t.max_error_px, 1e-6);
}

TEST(LensTable, WideLensByDirections) {
  const Lens lens("LENSMODEL_STEREOGRAPHIC", {400, 400, 320, 240}, {640, 480}, "t");
  const LensTable t = make_lens_table(lens);
  EXPECT_EQ(t.kind, CAMERA_GENERAL);
  EXPECT_LE(t.max_error_px, 1e-6);
}

// Every pixel's ray lies in its block's cone: culling never loses one.
TEST(LensTable, BlockConesContainTheirPixels) {
  const Lens lens("LENSMODEL_OPENCV5", {500, 502, 319.3, 241.1, -0.3, 0.1, 1e-3, -2e-3, -0.01}, {650, 483},
                  "t");
  const LensTable t = make_lens_table(lens);
  for (int y = 0; y < lens.height(); y += 3)
    for (int x = 0; x < lens.width(); ++x) {
      const Eigen::Vector4d& cone =
          t.block_cones[static_cast<std::size_t>(y / BLOCK_HEIGHT * t.blocks_x + x / BLOCK_WIDTH)];
      const Eigen::Vector3d d = *lens.unproject({x, y});
      EXPECT_LE(std::acos(std::min(1.0, d.dot(cone.head<3>()))), cone[3] + 1e-12);
    }
}

TEST(ProjectorTable, WideProjector) {
  const Lens lens("LENSMODEL_STEREOGRAPHIC", {900, 900, 640, 360}, {1280, 720}, "t");
  const ProjectorTable t = make_projector_table(lens);
  EXPECT_LE(t.max_error_px, 1e-5);
}

TEST(ProjectorTable, RefusesHalfTheSphere) {
  const Lens lens("LENSMODEL_STEREOGRAPHIC", {200, 200, 640, 360}, {1280, 720}, "t");
  EXPECT_THROW(make_projector_table(lens), UserError);
}

}  // namespace
}  // namespace fringetwin::render
