// SPDX-License-Identifier: Apache-2.0
#include "measure/light/light_factors.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numeric>

#include "measure/light/light_steps.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/statistics.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::measure {
namespace {

constexpr int kLightIterations = 12;
constexpr std::size_t kFewestLightPixels = 200, kMostLightPixels = 12'000;
constexpr std::size_t kCandidates = 4;  ///< looked at for each pixel that takes part
constexpr double kMostProducts = 1e7;   ///< of one pass over the pixels of a pitch
constexpr int kLightBlocks = 16;        ///< each way: what belongs together lies in one
constexpr int kLeastBlockPx = 8;
constexpr std::size_t kFewestLightBlocks = 12;
constexpr Eigen::Index kFewestLevelBlocks = 2;  ///< that a pitch shares with the first
constexpr int kWaveformFirst = 2;               ///< iterations before factors are fitted
constexpr double kSettledFactor = 1e-6;         ///< of a factor
constexpr double kCut2 = 9.0;                   ///< squared robust scales of a pixel's residual
/// Standard error of a factor that is not told: taken out, it would move a phase by 0.005 rad.
constexpr double kNotTold = 0.005;
constexpr double kNull = 1e-9;  ///< of the largest eigenvalue of the scaled normal matrix
constexpr double kLeastVariance = 1e-6, kRelativeAmplitude = 1e-3;
constexpr double kDiffer = 4.0;  ///< standard errors

/// One pitch of one direction: the steps that are asked, their images' indices and images.
struct PitchSteps {
  bool is_finest = false;  ///< of its direction
  int total = 0;           ///< steps of a period
  std::vector<int> step = {};
  std::vector<std::size_t> index = {};
  std::vector<const GrayImage*> image = {};
};

std::vector<PitchSteps> pitches_of(const CameraImages& images, const Fringes& fringes,
                                   const std::vector<int>& steps) {
  std::vector<PitchSteps> pitches;
  const std::vector<PatternSpec> sequence = expand_sequence(fringes);
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    if (sequence[i].kind != PatternSpec::Kind::phase_step) continue;
    if (sequence[i].step == 0)
      pitches.push_back(
          {fringes.directions[static_cast<std::size_t>(sequence[i].direction)].finest() == sequence[i].pitch,
           fringes.steps});
    if (!steps.empty() && std::ranges::find(steps, sequence[i].step) == steps.end()) continue;
    pitches.back().step.push_back(sequence[i].step);
    pitches.back().index.push_back(i);
    pitches.back().image.push_back(&images.images.at(i));
  }
  return pitches;
}

/// Says which pixels of a pitch take part: lit fringes without a clipped value, evenly spread, block by
/// block.
struct Chosen {
  std::vector<std::vector<std::size_t>> blocks;  ///< pixels of each block that has any
  std::size_t n = 0;
};

/// Returns about `most` of the numbers below n, evenly spread but not evenly spaced: every seventh pixel may
/// meet the same place of each fringe.
std::vector<std::size_t> spread_over(std::size_t n, std::size_t most) {
  constexpr std::size_t kScatter = 7919;
  const std::size_t stride = std::max<std::size_t>(1, (n + most - 1) / most);
  std::vector<std::size_t> out;
  for (std::size_t j = 0; j * stride < n; ++j)
    out.push_back(std::min(n - 1, j * stride + j * kScatter % stride));
  return out;
}

/// Sums over the pixels of one block.
struct LightSums {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
  Eigen::MatrixXd scores;  ///< squares of what each pixel adds to `right`
  double squares = 0.0, weight = 0.0;
  std::vector<float> of_pixels = {};  ///< weighted squares of what each leaves
};

/// Finds the factors of the steps of one pitch.
class PitchLight {
 public:
  PitchLight(const PitchSteps& pitch, const LightOptions& options, double saturation)
      : pitch_(pitch),
        options_(options),
        steps_(pitch.step, pitch.total, options.with_shifts),
        log_factor_(Eigen::VectorXd::Zero(steps_.count())),
        per_factor_(Eigen::VectorXd::Ones(steps_.count())) {
    choose(saturation);
  }

