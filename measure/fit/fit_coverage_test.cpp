// SPDX-License-Identifier: Apache-2.0
// Do the printed standard errors of fits tell the scatter when neighbouring points share their errors?
// clang-format off
// | check                           | tolerance            | origin                                                      |
// |---------------------------------|----------------------|-------------------------------------------------------------|
// | rms of (estimate - truth)/sigma | 0.75 ... 1.35        | 100 draws: 7 %; correlation across block borders: 10 to 15 %; |
// |                                 |                      | t distribution of some 20 blocks: 5 %                       |
// | 95 % intervals hold the truth   | >= 0.86              | the same                                                    |
// | through the chain, noise 1 DN   | 0.6 ... 1.35, >= 0.86 | 20 draws of 4 parameters                                   |
// | the same without noise          | 0.6 ... 1.8, >= 0.72 | rounding alone follows the fringes over more than a block   |
// clang-format on
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "measure/fit/block_covariance.hpp"
#include "measure/fit/fits.hpp"
#include "measure/measurement.hpp"
#include "tests/support/measure/measure_rig.hpp"

namespace fringetwin::measure::fit_coverage_test {
namespace {

using namespace testing;

/// Scores of many draws: (estimate - truth) / sigma.
struct Scores {
  double sum_sq = 0.0;
  int n = 0, inside = 0;
  void add(double error, double sigma) {
    const double z = error / sigma;
    sum_sq += z * z;
    ++n;
    inside += std::abs(z) <= 1.96;
  }
  double rms() const { return std::sqrt(sum_sq / n); }
  double coverage() const { return static_cast<double>(inside) / n; }
};

/// White noise averaged over (2 half + 1)^2 px, unit variance: correlated over that many pixels.
ImageD correlated_noise(int side, int half, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  ImageD white(side + 2 * half, side + 2 * half), out(side, side);
  for (double& v : white.data) v = normal(random);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      double sum = 0.0;
      for (int v = 0; v <= 2 * half; ++v)
        for (int u = 0; u <= 2 * half; ++u) sum += white(x + u, y + v);
      out(x, y) = sum / (2 * half + 1);
    }
  return out;
}

struct Sample {
  std::vector<Eigen::Vector3d> p_mm;
  std::vector<Eigen::Vector2f> q_px;
};

/// The cap of a sphere that a camera sees, one point per pixel of a disc of the given diameter.
Sample cap(const SphereShape& s, int diameter_px, double noise_mm, int half, std::mt19937_64& random) {
  const ImageD noise = correlated_noise(diameter_px, half, random);
  Sample out;
  const double r_px = 0.5 * diameter_px;
  for (int y = 0; y < diameter_px; ++y)
    for (int x = 0; x < diameter_px; ++x) {
      const double u = 0.95 * (x + 0.5 - r_px) / r_px, v = 0.95 * (y + 0.5 - r_px) / r_px;
      if (u * u + v * v > 0.9) continue;
      const Eigen::Vector3d d(u, v, -std::sqrt(1.0 - u * u - v * v));
      out.p_mm.push_back(s.center_mm + (s.radius_mm + noise_mm * noise(x, y)) * d);
      out.q_px.emplace_back(static_cast<float>(x + 300), static_cast<float>(y + 200));
    }
  return out;
}

TEST(FitCoverage, SphereWithErrorsSharedByNeighbours) {
  const SphereShape truth{{0.3, -0.2, 250}, 5.0};
  for (const auto& [diameter_px, half] : {std::pair{80, 1}, std::pair{80, 2}, std::pair{160, 3}}) {
    std::mt19937_64 random(11);
    Scores blocks, independent;
    for (int draw = 0; draw < (diameter_px > 100 ? 40 : 100); ++draw) {
      const Sample s = cap(truth, diameter_px, 0.001, half, random);
      FitOptions o;
      o.loss = RobustLoss::tukey;
      const SphereFit plain = fit_sphere(s.p_mm, truth, o);
      o.block = image_blocks(s.q_px);
      const SphereFit fit = fit_sphere(s.p_mm, truth, o);
      ASSERT_TRUE(fit.usable && plain.usable);
      ASSERT_EQ(fit.radius_mm, plain.radius_mm);  // only the covariance differs
      for (int k = 0; k < 4; ++k) {
        const double error = k < 3 ? fit.center_mm[k] - truth.center_mm[k] : fit.radius_mm - truth.radius_mm;
        blocks.add(error, std::sqrt(fit.covariance(k, k)));
        independent.add(error, std::sqrt(plain.covariance(k, k)));
      }
    }
    std::printf("%d px, correlated over %d px: rms z %.2f (independent %.2f), 95 %% hold %.3f (%.3f)\n",
                diameter_px, 2 * half + 1, blocks.rms(), independent.rms(), blocks.coverage(),
                independent.coverage());
    EXPECT_GT(blocks.rms(), 0.75);
    EXPECT_LT(blocks.rms(), 1.35);
    EXPECT_GE(blocks.coverage(), 0.86);
    EXPECT_GT(independent.rms(), 0.8 * (2 * half + 1));  // what the blocks mend
  }
}

TEST(FitCoverage, PlaneWithErrorsSharedByNeighbours) {
  std::mt19937_64 random(12);
  Scores offset, tilt;
  for (int draw = 0; draw < 100; ++draw) {
    const ImageD noise = correlated_noise(120, 2, random);
    std::vector<Eigen::Vector3d> p;
    std::vector<Eigen::Vector2f> q;
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 120; ++x) {
        p.push_back({0.1 * (x - 59.5), 0.15 * (y - 59.5), 300 + 0.002 * noise(x, y)});
        q.emplace_back(static_cast<float>(x), static_cast<float>(y));
      }
    FitOptions o;
    o.block = image_blocks(q);
    const PlaneFit fit = fit_plane(p, o);
    ASSERT_TRUE(fit.usable);
    offset.add(fit.point_mm.z() - 300.0, fit.offset_sigma_mm);
    for (int j = 0; j < 2; ++j)
      tilt.add(fit.normal[j] / fit.normal.z(), std::sqrt(fit.tilt_covariance(j, j)));
  }
  std::printf("plane: offset rms z %.2f, tilt %.2f\n", offset.rms(), tilt.rms());
  for (const Scores& s : {offset, tilt}) {
    EXPECT_GT(s.rms(), 0.75);
    EXPECT_LT(s.rms(), 1.35);
    EXPECT_GE(s.coverage(), 0.86);
  }
}

