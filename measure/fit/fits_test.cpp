// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   1e-9 mm      noiseless points, extent 10...100 mm: rounding times conditioning
//   1e-7 mm      the same on a 10 degree cap (condition about 1e3) or 10 m away (coordinates round at 2e-12
//   mm) chi^2        Monte Carlo: the Mahalanobis distance d^2 of the estimated parameters over R runs has
//   mean m and
//                variance 2 m / R; |mean - m| < 4 sqrt(2 m / R), false alarm 6e-5
//   0.1 sigma    bias of robust fits against outliers, in units of the noise
#include "measure/fit/fits.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "measure/fit/robust.hpp"
#include "tests/support/measure/find_planes.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure::fits_test {
namespace {

using Points = std::vector<Eigen::Vector3d>;
using Random = std::mt19937_64;
using testing::find_planes;

double normal(Random& random) { return std::normal_distribution<double>()(random); }
double uniform(Random& random, double a, double b) {
  return std::uniform_real_distribution<double>(a, b)(random);
}

/// Uniform on a cap about -z (towards a viewer at the origin).
Points cap(const SphereShape& s, double half_angle_rad, std::size_t n, double noise_mm, Random& random) {
  Points p;
  for (std::size_t i = 0; i < n; ++i) {
    const double c = uniform(random, std::cos(half_angle_rad), 1.0), a = uniform(random, 0, 2 * M_PI);
    const double r = std::sqrt(1 - c * c);
    const Eigen::Vector3d u(r * std::cos(a), r * std::sin(a), -c);
    p.push_back(s.center_mm + (s.radius_mm + noise_mm * normal(random)) * u);
  }
  return p;
}

Points wall(const Eigen::Vector3d& point, const Eigen::Vector3d& n, double half, std::size_t count,
            double noise_mm, Random& random) {
  const Eigen::Vector3d u = n.unitOrthogonal(), v = n.cross(u);
  Points p;
  for (std::size_t i = 0; i < count; ++i)
    p.push_back(point + uniform(random, -half, half) * u + uniform(random, -half, half) * v +
                noise_mm * normal(random) * n);
  return p;
}

Points pipe(const CylinderShape& c, double half_angle_rad, double half_length, std::size_t n, double noise_mm,
            Random& random) {
  const Eigen::Vector3d u = c.axis.unitOrthogonal(), v = c.axis.cross(u);
  Points p;
  for (std::size_t i = 0; i < n; ++i) {
    const double a = uniform(random, -half_angle_rad, half_angle_rad);
    p.push_back(c.point_mm + uniform(random, -half_length, half_length) * c.axis +
                (c.radius_mm + noise_mm * normal(random)) * (std::cos(a) * u + std::sin(a) * v));
  }
  return p;
}

FitOptions robust(RobustLoss loss = RobustLoss::tukey) {
  FitOptions o;
  o.loss = loss;
  return o;
}

TEST(SphereFit, ExactFromRoughStartsAndWithoutOne) {
  Random random(1);
  const SphereShape truth{{6.567, -5.497, 270.634}, 19.065};
  const Points p = cap(truth, 1.2, 2000, 0.0, random);
  for (const SphereShape& start :
       {truth, SphereShape{{8, -4, 268}, 17}, SphereShape{{0, 0, 250}, 40}, SphereShape{{0, 0, 0}, 0}}) {
    for (const RobustLoss loss : {RobustLoss::none, RobustLoss::huber, RobustLoss::tukey}) {
      const SphereFit fit = fit_sphere(p, start, robust(loss));
      ASSERT_TRUE(fit.usable) << fit.message;
      EXPECT_LT((fit.center_mm - truth.center_mm).norm(), 1e-9);
      EXPECT_NEAR(fit.radius_mm, truth.radius_mm, 1e-9);
      EXPECT_LT(fit.rms_mm, 1e-9);
    }
  }
}

TEST(SphereFit, SmallCapAndFarAway) {
  Random random(2);
  const double ten_degrees = 10 * M_PI / 180;
  for (const Eigen::Vector3d& center : {Eigen::Vector3d(0, 0, 250), Eigen::Vector3d(6000, -5000, 10000)}) {
    const SphereShape truth{center, 19.0};
    const SphereFit fit = fit_sphere(cap(truth, ten_degrees, 5000, 0.0, random), {center, 18.0}, {});
    ASSERT_TRUE(fit.usable) << fit.message;
    EXPECT_LT((fit.center_mm - center).norm(), 1e-7);
    EXPECT_NEAR(fit.radius_mm, 19.0, 1e-7);
  }
}

/// Mean squared Mahalanobis distance of the estimates, from each run's own covariance.
TEST(SphereFit, CovariancePredictsTheScatter) {
  Random random(3);
  const SphereShape truth{{1, 2, 250}, 5.0};
  const int runs = 400;
  for (const double half_angle : {10 * M_PI / 180, 1.2}) {
    double sum = 0.0;
    for (int k = 0; k < runs; ++k) {
      const SphereFit fit = fit_sphere(cap(truth, half_angle, 2000, 0.002, random), truth, {});
      ASSERT_TRUE(fit.usable) << fit.message;
      Eigen::Vector4d d;
      d << fit.center_mm - truth.center_mm, fit.radius_mm - truth.radius_mm;
      sum += d.dot(fit.covariance.inverse() * d);
    }
    // the cap's curvature of the parameters adds a bias of (condition * noise)^2, below 0.1 here
    EXPECT_NEAR(sum / runs, 4.0, 4 * std::sqrt(8.0 / runs) + 0.1) << half_angle;
  }
}

TEST(SphereFit, ThirtyPercentOutliers) {
  Random random(4);
  const SphereShape truth{{6.567, -5.497, 270.634}, 19.065};
  const double noise = 0.01;
  Points p = cap(truth, 1.0, 7000, noise, random);
  // one-sided, as flyers are: anywhere within the gate, mostly behind the surface
  for (const Eigen::Vector3d& q : cap(truth, 1.0, 3000, 0.0, random))
    p.push_back(truth.center_mm + (q - truth.center_mm) * (1.0 - uniform(random, -0.2, 1.8) / 19.065));
  SphereShape start = truth;
  start.center_mm += Eigen::Vector3d(0.3, -0.3, 0.5);
  const SphereFit fit = fit_sphere(p, start, robust());
  ASSERT_TRUE(fit.usable) << fit.message;
  std::printf("30 %% outliers: n %zu of %zu, rms %.4f (noise %.4f), centre off %.5f, radius off %.5f\n",
              fit.n, fit.n_gated, fit.rms_mm, noise, (fit.center_mm - truth.center_mm).norm(),
              fit.radius_mm - 19.065);
  EXPECT_LT((fit.center_mm - truth.center_mm).norm(), 0.2 * noise);
  EXPECT_NEAR(fit.radius_mm, truth.radius_mm, 0.2 * noise);
  // outliers within 4 sigma of the surface (4 % of them, 120) cannot be told from inliers; they are uniform
  // within +-4 sigma, so the rms grows to sqrt((7000 + 120 * 16 / 3) / 7120) = 1.04
  EXPECT_NEAR(fit.rms_mm, noise, 0.05 * noise);
  EXPECT_GT(fit.n, 6990u);
  EXPECT_LT(fit.n, 7200u);
  EXPECT_EQ(fit.n_gated, 10000u);
  EXPECT_GT(fit_sphere(p, start, {}).rms_mm, 10 * noise);  // and without robustness it would fail
}

TEST(SphereFit, TooLittleIsSaid) {
  const SphereShape start{{0, 0, 250}, 5};
  Random random(5);
  const Points four = {{5, 0, 250}, {-5, 0, 250}, {0, 5, 250}, {0, 0, 245}};
  EXPECT_FALSE(fit_sphere({}, start, {}).usable);
  const SphereFit three = fit_sphere({four.begin(), four.begin() + 3}, start, robust());
  EXPECT_FALSE(three.usable);
  EXPECT_EQ(three.n, 3u);
  EXPECT_NE(three.message.find("at least 4"), std::string::npos);
  const SphereFit exact = fit_sphere(four, start, {});
  EXPECT_TRUE(exact.usable) << exact.message;
  EXPECT_NEAR(exact.radius_mm, 5.0, 1e-9);
  EXPECT_TRUE(std::isnan(exact.covariance(3, 3)));  // no redundancy, no uncertainty
  for (const RobustLoss loss : {RobustLoss::none, RobustLoss::tukey}) {
    EXPECT_FALSE(fit_sphere(Points(100, {1, 2, 250}), start, robust(loss)).usable);
    Points line;
    for (int i = 0; i < 100; ++i) line.push_back({0.1 * i, 0, 245});
    EXPECT_FALSE(fit_sphere(line, start, robust(loss)).usable);
    EXPECT_FALSE(fit_sphere(wall({0, 0, 245}, {0, 0, 1}, 5, 1000, 0.0, random), start, robust(loss)).usable);
    Points bad = cap(start, 1.0, 100, 0.0, random);
    bad[7].y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(fit_sphere(bad, start, robust(loss)).usable);
  }
}

TEST(SphereFit, ManyPoints) {
  Random random(6);
  const SphereShape truth{{0, 0, 250}, 50};
  const Points p = cap(truth, 1.0, 300'000, 0.01, random);
  const auto start = std::chrono::steady_clock::now();
  const SphereFit fit = fit_sphere(p, {{0.5, 0.5, 250.5}, 49.5}, robust());
  const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("300,000 points: %.2f s\n", s);
  ASSERT_TRUE(fit.usable) << fit.message;
  EXPECT_LT((fit.center_mm - truth.center_mm).norm(),
            5 * std::sqrt(fit.covariance.topLeftCorner<3, 3>().trace()));
  EXPECT_NEAR(fit.radius_mm, 50, 5 * std::sqrt(fit.covariance(3, 3)));
}

TEST(PlaneFit, ExactAndFacesTheViewer) {
  Random random(10);
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(3, 4, 250), Eigen::Vector3d(7000, -2000, 10000)}) {
    const Eigen::Vector3d n = Eigen::Vector3d(0.3, -0.2, -1).normalized();
    const PlaneFit fit = fit_plane(wall(at, n, 50, 3000, 0.0, random), {});
    ASSERT_TRUE(fit.usable) << fit.message;
    EXPECT_LT(fit.rms_mm, 1e-9);
    EXPECT_LT(std::abs(n.dot(fit.point_mm - at)), 1e-9);
    EXPECT_LT((fit.normal - n).norm(), 1e-10);  // n faces the origin: n.at < 0
  }
}

