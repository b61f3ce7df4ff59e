// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/gain_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/gray/gain_sums.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kHuber = 1.345;  // 95 % efficiency for Gaussian residuals
constexpr std::size_t kSubsample = 200'000;
constexpr std::uint64_t kFewestValues = 50;  // below this no gain is reported
constexpr double kMarginSigmas = 3.0;        // kept from a clip
constexpr double kWidestScale = 0.01;        // of the range: residuals beyond it are no noise
constexpr double kLeastR2 = 0.5;             // below it the line explains too little to be a gain
constexpr double kMostMoved = 0.2;           // from the ratio of the amplitudes, beyond two of its spreads
constexpr double kAsNoisy = 2.0;             // times the noise: residuals that explain a low R2

struct Sample {
  double e, y;
};

/// Collects every k-th gray value that is not saturated, over all images: enough for the start values.
std::vector<Sample> subsample(const GrayPair& pair) {
  const UsableRange u = usable_range(pair, 1.0, 0.0, {});
  const std::vector<std::size_t> pixels = set_pixels(pair.mask);
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
  std::optional<GainStart> amplitudes;
  std::vector<Sample> samples;
  bool ok = false;
};

/// Returns how far predictions keep away from the clips, by the noise there; by the scale of the residuals
/// where nothing is known of it, but misfit of a whole scene is no noise.
ClipMargins clip_margins(const GrayPair& pair, const GrayNoise* noise, double scale_dn) {
  const double saturation_dn = pair.real->saturation_dn();
  if (!noise || !noise->known() || pair.real->radiance) {
    const double margin_dn = kMarginSigmas * std::min(scale_dn, kWidestScale * saturation_dn);
    return {margin_dn, margin_dn};
  }
  const double dark_dn = kMarginSigmas * std::sqrt(noise->variance(0.0));
  return {kMarginSigmas * std::sqrt(noise->variance(dark_dn)),
          kMarginSigmas * std::sqrt(noise->variance(saturation_dn))};
}

/// Returns the least robust scale: rounding makes residuals below it meaningless (noise-free images agree to
/// the last bit).
double smallest_scale(const GrayPair& pair, const std::vector<Sample>& samples) {
  if (!pair.real->radiance) return std::sqrt(kRoundingVariance);
  double largest = 0.0;
  for (const Sample& s : samples) largest = std::max(largest, std::abs(s.y));
  return std::max(1e-7 * largest, 1e-300);
}

