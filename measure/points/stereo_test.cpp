// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   1e-8 mm   a plane through distorted lenses at half size, every point: Newton leaves 1e-9 px of 0.15 mm,
//             4x4 Lagrange follows the map; measured 5e-10
//   3e-5 mm   sphere fits: interpolation error of 4x4 Lagrange towards the rim, rms over inliers (3e-4: over
//             all); 6e-5 mm for centre and radius
//   4 sigma   of the mean / of the scatter ratio where noise is added (n > 1e4: ratio 1 +- 3 %)
#include <gtest/gtest.h>
#include <omp.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>

#include "measure/fit/fits.hpp"
#include "measure/points/points.hpp"
#include "tests/support/measure/measure_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure::stereo_test {
namespace {

using namespace testing;

struct Errors {
  double rms_mm = 0.0, largest_mm = 0.0;
};

/// Against the surface point that the pixel really sees.
Errors point_errors(const Twin& twin, const PointCloud& cloud, const RaySurface& scene) {
  Errors e;
  double sum = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto truth = true_point(twin, 0, cloud.q_cam_px[i].cast<double>(), scene);
    EXPECT_TRUE(truth.has_value());
    const double d = truth ? (cloud.p_world_mm[i] - *truth).norm() : 1e9;
    sum += d * d;
    e.largest_mm = std::max(e.largest_mm, d);
  }
  e.rms_mm = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, cloud.size())));
  return e;
}

PointCloud run(const Twin& twin, const RaySurface& scene, const MapOptions& options,
               TriangulationSummary* summary) {
  MapOptions right = options;
  right.seed = options.seed + 1000;
  return triangulate_stereo(twin, ideal_decode(twin, 0, scene, options), ideal_decode(twin, 1, scene, right),
                            summary);
}

TEST(Stereo, PlaneIsExact) {
  const Twin twin = scaled_paper_rig(0.5);
  const RaySurface scene = plane_surface({0, 0, 260}, Eigen::Vector3d(0.1, 0.05, -1).normalized());
  const CameraDecode left = ideal_decode(twin, 0, scene), right = ideal_decode(twin, 1, scene);
  TriangulationSummary summary;
  const auto start = std::chrono::steady_clock::now();
  const PointCloud cloud = triangulate_stereo(twin, left, right, &summary);
  const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const Errors e = point_errors(twin, cloud, scene);
  std::printf(
      "plane: %zu of %zu candidates, no match %zu, ambiguous %zu, rejected %zu, rms %.2e mm, max %.2e mm, "
      "%.2f s\n",
      cloud.size(), summary.n_candidates, summary.n_no_match, summary.n_ambiguous, summary.n_rejected,
      e.rms_mm, e.largest_mm, s);
  EXPECT_GT(cloud.size(), 125000u);
  EXPECT_LT(e.largest_mm, 1e-8);
  EXPECT_EQ(summary.n_ambiguous, 0u);
  EXPECT_LE(summary.n_rejected, 5u);  // lonely corners
  EXPECT_EQ(summary.n_points + summary.n_no_match + summary.n_rejected, summary.n_candidates);
}

TEST(Stereo, SpheresFitToInterpolationError) {
  const Twin twin = scaled_paper_rig();
  struct Case {
    Eigen::Vector3d center_mm;
    double radius_mm;
  };
  for (const Case& c : {Case{{0, 0, 250}, 5.0}, Case{{6.567, -5.497, 270.634}, 19.065}}) {
    const RaySurface scene = sphere_surface(c.center_mm, c.radius_mm);
    MapOptions options;
    options.shadows = true;
    TriangulationSummary summary;
    const PointCloud cloud = run(twin, scene, options, &summary);
    FitOptions robust;
    robust.loss = RobustLoss::tukey;
    const SphereFit all = fit_sphere(cloud.p_world_mm, {c.center_mm, c.radius_mm}, {});
    const SphereFit fit = fit_sphere(cloud.p_world_mm, {c.center_mm, c.radius_mm}, robust);
    std::printf(
        "sphere r %.3f: %zu of %zu, ambiguous %zu, rejected %zu; rms all %.2e, robust %.2e mm (n %zu), "
        "centre %.2e, radius %.2e\n",
        c.radius_mm, cloud.size(), summary.n_candidates, summary.n_ambiguous, summary.n_rejected, all.rms_mm,
        fit.rms_mm, fit.n, (fit.center_mm - c.center_mm).norm(), fit.radius_mm - c.radius_mm);
    ASSERT_TRUE(fit.usable) << fit.message;
    EXPECT_GT(cloud.size(), 3000u);
    EXPECT_LT(all.rms_mm, 3e-4);  // with the rim, where stencils are one-sided
    EXPECT_LT(fit.rms_mm, 3e-5);
    EXPECT_GT(static_cast<double>(fit.n), 0.85 * static_cast<double>(cloud.size()));
    EXPECT_LT((fit.center_mm - c.center_mm).norm(), 6e-5);
    EXPECT_NEAR(fit.radius_mm, c.radius_mm, 6e-5);
  }
}