  /// Returns false where these pixels do not tell.
  bool run() {
    if (chosen_.n < kFewestLightPixels) return false;
    const Eigen::Index n = steps_.count(), m = steps_.of_harmonics();
    Eigen::VectorXd solution;
    for (int i = 0; i < kLightIterations; ++i) {
      throw_if_cancelled();
      sum_up();
      if (i < kWaveformFirst) {
        steps_.waveform += of_waveform().segment(n, m);
        continue;
      }
      if (i == kWaveformFirst) before_ = mean_square(of_waveform());
      solution = solve();
      if (solution.size() == 0) return false;
      const Eigen::VectorXd step = solution.head(n);
      if (step.cwiseAbs().maxCoeff() < kSettledFactor) break;
      log_factor_ += step.cwiseMax(-0.5).cwiseMin(0.5);
      per_factor_ = (-log_factor_).array().exp();
      steps_.waveform += solution.segment(n, m);
      steps_.move_by(solution.tail(steps_.of_shifts()).cwiseMax(-0.2).cwiseMin(0.2));
    }
    after_ = mean_square(solution);
    set_sigma(solution);
    return sigma_.head(n).maxCoeff() < kNotTold;
  }

  const Eigen::VectorXd& log_factor() const { return log_factor_; }
  const Eigen::VectorXd& sigma() const { return sigma_; }
  const Eigen::VectorXd& shift_rad() const { return steps_.shift_rad; }
  const Eigen::VectorXd& shift_sigma_rad() const { return shift_sigma_; }
  std::vector<double> waveform() const { return {steps_.waveform.begin(), steps_.waveform.end()}; }
  double before() const { return before_; }
  double after() const { return after_; }
  const Chosen& chosen() const { return chosen_; }
  /// Returns whether no value of a pixel is clipped, at either end.
  bool is_whole(std::size_t pixel, double saturation) const {
    return std::ranges::all_of(pitch_.image, [&](const GrayImage* image) {
      return static_cast<double>((*image)[pixel]) < saturation && (*image)[pixel] > 0.0F;
    });
  }
  /// Returns the mean of a pixel over black with a steady light.
  double mean_of(std::size_t pixel) const { return steps_.mean(values(pixel)); }
  /// Returns the ratio of mean and amplitude of most pixels.
  double mean_over_amplitude() const {
    std::vector<float> ratios;
    for (const std::vector<std::size_t>& block : chosen_.blocks)
      for (const std::size_t pixel : block) {
        const StepFringe f = steps_.sinusoid(values(pixel));
        ratios.push_back(static_cast<float>(f.mean / f.amplitude));
      }
    return upper_median(ratios);
  }

 private:
  /// Returns a pixel's values over black as they would be with a steady light, by the factors so far.
  Eigen::VectorXd values(std::size_t pixel) const {
    Eigen::VectorXd out(steps_.count());
    read(pixel, out);
    return out;
  }
  void read(std::size_t pixel, Eigen::VectorXd& values) const {
    for (Eigen::Index k = 0; k < values.size(); ++k)
      values[k] = per_factor_[k] * (static_cast<double>((*pitch_.image[static_cast<std::size_t>(k)])[pixel]) -
                                    options_.black_level_dn);
  }