TEST(FitCoverage, FewBlocksKeepTheIndependentSigma) {
  std::mt19937_64 random(13);
  const SphereShape truth{{0, 0, 250}, 5.0};
  Sample s = cap(truth, 60, 0.001, 0, random);
  FitOptions o;
  const SphereFit plain = fit_sphere(s.p_mm, truth, o);
  o.block.assign(s.p_mm.size(), 0);
  for (std::size_t i = 0; i < o.block.size(); ++i) o.block[i] = static_cast<int>(i % 5);
  EXPECT_EQ(fit_sphere(s.p_mm, truth, o).covariance, plain.covariance);
}

/// 8-bit images of the sphere at a place of its own, formed per pixel from the pattern's definition.
CameraImages expose(const Twin& twin, std::size_t camera, const SphereShape& sphere, double noise_dn,
                    std::mt19937_64& random) {
  MapOptions options;
  options.shadows = true;
  const CameraDecode truth =
      ideal_decode(twin, camera, sphere_surface(sphere.center_mm, sphere.radius_mm), options);
  std::normal_distribution<double> normal;
  CameraImages images;
  images.camera = twin.cameras[camera].name;
  for (const PatternSpec& pattern : expand_sequence(twin.fringes)) {
    ImageF image(truth.width(), truth.height(), 0.0f);
    for (std::size_t i = 0; i < image.size(); ++i) {
      const double c = truth.directions[0].coordinate_px.data[i];
      double v = std::isfinite(c) ? 150.0 * pattern_value(twin.fringes, pattern, c) : 0.0;
      if (noise_dn > 0.0) v += noise_dn * normal(random);
      image.data[i] = static_cast<float>(std::clamp(std::round(v), 0.0, 255.0));
    }
    images.images.push_back(std::move(image));
  }
  return images;
}

TEST(FitCoverage, ThroughTheWholeChainOnEightBitImages) {
  for (const double noise_dn : {0.0, 1.0}) {
    std::mt19937_64 random(14);
    std::uniform_real_distribution<double> place(-0.3, 0.3);
    Scores scores;
    for (int draw = 0; draw < 20; ++draw) {
      Twin twin = scaled_paper_rig(0.4);
      const SphereShape truth{{place(random), place(random), 250 + place(random)}, 8.0};
      twin.objects = {{"ball", SphereShape{{0, 0, 250}, 8.0}, {}}};
      twin.measure.fits = {{"ball", 2.0}};
      std::vector<CameraImages> images;
      for (std::size_t c = 0; c < 2; ++c) images.push_back(expose(twin, c, truth, noise_dn, random));
      const Measurement m = measure(twin, images);
      ASSERT_TRUE(m.fits.at(0).usable) << m.fits[0].warning;
      const ObjectFit& fit = m.fits[0];
      for (int k = 0; k < 3; ++k)
        scores.add(fit.vectors.at("center_mm")[k] - truth.center_mm[k], fit.vectors.at("center_sigma_mm")[k]);
      scores.add(fit.numbers.at("radius_mm") - truth.radius_mm, fit.numbers.at("radius_sigma_mm"));
    }
    std::printf("chain, noise %.1f DN: rms z %.2f, 95 %% hold %.3f\n", noise_dn, scores.rms(),
                scores.coverage());
    EXPECT_GT(scores.rms(), 0.6);
    EXPECT_LT(scores.rms(), noise_dn > 0.0 ? 1.35 : 1.8);
    EXPECT_GE(scores.coverage(), noise_dn > 0.0 ? 0.86 : 0.72);
  }
}

}  // namespace
}  // namespace fringetwin::measure::fit_coverage_test
