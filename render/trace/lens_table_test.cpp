// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit | origin                                                              |
// |-----------|------|---------------------------------------------------------------------|
// | 1e-6      | px   | interpolation against Lens::unproject, in double, off the grid nodes |
// | 1e-5      | px   | the same on the projector side, against Lens::project               |
// | 5e-4      | px   | the projector's table in single precision: residuals of 100 px, twice|
#include "render/trace/lens_table.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"
#include "twin/lens/mrcal_facade.hpp"

namespace fringetwin::render::lens_table_test {
namespace {

TEST(LensTable, PinholeNeedsNone) {
  const LensTable t = make_lens_table(Lens("LENSMODEL_PINHOLE", {1000, 1001, 320, 240}, {640, 480}, "test"));
  EXPECT_EQ(t.kind, CAMERA_PINHOLE);
  EXPECT_TRUE(t.nodes.empty());
}

TEST(LensTable, PaperCamerasNeedACoarseGrid) {
  for (const Camera& c : testing::paper_rig().cameras) {
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

// The value the shader finds at (x/z, y/z).
Eigen::Vector2d look_up(const ProjectorTable& t, const Eigen::Vector2d& a) {
  const auto weights = [](double s) {
    return Eigen::Vector4d((-s * s * s + 3 * s * s - 2 * s) / 6, (s * s * s - 2 * s * s - s + 2) / 2,
                           (-s * s * s + s * s + 2 * s) / 2, (s * s * s - s) / 6);
  };
  const double gx = (a.x() - t.grid.x) * t.grid.z, gy = (a.y() - t.grid.y) * t.grid.w;
  const int nx = static_cast<int>(t.grid_n.x), ny = static_cast<int>(t.grid_n.y);
  const int i = std::clamp(static_cast<int>(std::floor(gx)), 1, nx - 3);
  const int j = std::clamp(static_cast<int>(std::floor(gy)), 1, ny - 3);
  Eigen::Vector2d q(t.cx + t.fx * a.x(), t.cy + t.fy * a.y());
  for (int b = 0; b < 4; ++b)
    for (int c = 0; c < 4; ++c) {
      const gpu::vec4& v = t.nodes[static_cast<std::size_t>((j - 1 + b) * nx + i - 1 + c)];
      q += weights(gx - i)[c] * weights(gy - j)[b] * Eigen::Vector2d(v.x, v.y);
    }
  return q;
}

// The image reaches 99.95 % of the spline's knots, the grid farther: its nodes out there have no pixel, and
// yet the pixels along the border need them.
TEST(ProjectorTable, ReachesTheBorderOfASplinesDomain) {
  const std::string model = "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=11_Ny=8_fov_x_deg=60";
  const double focal_px = 640.0 / (0.9995 * MrcalModel::from_name(model)->spline_half_size()->x());
  std::vector<double> k{focal_px, focal_px, 639.5, 359.5};
  k.resize(4 + 2 * 11 * 8, 0.0);
  const Lens lens(model, k, {1280, 720}, "t");
  const ProjectorTable t = make_projector_table(lens);
  EXPECT_LE(t.max_error_px, 1e-5);
  EXPECT_FALSE(lens.project({t.grid.x, 0.0, 1.0}));  // the grid does leave the domain
  for (double s = 0.0; s <= 1.0; s += 1.0 / 512)
    for (const Eigen::Vector2d& q :
         {Eigen::Vector2d(s * 1280 - 0.5, -0.5), Eigen::Vector2d(s * 1280 - 0.5, 719.5),
          Eigen::Vector2d(-0.5, s * 720 - 0.5), Eigen::Vector2d(1279.5, s * 720 - 0.5)})
      EXPECT_LE((look_up(t, lens.unproject(q)->hnormalized()) - q).norm(), 5e-4) << q.transpose();
}

// Knots of 0.5 px cannot be followed by a grid of 1 px: said, not passed over.
TEST(LensTable, RefusesWhatTheGridCannotFollow) {
  std::vector<double> k{50, 50, 15.5, 11.5};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.003, 0.003);
  for (int i = 0; i < 2 * 110 * 80; ++i) k.push_back(uniform(random));
  const Lens lens("LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=110_Ny=80_fov_x_deg=60", k, {32, 24}, "t");
  EXPECT_THROW(make_lens_table(lens), UserError);
  EXPECT_THROW(make_projector_table(lens), UserError);
}

TEST(ProjectorTable, RefusesHalfTheSphere) {
  const Lens lens("LENSMODEL_STEREOGRAPHIC", {200, 200, 640, 360}, {1280, 720}, "t");
  EXPECT_THROW(make_projector_table(lens), UserError);
}

}  // namespace
}  // namespace fringetwin::render::lens_table_test