TEST(Stereo, PredictedSigmaIsTheScatter) {
  const Twin twin = scaled_paper_rig(0.25);
  const RaySurface scene = plane_surface({0, 0, 260}, Eigen::Vector3d(0.1, 0.05, -1).normalized());
  MapOptions options;
  options.noise_px = 0.02;
  const PointCloud cloud = run(twin, scene, options, nullptr);
  ASSERT_GT(cloud.size(), 10000u);
  double sum = 0.0, mean = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto truth = true_point(twin, 0, cloud.q_cam_px[i].cast<double>(), scene);
    const double z = (cloud.p_world_mm[i].norm() - truth->norm()) / static_cast<double>(cloud.sigma_mm[i]);
    sum += z * z;
    mean += z;
  }
  const double n = static_cast<double>(cloud.size());
  std::printf("noise: rms z %.3f, mean z %.4f\n", std::sqrt(sum / n), mean / n);
  EXPECT_LT(std::abs(mean / n), 0.05);
  EXPECT_NEAR(std::sqrt(sum / n), 1.0, 0.03);
}

TEST(Stereo, NothingIsInventedAtDepthSteps) {
  const Twin twin = scaled_paper_rig(0.5);
  // a ball in front of a wall: shadows, occlusions in both cameras, columns that occur twice on a line
  const RaySurface scene = nearest({sphere_surface({0, 0, 250}, 12), plane_surface({0, 0, 300}, {0, 0, -1})});
  for (const bool projector_known : {true, false}) {
    MapOptions options;
    options.shadows = true;
    const CameraDecode left = ideal_decode(twin, 0, scene, options),
                       right = ideal_decode(twin, 1, scene, options);
    Twin rig = twin;
    if (!projector_known) rig.projector.reset();
    TriangulationSummary summary;
    const PointCloud cloud = triangulate_stereo(rig, left, right, &summary);
    std::size_t wrong = 0;
    double largest = 0.0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const auto truth = true_point(twin, 0, cloud.q_cam_px[i].cast<double>(), scene);
      const double d = (cloud.p_world_mm[i] - *truth).norm();
      wrong += d > 0.05;
      largest = std::max(largest, d);
    }
    std::printf(
        "steps (projector %s): %zu of %zu points, ambiguous %zu, rejected %zu, wrong %zu, largest %.3f mm\n",
        projector_known ? "known" : "unknown", cloud.size(), summary.n_candidates, summary.n_ambiguous,
        summary.n_rejected, wrong, largest);
    EXPECT_EQ(summary.n_points + summary.n_no_match + summary.n_rejected, summary.n_candidates);
    EXPECT_GT(cloud.size(), 40000u);
    if (projector_known)
      EXPECT_EQ(wrong, 0u);
    else
      EXPECT_LE(static_cast<double>(wrong), 2e-3 * static_cast<double>(cloud.size()));
  }
}

/// A plate before a wall; its edges stand square to the baseline.
RaySurface plate_before_wall(double plate_z_mm, double wall_z_mm) {
  const RaySurface plate = plane_surface({0, 0, plate_z_mm}, {0, 0, -1});
  return nearest({[=](const Eigen::Vector3d& o, const Eigen::Vector3d& d) -> std::optional<double> {
                    const auto s = plate(o, d);
                    if (!s || std::abs((o + *s * d).x()) > 8.0 || std::abs((o + *s * d).y()) > 10.0)
                      return std::nullopt;
                    return s;
                  },
                  plane_surface({0, 0, wall_z_mm}, {0, 0, -1})});
}

/// Mixes the coordinates of neighbours along x, as a lens does whose point spread reaches them, and adds
/// noise.
void mix_and_add_noise(CameraDecode& decode, double noise_px, double share, unsigned seed) {
  DirectionDecode& d = decode.directions[0];
  const ImageD sharp = d.coordinate_px;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, noise_px);
  for (int y = 0; y < sharp.height; ++y)
    for (int x = 0; x < sharp.width; ++x) {
      const double mixed =
          x == 0 || x + 1 == sharp.width
              ? sharp(x, y)
              : share * sharp(x - 1, y) + (1.0 - 2.0 * share) * sharp(x, y) + share * sharp(x + 1, y);
      if (std::isfinite(mixed)) d.coordinate_px(x, y) = mixed;
      d.coordinate_px(x, y) += noise(random);
      d.coordinate_sigma_px(x, y) = static_cast<float>(noise_px);
    }
}

