// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   1e-9 mm   exact coordinates, exact lens: only Newton's stopping rule (1e-6 px, quadratic) is left
//   1.02      scatter over predicted sigma, n > 1e4: 1 +- 4 / sqrt(2 n) = 1 +- 0.028
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "measure/points/points.hpp"
#include "tests/support/measure/measure_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure::triangulate_projector_test {
namespace {

using namespace testing;

double largest_error(const Twin& twin, std::size_t camera, const PointCloud& cloud, const RaySurface& scene) {
  double largest = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto truth = true_point(twin, camera, cloud.q_cam_px[i].cast<double>(), scene);
    largest = std::max(largest, truth ? (cloud.p_world_mm[i] - *truth).norm() : 1e9);
  }
  return largest;
}

TEST(ProjectorTriangulation, ExactForEveryShapeAndDirection) {
  const Twin twin = scaled_paper_rig(0.25);
  const RaySurface scenes[] = {
      plane_surface({0, 0, 260}, Eigen::Vector3d(0.3, 0.1, -1).normalized()),
      sphere_surface({3, -2, 255}, 12),
      nearest({cylinder_surface({0, 0, 260}, {0, 1, 0}, 8), plane_surface({0, 0, 300}, {0, 0, -1})})};
  for (const RaySurface& scene : scenes)
    for (const std::size_t camera : {std::size_t{0}, std::size_t{1}})
      for (const auto& axes : {std::vector<Axis>{Axis::x}, {Axis::x, Axis::y}}) {
        MapOptions options;
        options.axes = axes;
        TriangulationSummary summary;
        const PointCloud cloud =
            triangulate_projector(twin, camera, ideal_decode(twin, camera, scene, options), &summary);
        EXPECT_GT(cloud.size(), 2000u);
        EXPECT_EQ(summary.n_points, summary.n_candidates);
        EXPECT_LT(summary.residual_rms_px, 1e-9);
        EXPECT_LT(largest_error(twin, camera, cloud, scene), 1e-9);
      }
}

TEST(ProjectorTriangulation, PredictedSigmaIsTheScatter) {
  const Twin twin = scaled_paper_rig(0.25);
  const RaySurface scene = plane_surface({0, 0, 260}, Eigen::Vector3d(0.1, 0.05, -1).normalized());
  for (const auto& axes : {std::vector<Axis>{Axis::x}, {Axis::x, Axis::y}}) {
    MapOptions options;
    options.noise_px = 0.05;
    options.axes = axes;
    const PointCloud cloud = triangulate_projector(twin, 0, ideal_decode(twin, 0, scene, options));
    ASSERT_GT(cloud.size(), 10000u);
    double sum = 0.0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const auto truth = true_point(twin, 0, cloud.q_cam_px[i].cast<double>(), scene);
      sum +=
          std::pow((cloud.p_world_mm[i].norm() - truth->norm()) / static_cast<double>(cloud.sigma_mm[i]), 2);
    }
    const double n = static_cast<double>(cloud.size());
    EXPECT_NEAR(std::sqrt(sum / n), 1.0, 4.0 / std::sqrt(2.0 * n));
  }
}

// The projector's image moved by a third of its height, up or down, leaves points without light: columns
// alone do not tell, the rows where the depths put them do.
TEST(ProjectorTriangulation, PointsBeyondTheProjectorsRowsAreRejected) {
  const Twin twin = scaled_paper_rig(0.25);
  const CameraDecode decode = ideal_decode(twin, 0, plane_surface({0, 0, 260}, {0, 0, -1}));
  const Lens& lens = twin.projector->lens;
  for (const double share : {-1.0 / 3.0, 1.0 / 3.0}) {
    Twin moved = twin;
    std::vector<double> intrinsics = lens.intrinsics();
    intrinsics[3] += share * lens.height();
    moved.projector->lens = Lens(lens.model(), intrinsics, {lens.width(), lens.height()}, "moved");
    TriangulationSummary summary;
    const PointCloud cloud = triangulate_projector(moved, 0, decode, &summary);
    ASSERT_GT(cloud.size(), 1000u);
    EXPECT_GT(summary.n_rejected, 1000u) << share;
    const double margin_px = 0.05 * lens.height();  // what a wrong calibration may take a point out by
    for (const Eigen::Vector3d& p_mm : cloud.p_world_mm) {
      const auto q_px = moved.projector->lens.project(moved.projector->T_proj_world * p_mm);
      ASSERT_TRUE(q_px);
      ASSERT_GE(q_px->y(), -0.5 - margin_px - 1e-6) << share;
      ASSERT_LE(q_px->y(), lens.height() - 0.5 + margin_px + 1e-6) << share;
    }
  }
}

// Coordinates that are right and say nothing, as of Gray code alone on a short baseline: no point, and
// nothing against the poses, of one camera and of two.
TEST(ProjectorTriangulation, RightCoordinatesOfALargeSigmaAreTooUncertain) {
  const Twin twin = scaled_paper_rig(0.1);
  const RaySurface scene = plane_surface({0, 0, 260}, {0, 0, -1});
  CameraDecode first = ideal_decode(twin, 0, scene), second = ideal_decode(twin, 1, scene);
  for (CameraDecode* camera : {&first, &second})
    for (DirectionDecode& d : camera->directions)
      d.coordinate_sigma_px = ImageF(camera->width(), camera->height(), 200.0f);
  TriangulationSummary of_one, of_two;
  EXPECT_EQ(triangulate_projector(twin, 0, first, &of_one).size(), 0u);
  EXPECT_EQ(triangulate_stereo(twin, first, second, &of_two).size(), 0u);
  for (const TriangulationSummary& summary : {of_one, of_two}) {
    EXPECT_GT(summary.n_too_uncertain, 1000u);
    EXPECT_LT(missing_pixels(summary), summary.n_too_uncertain / 20);
    EXPECT_FALSE(mostly_rejected(summary));
  }
}

TEST(ProjectorTriangulation, WrongOrdersAreAbsurdAndRejected) {
  const Twin twin = scaled_paper_rig(0.1);
  const RaySurface scene = plane_surface({0, 0, 260}, {0, 0, -1});
  CameraDecode decode = ideal_decode(twin, 0, scene);
  // columns whose sheet of light the ray meets behind the camera or far outside the projector's rows
  for (double& c : decode.directions[0].coordinate_px.data) c += 20000.0;
  TriangulationSummary summary;
  EXPECT_EQ(triangulate_projector(twin, 0, decode, &summary).size(), 0u);
  EXPECT_EQ(summary.n_rejected, summary.n_candidates);
  EXPECT_EQ(summary.n_too_uncertain, 0u);
  Twin without = twin;
  without.projector.reset();
  EXPECT_THROW(triangulate_projector(without, 0, decode), UserError);
}

}  // namespace
}  // namespace fringetwin::measure::triangulate_projector_test
