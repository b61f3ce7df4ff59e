// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/gain_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "compare/gray/gain_sums.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kHuber = 1.345;  // 95 % efficiency for Gaussian residuals
constexpr std::size_t kSubsample = 200'000;
constexpr std::uint64_t kFewestValues = 50;  // below this no gain is reported

struct Sample {
  double e, y;
};

/// Collects every k-th gray value that is not saturated, over all images: enough for the start values.
std::vector<Sample> subsample(const GrayPair& pair) {
  const UsableRange u = usable_range(pair, 1.0, 0.0, 0.0);
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < pair.mask.size(); ++i)
    if (pair.mask.data[i] != 0) pixels.push_back(i);
  const std::size_t total = pixels.size() * pair.gain_images.size();
  // an odd stride shares no factor with image widths
  const std::size_t stride = total / kSubsample + (total / kSubsample) % 2 + 1;
  std::vector<Sample> samples;
  for (std::size_t at = 0; at < total; at += stride) {
    const std::size_t pixel = pixels[at % pixels.size()];
    const int image = pair.gain_images[at / pixels.size()];
    const double y = pair.real_at(image, pixel), v = pair.source_at(image, pixel);
    if (y < u.saturation_dn && v > u.sim_low && v < u.sim_high && std::isfinite(v))
      samples.push_back({pair.e_scale * v + pair.e_offset, y});
  }
  return samples;
}

/// Solves weighted least squares of y = a + b (e - center). Returns false when E does not vary.
bool solve_line(const std::vector<Sample>& samples, const std::vector<double>& weight, GainModel& m) {
  double sw = 0, sx = 0, sxx = 0, sy = 0, sxy = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double w = weight[i], x = samples[i].e - m.e_center;
    sw += w, sx += w * x, sxx += w * x * x, sy += w * samples[i].y, sxy += w * x * samples[i].y;
  }
  const double det = sw * sxx - sx * sx;
  if (!(det > 1e-12 * sw * sxx) || !(sxx > 0.0)) return false;
  m.b = (sw * sxy - sx * sy) / det;
  m.a = (sy - m.b * sx) / sw;
  return true;
}

double prediction(const GainModel& m, double e) { return m.a + m.b * (e - m.e_center); }

struct Start {
  GainModel model;
  double scale_dn = 0.0;
  UsableRange usable;
  bool ok = false;
};

/// Returns the least robust scale: rounding makes residuals below it meaningless (noise-free images agree to
/// the last bit).
double smallest_scale(const GrayPair& pair, const std::vector<Sample>& samples) {
  if (!pair.real->radiance) return std::sqrt(kRoundingVariance);
  double largest = 0.0;
  for (const Sample& s : samples) largest = std::max(largest, std::abs(s.y));
  return std::max(1e-7 * largest, 1e-300);
}

/// Iterates reweighted least squares on the subsample: line, robust scale and the clip test settle together.
Start start_values(const GrayPair& pair) {
  Start start;
  const std::vector<Sample> all = subsample(pair);
  if (all.size() < kFewestValues) return start;
  double sum_e = 0.0;
  for (const Sample& s : all) sum_e += s.e;
  GainModel& m = start.model;
  m.e_center = sum_e / static_cast<double>(all.size());
  const double floor_dn = smallest_scale(pair, all);
  if (!solve_line(all, std::vector<double>(all.size(), 1.0), m)) return start;
  std::vector<double> weight(all.size()), size;
  for (int iteration = 0; iteration < 40; ++iteration) {
    // the clip test only once the line is roughly right
    const double margin_sigma = start.scale_dn;
    start.usable = usable_range(pair, m.b, m.a - m.b * m.e_center, margin_sigma);
    const auto usable = [&](const Sample& s) {
      const double p = prediction(m, s.e);
      return iteration < 3 || (p >= start.usable.low_dn && p <= start.usable.high_dn);
    };
    size.clear();
    for (const Sample& s : all)
      if (usable(s)) size.push_back(std::abs(s.y - prediction(m, s.e)));
    if (size.size() < kFewestValues) return start;
    start.scale_dn = std::max(mad_sigma(size), floor_dn);
    const double threshold = kHuber * start.scale_dn;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double r = std::abs(all[i].y - prediction(m, all[i].e));
      weight[i] = usable(all[i]) ? std::min(1.0, threshold / std::max(r, 1e-300)) : 0.0;
    }
    const GainModel before = m;
    if (!solve_line(all, weight, m)) return start;
    // 1 % of the subsample's own standard error; the Newton steps on all values do the rest
    const double settled_dn = 0.01 * start.scale_dn / std::sqrt(static_cast<double>(size.size()));
    const double typical_e = std::abs(m.e_center) + 1e-300;
    if (iteration > 4 && std::abs(m.b - before.b) * typical_e <= settled_dn &&
        std::abs(m.a - before.a) <= settled_dn)
      break;
  }
  m.threshold_dn = kHuber * start.scale_dn;
  start.usable = usable_range(pair, m.b, m.a - m.b * m.e_center, start.scale_dn);
  start.ok = true;
  return start;
}

