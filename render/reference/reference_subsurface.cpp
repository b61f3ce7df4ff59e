// SPDX-License-Identifier: Apache-2.0
#include "render/reference/reference_subsurface.hpp"

#include <cmath>
#include <numbers>

#include "twin/base/errors.hpp"

namespace fringetwin::render {

using std::numbers::pi;
using Complex = std::complex<double>;

double reference_scattered_share(double albedo) {
  double s = 0.5;
  for (int i = 0; i < 50; ++i) {
    const double top = (1.0 - s) * (1.0 - 0.139 * s), below = 1.0 + 1.17 * s;
    const double slope = (-(1.0 - 0.139 * s) - 0.139 * (1.0 - s)) / below - 1.17 * top / (below * below);
    s -= (top / below - albedo) / slope;
  }
  return 1.0 - s * s;
}

Complex reference_kept_below(const BelowSurface& place, const Eigen::Vector2d& k_per_px) {
  constexpr double kRefraction = 1.4;
  const Eigen::Vector2d k = place.mean_free_path_mm * place.px_per_mm.transpose() * k_per_px;
  const Eigen::Vector2d in = place.to_light / kRefraction, out = place.to_viewer / kRefraction;
  const auto reflected = [&](const Eigen::Vector2d& frequency) {
    const Complex i(0.0, 1.0);
    const Complex a = (1.0 - i * frequency.dot(in)) / std::sqrt(1.0 - in.squaredNorm());
    const Complex b = (1.0 + i * frequency.dot(out)) / std::sqrt(1.0 - out.squaredNorm());
    const auto h = [&](const Complex& slant) {
      return (slant + std::sqrt(frequency.squaredNorm() + 3.0)) /
             (slant + std::sqrt(frequency.squaredNorm() + 3.0 * (1.0 - place.scattered_share)));
    };
    return h(a) * h(b) / (a + b);
  };
  return reflected(k) / reflected(Eigen::Vector2d::Zero());
}

PatternSpectrum::PatternSpectrum(const std::function<double(double)>& value, double period_px, int samples)
    : period_px_(period_px) {
  std::vector<double> values;
  for (int i = 0; i < samples; ++i) values.push_back(value((i + 0.5) * period_px / samples));
  for (int h = 0; h < samples / 2; ++h) {
    Complex sum = 0.0;
    for (int i = 0; i < samples; ++i) sum += values[i] * std::polar(1.0, -2.0 * pi * h * (i + 0.5) / samples);
    terms_.push_back(sum * ((h == 0 ? 1.0 : 2.0) / samples));
  }
}

double PatternSpectrum::value(double at_px, const Eigen::Vector2d& axis, const BelowSurface& place) const {
  constexpr double kNothing = 1e-12;
  double sum = 0.0;
  for (std::size_t h = 0; h < terms_.size(); ++h) {
    if (std::abs(terms_[h]) < kNothing) continue;
    const double k = 2.0 * pi * static_cast<double>(h) / period_px_;
    sum += (terms_[h] * std::polar(1.0, k * at_px) * reference_kept_below(place, k * axis)).real();
  }
  return sum;
}

std::vector<PatternSpectrum> pattern_spectra(const Twin& twin,
                                             const std::vector<ReferencePattern>& patterns) {
  FT_CHECK(
      !twin.projector->has_blur_field() && !twin.fringes.has_harmonics_field() && twin.fringes.images.empty(),
      "light below surfaces under patterns that have one spectrum");
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  std::vector<PatternSpectrum> spectra;
  for (std::size_t i = 0; i < patterns.size(); ++i) {
    const DirectionFringes& direction = twin.fringes.directions[sequence[i].direction];
    const bool step = sequence[i].kind == PatternSpec::Kind::phase_step;
    const double pitch = direction.pitches_px.at(step ? sequence[i].pitch : 0);
    const int words = step ? 1 : 1 << direction.gray->bits;
    const auto value = [&](double x) {
      return patterns[i](direction.axis == Axis::x ? Eigen::Vector2d(x, 0.0) : Eigen::Vector2d(0.0, x),
                         Eigen::Vector2d::Zero());
    };
    spectra.emplace_back(value, pitch * words, step ? 256 : 64 * words);
  }
  return spectra;
}

}  // namespace fringetwin::render
