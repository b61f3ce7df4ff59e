// SPDX-License-Identifier: Apache-2.0
#include "compare/phase/phase_budget.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "compare/gray/gray_pair.hpp"
#include "compare/phase/phase_rows.hpp"
#include "compare/phase/texture_shift.hpp"
#include "measure/decode/phase.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::compare {
namespace {

using measure::DirectionDecode;

constexpr int kBlock = 16;  ///< px; slower than this is low frequency
constexpr std::size_t kFewestInBlock = 64;
constexpr int kGradientOver = 8;   ///< px, between which the width of the fringes is seen
constexpr int kEveryGradient = 7;  ///< pixel, in both directions
constexpr int kBlocksAtOnce = 512;
constexpr std::uint64_t kFewestOfPlane = 16;  ///< pixels of a block
constexpr double kNoPlane = 1e-6;             ///< of the sums of squares: pixels of one line
constexpr std::uint64_t kFewestPixels = 1000;
constexpr double kSteep = 0.1;       ///< of a pixel's noise: a shift by texture that may add up
constexpr Eigen::Index kBatch = 64;  ///< pixels per update of the normal matrix

/// The pitches whose phases are in the coordinate: heterodyne takes the mean of all, the others the finest.
/// Basis: 1, then cos and sin of the orders 1 and 2 of each pitch (brightness), then of the alias order and
/// its double (harmonics; instead of the others where the alias order is 1).
struct Ripple {
  std::vector<double> pitch_px, origin_px;
  int order = 1;

  bool has_brightness() const { return order > 2; }
  /// 1 and the brightness orders.
  int leading() const { return 1 + (has_brightness() ? per_group() : 0); }
  int size() const { return leading() + per_group(); }
  int per_group() const { return 4 * static_cast<int>(pitch_px.size()); }
  void basis(double x_px, double* f) const {
    *f++ = 1.0;
    double* harmonics = has_brightness() ? f + per_group() : f;
    for (std::size_t p = 0; p < pitch_px.size(); ++p) {
      const double angle = kTwoPi * (x_px - origin_px[p]) / pitch_px[p];
      const Turn one{std::cos(angle), std::sin(angle)};
      if (has_brightness()) f = put(one, f);
      Turn high = one;
      for (int k = 1; k < order; ++k) high = high.by(one);
      harmonics = put(high, harmonics);
    }
  }

 private:
  /// cos and sin of an angle; higher orders by multiplication, as one sine costs more than all of them.
  struct Turn {
    double c, s;
    Turn by(const Turn& o) const { return {c * o.c - s * o.s, s * o.c + c * o.s}; }
  };
  /// A turn and its double.
  static double* put(const Turn& t, double* f) {
    const Turn twice = t.by(t);
    *f++ = t.c, *f++ = t.s, *f++ = twice.c, *f++ = twice.s;
    return f;
  }
};

struct RippleSums {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
  double d = 0.0, d2 = 0.0, noise = 0.0;
  double information = 0.0;  ///< sum of the squares of the weights
  std::uint64_t n = 0;
};

class PhaseBudgetFit {
 public:
  PhaseBudgetFit(const DirectionDecode& real, const DirectionDecode& simulated, Ripple ripple)
      : real_(real),
        simulated_(simulated),
        ripple_(std::move(ripple)),
        difference_(phase_difference(real, simulated)) {
    per_px_ = kTwoPi / real.pitches_px[real.finest];
  }

  std::optional<PhaseBudget> run() {
    const RippleSums sums = add_rows();
    if (sums.n < kFewestPixels) return std::nullopt;
    PhaseBudget out;
    const auto n = static_cast<double>(sums.n);
    out.n = sums.n;
    out.alias_order = ripple_.order;
    out.total_rad2 = sums.d2 / n;
    out.offset_rad2 = std::pow(sums.d / n, 2);
    out.noise_rad2 = sums.noise / n;
    const int leading = ripple_.leading();
    const double by_brightness = solve(sums, leading);
    const double by_all = solve(sums, ripple_.size());
    if (ripple_.has_brightness()) out.brightness_rad2 = std::max(0.0, by_brightness / n - out.offset_rad2);
    out.harmonic_rad2 = std::max(0.0, by_all / n - out.offset_rad2 - out.brightness_rad2);
    out.harmonic_amplitude_rad = std::hypot(solution_[leading], solution_[leading + 1]);
    out.low_frequency_rad2 = low_frequency() / n;
    out.high_frequency_rad2 = out.total_rad2 - out.offset_rad2 - out.brightness_rad2 - out.harmonic_rad2 -
                              out.noise_rad2 - out.low_frequency_rad2;
    return out;
  }