TEST(PlaneFit, CovariancePredictsTheScatter) {
  Random random(11);
  const Eigen::Vector3d n(0, 0, -1), at(0, 0, 250);
  const int runs = 1000;
  double offset = 0.0, tilt = 0.0;
  for (int k = 0; k < runs; ++k) {
    Points p = wall(at, n, 20, 500, 0.01, random);
    for (Eigen::Vector3d& q : p) q.x() *= 3.0;  // distinct principal directions: x long, y short
    const PlaneFit fit = fit_plane(p, {});
    offset += std::pow(n.dot(fit.point_mm - at) / fit.offset_sigma_mm, 2);
    tilt += std::pow(fit.normal.x(), 2) / fit.tilt_covariance(0, 0) +
            std::pow(fit.normal.y(), 2) / fit.tilt_covariance(1, 1);
  }
  EXPECT_NEAR(offset / runs, 1.0, 4 * std::sqrt(2.0 / runs));
  EXPECT_NEAR(tilt / runs, 2.0, 4 * std::sqrt(4.0 / runs));
}

TEST(PlaneFit, OutliersAndDegenerateSets) {
  Random random(12);
  const Eigen::Vector3d n = Eigen::Vector3d(0.2, 0.1, -1).normalized(), at(0, 0, 260);
  Points p = wall(at, n, 40, 7000, 0.01, random);
  for (const Eigen::Vector3d& q : wall(at, n, 40, 3000, 0.0, random))
    p.push_back(q + uniform(random, -0.1, 2.0) * n);
  const PlaneFit fit = fit_plane(p, robust());
  ASSERT_TRUE(fit.usable) << fit.message;
  EXPECT_LT(std::abs(n.dot(fit.point_mm - at)), 0.001);
  EXPECT_LT((fit.normal - n).norm(), 0.001 / 40);
  EXPECT_NEAR(fit.rms_mm, 0.01, 0.0005);

  const Points three = {{0, 0, 250}, {1, 0, 250}, {0, 1, 250}};
  EXPECT_TRUE(fit_plane(three, {}).usable);
  EXPECT_TRUE(std::isnan(fit_plane(three, {}).offset_sigma_mm));
  EXPECT_FALSE(fit_plane({three.begin(), three.begin() + 2}, {}).usable);
  Points line;
  for (int i = 0; i < 100; ++i) line.push_back({0.1 * i, 0.2 * i, 245 + 0.3 * i});
  EXPECT_FALSE(fit_plane(line, {}).usable);
  EXPECT_FALSE(fit_plane(line, robust()).usable);
  EXPECT_FALSE(fit_plane(Points(50, {1, 2, 3}), robust()).usable);
}