  void choose(double saturation) {
    const GrayImage& size = *pitch_.image.front();
    const double products = static_cast<double>(steps_.count()) * steps_.unknowns();
    const auto most = std::clamp(static_cast<std::size_t>(kMostProducts / products), 10 * kFewestLightPixels,
                                 kMostLightPixels);
    std::vector<std::size_t> lit;
    std::vector<double> amplitude;
    for (const std::size_t i : spread_over(size.size(), kCandidates * most))
      if (is_whole(i, saturation)) {
        lit.push_back(i);
        amplitude.push_back(steps_.sinusoid(values(i)).amplitude);
      }
    if (lit.empty()) return;
    const double least =
        std::isfinite(saturation) ? options_.min_amplitude : kRelativeAmplitude * std::ranges::max(amplitude);
    std::size_t n_lit = 0;
    for (std::size_t j = 0; j < lit.size(); ++j)
      if (amplitude[j] >= least) lit[n_lit++] = lit[j];
    lit.resize(n_lit);
    const int side_x = std::max(kLeastBlockPx, (size.width + kLightBlocks - 1) / kLightBlocks),
              side_y = std::max(kLeastBlockPx, (size.height + kLightBlocks - 1) / kLightBlocks);
    chosen_.blocks.resize(static_cast<std::size_t>(kLightBlocks) * kLightBlocks);
    for (const std::size_t j : spread_over(lit.size(), most)) {
      const auto x = static_cast<int>(lit[j] % static_cast<std::size_t>(size.width)),
                 y = static_cast<int>(lit[j] / static_cast<std::size_t>(size.width));
      chosen_.blocks[static_cast<std::size_t>(y / side_y * kLightBlocks + x / side_x)].push_back(lit[j]);
      ++chosen_.n;
    }
    std::erase_if(chosen_.blocks, [](const auto& block) { return block.empty(); });
    for (const std::vector<std::size_t>& block : chosen_.blocks) {
      fringes_.emplace_back();
      for (const std::size_t pixel : block) fringes_.back().push_back(steps_.sinusoid(values(pixel)));
    }
  }

  double weight(const StepFringe& f) const { return options_.weight(f.mean); }

  /// Sets the scale of a pixel's residual beyond which it weighs less, from the middle of all.
  void robust_scale() {
    std::vector<float> all;
    for (const LightSums& block : sums_)
      all.insert(all.end(), block.of_pixels.begin(), block.of_pixels.end());
    // the median of chi2 of nu degrees of freedom is nu (1 - 2/(9 nu))^3 (Wilson and Hilferty)
    const double nu = steps_.freedom();
    scale2_ = upper_median(all) / (nu * std::pow(1.0 - 2.0 / (9.0 * nu), 3));
  }

  /// Returns what a pixel counts whose weighted squares add up to this.
  double trust(double squares) const {
    const double q = squares / steps_.freedom();
    return q > kCut2 * scale2_ ? kCut2 * scale2_ / q : 1.0;
  }

  /// Sums up the equations where the fit is, each pixel's own fringe fitted once more before. The pixels of
  /// the pass before tell which of them to trust.
  void sum_up() {
    if (!sums_.empty()) robust_scale();
    sums_.assign(chosen_.blocks.size(), {});
    const auto n_blocks = static_cast<std::ptrdiff_t>(chosen_.blocks.size());
#pragma omp parallel for schedule(dynamic)
    for (std::ptrdiff_t b = 0; b < n_blocks; ++b) sum_up_block(static_cast<std::size_t>(b));
    total_ = {.normal = Eigen::MatrixXd::Zero(steps_.unknowns(), steps_.unknowns()),
              .right = Eigen::VectorXd::Zero(steps_.unknowns()),
              .scores = {}};
    for (const LightSums& s : sums_) {
      total_.normal += s.normal;
      total_.right += s.right;
      total_.squares += s.squares;
      total_.weight += s.weight;
    }
  }