  std::optional<RippleTest> test(ImageU8 interior, const TextureShift& texture) {
    leave_out_steep_texture(texture.largest_rad, interior);
    const RippleSums sums = add_blocks(interior);
    if (sums.n < kFewestPixels) return std::nullopt;
    RippleTest out{.order = ripple_.order,
                   .strongest = ripple_.order,
                   .functions = ripple_.per_group(),
                   .information = sums.information};
    const int leading = ripple_.leading();
    const double by_leading = ripple_.has_brightness() ? solve(sums, leading) : 0.0;
    if (ripple_.has_brightness()) out.brightness_chi2 = by_leading / out.functions;
    out.harmonic_chi2 = std::max(0.0, solve(sums, ripple_.size()) - by_leading) / out.functions;
    double single = 0.0, twice = 0.0;
    for (int k = leading; k < ripple_.size(); k += 4) {
      single += solution_.segment<2>(k).squaredNorm();
      twice += solution_.segment<2>(k + 2).squaredNorm();
    }
    out.strongest = (twice > single ? 2 : 1) * out.order;
    return out;
  }

 private:
  /// A texture that changes within a pixel moves its phase with the fringe, and more so at a finer pitch.
  void leave_out_steep_texture(const ImageF& shift_rad, ImageU8& interior) const {
    for (std::size_t i = 0; i < interior.size(); ++i)
      if (std::pow(static_cast<double>(shift_rad.data[i]), 2) > kSteep * kSteep * noise_variance(i))
        interior.data[i] = 0;
  }

  /// Solves least squares on the first `used` functions and returns by how much they lower the sum of
  /// squares.
  double solve(const RippleSums& sums, int used) {
    Eigen::MatrixXd normal = sums.normal.topLeftCorner(used, used);
    // a trace of damping: a part narrower than one ripple cannot tell it from a constant
    normal.diagonal().array() += 1e-9 * normal.trace() / used;
    const Eigen::VectorXd right = sums.right.head(used);
    solution_ = solve_symmetric(normal, right);
    return 2.0 * solution_.dot(right) - solution_.dot(sums.normal.topLeftCorner(used, used) * solution_);
  }

  static double variance_px2(const DirectionDecode& side, std::size_t i) {
    const double sigma = side.coordinate_sigma_px.data[i];
    return std::isfinite(sigma) ? sigma * sigma : 0.0;
  }
  double noise_variance(std::size_t i) const {
    return per_px_ * per_px_ * (variance_px2(real_, i) + variance_px2(simulated_, i));
  }
  /// Returns the place in the projector's image where a pixel's ripple is: the mean of both sides, each
  /// weighed by its noise, the noise of which has nothing to do with that of their difference. Taken at the
  /// place of one side, noise itself ripples where phases that ripple crowd (docs/metrics/verdict.md).
  double place_px(std::size_t i) const {
    const double r = variance_px2(real_, i), s = variance_px2(simulated_, i);
    const double x = real_px(i);
    return r > 0.0 ? x + r / (r + s) * (static_cast<double>(simulated_.coordinate_px.data[i]) - x) : x;
  }
  double real_px(std::size_t i) const { return static_cast<double>(real_.coordinate_px.data[i]); }

  /// What is smooth in a block of pixels: its side, and the functions 1, x, y, or 1 alone where two fringes
  /// of the widest pitch do not fit into the image: a plane would take most of a ripple of one per fringe.
  struct Smooth {
    int side, functions;
  };
  Smooth smooth_blocks(const ImageU8& interior) const {
    std::vector<double> per_pixel;  // projector px; over a distance, so that noise does not count
    for (int y = 0; y + kGradientOver < difference_.height; y += kEveryGradient)
      for (int x = 0; x + kGradientOver < difference_.width; x += kEveryGradient) {
        const double here = real_.coordinate_px(x, y),
                     g = std::hypot(real_.coordinate_px(x + kGradientOver, y) - here,
                                    real_.coordinate_px(x, y + kGradientOver) - here) /
                         kGradientOver;
        if (interior(x, y) != 0 && std::isfinite(g)) per_pixel.push_back(g);
      }
    if (per_pixel.empty()) return {kBlock, 3};
    const auto middle = per_pixel.begin() + static_cast<std::ptrdiff_t>(per_pixel.size() / 2);
    std::ranges::nth_element(per_pixel, middle);
    const double two_fringes = 2.0 * *std::ranges::max_element(ripple_.pitch_px) / std::max(*middle, 1e-9);
    const int all = std::max(difference_.width, difference_.height);
    if (two_fringes > all) return {all, 1};
    return {std::max(kBlock, static_cast<int>(two_fringes)), 3};
  }

