// SPDX-License-Identifier: Apache-2.0
// The sums of a disc are sums of its rows, and these are differences of running sums: a window costs as many
// steps as it has rows. Running sums cancel; in whole numbers they are exact, so weights are whole numbers,
// too.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "measure/depth_fit.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

constexpr int kTile = 128;        ///< px: side of what one thread works on
constexpr double kGrowth = 1.41;  ///< of the radius from one window to the next
/// Standard errors: intervals of so much must meet for a window to count as grown (datasets/README.md has
/// what others do), and for a pixel to follow its neighbours: beyond that its windows hold another surface.
constexpr double kAgree = 2.0, kFollow = 3.0;
constexpr double kKnownFraction = 0.7;  ///< of a window that must be measured
constexpr double kHalfKnown = 0.5;      ///< the same, of one that is held against another
/// Inverse depths above the least of a tile as whole numbers below 2^28, weights below 2^8: times the square
/// of a place in a tile with what windows reach beside it (270 px at most, 2^16.2) and added up over its row
/// (2^8.1), below 2^61.
constexpr double kWhole = 268435456.0, kMostWeight = 255.0;
constexpr double kSureFraction = 0.9;  ///< of a tile's pixels have less than the most weight

/// Running sums over the known pixels of a row up to a place x, counted from the left of the tile.
struct RunningSums {
  std::array<std::int64_t, 5> x = {};  ///< of weight times x^0 ... x^4
  std::array<std::int64_t, 3> z = {};  ///< of weight times x^0 ... x^2 times the inverse depth
  std::int64_t pixels = 0;
  double variance = 0.0;  ///< of the weights' squares times the variance of the inverse depth
};

/// Sums over a window, powers of x and y counted from its middle.
struct WindowSums {
  std::array<std::array<std::int64_t, 5>, 5> xy = {};  ///< of weight times x^i y^j, i + j <= 4
  std::array<std::array<std::int64_t, 3>, 3> z = {};   ///< the same times the inverse depth, i + j <= 2
  std::int64_t pixels = 0;
  double variance = 0.0;

  /// Returns the variance of a pixel of weight 1, on average: rounded weights, and those that would lie
  /// outside 1 ... 255, are not quite one over a variance.
  double variance_of_unit() const { return variance / static_cast<double>(xy[0][0]); }
};

/// The pixels of a window.
struct Disc {
  int radius;
  std::vector<int> half;  ///< half the width of each row, from the middle row down
  double pixels = 0.0;

  explicit Disc(int radius_px) : radius(radius_px) {
    for (int dy = 0; dy <= radius; ++dy) {
      half.push_back(static_cast<int>(std::floor(std::sqrt(static_cast<double>(radius * radius - dy * dy)))));
      pixels += (dy == 0 ? 1.0 : 2.0) * (2.0 * half.back() + 1.0);
    }
  }
};

/// Running sums of a tile and of what its windows reach beside it.
class Tile {
 public:
  Tile(const InverseDepths& depths, int x0, int y0, int reach)
      : depths_(depths), x0_(x0 - reach), y0_(y0 - reach), side_(kTile + 2 * reach) {
    find_ranges();
    sums_.resize(static_cast<std::size_t>(side_) * (static_cast<std::size_t>(side_) + 1));
    for (int j = 0; j < side_; ++j) {
      RunningSums sum;
      RunningSums* row = &sums_[static_cast<std::size_t>(j) * (static_cast<std::size_t>(side_) + 1)];
      for (int i = 0; i < side_; ++i) {
        row[i] = sum;
        if (is_known(x0_ + i, y0_ + j)) add(i, depths.value.index(x0_ + i, y0_ + j), sum);
      }
      row[side_] = sum;
    }
  }

  /// Returns the inverse depth that a whole number of the sums stands for.
  double depth_of(double whole) const { return least_ + whole / scale_; }
  double slope_of(double whole) const { return whole / scale_; }

  /// Returns the sums of the disc around a pixel of the image.
  WindowSums window(int x, int y, const Disc& disc) const {
    WindowSums out;
    const std::int64_t c = x - x0_;
    for (int dy = -disc.radius; dy <= disc.radius; ++dy) {
      const int w = disc.half[static_cast<std::size_t>(std::abs(dy))];
      const RunningSums* row =
          &sums_[static_cast<std::size_t>(y - y0_ + dy) * (static_cast<std::size_t>(side_) + 1)];
      add_row(row[c - w], row[c + w + 1], c, dy, out);
    }
    return out;
  }