/// Covariances of (a, b); the larger one counts: sandwich over blocks and sandwich of independent values.
struct Errors {
  Eigen::Matrix2d blocks = Eigen::Matrix2d::Zero(), independent = Eigen::Matrix2d::Zero();
};

Errors standard_errors(const GainSums& sums, double variance_floor_dn2) {
  const Eigen::Matrix2d inverse = sums.information.inverse();
  Errors e;
  const double g = static_cast<double>(sums.n_blocks);
  if (sums.n_blocks > 2) e.blocks = inverse * sums.score_blocks * inverse * (g / (g - 1.0));
  e.independent = inverse * sums.score_independent * inverse;
  // never below what rounding to whole gray values leaves behind
  const Eigen::Matrix2d rounding = variance_floor_dn2 * sums.gram.inverse();
  if (rounding(1, 1) > e.independent(1, 1)) e.independent = rounding;
  return e;
}

void fill_row(GainRow& row, const GainModel& m, const GainSums& sums, const Errors& errors, double scale_dn) {
  const auto n = static_cast<double>(sums.n);
  // black = a - b e_center
  const Eigen::Vector2d to_black(1.0, -m.e_center);
  const auto variance = [&](const Eigen::Vector2d& v) {
    return std::max(v.dot(errors.blocks * v), v.dot(errors.independent * v));
  };
  row.usable = true;
  row.gain_dn = m.b;
  row.gain_sigma_dn = std::sqrt(variance(Eigen::Vector2d::UnitY()));
  row.black_level_dn = m.a - m.b * m.e_center;
  row.black_level_sigma_dn = std::sqrt(variance(to_black));
  row.rms_before_dn = std::sqrt(sums.sum_before2 / n);
  row.rms_after_dn = std::sqrt(sums.sum_r2 / n);
  const double total = sums.sum_y2 - sums.sum_y * sums.sum_y / n;
  row.r2 = total > 0.0 ? 1.0 - sums.sum_r2 / total : kNaN;
  row.n = sums.n;
  row.black_state = "fitted";
  row.robust_scale_dn = scale_dn;
  row.outlier_fraction = static_cast<double>(sums.n_beyond) / n;
  row.sigma_inflation = std::sqrt(errors.blocks(1, 1) / errors.independent(1, 1));
}

GainFit failed(const GrayPair& pair, std::vector<std::string>& warnings, std::uint64_t n) {
  warnings.push_back(fmt::format(
      "{}: no gain can be fitted, only {} gray values are valid, unsaturated and away from the clips",
      pair.camera->name, n));
  GainFit fit;
  fit.row.camera = pair.camera->name;
  fit.row.n = n;
  for (double* number :
       {&fit.row.gain_dn, &fit.row.gain_sigma_dn, &fit.row.black_level_dn, &fit.row.black_level_sigma_dn,
        &fit.row.rms_before_dn, &fit.row.rms_after_dn, &fit.row.r2, &fit.row.sigma_inflation})
    *number = kNaN;
  return fit;
}

}  // namespace

GainFit fit_gain(const GrayPair& pair, std::vector<std::string>& warnings) {
  Start start = start_values(pair);
  if (!start.ok) return failed(pair, warnings, 0);
  GainModel m = start.model;
  const double rounding = (pair.real->radiance ? 0.0 : kRoundingVariance) +
                          (pair.from_dn ? kRoundingVariance * m.b * m.b * pair.e_scale * pair.e_scale : 0.0);
  GainSums sums = sum_gain(pair, start.usable, m);
  Errors errors;
  for (int step = 0; step < 20; ++step) {
    if (sums.n < kFewestValues || !(sums.information.determinant() > 0.0))
      return failed(pair, warnings, sums.n);
    errors = standard_errors(sums, rounding);
    const Eigen::Vector2d move = sums.information.ldlt().solve(sums.score);
    const double sigma_a = std::sqrt(std::max(errors.independent(0, 0), errors.blocks(0, 0)));
    const double sigma_b = std::sqrt(std::max(errors.independent(1, 1), errors.blocks(1, 1)));
    if (std::abs(move[0]) <= 0.01 * sigma_a && std::abs(move[1]) <= 0.01 * sigma_b) break;
    m.a += move[0];
    m.b += move[1];
    sums = sum_gain(pair, start.usable, m);
  }
  GainFit fit;
  fit.usable = start.usable;
  fit.row.camera = pair.camera->name;
  fit.row.low_dn = start.usable.low_dn;
  fit.row.high_dn = start.usable.high_dn;
  fill_row(fit.row, m, sums, errors, start.scale_dn);
  if (pair.real->radiance) fit.row.rms_before_dn = kNaN;  // gray values of the twin against irradiance
  if (pair.from_dn && pair.camera->sensor.has_noise())
    warnings.push_back(
        fmt::format("{}: the simulated irradiance is taken from noisy gray values, which biases the gain "
                    "low; render with --radiance",
                    pair.camera->name));
  return fit;
}

}  // namespace fringetwin::compare