TEST(CylinderFit, ExactFromRoughStarts) {
  Random random(20);
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(5, -3, 260), Eigen::Vector3d(6000, -5000, 10000)}) {
    const CylinderShape truth{at, Eigen::Vector3d(0.1, 1, 0.05).normalized(), 12.0, {}};
    const Points p = pipe(truth, 1.0, 20, 3000, 0.0, random);
    CylinderShape start = truth;
    start.axis = Eigen::Vector3d(0, 1, 0);
    start.radius_mm = 10;
    start.point_mm += Eigen::Vector3d(1, 10, -1);
    for (const RobustLoss loss : {RobustLoss::none, RobustLoss::tukey}) {
      const CylinderFit fit = fit_cylinder(p, start, robust(loss));
      ASSERT_TRUE(fit.usable) << fit.message;
      EXPECT_NEAR(fit.radius_mm, 12.0, 1e-8);
      EXPECT_LT((fit.axis - truth.axis).norm(), 1e-9);
      EXPECT_LT((fit.point_mm - at).cross(truth.axis).norm(), 1e-8);
    }
  }
}

TEST(CylinderFit, CovariancePredictsTheScatter) {
  Random random(21);
  const CylinderShape truth{{0, 0, 260}, {0, 1, 0}, 12.0, {}};
  const int runs = 400;
  double radius = 0.0, axis = 0.0, shift = 0.0;
  for (int k = 0; k < runs; ++k) {
    const CylinderFit fit = fit_cylinder(pipe(truth, 0.8, 15, 1000, 0.005, random), truth, {});
    ASSERT_TRUE(fit.usable) << fit.message;
    radius += std::pow((fit.radius_mm - 12.0) / fit.radius_sigma_mm, 2);
    axis += (fit.axis - truth.axis).squaredNorm() / fit.tilt_covariance.trace();
    shift += std::pow(fit.point_mm.x(), 2) / fit.shift_covariance(0, 0) +
             std::pow(fit.point_mm.z() - 260.0, 2) / fit.shift_covariance(2, 2);
  }
  EXPECT_NEAR(radius / runs, 1.0, 4 * std::sqrt(2.0 / runs));
  EXPECT_NEAR(axis / runs, 1.0, 4 * std::sqrt(2.0 / runs));
  EXPECT_NEAR(shift / runs, 2.0, 4 * std::sqrt(4.0 / runs));
}

