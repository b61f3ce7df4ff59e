// SPDX-License-Identifier: Apache-2.0
// | tolerance    | origin                                                                              |
// |--------------|-------------------------------------------------------------------------------------|
// | 5 % and 10 % | variances over some 9,000 values whose windows overlap (radius 4: 49 pixels, 180    |
// |              | windows apart; standard error of a variance sqrt(2/180) = 10 % at worst, 3 % in     |
// |              | the mean of the draws below), and what Tukey's weights cost beside least squares    |
// |              | (5 % of the variance at a normal distribution)                                      |
// | 1e-9         | a quadratic is told exactly: whole numbers of 2^-28 of a tile's range               |
// | 1e-9 noise   | windows whose pixels are alike: the same sums in another order                      |
// | 4.5 se       | a variance of n draws is known to sqrt(2/n): one false alarm in 1e5                 |
// | 8 %          | of a variance, Tukey's weights: 5 % lost to least squares, and as much again, since |
// |              | weights as they came count each point that chance left far off as a worse one       |
#include "measure/depth_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "measure/fit/robust.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure::depth_fit_test {
namespace {

constexpr int kSize = 128;

/// Returns the depths of 1/z = 1/800 + shape(x, y), each with this noise of 1/z.
DepthMap map_of(const std::function<double(int, int)>& shape, double noise, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  DepthMap map{ImageD(kSize, kSize, 0.0), ImageF(kSize, kSize, 0.0F), 5e-4};
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double z = 1.0 / (1.0 / 800.0 + shape(x, y) + noise * normal(random));
      map.z_mm(x, y) = z;
      map.sigma_mm(x, y) = static_cast<float>(noise * z * z);
    }
  return map;
}

struct Scatter {
  double value = 0.0, slope = 0.0, said_value = 0.0, said_slope = 0.0, radius_px = 0.0;
};

/// Returns the mean squares of what fits inside an image are off by, over the noise of one pixel, beside what
/// the fits say.
Scatter scatter_of(const std::function<double(int, int)>& shape, const std::function<double(int, int)>& slope,
                   double most_px, int border) {
  constexpr double kNoise = 2e-7;
  Scatter s;
  double n = 0.0;
  for (unsigned seed = 1; seed <= 2; ++seed) {
    const Image<DepthFit> fits = fit_depths(map_of(shape, kNoise, seed), 4.0, most_px);
    for (int y = border; y < kSize - border; ++y)
      for (int x = border; x < kSize - border; ++x) {
        const DepthFit& fit = fits(x, y);
        s.value += std::pow((fit.inverse_depth - 1.0 / 800.0 - shape(x, y)) / kNoise, 2);
        s.slope += std::pow((fit.slope_x - slope(x, y)) / kNoise, 2);
        s.said_value += static_cast<double>(fit.leverage);
        s.said_slope += static_cast<double>(fit.slope_xx);
        s.radius_px += static_cast<double>(fit.radius_px);
        n += 1.0;
      }
  }
  for (double* sum : {&s.value, &s.slope, &s.said_value, &s.said_slope, &s.radius_px}) *sum /= n;
  return s;
}

double bowl(int x, int y) { return 1e-9 * (x * x + 0.5 * y * y) + 2e-8 * x; }
double bowl_slope(int x, int) { return 2e-9 * x + 2e-8; }

TEST(DepthFit, SaysWhatNoiseIsLeft) {
  const Scatter s = scatter_of(bowl, bowl_slope, 0.0, 8);
  EXPECT_NEAR(s.value / s.said_value, 1.0, 0.10);
  EXPECT_NEAR(s.slope / s.said_slope, 1.0, 0.10);
  EXPECT_DOUBLE_EQ(s.radius_px, 4.0);
}