  /// Adds up the normal equations over the interior, each pixel weighted by its noise, blocks in order: the
  /// same for any number of threads. What fringes that lie elsewhere leave in a block, a plane, is projected
  /// out of difference and ripples: camera pixels sample some ripples so that they look as slow as that.
  RippleSums add_blocks(const ImageU8& interior) const {
    const Smooth smooth = smooth_blocks(interior);
    const int m = ripple_.size(), across = (difference_.width + smooth.side - 1) / smooth.side,
              n_blocks = across * ((difference_.height + smooth.side - 1) / smooth.side);
    RippleSums sums{Eigen::MatrixXd::Zero(m, m), Eigen::VectorXd::Zero(m)};
    for (int first = 0; first < n_blocks; first += kBlocksAtOnce) {
      std::vector<RippleSums> blocks(static_cast<std::size_t>(std::min(kBlocksAtOnce, n_blocks - first)));
#pragma omp parallel for schedule(dynamic)
      for (std::size_t k = 0; k < blocks.size(); ++k) {
        const int b = first + static_cast<int>(k);
        blocks[k] = block_sums(interior, b % across * smooth.side, b / across * smooth.side, smooth);
      }
      for (const RippleSums& block : blocks) {
        if (block.right.size() == 0) continue;
        sums.n += block.n;
        sums.information += block.information;
        sums.normal += block.normal;
        sums.right += block.right;
      }
    }
    return sums;
  }

  /// Returns the sums of a block, empty where too few pixels tell what is smooth.
  RippleSums block_sums(const ImageU8& interior, int x0, int y0, const Smooth& smooth) const {
    const int m = ripple_.size(), f_smooth = smooth.functions,
              every = row_step(difference_.width, difference_.height);
    RippleSums s;
    // of each pixel the ripples, what is smooth and the difference, to be added up as one matrix
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(m + f_smooth + 1, m + f_smooth + 1),
                    f(m + f_smooth + 1, kBatch);
    Eigen::Index filled = 0;
    const auto add_batch = [&] {
      all.selfadjointView<Eigen::Lower>().rankUpdate(f.leftCols(filled));
      filled = 0;
    };
    for (int y = y0; y < std::min(y0 + smooth.side, difference_.height); ++y) {
      if (y % every != 0) continue;
      for (int x = x0; x < std::min(x0 + smooth.side, difference_.width); ++x) {
        const auto d = static_cast<double>(difference_(x, y));
        const std::size_t i = difference_.index(x, y);
        const double noise = noise_variance(i);
        if (std::isnan(d) || interior(x, y) == 0 ||
            !(noise > 0.0 && std::isfinite(real_.coordinate_sigma_px.data[i])))
          continue;
        const double weight = 1.0 / std::sqrt(noise), half = 0.5 * smooth.side;
        const double plane[] = {1.0, (x - x0) / half - 1.0, (y - y0) / half - 1.0};
        ripple_.basis(place_px(i), f.col(filled).data());
        for (int k = 0; k < f_smooth; ++k) f(m + k, filled) = plane[k];
        f(m + f_smooth, filled) = d;
        f.col(filled) *= weight;
        s.information += weight * weight;
        ++s.n;
        if (++filled == kBatch) add_batch();
      }
    }
    add_batch();
    all = Eigen::MatrixXd(all.selfadjointView<Eigen::Lower>());
    const Eigen::MatrixXd own = all.block(m, m, f_smooth, f_smooth);
    const Eigen::VectorXd size = symmetric_eigen(own).values;
    if (s.n < kFewestOfPlane || !(size[0] > kNoPlane * size[f_smooth - 1])) return {};
    const Eigen::MatrixXd by_smooth = solve_symmetric(own, all.block(m, 0, f_smooth, m));
    s.normal = all.topLeftCorner(m, m) - all.block(0, m, m, f_smooth) * by_smooth;
    s.right =
        all.block(0, m + f_smooth, m, 1) - by_smooth.transpose() * all.block(m, m + f_smooth, f_smooth, 1);
    return s;
  }