TEST(CylinderFit, OutliersAndDegenerateSets) {
  Random random(22);
  const CylinderShape truth{{0, 0, 260}, {0, 1, 0}, 12.0, {}};
  Points p = pipe(truth, 0.8, 15, 7000, 0.01, random);
  for (const Eigen::Vector3d& q : pipe(truth, 0.8, 15, 3000, 0.0, random))
    p.push_back(q + uniform(random, -0.2, 1.8) * Eigen::Vector3d(q.x(), 0, q.z() - 260).normalized());
  const CylinderFit fit = fit_cylinder(p, truth, robust());
  ASSERT_TRUE(fit.usable) << fit.message;
  EXPECT_NEAR(fit.radius_mm, 12.0, 0.004);
  EXPECT_NEAR(fit.rms_mm, 0.01, 0.0005);
  Points line;
  for (int i = 0; i < 100; ++i) line.push_back({0, 0.2 * i, 248});
  EXPECT_FALSE(fit_cylinder(line, truth, {}).usable);
  EXPECT_FALSE(fit_cylinder(Points(50, {1, 2, 3}), truth, {}).usable);
  EXPECT_FALSE(fit_cylinder({p.begin(), p.begin() + 4}, truth, {}).usable);
  EXPECT_FALSE(fit_cylinder(wall({0, 0, 248}, {0, 0, 1}, 5, 1000, 0.0, random), truth, {}).usable);
}