TEST(DepthFit, WindowsGrowWhereTheSurfaceIsAQuadratic) {
  const Scatter small = scatter_of(bowl, bowl_slope, 0.0, 24), large = scatter_of(bowl, bowl_slope, 16.0, 24);
  std::printf("depth fit: slopes' variance %.2e -> %.2e (said %.2e), radius %.1f px\n", small.slope,
              large.slope, large.said_slope, large.radius_px);
  EXPECT_GT(large.radius_px, 12.0);
  // a radius of 16 for 4 leaves 1/256 of the variance; where many windows stop early by chance more is left
  EXPECT_LT(large.slope, small.slope / 128.0);
  // 2 draws of 80 x 80 pixels hold 16 windows, whose variance has a standard error of 0.35; seen 0.11. Where
  // each window is as large as its own noise lets it grow, the quotient is 2.6.
  EXPECT_NEAR(large.slope / large.said_slope, 1.0, 0.5);
}

TEST(DepthFit, StepsAndCreasesStayWhereTheyAre) {
  const auto roof = [](int x, int) { return 1e-7 * std::abs(x - kSize / 2); };
  const auto step = [](int x, int) { return x < kSize / 2 ? 0.0 : 2e-6; };
  constexpr double kNoise = 2e-8;
  const DepthMap roofs = map_of(roof, kNoise, 3), steps = map_of(step, kNoise, 4);
  const Image<DepthFit> of_roof = fit_depths(roofs, 3.0, 24.0), of_step = fit_depths(steps, 3.0, 24.0);
  for (int y = 30; y < kSize - 30; y += 7)
    for (const int away : {-12, -8, 8, 12}) {
      const int x = kSize / 2 + away;
      // a window beyond the crease or the step would be off by many times the noise of one pixel
      EXPECT_NEAR(of_roof(x, y).slope_x, away < 0 ? -1e-7 : 1e-7, 0.5 * kNoise) << x;
      EXPECT_NEAR(of_step(x, y).inverse_depth - 1.0 / 800.0, step(x, y), 2.0 * kNoise) << x;
      EXPECT_LE(of_step(x, y).radius_px, static_cast<float>(std::abs(away)) + 4.0F);
    }
}

constexpr double kDrawnNoise = 2e-7;
using Draws = std::vector<Image<DepthFit>>;

/// Returns the fits, with windows that grow, to some draws of a form.
Draws draws_of(const std::function<double(int, int)>& shape) {
  Draws draws;
  for (unsigned seed = 1; seed <= 6; ++seed)
    draws.push_back(fit_depths(map_of(shape, kDrawnNoise, seed), 2.0, 16.0));
  return draws;
}

/// Returns the root mean square of what slopes and depth of a level form are off by at a pixel, over what the
/// fits say.
double errors_at(const Draws& draws, int x, int y) {
  double sum = 0.0;
  for (const Image<DepthFit>& fits : draws) {
    const DepthFit& fit = fits(x, y);
    const auto squared = [](double error, float of_fit) {
      return error * error / (kDrawnNoise * kDrawnNoise * static_cast<double>(of_fit));
    };
    sum += squared(fit.slope_x, fit.slope_xx) + squared(fit.slope_y, fit.slope_yy) +
           squared(fit.inverse_depth - 1.0 / 800.0, fit.leverage);
  }
  return std::sqrt(sum / (3.0 * static_cast<double>(draws.size())));
}

// Neighbours further from the corner of a step, or from a pixel that is far off, have larger windows: a pixel
// follows them as far as its own windows agree within three standard errors, to which its noise adds. Where
// it took the neighbours' windows unseen, it was off by 17 to 46.
TEST(DepthFit, WindowsOfNeighboursReachAcrossNoCornerOrOutlier) {
  constexpr double kOther = 4e-5;  // 200 times the noise
  const Draws corners = draws_of([](int x, int y) { return x >= 64 && y >= 64 ? kOther : 0.0; });
  const Draws spikes = draws_of([](int x, int y) { return x == 64 && y == 64 ? kOther : 0.0; });
  constexpr double kMost = 5.0;
  for (const int away : {1, 2, 3, 5, 8}) EXPECT_LT(errors_at(corners, 64 - away, 64 - away), kMost) << away;
  for (const int away : {3, 4, 6, 8, 10}) EXPECT_LT(errors_at(spikes, 64 + away, 64), kMost) << away;
  EXPECT_LT(errors_at(spikes, 66, 66), kMost);
  const Draws strips = draws_of([](int x, int) { return x >= 64 && x < 67 ? kOther : 0.0; });
  for (const int away : {1, 2, 4, 8}) EXPECT_LT(errors_at(strips, 64 - away, 64), kMost) << away;
}

