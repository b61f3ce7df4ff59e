// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/phase_noise.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "twin/base/statistics.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::measure {
namespace {

constexpr std::size_t kMostNoiseValues = 400'000, kMostUnlitValues = 50'000, kFewestNoiseValues = 200;
constexpr int kMostNoiseSteps = 64, kNoiseIterations = 20;
constexpr double kSettled = 1e-5;
/// Of the mean variance: no level weighs as if it had less. It matters for irradiance only.
constexpr double kQuietest = 1e-4;
/// Variance of a squared normal value, 2, times 2 for triples of pixels that overlap.
constexpr double kSquareVariance = 4.0;
/// Times the rounding's variance: less noise than that is rounded alike in many images.
constexpr double kSmoothRounding = 4.0;
constexpr int kHarmonicsStride = 3;  // ten numbers need fewer pixels than noise does
/// Of the triples: a few outliers and the noise of many valleys reach far below any light.
constexpr double kDarkestShare = 0.01;
/// Of the sigmas of roughness: harmonics that leave more than half a sigma are not known well enough.
constexpr double kHarmonicsRough = 2.0 * kRoughSigmas;

using Steps = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostNoiseSteps, 1>;

/// Of each triple of pixels the levels of the darkest and of the brightest step, by the fitted sinusoid.
struct Ends {
  std::vector<float> darkest, brightest;
};

/// Takes noise from the steps of three neighbouring pixels.
class StepContrasts {
 public:
  explicit StepContrasts(const StepSolver& solver) {
    const int n = solver.count();
    Eigen::MatrixXd known(n, 3);
    for (int i = 0; i < n; ++i) known.row(i) << 1.0, solver.basis_cos(i), solver.basis_sin(i);
    sinusoids_ = orthonormal_basis(known);
    contrasts_ = orthonormal_complement(known);
    squares_ = contrasts_.cwiseAbs2();
    level_ = Eigen::Map<const Eigen::VectorXf>(solver.mean_weights().data(), n).cast<double>().normalized();
  }

  std::size_t count() const { return static_cast<std::size_t>(contrasts_.cols()); }

  /// Returns the contrasts of about `most` values, or all, evenly spread over the triples of the `n` pixels
  /// of which `is_wanted(pitch, pixel)` is true, and their `ends`. Without the harmonics of fringes whose
  /// amplitude is `fringes_from` or more.
  std::vector<NoiseValue> of_triples(const std::vector<NoiseInput>& pitches, Axis axis, std::size_t n,
                                     std::size_t most, auto is_wanted, Ends& ends,
                                     std::optional<double> fringes_from = {}) const {
    std::vector<NoiseValue> out;
    if (n == 0 || most == 0) return out;
    const double many = static_cast<double>(n * count()) / static_cast<double>(most);
    const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(many))));
    // Column patterns vary along camera x (roughly): the stripes run along camera y, and vice versa.
    const int dx = axis == Axis::x ? 0 : 1, dy = axis == Axis::x ? 1 : 0;
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(contrasts_.cols());
    for (const NoiseInput& in : pitches) {
      const ImageF& size = *in.amplitude;
      std::optional<StripeHarmonics> harmonics;
      if (fringes_from) harmonics.emplace(in, contrasts_, axis, kHarmonicsStride * stride, *fringes_from);
      if (harmonics && !harmonics->matter()) harmonics.reset();
      for (int y = dy; y < size.height - dy; y += stride)
        for (int x = dx; x < size.width - dx; x += stride) {
          const std::size_t before = size.index(x - dx, y - dy), at = size.index(x, y),
                            after = size.index(x + dx, y + dy);
          if (is_wanted(in, at) && is_wanted(in, before) && is_wanted(in, after))
            add(in, before, at, after, harmonics ? harmonics->remainder(x, y) : none, out, ends);
        }
    }
    return out;
  }

 private:
  /// Appends the contrasts less `expected`.
  void add(const NoiseInput& in, std::size_t before, std::size_t at, std::size_t after,
           const Eigen::VectorXd& expected, std::vector<NoiseValue>& out, Ends& ends) const {
    Steps second(sinusoids_.rows()), mean(sinusoids_.rows());
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
      const GrayImage& v = *in.steps[static_cast<std::size_t>(i)];
      const auto a = static_cast<double>(v[before]), b = static_cast<double>(v[at]),
                 c = static_cast<double>(v[after]);
      second[i] = (a - 2.0 * b + c) / std::sqrt(6.0);
      mean[i] = (a + 4.0 * b + c) / 6.0;  // weighted as the second difference's variance is
    }
    // of the pixel's mean: independent of the contrasts, and no fringe is in it
    const double texture = std::abs(level_.dot(second));
    for (Eigen::Index j = 0; j < contrasts_.cols(); ++j)
      out.push_back({static_cast<float>(squares_.col(j).dot(mean)),
                     static_cast<float>(contrasts_.col(j).dot(second) - expected[j]),
                     static_cast<float>(std::max(texture, kHarmonicsRough * std::abs(expected[j])))});
    const Eigen::Vector3d fit = sinusoids_.transpose() * mean;
    const Steps sinusoid = sinusoids_ * fit;
    ends.darkest.push_back(static_cast<float>(sinusoid.minCoeff()));
    ends.brightest.push_back(static_cast<float>(sinusoid.maxCoeff()));
  }

  Eigen::Matrix<double, Eigen::Dynamic, 3> sinusoids_;  ///< orthonormal: mean, cosine and sine
  Eigen::MatrixXd contrasts_, squares_;
  Eigen::VectorXd level_;  ///< takes the mean, scaled to the noise of one gray value
};