 private:
  /// Adds what lies between two running sums of a row, powers of x counted from c.
  static void add_row(const RunningSums& from, const RunningSums& to, std::int64_t c, std::int64_t dy,
                      WindowSums& out) {
    std::array<std::int64_t, 5> d;
    for (std::size_t k = 0; k < 5; ++k) d[k] = to.x[k] - from.x[k];
    if (d[0] == 0) return;
    const std::int64_t c2 = c * c;
    const std::array<std::int64_t, 5> m = {
        d[0], d[1] - c * d[0], d[2] - 2 * c * d[1] + c2 * d[0],
        d[3] - 3 * c * d[2] + 3 * c2 * d[1] - c2 * c * d[0],
        d[4] - 4 * c * d[3] + 6 * c2 * d[2] - 4 * c2 * c * d[1] + c2 * c2 * d[0]};
    const std::array<std::int64_t, 3> e = {to.z[0] - from.z[0], to.z[1] - from.z[1], to.z[2] - from.z[2]};
    const std::array<std::int64_t, 3> n = {e[0], e[1] - c * e[0], e[2] - 2 * c * e[1] + c2 * e[0]};
    std::int64_t power = 1;
    for (std::size_t j = 0; j < 5; ++j, power *= dy) {
      for (std::size_t i = 0; i + j < 5; ++i) out.xy[i][j] += m[i] * power;
      if (j < 3)
        for (std::size_t i = 0; i + j < 3; ++i) out.z[i][j] += n[i] * power;
    }
    out.pixels += to.pixels - from.pixels;
    out.variance += to.variance - from.variance;
  }

  /// Pixels that have a depth whose noise is stated.
  bool is_known(int x, int y) const {
    return x >= 0 && y >= 0 && x < depths_.value.width && y < depths_.value.height &&
           depths_.certainty(x, y) > 0.0F;
  }

  /// Finds which depths and weights the whole numbers stand for.
  void find_ranges() {
    double most = 0.0;
    std::vector<float> certainties;
    for (int y = y0_; y < y0_ + side_; ++y)
      for (int x = x0_; x < x0_ + side_; ++x) {
        if (!is_known(x, y)) continue;
        least_ = std::min(least_, depths_.value(x, y));
        most = std::max(most, depths_.value(x, y));
        if (y % 4 == 0) certainties.push_back(depths_.certainty(x, y));  // enough to tell what most have
      }
    if (most > least_) scale_ = (kWhole - 1.0) / (most - least_);
    if (!certainties.empty()) sure_ = lower_quantile(certainties, kSureFraction);
  }

  void add(std::int64_t place, std::size_t pixel, RunningSums& sum) const {
    const auto certainty = static_cast<double>(depths_.certainty.data[pixel]);
    const double relative = std::clamp(kMostWeight * std::pow(certainty / sure_, 2), 1.0, kMostWeight);
    const auto weight = static_cast<std::int64_t>(std::lround(relative));
    const std::int64_t z = std::llround((depths_.value.data[pixel] - least_) * scale_);
    std::int64_t power = weight;
    for (std::size_t k = 0; k < 5; ++k, power *= place) {
      sum.x[k] += power;
      if (k < 3) sum.z[k] += power * z;
    }
    ++sum.pixels;
    sum.variance += std::pow(static_cast<double>(weight) / certainty, 2);
  }

  const InverseDepths& depths_;
  int x0_, y0_, side_;
  double least_ = std::numeric_limits<double>::infinity(), scale_ = 1.0;
  double sure_ = 1.0;              ///< certainty that has the most weight
  std::vector<RunningSums> sums_;  ///< rows of side_ + 1
};

/// Returns the quadratic of a window of this radius, by least squares, its variances over one that is given.
DepthFit quadratic(const WindowSums& sums, int radius, const Tile& tile, double over_variance) {
  constexpr std::array<std::array<std::size_t, 2>, 6> kPowers = {
      {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}}};
  using Matrix = Eigen::Matrix<double, 6, 6>;
  const double r = radius;
  const std::array<double, 5> per = {1.0, 1.0 / r, 1.0 / (r * r), 1.0 / (r * r * r), 1.0 / (r * r * r * r)};
  Matrix a;
  Eigen::Matrix<double, 6, 1> b;
  for (std::size_t i = 0; i < 6; ++i) {
    const auto [px, py] = kPowers[i];
    b[static_cast<Eigen::Index>(i)] = static_cast<double>(sums.z[px][py]) * per[px + py];
    for (std::size_t j = 0; j < 6; ++j) {
      const std::size_t qx = px + kPowers[j][0], qy = py + kPowers[j][1];
      a(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          static_cast<double>(sums.xy[qx][qy]) * per[qx + qy];
    }
  }
  const Eigen::LDLT<Matrix> ldlt(a);
  if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) return {};
  const Eigen::Matrix<double, 6, 1> solution = ldlt.solve(b);
  const Eigen::Matrix<double, 6, 3> inverse = ldlt.solve(Eigen::Matrix<double, 6, 3>::Identity());
  const double relative = sums.variance_of_unit() / over_variance;
  return {.inverse_depth = tile.depth_of(solution[0]),
          .slope_x = tile.slope_of(solution[1] * per[1]),
          .slope_y = tile.slope_of(solution[2] * per[1]),
          .curvature = tile.slope_of(2.0 * (solution[3] + solution[5]) * per[2]),
          .leverage = static_cast<float>(inverse(0, 0) * relative),
          .slope_xx = static_cast<float>(inverse(1, 1) * per[2] * relative),
          .slope_xy = static_cast<float>(inverse(1, 2) * per[2] * relative),
          .slope_yy = static_cast<float>(inverse(2, 2) * per[2] * relative),
          .radius_px = static_cast<float>(r)};
}

