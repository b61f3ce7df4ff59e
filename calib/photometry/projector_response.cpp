// SPDX-License-Identifier: Apache-2.0
#include "calib/photometry/projector_response.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "twin/base/constants.hpp"

namespace fringetwin::calib {
namespace {

// Fringes are never known better than this: exposure differs from image to image, pixels are no squares.
constexpr double kModelError = 0.003;
constexpr double kGoodMisfit = 0.01;
constexpr int kTableLevels = 33;  // linear between them: 2.5e-4 off for gamma 2

double gaussian(double blur_sq, double pitch_px, int order) {
  return std::exp(-2.0 * std::numbers::pi * std::numbers::pi * blur_sq * order * order /
                  (pitch_px * pitch_px));
}

const PitchHarmonics& reference_of(const FringeHarmonics& h) { return h.pitches[h.reference]; }

std::vector<MtfPoint> mtf_points(const FringeHarmonics& f) {
  std::vector<MtfPoint> points;
  const PitchHarmonics& reference = reference_of(f);
  for (const PitchHarmonics& pitch : f.pitches) {
    if (&pitch == &reference) continue;
    for (std::size_t k = 0; k < pitch.amplitude.size(); ++k) {
      const Estimate a = pitch.amplitude[k], r = reference.amplitude[k];
      if (!(std::abs(r.value) > 0.01) || !(std::abs(r.value) > 10.0 * r.sigma) ||
          !(a.value / r.value > 0.02) || !(std::abs(a.value) > 10.0 * a.sigma))
        continue;
      MtfPoint m{.pitch_px = pitch.pitch_px, .order = static_cast<int>(k) + 1};
      m.period_px = pitch.pitch_px / m.order;
      m.contrast.value = a.value / r.value;
      m.contrast.sigma = std::abs(m.contrast.value) * std::hypot(a.sigma / a.value, r.sigma / r.value);
      m.camera_factor = pitch.camera_factor[k] / reference.camera_factor[k];
      points.push_back(m);
    }
  }
  return points;
}

/// ln(contrast / camera) = -2 pi^2 blur^2 h^2 (1/p^2 - 1/p_ref^2), weighted through the origin.
void fit_blur(ProjectorPhotometry& out) {
  if (out.mtf.empty()) return;
  const double reference = reference_of(out.harmonics).pitch_px;
  const auto x_of = [&](const MtfPoint& m) {
    const double h = m.order;
    return -2.0 * std::numbers::pi * std::numbers::pi * h * h *
           (1.0 / (m.pitch_px * m.pitch_px) - 1.0 / (reference * reference));
  };
  const auto y_of = [](const MtfPoint& m) { return std::log(m.contrast.value / m.camera_factor); };
  double xx = 0.0, xy = 0.0;
  for (const MtfPoint& m : out.mtf) {
    const double w = 1.0 / (std::pow(m.contrast.sigma / m.contrast.value, 2) + kModelError * kModelError);
    xx += w * x_of(m) * x_of(m);
    xy += w * x_of(m) * y_of(m);
  }
  const double blur_sq = xy / xx;
  double chi2 = 0.0, sum = 0.0;
  for (MtfPoint& m : out.mtf) {
    const double off = y_of(m) - blur_sq * x_of(m);
    chi2 += off * off / (std::pow(m.contrast.sigma / m.contrast.value, 2) + kModelError * kModelError);
    sum += off * off;
  }
  const auto n = static_cast<double>(out.mtf.size());
  out.blur_misfit = std::sqrt(sum / n);
  const double spread = std::sqrt(std::max(1.0, n > 1.0 ? chi2 / (n - 1.0) : 1.0) / xx);
  out.blur_px.value = std::sqrt(std::max(0.0, blur_sq));
  out.blur_px.sigma = blur_sq > spread ? 0.5 * spread / out.blur_px.value
                                       : std::sqrt(std::max(0.0, blur_sq) + spread) - out.blur_px.value;
  for (MtfPoint& m : out.mtf) m.gaussian = std::exp(std::max(0.0, blur_sq) * x_of(m));
}

/// Relative harmonics of the light before blur and camera.
std::vector<Estimate> light_harmonics(const ProjectorPhotometry& p) {
  const PitchHarmonics& reference = reference_of(p.harmonics);
  const double blur = std::isfinite(p.blur_px.value) ? p.blur_px.value : 0.0,
               spread = std::isfinite(p.blur_px.sigma) ? p.blur_px.sigma : 0.0;
  const auto lowered = [&](double b, std::size_t k) {
    return gaussian(b * b, reference.pitch_px, static_cast<int>(k) + 1) * reference.camera_factor[k];
  };
  std::vector<Estimate> out;
  for (std::size_t k = 1; k < reference.amplitude.size(); ++k) {
    const Estimate a = reference.amplitude[k];
    const double factor = lowered(blur, k) / lowered(blur, 0);
    const double by_blur = lowered(blur + spread, k) / lowered(blur + spread, 0);
    out.push_back({a.value / factor, std::hypot(a.sigma / factor, a.value / by_blur - a.value / factor)});
  }
  return out;
}

double chi2_of(double gamma, const std::vector<Estimate>& r, double mean, double amplitude) {
  const std::vector<double> g = gamma_harmonics(gamma, mean, amplitude, static_cast<int>(r.size()) + 1);
  double sum = 0.0;
  for (std::size_t k = 0; k < r.size(); ++k)
    sum += std::pow((r[k].value - g[k + 1] / g[0]) / std::hypot(r[k].sigma, kModelError), 2);
  return sum;
}

void fit_gamma(ProjectorPhotometry& p, double mean, double amplitude) {
  const auto& r = p.response_harmonics;
  if (r.empty()) return;
  const auto chi2 = [&](double gamma) { return chi2_of(gamma, r, mean, amplitude); };
  double best = 0.2;
  for (double g = 0.2; g <= 5.0; g += 0.05)
    if (chi2(g) < chi2(best)) best = g;
  double low = std::max(0.1, best - 0.05), high = best + 0.05;  // golden section
  const double ratio = 0.5 * (std::sqrt(5.0) - 1.0);
  while (high - low > 1e-6) {
    const double a = high - ratio * (high - low), b = low + ratio * (high - low);
    if (chi2(a) < chi2(b))
      high = b;
    else
      low = a;
  }
  p.gamma.value = 0.5 * (low + high);
  // d ratio_h / d gamma is the Jacobian of the weighted fit.
  constexpr double kStep = 1e-3;
  const int n = static_cast<int>(r.size()) + 1;
  const auto plus = gamma_harmonics(p.gamma.value + kStep, mean, amplitude, n),
             minus = gamma_harmonics(p.gamma.value - kStep, mean, amplitude, n),
             at = gamma_harmonics(p.gamma.value, mean, amplitude, n);
  double information = 0.0, off = 0.0;
  for (std::size_t k = 0; k < r.size(); ++k) {
    const double slope = (plus[k + 1] / plus[0] - minus[k + 1] / minus[0]) / (2.0 * kStep);
    information += std::pow(slope / std::hypot(r[k].sigma, kModelError), 2);
    off += std::pow(r[k].value - at[k + 1] / at[0], 2);
  }
  const double dof = std::max(1.0, static_cast<double>(r.size()) - 1.0);
  const double inflation = std::max(1.0, r.size() > 1 ? chi2(p.gamma.value) / dof : 1.0);
  p.gamma.sigma = std::sqrt(inflation / information);
  // rms over theta of the difference, whose range is about two fundamentals.
  p.gamma_misfit = 0.5 * std::sqrt(0.5 * off);
}

void make_curve(ProjectorPhotometry& p, double mean, double amplitude) {
  const auto& r = p.response_harmonics;
  if (r.size() < 2) return;
  const auto light = [&](double theta) {
    double sum = std::cos(theta);
    for (std::size_t k = 0; k < r.size(); ++k)
      sum += r[k].value * std::cos(static_cast<double>(k + 2) * theta);
    return sum;
  };
  const double low = light(std::numbers::pi), range = light(0.0) - low;
  for (int i = 0; i < kTableLevels; ++i) {
    const double u = -1.0 + 2.0 * i / (kTableLevels - 1.0), theta = std::acos(u);
    double variance = 0.0;
    const double value = (light(theta) - low) / range;
    for (std::size_t k = 0; k < r.size(); ++k) {  // d value / d r_h
      const auto h = static_cast<double>(k + 2);
      const double end = std::cos(h * std::numbers::pi);
      const double slope = (std::cos(h * theta) - end - value * (1.0 - end)) / range;
      variance += slope * slope * r[k].sigma * r[k].sigma;
    }
    p.curve_level.push_back(mean + amplitude * u);
    p.curve_light.push_back(value);
    p.curve_sigma.push_back(std::sqrt(variance));
  }
}

void choose_response(ProjectorPhotometry& p, double mean, double amplitude) {
  if (!std::isfinite(p.gamma.value)) return;
  p.response_known = true;
  const bool covers = mean - amplitude < 1e-6 && mean + amplitude > 1.0 - 1e-6;
  if (p.gamma_misfit > kGoodMisfit && covers && !p.curve_light.empty()) {
    p.response.kind = ProjectorResponse::Kind::table;
    double highest = 0.0;
    for (const double v : p.curve_light) {  // a response does not fall; wiggles of the series would
      highest = std::max(highest, std::clamp(v, 0.0, 1.0));
      p.response.table.push_back(std::round(highest * 1e5) * 1e-5);
    }
  } else if (std::abs(p.gamma.value - 1.0) < std::max(0.01, 2.0 * p.gamma.sigma)) {
    p.response.kind = ProjectorResponse::Kind::linear;
  } else {
    p.response.kind = ProjectorResponse::Kind::gamma;
    p.response.gamma = p.gamma.value;
  }
}

}  // namespace

std::vector<double> gamma_harmonics(double gamma, double mean, double amplitude, int n) {
  constexpr int kPoints = 1024;  // trapezoid on a period
  std::vector<double> out(static_cast<std::size_t>(n), 0.0);
  for (int i = 0; i < kPoints; ++i) {
    const double theta = 2.0 * std::numbers::pi * (i + 0.5) / kPoints;
    const double light = std::pow(std::max(0.0, mean + amplitude * std::cos(theta)), gamma);
    for (int h = 1; h <= n; ++h) out[h - 1] += 2.0 / kPoints * light * std::cos(h * theta);
  }
  return out;
}

bool ProjectorPhotometry::tells_blur() const {
  const double square = blur_px.value * blur_px.value, upper = blur_px.value + blur_px.sigma,
               spread = upper * upper - square;
  const auto told_from = [&](double other_px) {
    return std::abs(square - other_px * other_px) >= 3.0 * spread;
  };
  return told_from(0.0) || told_from(blur_of_twin_px);
}

ProjectorPhotometry projector_photometry(FringeHarmonics harmonics, double mean, double amplitude) {
  ProjectorPhotometry p;
  p.harmonics = std::move(harmonics);
  p.gamma_misfit = p.blur_misfit = kNaN;
  if (p.harmonics.pitches.empty()) return p;
  p.mtf = mtf_points(p.harmonics);
  fit_blur(p);
  p.response_harmonics = light_harmonics(p);
  fit_gamma(p, mean, amplitude);
  make_curve(p, mean, amplitude);
  choose_response(p, mean, amplitude);
  return p;
}

}  // namespace fringetwin::calib