  /// Adds up the normal equations, rows in order: the same for any number of threads.
  RippleSums add_rows() const {
    const int height = difference_.height, m = ripple_.size();
    std::vector<RippleSums> rows(static_cast<std::size_t>(height));
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; ++y) {
      RippleSums& s = rows[y];
      s.normal = Eigen::MatrixXd::Zero(m, m);
      s.right = Eigen::VectorXd::Zero(m);
      // pixels are added in batches: one update of the matrix for many
      Eigen::MatrixXd f(m, kBatch);
      Eigen::VectorXd differences(kBatch);
      Eigen::Index filled = 0;
      const auto add_batch = [&] {
        s.normal.selfadjointView<Eigen::Lower>().rankUpdate(f.leftCols(filled));
        s.right += f.leftCols(filled) * differences.head(filled);
        filled = 0;
      };
      for (int x = 0; x < difference_.width; ++x) {
        const auto d = static_cast<double>(difference_(x, y));
        if (std::isnan(d)) continue;
        const std::size_t i = difference_.index(x, y);
        ripple_.basis(real_px(i), f.col(filled).data());
        differences[filled] = d;
        s.d += d, s.d2 += d * d, s.noise += noise_variance(i);
        ++s.n;
        if (++filled == kBatch) add_batch();
      }
      add_batch();
    }
    RippleSums sums{Eigen::MatrixXd::Zero(m, m), Eigen::VectorXd::Zero(m)};
    for (const RippleSums& row : rows) {
      sums.normal += row.normal;
      sums.right += row.right;
      sums.d += row.d, sums.d2 += row.d2, sums.noise += row.noise, sums.n += row.n;
    }
    sums.normal = Eigen::MatrixXd(sums.normal.selfadjointView<Eigen::Lower>());
    return sums;
  }

  /// Returns the sum over blocks of n_b (mean of what the ripple leaves)^2, less what noise alone puts into a
  /// mean.
  double low_frequency() const {
    const int across = (difference_.width + kBlock - 1) / kBlock,
              down = (difference_.height + kBlock - 1) / kBlock;
    std::vector<double> sums(static_cast<std::size_t>(across) * static_cast<std::size_t>(down), 0.0);
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < across * down; ++b) {
      const int x0 = b % across * kBlock, y0 = b / across * kBlock;
      double sum = 0.0, noise = 0.0;
      std::size_t n = 0;
      Eigen::VectorXd f(ripple_.size());
      for (int y = y0; y < std::min(y0 + kBlock, difference_.height); ++y)
        for (int x = x0; x < std::min(x0 + kBlock, difference_.width); ++x) {
          const auto d = static_cast<double>(difference_(x, y));
          if (std::isnan(d)) continue;
          const std::size_t i = difference_.index(x, y);
          ripple_.basis(real_px(i), f.data());
          sum += d - solution_.dot(f);
          noise += noise_variance(i);
          ++n;
        }
      const auto count = static_cast<double>(n);
      if (n >= kFewestInBlock) sums[b] = (sum * sum - noise) / count;
    }
    double total = 0.0;
    for (const double s : sums) total += s;
    return total;
  }

  const DirectionDecode &real_, &simulated_;
  Ripple ripple_;
  ImageF difference_;
  double per_px_ = 0.0;
  Eigen::VectorXd solution_;
};

/// Returns the ripple that this direction may have; without pitches where it has no phase steps.
Ripple ripple_of(const Twin& twin, const DirectionDecode& real, const std::vector<int>& use_steps) {
  const int steps = twin.fringes.steps;
  Ripple ripple;
  if (steps == 0) return ripple;
  ripple.order = use_steps.empty() ? steps : alias_order(use_steps, steps);
  for (const DirectionFringes& d : twin.fringes.directions) {
    if (d.axis != real.axis) continue;
    const auto finest = static_cast<std::size_t>(d.finest());
    ripple.pitch_px = {d.pitches_px[finest]};
    ripple.origin_px = {d.phase_origin_px[finest]};
    if (twin.fringes.unwrap != Unwrap::heterodyne) continue;
    for (std::size_t p = 0; p < d.pitches_px.size(); ++p)
      if (p != finest) {
        ripple.pitch_px.push_back(d.pitches_px[p]);
        ripple.origin_px.push_back(d.phase_origin_px[p]);
      }
  }
  return ripple;
}

}  // namespace

