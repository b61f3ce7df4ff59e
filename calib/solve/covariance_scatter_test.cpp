// SPDX-License-Identifier: Apache-2.0
// Does what is measured with a calibration scatter as its covariance says? The paper's rig, 25 boards, 30
// draws of the corners' noise, each solved from the truth.
//
// | check                        | tolerance              | origin                                        |
// |------------------------------|------------------------|-----------------------------------------------|
// | chi2 of n numbers / n        | 1 ± 3 sqrt(2/n) ± 0.03 | 3 standard errors; 0.03: sigma from residuals |
// | rms / sigma of one number    | 1 ± 3 / sqrt(60)       | 3 standard errors of an rms of 30             |
// | noise of the point's picture | 1 ± 3 sqrt(2/n)        | 2000 points                                   |
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "calib/solve/uncertainty.hpp"
#include "tests/support/calib/calib_draws.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::calib::covariance_scatter_test {
namespace {

using testing::CalibrationDraws;
using testing::ProjectorCorners;
using testing::Scatter;

constexpr int kDraws = 30;

/// Covariance of centre (3) and radius (1) of the least-squares sphere through these points.
Eigen::Matrix4d sphere_fit_covariance(const std::vector<Eigen::Vector3d>& p_mm,
                                      const Eigen::Vector3d& center_mm,
                                      const Eigen::MatrixXd& covariance_mm2) {
  const auto n = static_cast<Eigen::Index>(p_mm.size());
  Eigen::MatrixXd X(n, 4), radial = Eigen::MatrixXd::Zero(n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d normal = (p_mm[static_cast<std::size_t>(i)] - center_mm).normalized();
    X.row(i) << normal.transpose(), 1.0;
    radial.block<1, 3>(i, 3 * i) = normal.transpose();
  }
  const Eigen::MatrixXd gain = least_squares(X, radial);
  const Eigen::MatrixXd spread = covariance_mm2 * gain.transpose();
  return gain * spread;
}

/// Least squares of the distances: centre, radius.
Eigen::Vector4d fit_sphere(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector4d& start) {
  Eigen::Vector4d s = start;
  for (int step = 0; step < 20; ++step) {
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (const auto& p : points) {
      const Eigen::Vector3d d = p - s.head<3>();
      Eigen::Vector4d g;
      g << d.normalized(), 1.0;
      normal += g * g.transpose();
      right += g * (d.norm() - s[3]);
    }
    s += Eigen::Vector4d(solve_symmetric(normal, right));
  }
  return s;
}

TEST(CovarianceScatter, PointsAndSpheres) {
  CalibrationDraws draws(ProjectorCorners::measured_by_itself);
  const Uncertainty uncertainty(draws.first());
  EXPECT_LT(uncertainty.shared(), 0.1);
  const Eigen::Vector3d center(5.0, -4.0, 280.0);
  constexpr double kRadiusMm = 15.0;
  std::vector<Eigen::Vector3d> on_sphere;
  for (int ring = 0; ring <= 4; ++ring)  // the side that faces the rig
    for (int k = 0; k < (ring == 0 ? 1 : 12); ++k) {
      const double t = 0.25 * ring, a = 2.0 * M_PI * k / 12.0;
      on_sphere.push_back(center + kRadiusMm * Eigen::Vector3d(std::sin(t) * std::cos(a),
                                                               std::sin(t) * std::sin(a), -std::cos(t)));
    }
  const Eigen::Vector3d p(-15.0, 10.0, 265.0);
  std::vector<Scatter> point, sphere;
  for (const int other : {1, 2}) {
    point.emplace_back(uncertainty.points({p}, {{0}, {other}}));
    sphere.emplace_back(
        sphere_fit_covariance(on_sphere, center, uncertainty.points(on_sphere, {{0}, {other}})));
  }
  for (int draw = 0; draw < kDraws; ++draw) {
    const Calibration c = draws.next();
    for (const int other : {1, 2}) {
      const auto k = static_cast<std::size_t>(other - 1);
      point[k].add(draws.measured_mm(c, other, {p})[0] - draws.carried_mm(c, p));
      const auto measured = draws.measured_mm(c, other, on_sphere);
      Eigen::Vector4d start;
      start << center, kRadiusMm;
      Eigen::Vector4d carried;
      carried << draws.carried_mm(c, center), kRadiusMm;
      sphere[k].add(fit_sphere(measured, start) - carried);
    }
  }
  std::printf("sigma of the radius: %.5f mm (L+R), %.5f mm (L+P)\n", std::sqrt(sphere[0].covariance(3, 3)),
              std::sqrt(sphere[1].covariance(3, 3)));
  point[0].expect_as_predicted("a point, L+R");
  point[1].expect_as_predicted("a point, L+P");
  sphere[0].expect_as_predicted("a sphere, L+R");
  sphere[1].expect_as_predicted("a sphere, L+P");
}

TEST(CovarianceScatter, NoiseOfAPointsOwnPicture) {
  CalibrationDraws draws(ProjectorCorners::measured_by_itself);
  const Calibration& c = draws.first();
  const Uncertainty uncertainty(c);
  const Eigen::Vector3d p(-15.0, 10.0, 265.0);
  constexpr double kSigmaPx = 0.05;
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, kSigmaPx);
  for (const int other : {1, 2}) {
    const auto k = static_cast<std::size_t>(other);
    const Eigen::Matrix3d m =
        uncertainty.point_noise(p, {{0, true, true, kSigmaPx}, {other, true, true, kSigmaPx}});
    const SymmetricFactor factor(m);
    const std::vector<Lens> lenses{c.lens(0), c.lens(other)};
    const std::vector<Pose> poses{Pose{}, c.devices[k].T_device_ref};
    double chi2 = 0.0;
    constexpr int kPoints = 2000;
    for (int i = 0; i < kPoints; ++i) {
      std::vector<Eigen::Vector2d> q;
      for (std::size_t d = 0; d < 2; ++d)
        q.push_back(*lenses[d].project(poses[d] * p) + Eigen::Vector2d(noise(random), noise(random)));
      const Eigen::Vector3d error = *triangulate(lenses, poses, q, p) - p;
      chi2 += error.dot(Eigen::Vector3d(factor.solve(error)));
    }
    EXPECT_NEAR(chi2 / (3.0 * kPoints), 1.0, 3.0 * std::sqrt(2.0 / (3.0 * kPoints)));
  }
}

}  // namespace
}  // namespace fringetwin::calib::covariance_scatter_test