/// Mean squares of what other windows tell, over what the noise of both windows makes.
struct Differences {
  double value = 0.0, slope = 0.0, n = 0.0;
};
Differences differences_of(const DepthMap& map, double most_px, double noise) {
  const Image<DepthFit> fits = fit_depths(map, 4.0, most_px), others = other_fits(map, 4.0, fits);
  Differences out;
  for (int y = 20; y < kSize - 20; ++y)
    for (int x = 20; x < kSize - 20; ++x) {
      const DepthFit &fit = fits(x, y), &other = others(x, y);
      if (!other.known()) continue;
      out.value += std::pow((other.inverse_depth - fit.inverse_depth) / noise, 2) /
                   std::abs(static_cast<double>(other.leverage - fit.leverage));
      out.slope += std::pow((other.slope_x - fit.slope_x) / noise, 2) /
                   std::abs(static_cast<double>(other.slope_xx - fit.slope_xx));
      out.n += 1.0;
    }
  out.value /= out.n, out.slope /= out.n;
  return out;
}

// The least squares of a window and of one around it: the variance of what they differ in is the difference
// of theirs.
TEST(DepthFit, OtherWindowsTellTheSameOfAQuadratic) {
  constexpr double kNoise = 2e-7, kOfVariance = 0.15;
  for (const double most_px : {4.0, 12.0}) {
    Differences mean;
    for (unsigned seed = 1; seed <= 4; ++seed) {
      const Differences d = differences_of(map_of(bowl, kNoise, seed), most_px, kNoise);
      mean.value += 0.25 * d.value, mean.slope += 0.25 * d.slope, mean.n += d.n;
    }
    std::printf(
        "depth fit: up to %.0f px, difference to other windows over its noise: value %.3f, slope %.3f\n",
        most_px, mean.value, mean.slope);
    EXPECT_EQ(mean.n, 4.0 * (kSize - 40) * (kSize - 40));
    EXPECT_NEAR(mean.value, 1.0, kOfVariance);
    EXPECT_NEAR(mean.slope, 1.0, kOfVariance);
  }
}

// A wave without noise: wider windows flatten its slopes by k^2 (r'^2 - r^2) / 12 more, as least squares over
// discs do, to the next order.
TEST(DepthFit, WiderWindowsSeeWhatIsSmoothedAway) {
  constexpr double kSize2 = 1e-6, kPerPx = 2.0 * std::numbers::pi / 40.0, kNoise = 1e-8;
  const auto wave = [](int x, int) { return kSize2 * std::sin(kPerPx * x); };
  DepthMap map = map_of(wave, 0.0, 1);
  for (float& sigma : map.sigma_mm.data) sigma = static_cast<float>(kNoise * 800.0 * 800.0);
  const Image<DepthFit> fits = fit_depths(map, 4.0, 4.0), others = other_fits(map, 4.0, fits);
  const int x = 80;  // where it is steepest: sin(0) after two periods
  const double slope = kSize2 * kPerPx, flattened = kPerPx * kPerPx * (36.0 - 16.0) / 12.0;
  EXPECT_EQ(others(x, 60).radius_px, 6.0F);
  EXPECT_NEAR((fits(x, 60).slope_x - others(x, 60).slope_x) / slope / flattened, 1.0, 0.1);
}

// A step of 20 mm tells nothing of the surfaces beside it; a window that has grown is held against a narrower
// one, and one that has not against a wider one, whatever its radius rounds to.
TEST(DepthFit, OtherWindowsReachNoStep) {
  constexpr double kNoise = 2e-7;
  constexpr int kEdge = 64;
  DepthMap map = map_of([](int x, int) { return x < kEdge ? 0.0 : 1.0 / 780.0 - 1.0 / 800.0; }, kNoise, 3);
  const Image<DepthFit> fits = fit_depths(map, 4.0, 4.0), others = other_fits(map, 4.0, fits);
  for (int x = kEdge - 8; x < kEdge + 8; ++x)
    EXPECT_EQ(others(x, 60).known(), x < kEdge - 7 || x > kEdge + 6) << x;
  for (const double radius_px : {2.2, 3.4}) {
    const Image<DepthFit> plain = fit_depths(map, radius_px, 0.0);
    EXPECT_GT(other_fits(map, radius_px, plain)(20, 60).radius_px, radius_px) << radius_px;
  }
  const Image<DepthFit> grown = fit_depths(map, 4.0, 12.0);
  EXPECT_GT(grown(20, 60).radius_px, 4.0F);
  EXPECT_LT(other_fits(map, 4.0, grown)(20, 60).radius_px, grown(20, 60).radius_px);
}