int alias_order(const std::vector<int>& steps, int steps_total) {
  const int m = static_cast<int>(steps.size());
  if (m < 3 || steps_total % m != 0) return 1;
  std::vector<int> sorted = steps;
  std::ranges::sort(sorted);
  for (int i = 1; i < m; ++i)
    if (sorted[i] - sorted[i - 1] != steps_total / m) return 1;
  return m;
}

std::optional<PhaseBudget> phase_budget(const Twin& twin, const DirectionDecode& real,
                                        const DirectionDecode& simulated, const std::vector<int>& use_steps) {
  Ripple ripple = ripple_of(twin, real, use_steps);
  if (ripple.pitch_px.empty()) return std::nullopt;
  return PhaseBudgetFit(real, simulated, std::move(ripple)).run();
}

std::optional<RippleTest> test_ripple(const Twin& twin, const DirectionDecode& real,
                                      const DirectionDecode& simulated, const std::vector<int>& use_steps,
                                      const ImageU8& interior, const TextureShift& texture) {
  Ripple ripple = ripple_of(twin, real, use_steps);
  if (ripple.pitch_px.empty()) return std::nullopt;
  return PhaseBudgetFit(real, simulated, std::move(ripple)).test(interior, texture);
}

namespace {

/// Returns the ratio of mean over black and amplitude of most valid fringes of a pitch.
double mean_over_amplitude(const DirectionDecode& d, std::size_t pitch, double black_dn) {
  constexpr std::size_t kEvery = 7;
  std::vector<float> ratios;
  for (std::size_t i = 0; i < d.mean_dn.size(); i += kEvery)
    if (std::isfinite(d.wrapped_rad[pitch].data[i]))
      ratios.push_back((d.mean_dn.data[i] - static_cast<float>(black_dn)) / d.amplitude_dn[pitch].data[i]);
  return ratios.empty() ? kNaN : upper_median(ratios);
}

}  // namespace

double predicted_brightness_rad2(const Twin& twin, std::size_t camera, const DirectionDecode& real,
                                 const std::vector<int>& use_steps, const measure::LightFactors& light) {
  const std::vector<int> steps = use_steps.empty() ? measure::all_steps(twin.fringes.steps) : use_steps;
  if (real.wrapped_rad.empty() || alias_order(steps, twin.fringes.steps) != static_cast<int>(steps.size()))
    return kNaN;
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  const bool all_pitches = twin.fringes.unwrap == Unwrap::heterodyne;
  const auto n_pitches = static_cast<double>(real.pitches_px.size());
  double sum = 0.0;
  for (std::size_t p = 0; p < real.pitches_px.size(); ++p) {
    if (!all_pitches && static_cast<int>(p) != real.finest) continue;
    std::vector<double> factors;
    bool told = false;  // else the factors of this pitch are 1, and nobody knows them
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      const PatternSpec& image = sequence[i];
      if (image.kind != PatternSpec::Kind::phase_step || image.pitch != static_cast<int>(p) ||
          twin.fringes.directions[static_cast<std::size_t>(image.direction)].axis != real.axis ||
          std::ranges::find(steps, image.step) == steps.end())
        continue;
      told = told || std::isfinite(light.sigma.at(i)) || light.factor.at(i) != 1.0;
      factors.push_back(light.factor.at(i) / factor_of(twin.cameras[camera].exposure_factors, i) /
                        (twin.projector ? factor_of(twin.projector->light_factors, i) : 1.0));
    }
    if (!told) return kNaN;
    // of the coordinate, in phase of the finest pitch: the mean of all where all are in it
    const double share =
        all_pitches ? real.pitches_px[p] / real.pitches_px[static_cast<std::size_t>(real.finest)] / n_pitches
                    : 1.0;
    const double ratio = mean_over_amplitude(real, p, twin.cameras[camera].sensor.black_level_dn);
    sum += std::pow(share * measure::light_phase_rms_rad(factors, ratio), 2);
  }
  return sum;
}

}  // namespace fringetwin::compare