  void sum_up_block(std::size_t block) {
    const Eigen::Index n = steps_.count(), m = steps_.of_harmonics(), q = steps_.of_shifts(), all = n + m + q;
    LightSums& out = sums_[block];
    out.normal = Eigen::MatrixXd::Zero(all, all);
    out.right = Eigen::VectorXd::Zero(all);
    out.scores = out.normal;
    PixelEquations e;
    Eigen::VectorXd y(n), left(n), score(all);
    Eigen::MatrixXd harmonics(n, m), free(n, n), shifts(n, q);
    for (std::size_t i = 0; i < chosen_.blocks[block].size(); ++i) {
      read(chosen_.blocks[block][i], y);
      StepFringe& fringe = fringes_[block][i];
      e.set(steps_, fringe, y);
      fringe = e.better(fringe);
      e.set(steps_, fringe, y);
      e.contrasts(e.residual, left);
      e.contrasts(e.harmonics, harmonics);
      free.noalias() = -e.own * e.own.transpose();
      free.diagonal().array() += 1.0;
      const double noise = weight(fringe), squares = noise * left.squaredNorm(), w = noise * trust(squares);
      // a factor changes its step by the signal there: (P diag s)^T (P diag s) = P s s^T, entry by entry
      out.normal.topLeftCorner(n, n) += w * (e.signal.asDiagonal() * free * e.signal.asDiagonal());
      out.normal.block(0, n, n, m).noalias() += w * e.signal.asDiagonal() * harmonics;
      out.normal.block(n, n, m, m).noalias() += w * harmonics.transpose() * harmonics;
      score.head(n) = w * e.signal.cwiseProduct(left);
      score.segment(n, m).noalias() = w * harmonics.transpose() * left;
      if (q > 0) {
        shifts.noalias() = free * (e.by_phase.asDiagonal() * steps_.shift_basis);
        out.normal.topRightCorner(n, q).noalias() += w * e.signal.asDiagonal() * shifts;
        out.normal.block(n, n + m, m, q).noalias() += w * harmonics.transpose() * shifts;
        out.normal.bottomRightCorner(q, q).noalias() += w * shifts.transpose() * shifts;
        score.tail(q).noalias() = w * shifts.transpose() * left;
      }
      out.right += score;
      out.scores.noalias() += score * score.transpose();
      out.squares += w * left.squaredNorm();
      out.weight += w / noise;
      out.of_pixels.push_back(static_cast<float>(squares));
    }
    out.normal.triangularView<Eigen::StrictlyLower>() = out.normal.transpose();
  }