TEST(DepthFit, AQuadraticIsToldExactly) {
  const Image<DepthFit> fits = fit_depths(map_of(bowl, 1e-12, 5), 4.0, 16.0);
  for (int y = 20; y < kSize - 20; y += 11)
    for (int x = 20; x < kSize - 20; x += 11) {
      EXPECT_NEAR(fits(x, y).inverse_depth, 1.0 / 800.0 + bowl(x, y), 1e-9 / 800.0);
      EXPECT_NEAR(fits(x, y).slope_x, bowl_slope(x, y), 1e-9 / 800.0);
    }
}

/// Returns the bowl's depths with noise of 1/z that differs from pixel to pixel; what is stated of it, too.
DepthMap uneven_map(const Image<double>& noise, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  DepthMap map{ImageD(noise.width, noise.height, 0.0), ImageF(noise.width, noise.height, 0.0F), 5e-4};
  for (int y = 0; y < noise.height; ++y)
    for (int x = 0; x < noise.width; ++x) {
      const double u = 1.0 / 800.0 + bowl(x, y), z = 1.0 / (u + noise(x, y) * normal(random));
      map.z_mm(x, y) = z;
      map.sigma_mm(x, y) =
          static_cast<float>(noise(x, y) / (u * u));  // as stated: of the pixel, not of its draw
    }
  return map;
}

/// Noise of a dark and a bright texture, grain by grain, `ratio` apart.
Image<double> grains(int size, double ratio) {
  std::mt19937_64 random(11);
  Image<double> noise(size, size, 2e-7);
  for (double& n : noise.data)
    if (random() % 2 == 0) n *= ratio;
  return noise;
}

/// Variances of depth and slope that least squares leave in the middle of a window, from noise like this.
struct Theory {
  double weighted = 0.0, alike = 0.0, weighted_slope = 0.0, alike_slope = 0.0;
};

Theory theory_of(const Image<double>& noise, int x, int y, double radius, Eigen::Index terms) {
  const auto offsets = window_of(radius);
  Eigen::MatrixXd a(static_cast<Eigen::Index>(offsets.size()), terms);
  Eigen::VectorXd variance(a.rows());
  for (Eigen::Index k = 0; k < a.rows(); ++k) {
    const WindowOffset& o = offsets[static_cast<std::size_t>(k)];
    const double dx = o.dx, dy = o.dy;
    Eigen::VectorXd row(6);
    row << 1.0, dx, dy, dx * dx, dx * dy, dy * dy;
    a.row(k) = row.head(terms);
    variance[k] = std::pow(noise(x + o.dx, y + o.dy), 2);
  }
  const Eigen::MatrixXd best = (a.transpose() * variance.cwiseInverse().asDiagonal() * a).inverse();
  const Eigen::MatrixXd plain = (a.transpose() * a).inverse();
  const Eigen::MatrixXd with_plain = plain * a.transpose() * variance.asDiagonal() * a * plain;
  return {best(0, 0), with_plain(0, 0), best(1, 1), with_plain(1, 1)};
}

/// Mean squares over draws of what fits of one kind are off by, beside what theory and fits say of it.
struct Uneven {
  double value = 0.0, slope = 0.0, said_value = 0.0, said_slope = 0.0;
  Theory theory;
  double n = 0.0;
};