/// What all windows so far allow a number to be.
struct Interval {
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
  /// Returns whether something is left after `value` +- `halfwidth` is allowed only.
  bool narrow(double value, double halfwidth) {
    least = std::max(least, value - halfwidth);
    most = std::min(most, value + halfwidth);
    return least <= most;
  }
};

/// What a pixel's windows allow its depth and slopes to be.
struct Allowed {
  Interval depth, slope_x, slope_y;
  /// Returns whether something is left after these standard errors around the numbers of a fit are allowed
  /// only.
  bool narrow(const DepthFit& fit, double variance, double standard_errors) {
    const auto width = [&](float of_fit) {
      return standard_errors * std::sqrt(static_cast<double>(of_fit) * variance);
    };
    const bool depth_left = depth.narrow(fit.inverse_depth, width(fit.leverage)),
               x_left = slope_x.narrow(fit.slope_x, width(fit.slope_xx)),
               y_left = slope_y.narrow(fit.slope_y, width(fit.slope_yy));
    return depth_left && x_left && y_left;
  }
};

/// Returns the fit to a disc around a pixel; unknown where less than a share of it is measured.
DepthFit fit_disc(const Tile& tile, int x, int y, const Disc& disc, double least_known,
                  double over_variance) {
  const WindowSums sums = tile.window(x, y, disc);
  if (static_cast<double>(sums.pixels) < least_known * disc.pixels) return {};
  return quadratic(sums, disc.radius, tile, over_variance);
}

/// Calls visit(tile, x, y) for the pixels that have a fit with slopes and a depth whose noise is stated, in
/// parallel by tiles, whose windows reach so far.
template <class Visit>
void for_fitted_pixels(const InverseDepths& depths, const Image<DepthFit>& fits, int reach,
                       const Visit& visit) {
  const int across = (fits.width + kTile - 1) / kTile, down = (fits.height + kTile - 1) / kTile;
  const auto is_fitted = [&](int x, int y) {
    return std::isfinite(fits(x, y).slope_x) && depths.certainty(x, y) > 0.0F;
  };
#pragma omp parallel for schedule(dynamic)
  for (int t = 0; t < across * down; ++t) {
    const int x0 = t % across * kTile, y0 = t / across * kTile;
    const int x1 = std::min(x0 + kTile, fits.width), y1 = std::min(y0 + kTile, fits.height);
    bool any = false;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) any = any || is_fitted(x, y);
    if (!any) continue;
    const Tile tile(depths, x0, y0, reach);
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x)
        if (is_fitted(x, y)) visit(tile, x, y);
  }
}

/// A fit, and how often its window has grown from the first.
struct Grown {
  DepthFit fit;
  std::uint8_t times = 0;
};

/// Lets the window of a pixel grow over these discs, so often at most, while intervals of these standard
/// errors meet and enough is measured.
Grown grow(const Tile& tile, int x, int y, const DepthFit& first, const std::vector<Disc>& discs,
           int most_times, double standard_errors, double variance) {
  Grown grown{.fit = first};
  Allowed allowed;
  allowed.narrow(first, variance, standard_errors);
  while (grown.times < most_times) {
    const DepthFit fit = fit_disc(tile, x, y, discs[grown.times], kKnownFraction, variance);
    if (!fit.known() || !allowed.narrow(fit, variance, standard_errors)) break;
    grown.fit = fit;
    ++grown.times;
  }
  return grown;
}

constexpr std::uint8_t kNotFitted = 255;

/// Returns the median of how often the windows of the fitted pixels around one have grown, itself among them
/// (the lower of two). A window that its noise alone has stopped is small and holds much of that noise; most
/// of its neighbours go on.
int lower_median_around(const Image<std::uint8_t>& growths, int x, int y) {
  constexpr int kReach = 2;
  std::array<int, kNotFitted> counts{};
  int n = 0;
  for (int v = std::max(0, y - kReach); v <= std::min(growths.height - 1, y + kReach); ++v)
    for (int u = std::max(0, x - kReach); u <= std::min(growths.width - 1, x + kReach); ++u)
      if (growths(u, v) != kNotFitted) ++counts[growths(u, v)], ++n;
  int median = 0;
  for (int below = counts[0]; 2 * below < n; below += counts[static_cast<std::size_t>(median)]) ++median;
  return median;
}