TEST(Robust, ScaleAndWeights) {
  Random random(30);
  std::vector<double> r(100001);
  for (double& x : r) x = 0.5 * normal(random);
  EXPECT_NEAR(mad_sigma(r), 0.5, 0.5 * 4 * 1.17 / std::sqrt(1e5));  // efficiency of the MAD: 37 %
  EXPECT_TRUE(std::isnan(mad_sigma(std::span<double>())));
  EXPECT_EQ(robust_weight(RobustLoss::none, 1e9), 1.0);
  EXPECT_EQ(robust_weight(RobustLoss::huber, 1.0), 1.0);
  EXPECT_DOUBLE_EQ(robust_weight(RobustLoss::huber, -2.69), 0.5);
  EXPECT_EQ(robust_weight(RobustLoss::tukey, 4.7), 0.0);
  EXPECT_EQ(robust_weight(RobustLoss::tukey, 0.0), 1.0);
}

TEST(FindPlanes, TwoLargestInClutterInOrder) {
  Random random(40);
  const Eigen::Vector3d n1 = Eigen::Vector3d(0.1, 0, -1).normalized(),
                        n2 = Eigen::Vector3d(-0.3, 0.2, -1).normalized();
  Points p = wall({0, 0, 1210}, n1, 150, 200000, 0.7, random);
  const Points second = wall({100, 50, 1350}, n2, 200, 80000, 0.5, random);
  p.insert(p.end(), second.begin(), second.end());
  for (int i = 0; i < 120000; ++i)
    p.push_back({uniform(random, -200, 200), uniform(random, -200, 200), uniform(random, 1000, 1500)});
  std::vector<std::vector<std::size_t>> inliers;
  const auto start = std::chrono::steady_clock::now();
  const auto planes = find_planes(p, 2, 3.0, &inliers);
  std::printf("planes: %.2f s\n",
              std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  ASSERT_EQ(planes.size(), 2u);
  EXPECT_LT((planes[0].normal - n1).norm(), 1e-3);
  EXPECT_LT((planes[1].normal - n2).norm(), 1e-3);
  EXPECT_EQ(planes[0].n, inliers[0].size());
  EXPECT_GT(planes[0].n, 199000u);
  EXPECT_NEAR(planes[0].rms_mm, 0.7, 0.07);  // clutter within 3 mm adds a little
  EXPECT_NEAR(planes[1].rms_mm, 0.5, 0.09);
  const auto again = find_planes(p, 2, 3.0);
  EXPECT_EQ(again[1].point_mm, planes[1].point_mm);  // same seed, same bits
  EXPECT_TRUE(find_planes({}, 2, 3.0).empty());
  EXPECT_TRUE(find_planes(Points(10, {1, 2, 3}), 2, 3.0).empty());
}

}  // namespace
}  // namespace fringetwin::measure::fits_test