/// Returns that of pixels `radius_px` windows apart whose own noise lies in a range; of fits that are told
/// the noise, or none of it.
Uneven uneven_of(const Image<double>& noise, double smoothing_px, Eigen::Index terms, int draws, bool is_told,
                 double least = 0.0, double most = 1.0) {
  Uneven u;
  Image<Theory> theory(noise.width, noise.height, Theory{});
  const int reach = static_cast<int>(smoothing_px), apart = 2 * reach + 1;
  for (int draw = 0; draw < draws; ++draw) {
    DepthMap map = uneven_map(noise, 100U + static_cast<unsigned>(draw));
    if (!is_told) std::ranges::fill(map.sigma_mm.data, 0.0F);
    const Image<DepthFit> fits = fit_depths(map, smoothing_px, 0.0);
    for (int y = reach; y < noise.height - reach; y += apart)
      for (int x = reach; x < noise.width - reach; x += apart) {
        if (noise(x, y) < least || noise(x, y) > most) continue;
        const DepthFit& fit = fits(x, y);
        const double own = noise(x, y) * noise(x, y);
        u.value += std::pow(fit.inverse_depth - 1.0 / 800.0 - bowl(x, y), 2);
        u.slope += std::pow(fit.slope_x - bowl_slope(x, y), 2);
        u.said_value += static_cast<double>(fit.leverage) * own;
        u.said_slope += static_cast<double>(fit.slope_xx) * own;
        Theory& t = theory(x, y);
        if (draw == 0) t = theory_of(noise, x, y, smoothing_px, terms);
        u.theory.weighted += t.weighted, u.theory.alike += t.alike;
        u.theory.weighted_slope += t.weighted_slope, u.theory.alike_slope += t.alike_slope;
        u.n += 1.0;
      }
  }
  for (double* sum : {&u.value, &u.slope, &u.said_value, &u.said_slope, &u.theory.weighted, &u.theory.alike,
                      &u.theory.weighted_slope, &u.theory.alike_slope})
    *sum /= u.n;
  return u;
}

/// 4.5 standard errors of a variance that n squares tell, which are worth fewer where they differ in size.
double draws_tell(double n, double worth = 1.0) { return 4.5 * std::sqrt(2.0 / (n * worth)); }

// Planes over 3 x 3 pixels have no robust weights: theory is exact.
TEST(DepthFit, QuietPixelsCountForMore) {
  for (const double ratio : {2.0, 5.0}) {
    const Image<double> noise = grains(333, ratio);
    const Uneven told = uneven_of(noise, 1.5, 3, 1, true), untold = uneven_of(noise, 1.5, 3, 1, false);
    std::printf(
        "depth fit: noise x %.0f grain by grain: variance of depth over that of equal weights %.3f (theory "
        "%.3f), "
        "of slopes %.3f (%.3f)\n",
        ratio, told.value / untold.value, told.theory.weighted / told.theory.alike, told.slope / untold.slope,
        told.theory.weighted_slope / told.theory.alike_slope);
    // the variances of windows differ by up to ratio^2: a third of the squares are worth the rest
    const double tolerance = draws_tell(told.n, 1.0 / 3.0);
    EXPECT_NEAR(told.value / told.theory.weighted, 1.0, tolerance);
    EXPECT_NEAR(told.slope / told.theory.weighted_slope, 1.0, tolerance);
    EXPECT_NEAR(untold.value / untold.theory.alike, 1.0, tolerance);
    EXPECT_NEAR(told.said_value / told.theory.weighted, 1.0, 1e-3);  // leverages are floats; 1/z has noise
    EXPECT_NEAR(told.said_slope / told.theory.weighted_slope, 1.0, 1e-3);
    EXPECT_LT(told.value, (1.0 + tolerance) * told.theory.weighted / told.theory.alike * untold.value);
  }
}

// Whole quadratics with Tukey's weights: a residual is far off by the noise of its own pixel.
TEST(DepthFit, SaysWhatNoiseIsLeftWherePixelsDiffer) {
  constexpr double kRobust = 0.08;
  for (const double ratio : {2.0, 5.0}) {
    const Image<double> noise = grains(405, ratio);
    for (const bool quiet : {true, false}) {
      const double least = quiet ? 0.0 : 3e-7, most = quiet ? 3e-7 : 1.0;
      const Uneven told = uneven_of(noise, 4.0, 6, 2, true, least, most);
      std::printf(
          "depth fit: noise x %.0f, %s pixels: variance over that said %.3f, of slopes %.3f; over theory "
          "%.3f\n",
          ratio, quiet ? "quiet" : "noisy", told.value / told.said_value, told.slope / told.said_slope,
          told.value / told.theory.weighted);
      const double tolerance = draws_tell(told.n, 0.5) + kRobust;
      EXPECT_NEAR(told.value / told.said_value, 1.0, tolerance);
      EXPECT_NEAR(told.slope / told.said_slope, 1.0, tolerance);
      EXPECT_NEAR(told.value / told.theory.weighted, 1.0, tolerance);
    }
  }
}