/// Returns the radius of the window that a fit is held against, whole px; 0: none.
int other_radius_px(const DepthFit& fit, double smoothing_px) {
  constexpr double kLeast = 2.0;  // that tells a quadratic
  const auto radius_px = static_cast<double>(fit.radius_px);
  if (radius_px < kLeast) return 0;
  const bool has_grown = fit.radius_px > static_cast<float>(smoothing_px);
  const int other = static_cast<int>(std::lround(has_grown ? radius_px / kGrowth : radius_px * kGrowth));
  return has_grown && (other < kLeast || other >= radius_px) ? 0 : other;
}

/// Counts of the pixels up to a place whose neighbours to the right or below lie on another surface.
class StepsOfMap {
 public:
  explicit StepsOfMap(const DepthMap& map) : counts_(map.z_mm.width + 1, map.z_mm.height + 1, 0) {
    const ImageD& z_mm = map.z_mm;
    const auto is_step = [&](int x, int y, int right, int below) {
      if (x + right >= z_mm.width || y + below >= z_mm.height) return false;
      const double z = z_mm(x, y), other = z_mm(x + right, y + below);
      const auto sigma_mm =
          static_cast<double>(std::max(map.sigma_mm(x, y), map.sigma_mm(x + right, y + below)));
      return std::isfinite(z) && std::isfinite(other) && !map.joined(z, other, 1.0, sigma_mm);
    };
    for (int y = 0; y < z_mm.height; ++y)
      for (int x = 0; x < z_mm.width; ++x)
        counts_(x + 1, y + 1) = counts_(x, y + 1) + counts_(x + 1, y) - counts_(x, y) +
                                (is_step(x, y, 1, 0) || is_step(x, y, 0, 1) ? 1 : 0);
  }

  bool any_around(int x, int y, int reach) const {
    const int x0 = std::max(0, x - reach - 1), y0 = std::max(0, y - reach - 1),
              x1 = std::min(counts_.width - 1, x + reach + 1),
              y1 = std::min(counts_.height - 1, y + reach + 1);
    return counts_(x1, y1) - counts_(x0, y1) - counts_(x1, y0) + counts_(x0, y0) > 0;
  }

 private:
  Image<int> counts_;
};

}  // namespace

void grow_windows(const InverseDepths& depths, double smoothing_px, double most_smoothing_px,
                  Image<DepthFit>& fits) {
  std::vector<Disc> discs;
  for (double r = std::max(2.0, smoothing_px * kGrowth); r <= most_smoothing_px + 0.5; r *= kGrowth)
    discs.emplace_back(static_cast<int>(std::lround(std::min(r, most_smoothing_px))));
  if (discs.empty()) return;
  const int most_times = static_cast<int>(discs.size());
  Image<std::uint8_t> growths(fits.width, fits.height, kNotFitted);
  for_fitted_pixels(depths, fits, discs.back().radius, [&](const Tile& tile, int x, int y) {
    growths(x, y) = grow(tile, x, y, fits(x, y), discs, most_times, kAgree, depths.variance(x, y)).times;
  });
  for_fitted_pixels(depths, fits, discs.back().radius, [&](const Tile& tile, int x, int y) {
    fits(x, y) = grow(tile, x, y, fits(x, y), discs, lower_median_around(growths, x, y), kFollow,
                      depths.variance(x, y))
                     .fit;
  });
}

Image<DepthFit> other_fits(const DepthMap& map, double smoothing_px, const Image<DepthFit>& fits) {
  Image<DepthFit> out(fits.width, fits.height, DepthFit{});
  int reach = 0;
  for (const DepthFit& fit : fits.data) reach = std::max(reach, other_radius_px(fit, smoothing_px));
  if (reach == 0) return out;
  std::vector<Disc> discs;  // by radius
  for (int radius = 0; radius <= reach; ++radius) discs.emplace_back(radius);
  const InverseDepths depths(map);
  const StepsOfMap steps(map);
  for_fitted_pixels(depths, fits, reach, [&](const Tile& tile, int x, int y) {
    const int radius = other_radius_px(fits(x, y), smoothing_px);
    if (radius == 0 || steps.any_around(x, y, std::max(radius, static_cast<int>(fits(x, y).radius_px))))
      return;
    const Disc& disc = discs[static_cast<std::size_t>(radius)];
    const DepthFit fit = fit_disc(tile, x, y, disc, kHalfKnown, depths.variance(x, y));
    if (fit.known() && fit.inverse_depth > 0.0) out(x, y) = fit;
  });
  return out;
}

}  // namespace fringetwin::measure