  /// Solves the equations, all factors alike left out: no steps tell them. Empty where more is not told.
  Eigen::VectorXd solve() {
    const Eigen::VectorXd size = total_.normal.diagonal().cwiseSqrt();
    if (!(size.head(steps_.count()).minCoeff() > 0.0)) return {};
    // what no pixel shows of a harmonic stays 0
    const Eigen::VectorXd scale = size.cwiseMax(1e-300).cwiseInverse();
    const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * total_.normal * scale.asDiagonal());
    const double least = kNull * eigen.values.maxCoeff();
    Eigen::VectorXd inverse = Eigen::VectorXd::Zero(scale.size());
    int null = 0;
    for (Eigen::Index i = 0; i < inverse.size(); ++i)
      if (eigen.values[i] > least)
        inverse[i] = 1.0 / eigen.values[i];
      else
        ++null;
    if (null > 1) return {};
    const Eigen::MatrixXd vectors = scale.asDiagonal() * eigen.vectors;
    covariance_ = vectors * inverse.asDiagonal() * vectors.transpose();
    // relative to the mean of the factors
    Eigen::MatrixXd centre = Eigen::MatrixXd::Identity(scale.size(), scale.size());
    centre.topLeftCorner(steps_.count(), steps_.count()).array() -= 1.0 / steps_.count();
    covariance_ = centre * covariance_ * centre.transpose();
    return covariance_ * total_.right;
  }

  /// Returns the solution of the waveform alone, the factors held.
  Eigen::VectorXd of_waveform() const {
    const Eigen::Index n = steps_.count(), m = steps_.of_harmonics();
    Eigen::VectorXd out = Eigen::VectorXd::Zero(steps_.unknowns());
    if (m > 0)
      out.segment(n, m) = solve_symmetric(total_.normal.block(n, n, m, m), total_.right.segment(n, m));
    return out;
  }

  /// Returns the mean square that a solution leaves, per degree of freedom.
  double mean_square(const Eigen::VectorXd& solution) const {
    const double left =
        total_.squares - 2.0 * solution.dot(total_.right) + solution.dot(total_.normal * solution);
    return std::max(0.0, left) / (total_.weight * steps_.freedom());
  }

  /// Sets the standard errors: those of the scatter of pixels, whose noise is not the same at all levels, or
  /// of the scatter of blocks where that is more than chance makes of it.
  void set_sigma(const Eigen::VectorXd& solution) {
    const int n = steps_.count();
    Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(steps_.unknowns(), steps_.unknowns()), of_pixels = scores;
    for (const LightSums& s : sums_) {
      of_pixels += s.scores;
      const Eigen::VectorXd score = s.right - s.normal * solution;
      scores += score * score.transpose();
    }
    // a hair more than nothing, where images are without any noise
    const Eigen::MatrixXd noise =
        covariance_ * of_pixels * covariance_ + std::numeric_limits<double>::min() * covariance_;
    const auto blocks = static_cast<double>(sums_.size());
    const Eigen::MatrixXd sandwich = blocks / (blocks - 1.0) * covariance_ * scores * covariance_;
    const double chance = 1.0 + 3.0 * std::sqrt(2.0 / (blocks - 1.0));
    const bool may_scatter = sums_.size() >= kFewestLightBlocks;
    const auto sigma = [&](double by_blocks, double by_pixels) {
      return std::sqrt(may_scatter && by_blocks > chance * by_pixels ? by_blocks : by_pixels);
    };
    sigma_.resize(n);
    shift_sigma_ = Eigen::VectorXd::Zero(n);
    const int q = steps_.of_shifts();
    for (int k = 0; k < n; ++k) {
      sigma_[k] = sigma(sandwich(k, k), noise(k, k));
      if (q == 0) continue;
      const Eigen::RowVectorXd of_step = steps_.shift_basis.row(k);
      shift_sigma_[k] = sigma(of_step * sandwich.bottomRightCorner(q, q) * of_step.transpose(),
                              of_step * noise.bottomRightCorner(q, q) * of_step.transpose());
    }
  }

  const PitchSteps& pitch_;
  const LightOptions& options_;
  LightSteps steps_;
  Chosen chosen_;
  double scale2_ = std::numeric_limits<double>::infinity(), before_ = 0.0, after_ = 0.0;
  std::vector<std::vector<StepFringe>> fringes_;  ///< of the chosen pixels
  std::vector<LightSums> sums_;
  LightSums total_;
  Eigen::MatrixXd covariance_;  ///< for noise of variance 1 over the weights
  Eigen::VectorXd log_factor_, per_factor_, sigma_, shift_sigma_;  ///< per_factor_: one over the factors
};