// Noise that grows across the map fourfold: one window hardly sees it, a covariance of one noise for all
// does.
TEST(DepthFit, NoiseMayGrowAcrossTheMap) {
  Image<double> noise(405, 405, 0.0);
  for (int y = 0; y < noise.height; ++y)
    for (int x = 0; x < noise.width; ++x) noise(x, y) = 1e-7 * std::exp2(2.0 * x / 404.0);
  const Uneven told = uneven_of(noise, 4.0, 6, 2, true);
  const double tolerance = draws_tell(told.n, 0.5) + 0.08;
  EXPECT_NEAR(told.value / told.said_value, 1.0, tolerance);
  EXPECT_NEAR(told.value / told.theory.weighted, 1.0, tolerance);
}

/// The fit without weights for noise, plainly: as it was until 2026-12.
DepthFit unweighted(const DepthMap& map, int x, int y, double radius) {
  const auto offsets = window_of(radius);
  const auto n = static_cast<Eigen::Index>(offsets.size());
  Eigen::Matrix<double, Eigen::Dynamic, 6> rows(n, 6);
  Eigen::VectorXd value(n), weight = Eigen::VectorXd::Ones(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const WindowOffset& o = offsets[static_cast<std::size_t>(k)];
    const double dx = o.dx, dy = o.dy;
    rows.row(k) << 1.0, dx, dy, dx * dx, dx * dy, dy * dy;
    value[k] = 1.0 / map.z_mm(x + o.dx, y + o.dy);
  }
  for (int pass = 0;; ++pass) {
    const Eigen::Matrix<double, 6, 6> inverse = (rows.transpose() * weight.asDiagonal() * rows).inverse();
    const Eigen::Matrix<double, 6, 1> solution =
        inverse * (rows.transpose() * weight.cwiseProduct(value)).eval();
    if (pass == 2)
      return {.inverse_depth = solution[0],
              .slope_x = solution[1],
              .leverage = static_cast<float>(inverse(0, 0)),
              .slope_yy = static_cast<float>(inverse(2, 2))};
    const Eigen::VectorXd off = value - rows * solution;
    std::vector<double> sizes(off.begin(), off.end());
    const double scale = mad_sigma(sizes);
    for (Eigen::Index k = 0; k < n; ++k) weight[k] = robust_weight(RobustLoss::tukey, off[k] / scale);
  }
}

TEST(DepthFit, WindowsOfAlikePixelsAreFittedAsBefore) {
  constexpr double kNoise = 2e-7;
  DepthMap map = map_of(bowl, kNoise, 6);
  map.z_mm(60, 60) = DepthFit::kUnknown;
  for (std::size_t i = 0; i < map.z_mm.size(); ++i)
    map.sigma_mm.data[i] = static_cast<float>(kNoise * map.z_mm.data[i] * map.z_mm.data[i]);
  DepthMap untold = map;
  std::ranges::fill(untold.sigma_mm.data, 0.0F);
  const Image<DepthFit> told = fit_depths(map, 4.0, 0.0), alike = fit_depths(untold, 4.0, 0.0);
  for (std::size_t i = 0; i < told.size(); ++i) {
    const DepthFit &a = told.data[i], &b = alike.data[i];
    ASSERT_EQ(a.known(), b.known());
    if (!a.known()) continue;
    // sigmas are floats: weights differ by 1e-7, what they make of the noise by as much
    ASSERT_NEAR(a.inverse_depth, b.inverse_depth, 1e-6 * kNoise) << i;
    ASSERT_NEAR(a.slope_x, b.slope_x, 1e-6 * kNoise) << i;
    ASSERT_NEAR(a.leverage, b.leverage, 1e-5F * b.leverage) << i;
    ASSERT_NEAR(a.slope_yy, b.slope_yy, 1e-5F * b.slope_yy) << i;
  }
  for (int y = 6; y < 120; y += 9)
    for (int x = 6; x < 120; x += 9) {
      if (std::hypot(x - 60, y - 60) < 6.0) continue;
      const DepthFit &a = alike(x, y), b = unweighted(map, x, y, 4.0);
      ASSERT_NEAR(a.inverse_depth, b.inverse_depth, 1e-9 * kNoise) << x << ' ' << y;
      ASSERT_NEAR(a.slope_x, b.slope_x, 1e-9 * kNoise) << x << ' ' << y;
      ASSERT_NEAR(a.leverage, b.leverage, 1e-6F * b.leverage) << x << ' ' << y;
      ASSERT_NEAR(a.slope_yy, b.slope_yy, 1e-6F * b.slope_yy) << x << ' ' << y;
    }
}