// Columns jump by 30 and 13 px where camera 1 does not see the wall beside the plate. Its lens makes two
// pixels between of that, and 5 sigma of a third difference are 4.5 px, so that a part of the jump is read as
// a slope: 902 and 500 points lay between plate and wall. 30: a tenth of a pixel for each row of the plate's
// edge.
TEST(Stereo, NothingIsInventedAtDepthStepsWithinTheNoise) {
  const Twin twin = scaled_paper_rig(0.5);
  for (const double plate_z_mm : {290.0, 296.0}) {
    const RaySurface scene = plate_before_wall(plate_z_mm, 300);
    MapOptions options;
    options.shadows = true;
    CameraDecode left = ideal_decode(twin, 0, scene, options), right = ideal_decode(twin, 1, scene, options);
    mix_and_add_noise(left, 0.2, 0.0, 1);
    mix_and_add_noise(right, 0.2, 0.2, 2);
    TriangulationSummary summary;
    const PointCloud cloud = triangulate_stereo(twin, left, right, &summary);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3d truth = true_point(twin, 0, cloud.q_cam_px[i].cast<double>(), scene).value();
      wrong += (cloud.p_world_mm[i] - truth).norm() > 5.0 * static_cast<double>(cloud.sigma_mm[i]) + 0.5;
    }
    std::printf("steps within the noise: %zu of %zu points, no match %zu, rejected %zu, wrong %zu\n",
                cloud.size(), summary.n_candidates, summary.n_no_match, summary.n_rejected, wrong);
    EXPECT_GT(cloud.size(), 325000u);
    EXPECT_LE(wrong, 30u);
  }
}

TEST(Stereo, TwoDirectionsAndTheRightOneForTheBaseline) {
  Twin twin = scaled_paper_rig(0.25);
  const RaySurface scene = sphere_surface({0, 0, 260}, 15);
  for (const auto& axes : {std::vector<Axis>{Axis::x, Axis::y}, {Axis::y, Axis::x}}) {
    MapOptions options;
    options.axes = axes;
    TriangulationSummary summary;
    const PointCloud cloud = run(twin, scene, options, &summary);
    ASSERT_GT(cloud.size(), 2000u);
    EXPECT_LT(summary.residual_rms_px, 0.01);
    const SphereFit fit = fit_sphere(cloud.p_world_mm, {{0, 0, 260}, 15}, {});
    EXPECT_LT(fit.rms_mm, 1e-3);
  }
  // baseline along y: columns cannot tell the depth, rows can
  twin.cameras[1].T_cam_world = pose_from_rt((RotTrans() << -0.35, 0, 0, 0, -95, 15).finished());
  MapOptions options;
  options.axes = {Axis::x, Axis::y};
  twin.projector->T_proj_world = pose_from_rt((RotTrans() << -0.17, 0, 0, 0, -47, 5).finished());
  const PointCloud cloud = run(twin, scene, options, nullptr);
  ASSERT_GT(cloud.size(), 2000u);
  EXPECT_LT(fit_sphere(cloud.p_world_mm, {{0, 0, 260}, 15}, {}).rms_mm, 1e-3);
}

TEST(Stereo, ThreadsChangeNoBit) {
  const Twin twin = scaled_paper_rig(0.25);
  MapOptions options;
  options.noise_px = 0.02;
  const RaySurface scene = nearest({sphere_surface({0, 0, 250}, 12), plane_surface({0, 0, 300}, {0, 0, -1})});
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const PointCloud one = run(twin, scene, options, nullptr);
  omp_set_num_threads(4);
  const PointCloud four = run(twin, scene, options, nullptr);
  omp_set_num_threads(threads);
  EXPECT_TRUE(one.p_world_mm == four.p_world_mm);
  EXPECT_TRUE(one.sigma_mm == four.sigma_mm);
}

TEST(Stereo, EmptyMapsGiveNoPointAndBadRigsAreRefused) {
  Twin twin = scaled_paper_rig(0.1);
  const RaySurface nothing = [](const Eigen::Vector3d&, const Eigen::Vector3d&) {
    return std::optional<double>();
  };
  const CameraDecode empty0 = ideal_decode(twin, 0, nothing), empty1 = ideal_decode(twin, 1, nothing);
  TriangulationSummary summary;
  EXPECT_EQ(triangulate_stereo(twin, empty0, empty1, &summary).size(), 0u);
  EXPECT_EQ(summary.n_candidates, 0u);
  Twin same_place = twin;
  same_place.cameras[1].T_cam_world = twin.cameras[0].T_cam_world;
  EXPECT_THROW(triangulate_stereo(same_place, empty0, empty1), UserError);
  Twin one = twin;
  one.cameras.pop_back();
  EXPECT_THROW(triangulate_stereo(one, empty0, empty1), UserError);
}

}  // namespace
}  // namespace fringetwin::measure::stereo_test