/// Iterates reweighted least squares on the subsample: line, robust scale and the clip test settle together.
Start start_values(const GrayPair& pair, const GrayNoise* noise) {
  Start start;
  start.usable = usable_range(pair, 1.0, 0.0, {});  // without a line nothing is predicted near a clip
  start.usable.low_dn = -std::numeric_limits<double>::infinity();
  start.usable.high_dn = std::numeric_limits<double>::infinity();
  start.samples = subsample(pair);
  const std::vector<Sample>& all = start.samples;
  if (all.size() < kFewestValues) return start;
  double sum_e = 0.0;
  for (const Sample& s : all) sum_e += s.e;
  GainModel& m = start.model;
  m.e_center = sum_e / static_cast<double>(all.size());
  const double floor_dn = smallest_scale(pair, all);
  start.amplitudes = start_of_amplitudes(pair, noise);
  if (start.amplitudes) {
    m.b = start.amplitudes->gain_dn;
    m.a = start.amplitudes->black_level_dn + m.b * m.e_center;
  } else if (!solve_line(all, std::vector<double>(all.size(), 1.0), m)) {
    return start;
  }
  std::vector<double> weight(all.size()), size;
  for (int iteration = 0; iteration < 40; ++iteration) {
    // the clip test only once the line is roughly right
    start.usable = usable_range(pair, m.b, m.a - m.b * m.e_center, clip_margins(pair, noise, start.scale_dn));
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
  start.usable = usable_range(pair, m.b, m.a - m.b * m.e_center, clip_margins(pair, noise, start.scale_dn));
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

/// Says what became of the gray values at the pixels valid on both sides.
std::string say_counts(const GrayPair& pair, const UsableRange& u) {
  std::uint64_t total = 0, saturated = 0, clipped = 0, near_clip = 0;
  for (std::size_t i = 0; i < pair.mask.size(); ++i) {
    if (pair.mask.data[i] == 0) continue;
    for (const int image : pair.gain_images) {
      const double v = pair.source_at(image, i);
      const double predicted = u.gain_dn * pair.irradiance_at(image, i) + u.black_level_dn;
      ++total;
      if (!(pair.real_at(image, i) < u.saturation_dn))
        ++saturated;
      else if (!(v > u.sim_low && v < u.sim_high))
        ++clipped;
      else if (!(predicted >= u.low_dn && predicted <= u.high_dn))
        ++near_clip;
    }
  }
  if (total == 0) return "no pixel is valid on both sides";
  const std::uint64_t left = total - saturated - clipped - near_clip;
  std::string out =
      fmt::format("of {} gray values at pixels valid on both sides {} are saturated", total, saturated);
  if (clipped > 0) out += fmt::format(", {} more are clipped in the simulated images", clipped);
  if (near_clip > 0)
    out += fmt::format(", {} more are predicted below {:.4g} or above {:.4g} DN, too near to a clip",
                       near_clip, u.low_dn, u.high_dn);
  out += fmt::format("; {} are left", left);
  return left < kFewestValues ? out : out + ", and the irradiance does not vary there";
}

/// Says by what the pixels' own amplitudes differ from the twin's.
std::string say_scatter(const GainStart& start) {
  return fmt::format(
      "from pixel to pixel the ratio of real to simulated amplitude varies by {:.0f} %, and {:.1f} "
      "% of the pixels lie far beyond: reflectivity or contrast that the twin lacks",
      100.0 * start.spread, 100.0 * start.outlier_share);
}

/// Returns a fit without a gain, along the line of the amplitudes if there is one.
GainFit without_gain(const GrayPair& pair, const Start& start, const GrayNoise* noise, std::string why,
                     std::vector<std::string>& warnings) {
  GainFit fit;
  fit.start = start.amplitudes;
  fit.row.camera = pair.camera->name;
  for (double* number :
       {&fit.row.gain_dn, &fit.row.gain_sigma_dn, &fit.row.black_level_dn, &fit.row.black_level_sigma_dn,
        &fit.row.rms_before_dn, &fit.row.rms_after_dn, &fit.row.r2, &fit.row.sigma_inflation})
    *number = kNaN;
  if (start.amplitudes && start.amplitudes->gain_dn > 0.0) {
    const GainStart& line = *start.amplitudes;
    const auto residual = [&](const Sample& s) { return s.y - line.gain_dn * s.e - line.black_level_dn; };
    std::vector<double> size;
    for (const Sample& s : start.samples) size.push_back(residual(s));
    const double scale_dn = std::max(mad_sigma(size), smallest_scale(pair, start.samples));
    fit.usable = usable_range(pair, line.gain_dn, line.black_level_dn, clip_margins(pair, noise, scale_dn));
    const GainModel model{line.black_level_dn, line.gain_dn, 0.0, kHuber * scale_dn};
    fit.row.n = sum_gain(pair, fit.usable, model).n;
    if (fit.row.n >= kFewestValues) {
      fit.row.gain_dn = line.gain_dn;
      fit.row.black_level_dn = line.black_level_dn;
      fit.row.low_dn = fit.usable.low_dn;
      fit.row.high_dn = fit.usable.high_dn;
      fit.row.robust_scale_dn = scale_dn;
      fit.row.sigma_inflation = 1.0;
      why += fmt::format(
          "; gray values are judged along a provisional line, {:.5g} DN per unit of irradiance "
          "and black level {:.4g} DN, from the amplitudes of {} pixels: no gain of the sensor",
          line.gain_dn, line.black_level_dn, line.n_pixels);
    }
  }
  fit.row.why = std::move(why);
  warnings.push_back(fmt::format("{}: no gain can be fitted: {}", pair.camera->name, fit.row.why));
  return fit;
}

/// Returns why the fitted line is no gain; empty where it is one.
std::string objection(const Start& start, const GainRow& row, const GainSums& sums, const GrayNoise* noise) {
  const auto& amplitudes = start.amplitudes;
  const double moved = amplitudes ? std::abs(row.gain_dn / amplitudes->gain_dn - 1.0) : 0.0;
  const bool far = amplitudes && moved > kMostMoved + 2.0 * amplitudes->spread;
  // fringes of another phase pull the line away from the amplitudes, reflectivity does not
  std::string hint;
  if (far)
    hint =
        fmt::format("; the fringes' own amplitudes say {:.5g} DN: they do not lie where the twin puts them",
                    amplitudes->gain_dn);
  else if (amplitudes && amplitudes->scatters())
    hint = "; " + say_scatter(*amplitudes);
  if (!(row.gain_dn > 0.0))
    return fmt::format("the line that fits {} gray values best falls with the irradiance{}", row.n, hint);
  if (row.r2 < 0.0)
    return fmt::format("the line that fits {} gray values best explains less than their mean (R2 {:.2f}){}",
                       row.n, row.r2, hint);
  const double level_dn = sums.sum_y / static_cast<double>(sums.n);
  if (noise && noise->measured() &&
      row.rms_after_dn * row.rms_after_dn < kAsNoisy * noise->variance(level_dn))
    return "";  // little light: noise explains what the line does not
  if (row.r2 < kLeastR2)
    return fmt::format("a line explains too little of {} gray values (R2 {:.2f}){}", row.n, row.r2, hint);
  if (far)
    return fmt::format("the line that fits {} gray values best has the slope {:.5g} DN{}", row.n, row.gain_dn,
                       hint);
  return "";
}

GainFit fit_line(const GrayPair& pair, std::vector<std::string>& warnings, const GrayNoise* noise) {
  Start start = start_values(pair, noise);
  if (!start.ok) return without_gain(pair, start, noise, say_counts(pair, start.usable), warnings);
  GainModel m = start.model;
  const double rounding = (pair.real->radiance ? 0.0 : kRoundingVariance) +
                          (pair.from_dn ? kRoundingVariance * m.b * m.b * pair.e_scale * pair.e_scale : 0.0);
  GainSums sums = sum_gain(pair, start.usable, m);
  Errors errors;
  for (int step = 0; step < 20; ++step) {
    if (sums.n < kFewestValues || !(sums.information.determinant() > 0.0))
      return without_gain(pair, start, noise, say_counts(pair, start.usable), warnings);
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
  fit.start = start.amplitudes;
  fit.usable = start.usable;
  fit.row.camera = pair.camera->name;
  fit.row.low_dn = start.usable.low_dn;
  fit.row.high_dn = start.usable.high_dn;
  fill_row(fit.row, m, sums, errors, start.scale_dn);
  std::string why = objection(start, fit.row, sums, noise);
  if (!why.empty()) return without_gain(pair, start, noise, std::move(why), warnings);
  if (pair.real->radiance) fit.row.rms_before_dn = kNaN;  // gray values of the twin against irradiance
  if (fit.start && fit.start->scatters())
    warnings.push_back(fmt::format("{}: {}: the gain is a mean over it and no value of the sensor",
                                   pair.camera->name, say_scatter(*fit.start)));
  if (pair.from_dn && pair.camera->sensor.has_noise())
    warnings.push_back(
        fmt::format("{}: the simulated irradiance is taken from noisy gray values, which biases the gain "
                    "low; render with --radiance",
                    pair.camera->name));
  return fit;
}

}  // namespace

GainFit fit_gain(const GrayPair& pair, std::vector<std::string>& warnings, const GrayNoise* noise) {
  GainFit fit = fit_line(pair, warnings, noise);
  if (pair.real->clip) fit.row.clip_dn = pair.real->clip->dn;
  return fit;
}

GainRow published_row(const GainFit& fit) {
  GainRow row = fit.row;
  if (row.usable) return row;
  row.provisional_gain_dn = row.gain_dn;
  row.provisional_black_level_dn = row.black_level_dn;
  row.gain_dn = row.black_level_dn = row.sigma_inflation = kNaN;
  return row;
}

GainFit fit_of(const GrayPair& pair, const GainRow& published) {
  GainFit fit;
  fit.row = published;
  if (!published.usable) {
    fit.row.gain_dn = published.provisional_gain_dn;
    fit.row.black_level_dn = published.provisional_black_level_dn;
  }
  fit.usable = usable_range(pair, fit.row.gain_dn, fit.row.black_level_dn, {});
  fit.usable.low_dn = published.low_dn;
  fit.usable.high_dn = published.high_dn;
  return fit;
}

}  // namespace fringetwin::compare