// No number, zero, infinite, negative: such a pixel counts like the others of its window, and spoils none.
TEST(DepthFit, PixelsOfUnknownNoiseSpoilNothing) {
  const Image<double> noise = grains(64, 3.0);
  const DepthMap map = uneven_map(noise, 8);
  const Image<DepthFit> whole = fit_depths(map, 3.0, 6.0);
  for (const float odd :
       {0.0F, -0.1F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    DepthMap holed = map;
    for (int y = 4; y < 64; y += 8)
      for (int x = 4; x < 64; x += 8) holed.sigma_mm(x, y) = odd;
    const Image<DepthFit> fits = fit_depths(holed, 3.0, 6.0);
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) {
        ASSERT_TRUE(fits(x, y).known());
        ASSERT_TRUE(std::isfinite(fits(x, y).leverage) && fits(x, y).leverage > 0.0F)
            << x << ' ' << y << ' ' << odd;
        ASSERT_TRUE(std::isfinite(fits(x, y).slope_x));
        // by its own noise a pixel is off by 3 grains' noise; 6 of these is more than any of 4096 is off by
        ASSERT_NEAR(fits(x, y).inverse_depth, whole(x, y).inverse_depth, 6.0 * 6e-7);
      }
  }
}

// The discs that grow are weighted, too.
TEST(DepthFit, WindowsGrowWherePixelsDiffer) {
  const Image<double> noise = grains(kSize, 5.0);
  double value = 0.0, said_value = 0.0, slope = 0.0, said_slope = 0.0, weighted = 0.0, alike = 0.0,
         radius_px = 0.0, n = 0.0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Image<DepthFit> fits = fit_depths(uneven_map(noise, seed), 4.0, 11.0);
    for (int y = 24; y < kSize - 24; y += 2)
      for (int x = 24; x < kSize - 24; x += 2) {
        const DepthFit& fit = fits(x, y);
        radius_px += static_cast<double>(fit.radius_px);
        n += 1.0;
        if (fit.radius_px < 11.0F) continue;
        const Theory t = theory_of(noise, x, y, 11.0, 6);
        value += std::pow(fit.inverse_depth - 1.0 / 800.0 - bowl(x, y), 2);
        slope += std::pow(fit.slope_x - bowl_slope(x, y), 2);
        said_value += static_cast<double>(fit.leverage) * noise(x, y) * noise(x, y);
        said_slope += static_cast<double>(fit.slope_xx) * noise(x, y) * noise(x, y);
        weighted += t.weighted_slope, alike += t.alike_slope;
      }
  }
  std::printf(
      "depth fit: grown to %.1f px, slopes' variance %.3f of least squares with equal weights (theory "
      "%.3f)\n",
      radius_px / n, slope / alike, weighted / alike);
  EXPECT_GT(radius_px / n, 9.0);
  // weights are whole numbers up to 255: their rounding costs less than 1 %
  EXPECT_NEAR(said_slope / weighted, 1.0, 0.01);
  // 3 draws of 80 x 80 pixels hold 13 discs each: 4.5 standard errors of a variance of 39 are 1.0; seen 0.1
  EXPECT_LT(slope / weighted, 2.0);
  EXPECT_LT(value / said_value, 2.0);
  EXPECT_LT(slope, 0.5 * alike);
}

}  // namespace
}  // namespace fringetwin::measure::depth_fit_test