/// Leaves out triples whose noise the full scale cuts: pixels that pass below it by chance are quieter.
void leave_out_clipped(const Ends& ends, std::size_t together, double saturation,
                       std::vector<NoiseValue>& values) {
  std::vector<float> sizes;
  for (const NoiseValue& v : values) sizes.push_back(std::abs(v.value));
  const double brightest = saturation - kCutSigmas * kMadToSigma * upper_median(sizes);
  std::vector<NoiseValue> kept;
  for (std::size_t i = 0; i < ends.brightest.size(); ++i)
    if (static_cast<double>(ends.brightest[i]) < brightest)
      kept.insert(kept.end(), &values[i * together], &values[i * together] + together);
  if (kept.size() >= kFewestNoiseValues) values = std::move(kept);
}

}  // namespace

double NoiseModel::known_to(const std::vector<float>& levels) const {
  if (!(height_sigma > 0.0 || slope_sigma > 0.0)) return 0.0;  // nothing was fitted: silent images
  double of_height = 0.0, of_slope = 0.0;
  for (const float at : levels) {
    const double share = 1.0 / (variance(static_cast<double>(at)) * static_cast<double>(levels.size()));
    of_height += share, of_slope += share * (static_cast<double>(at) - level);
  }
  return std::hypot(height_sigma * of_height, slope_sigma * of_slope);
}

double add_unlit(const std::vector<NoiseValue>& unlit, std::size_t together, const NoiseLimits& limits,
                 std::vector<NoiseValue>& values) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  if (unlit.empty()) return kNone;
  std::vector<float> sizes;
  for (const NoiseValue& v : unlit) sizes.push_back(std::abs(v.value));
  const double sigma = kMadToSigma * upper_median(sizes), margin = kCutSigmas * sigma;
  if (!(sigma * sigma > kSmoothRounding * limits.least)) return kNone;
  const auto is_whole = [&](const NoiseValue& v) {
    const auto level = static_cast<double>(v.level);
    return level > margin && level < limits.saturation - margin;
  };
  std::vector<float> levels;
  for (auto first = unlit.begin(); first != unlit.end(); first += together)
    if (std::all_of(first, first + together, is_whole)) {
      values.insert(values.end(), first, first + together);
      levels.push_back(first->level);
    }
  return levels.empty() ? kNone : upper_median(levels);
}