/// Finds by how much brighter each pitch was shown than all in the mean, ln, from the means of the first
/// one's pixels (their squares: noise adds the same to both), and the standard errors by the scatter of
/// blocks. They are unknown, infinite, of all pitches where one shares fewer blocks than two with the first:
/// nothing scatters then, and the mean of all is as unknown as that pitch.
class PitchLevels {
 public:
  PitchLevels(const std::vector<PitchLight>& pitches, double saturation) {
    const std::size_t n = pitches.size(), n_blocks = pitches[0].chosen().blocks.size();
    log_level.assign(n, 0.0);
    bool scatters = true;
    Eigen::MatrixXd errors =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n_blocks),
                              static_cast<Eigen::Index>(n));  // of ln, by block and pitch
    for (std::size_t p = 1; p < n; ++p) {
      const Eigen::MatrixX2d squares = squares_of(pitches, p, saturation);
      const Eigen::RowVector2d sum = squares.colwise().sum();
      scatters = scatters && (squares.rowwise().minCoeff().array() > 0.0).count() >= kFewestLevelBlocks;
      if (!(sum.minCoeff() > 0.0)) continue;
      const double ratio = sum[1] / sum[0];
      log_level[p] = 0.5 * std::log(ratio);
      errors.col(static_cast<Eigen::Index>(p)) = 0.5 * (squares.col(1) - ratio * squares.col(0)) / sum[1];
    }
    const double mean = std::accumulate(log_level.begin(), log_level.end(), 0.0) / static_cast<double>(n);
    errors.colwise() -= errors.rowwise().mean().eval();
    const auto blocks = static_cast<double>(n_blocks);
    for (std::size_t p = 0; p < n; ++p) {
      log_level[p] -= mean;
      const double scatter = errors.col(static_cast<Eigen::Index>(p)).norm();
      sigma.push_back(n == 1     ? 0.0
                      : scatters ? std::sqrt(blocks / (blocks - 1.0)) * scatter
                                 : std::numeric_limits<double>::infinity());
    }
  }

  std::vector<double> log_level, sigma;

 private:
  /// Returns the sums of squares of the first pitch and of pitch p over the pixels of each block that are
  /// whole in both.
  static Eigen::MatrixX2d squares_of(const std::vector<PitchLight>& pitches, std::size_t p,
                                     double saturation) {
    const std::vector<std::vector<std::size_t>>& blocks = pitches[0].chosen().blocks;
    Eigen::MatrixX2d squares = Eigen::MatrixX2d::Zero(static_cast<Eigen::Index>(blocks.size()), 2);
    for (std::size_t b = 0; b < blocks.size(); ++b)
      for (const std::size_t pixel : blocks[b])
        if (pitches[p].is_whole(pixel, saturation))
          squares.row(static_cast<Eigen::Index>(b)) +=
              Eigen::RowVector2d(pitches[0].mean_of(pixel), pitches[p].mean_of(pixel)).cwiseAbs2();
    return squares;
  }
};

}  // namespace

LightOptions light_options(const Sensor& sensor, double min_modulation_dn) {
  LightOptions options{.black_level_dn = sensor.black_level_dn, .min_amplitude = min_modulation_dn};
  if (!sensor.has_noise()) return options;
  options.variance_per_dn = sensor.electrons_per_dn ? 1.0 / *sensor.electrons_per_dn : 0.0;
  options.variance_offset_dn2 = std::pow(sensor.read_noise_dn.value_or(0.0), 2) -
                                options.variance_per_dn * sensor.black_level_dn + kRoundingVariance;
  return options;
}

double LightOptions::weight(double over_black_dn) const {
  const double level = over_black_dn + black_level_dn,
               variance = variance_offset_dn2 + variance_per_dn * level;
  return 1.0 / std::max(variance, kLeastVariance);
}

bool LightFactors::differ() const {
  for (std::size_t i = 0; i < factor.size(); ++i)
    if (sigma[i] > 0.0 && std::abs(std::log(factor[i])) > kDiffer * sigma[i]) return true;
  return false;
}

bool LightFactors::are_shifted() const {
  for (std::size_t i = 0; i < shift_rad.size(); ++i)
    if (shift_sigma_rad[i] > 0.0 && std::abs(shift_rad[i]) > kDiffer * shift_sigma_rad[i]) return true;
  return false;
}

double largest_told(const std::vector<double>& sigma) {
  double most = 0.0;
  for (const double s : sigma)
    if (std::isfinite(s)) most = std::max(most, s);
  return most > 0.0 ? most : std::numeric_limits<double>::infinity();
}

double light_phase_rms_rad(const std::vector<double>& factors, double mean_over_amplitude) {
  std::complex<double> first, second;
  const auto n = static_cast<double>(factors.size());
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const double angle = kTwoPi * static_cast<double>(k) / n;
    first += (factors[k] - 1.0) / n * std::polar(1.0, -angle);
    second += (factors[k] - 1.0) / n * std::polar(1.0, -2.0 * angle);
  }
  return std::sqrt(2.0 * std::pow(mean_over_amplitude, 2) * std::norm(first) + 0.5 * std::norm(second));
}