std::optional<NoiseModel> fit_noise(const std::vector<NoiseValue>& values, std::size_t together,
                                    double darkest, double least) {
  if (values.size() < kFewestNoiseValues) return std::nullopt;
  std::vector<float> levels, sizes;
  for (const NoiseValue& v : values) levels.push_back(v.level);
  const double centre = upper_median(levels);
  for (const NoiseValue& v : values)
    if (static_cast<double>(v.level) >= centre) sizes.push_back(std::abs(v.value));
  // The first cut is wide: it is that of the brighter half, and coarse gray levels move a median by up to one
  // of their steps.
  double height = std::pow(kMadToSigma * upper_median(sizes) + std::sqrt(least), 2), slope = 0.0;
  if (!(height > 0.0)) return NoiseModel{0.0, 0.0, least};
  const double quietest = std::max(least, kQuietest * height);
  const auto variance_of = [&](const NoiseValue& v) {
    return std::max(height + slope * (static_cast<double>(v.level) - centre), quietest);
  };
  const auto is_noise = [&](const NoiseValue& v) {
    const auto value = static_cast<double>(v.value), roughness = static_cast<double>(v.roughness);
    const double variance = variance_of(v);
    return value * value <= kCutSigmas * kCutSigmas * variance &&
           roughness * roughness <= kRoughSigmas * kRoughSigmas * variance;
  };
  NoiseModel out{.least = least};
  for (int i = 0; i < kNoiseIterations; ++i) {
    double w = 0.0, x = 0.0, xx = 0.0, y = 0.0, xy = 0.0;
    for (auto first = values.begin(); first != values.end(); first += together) {
      if (!std::all_of(first, first + together, is_noise)) continue;
      for (auto v = first; v != first + together; ++v) {
        const double variance = variance_of(*v), weight = 1.0 / (variance * variance),
                     at = static_cast<double>(v->level) - centre,
                     square = std::pow(static_cast<double>(v->value), 2) / kKeptVariance;
        w += weight, x += weight * at, xx += weight * at * at, y += weight * square,
            xy += weight * at * square;
      }
    }
    if (!(w > 0.0)) return std::nullopt;
    const double level = x / w, mean = y / w, spread = xx - x * level;
    const double above = std::max(centre + level - darkest, std::numeric_limits<double>::min());
    // the darkest step has no less than what is not known of it
    out.level = centre + level, out.height_sigma = std::sqrt(kSquareVariance / w);
    out.slope_sigma = spread > 0.0 ? std::sqrt(kSquareVariance / spread) : 0.0;
    const double left = std::max(least, above * out.slope_sigma);
    slope =
        spread > 0.0 ? std::clamp((xy - x * mean) / spread, 0.0, std::max(mean - left, 0.0) / above) : 0.0;
    const double before = std::exchange(height, mean - slope * level);
    if (std::abs(height - before) <= kSettled * height) break;
  }
  out.offset = height - slope * centre, out.per_unit = slope;
  return out;
}

std::optional<NoiseModel> estimate_noise(const std::vector<NoiseInput>& pitches, const StepSolver& solver,
                                         Axis axis, const NoiseLimits& limits) {
  if (solver.count() <= 3 || solver.count() > kMostNoiseSteps) return std::nullopt;
  const StepContrasts contrasts(solver);
  const auto is_lit = [&limits](const NoiseInput& in, std::size_t i) {
    return static_cast<double>(in.amplitude->data[i]) >= limits.min_amplitude &&
           std::isfinite(in.phase->data[i]);
  };
  const auto is_unlit = [&](const NoiseInput& in, std::size_t i) {
    return !is_lit(in, i) && std::ranges::all_of(in.steps, [&](const GrayImage* step) {
      return static_cast<double>((*step)[i]) < limits.saturation;
    });
  };
  std::size_t n = 0, n_lit = 0;
  for (const NoiseInput& in : pitches) {
    n += in.amplitude->size();
    for (std::size_t i = 0; i < in.amplitude->size(); ++i) n_lit += is_lit(in, i) ? 1 : 0;
  }
  Ends ends, unused;
  std::vector<NoiseValue> values =
      contrasts.of_triples(pitches, axis, n_lit, kMostNoiseValues, is_lit, ends, limits.min_amplitude);
  double darkest = lower_quantile(ends.darkest, kDarkestShare);
  if (std::isfinite(limits.saturation)) {
    leave_out_clipped(ends, contrasts.count(), limits.saturation, values);
    const std::vector<NoiseValue> unlit = contrasts.of_triples(
        pitches, axis, n - n_lit, std::min(values.size(), kMostUnlitValues), is_unlit, unused);
    darkest = std::max(darkest, add_unlit(unlit, contrasts.count(), limits, values));
  }
  if (const auto smooth = fit_noise(values, contrasts.count(), darkest, limits.least)) return smooth;
  for (NoiseValue& v : values) v.roughness = 0.0f;  // texture everywhere: an upper bound is better than none
  return fit_noise(values, contrasts.count(), darkest, limits.least);
}

}  // namespace fringetwin::measure