std::optional<LightFactors> estimate_light(const CameraImages& images, const Fringes& fringes,
                                           const LightOptions& options, const std::vector<int>& steps) {
  const int n_steps = steps.empty() ? fringes.steps : static_cast<int>(steps.size());
  if (n_steps < kFewestLightSteps || n_steps > kMostLightSteps) return std::nullopt;
  const std::vector<PitchSteps> asked = pitches_of(images, fringes, steps);
  std::vector<PitchLight> pitches;
  std::vector<const PitchSteps*> of_pitch;
  LightFactors out{.factor = std::vector<double>(images.images.size(), 1.0),
                   .sigma = std::vector<double>(images.images.size(), 0.0),
                   .steps = steps};
  if (options.with_shifts) out.shift_rad = out.shift_sigma_rad = out.sigma;
  for (const PitchSteps& pitch : asked) {
    PitchLight light(pitch, options, images.saturation_dn());
    if (light.run()) {
      out.waveform.push_back(light.waveform());
      pitches.push_back(std::move(light));
      of_pitch.push_back(&pitch);
      continue;
    }
    // a wide pitch, seen at few phases, only unwraps the finest one, but where all are in the coordinate
    if (pitch.is_finest || fringes.unwrap == Unwrap::heterodyne) return std::nullopt;
    for (const std::size_t i : pitch.index) out.sigma[i] = std::numeric_limits<double>::infinity();
    out.waveform.emplace_back();
  }
  if (pitches.empty()) return std::nullopt;
  const PitchLevels levels(pitches, images.saturation_dn());
  for (std::size_t p = 0; p < pitches.size(); ++p) {
    const PitchLight& light = pitches[p];
    std::vector<double> of_steps;
    const std::vector<std::size_t>& index = of_pitch[p]->index;
    for (std::size_t k = 0; k < index.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      of_steps.push_back(std::exp(light.log_factor()[at]));
      out.factor[index[k]] = std::exp(light.log_factor()[at] + levels.log_level[p]);
      out.sigma[index[k]] = std::hypot(light.sigma()[at], levels.sigma[p]);
      if (!options.with_shifts) continue;
      out.shift_rad[index[k]] = light.shift_rad()[at];
      out.shift_sigma_rad[index[k]] = light.shift_sigma_rad()[at];
    }
    const double share = 1.0 / static_cast<double>(pitches.size());
    out.residual_before += share * light.before();
    out.residual_after += share * light.after();
    out.n_pixels += light.chosen().n;
    out.phase_rms_rad =
        std::max(out.phase_rms_rad, light_phase_rms_rad(of_steps, light.mean_over_amplitude()));
  }
  if (n_steps < fringes.steps) out.phase_rms_rad = std::numeric_limits<double>::quiet_NaN();
  return out;
}

CameraImages with_steady_light(CameraImages images, const LightFactors& light, double black_level_dn) {
  FT_CHECK(light.factor.size() == images.images.size(), "a factor for each image");
  const double saturation = images.saturation_dn(), darkest = std::ranges::min(light.factor),
               top = black_level_dn + (saturation - black_level_dn) / std::min(darkest, 1.0);
  const auto clipped = static_cast<float>(top);
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < images.images.size(); ++i) {
    const auto divisor = static_cast<float>(1.0 / light.factor[i]),
               black = static_cast<float>(black_level_dn);
    for (float& v : images.images[i].as_floats())
      v = static_cast<double>(v) >= saturation ? clipped : black + divisor * (v - black);
  }
  if (!images.radiance) images.clip = Clip{static_cast<double>(clipped), images.clip ? images.clip->n : 0};
  return images;
}

}  // namespace fringetwin::measure
