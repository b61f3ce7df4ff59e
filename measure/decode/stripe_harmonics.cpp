// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/stripe_harmonics.hpp"

#include <cmath>

#include "twin/base/constants.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::measure {
namespace {

constexpr int kFirstHarmonic = 2, kLastHarmonic = 6, kWaves = 2 * (kLastHarmonic - kFirstHarmonic + 1);
/// Fewer phases than this tell the ten waves apart no better than noise does.
constexpr double kTellsWaves = 1e-3;
/// Pixels each way over which the turn is averaged: noise of 0.1 rad in a phase is 0.035 rad of the turn.
constexpr int kTurnReach = 2;
/// Of the amplitude, which is some hundred sigmas of the noise: straight stripes leave a hundredth of this.
constexpr double kMatters = 1e-3;

using Waves = Eigen::Matrix<double, kWaves, 1>;

/// Calls each(index, cos k angle, sin k angle) for every harmonic k.
void for_each_harmonic(double angle_rad, auto each) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  double cos_k = c, sin_k = s;
  for (int k = kFirstHarmonic; k <= kLastHarmonic; ++k) {
    const double next = cos_k * c - sin_k * s;
    sin_k = sin_k * c + cos_k * s;
    cos_k = next;
    each(k - kFirstHarmonic, cos_k, sin_k);
  }
}

Waves waves_of(double amplitude, double phase_rad) {
  Waves out;
  for_each_harmonic(phase_rad, [&](int i, double cos_k, double sin_k) {
    out[2 * i] = amplitude * cos_k;
    out[2 * i + 1] = amplitude * sin_k;
  });
  return out;
}

}  // namespace

StripeHarmonics::StripeHarmonics(const NoiseInput& in, const Eigen::MatrixXd& contrasts, Axis axis,
                                 int stride, double min_amplitude)
    : in_(in),
      axis_(axis),
      min_amplitude_(min_amplitude),
      coefficients_(Eigen::MatrixXd::Zero(kWaves, contrasts.cols())) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(kWaves, kWaves), right = coefficients_;
  Eigen::VectorXd steps(contrasts.rows());
  for (int y = 0; y < in.phase->height; y += stride)
    for (int x = 0; x < in.phase->width; x += stride) {
      if (!is_lit(x, y)) continue;
      for (Eigen::Index i = 0; i < steps.size(); ++i)
        steps[i] = static_cast<double>((*in.steps[static_cast<std::size_t>(i)])(x, y));
      const Waves waves =
          waves_of(static_cast<double>((*in.amplitude)(x, y)), static_cast<double>((*in.phase)(x, y)));
      normal += waves * waves.transpose();
      right += waves * (contrasts.transpose() * steps).transpose();
    }
  const SymmetricFactor factor(normal);
  if (factor.rcond() > kTellsWaves) coefficients_ = factor.solve(right);
}

bool StripeHarmonics::matter() const { return coefficients_.cwiseAbs().maxCoeff() > kMatters; }

bool StripeHarmonics::is_lit(int x, int y) const {
  return x >= 0 && y >= 0 && x < in_.phase->width && y < in_.phase->height &&
         std::isfinite((*in_.phase)(x, y)) && static_cast<double>((*in_.amplitude)(x, y)) >= min_amplitude_;
}

double StripeHarmonics::turn_per_px(int x, int y) const {
  const int dx = axis_ == Axis::x ? 0 : 1, dy = axis_ == Axis::x ? 1 : 0;
  double turned_rad = 0.0;
  int pixels = 0;
  for (const int way : {-1, 1})
    for (int i = 1; i <= kTurnReach; ++i) {
      const int to_x = x + way * i * dx, to_y = y + way * i * dy;
      if (!is_lit(to_x, to_y)) break;
      const auto from_rad = static_cast<double>((*in_.phase)(to_x - way * dx, to_y - way * dy));
      turned_rad += way * std::remainder(static_cast<double>((*in_.phase)(to_x, to_y)) - from_rad, kTwoPi);
      ++pixels;
    }
  return pixels > 0 ? turned_rad / pixels : 0.0;
}

Eigen::VectorXd StripeHarmonics::remainder(int x, int y) const {
  Waves waves =
      waves_of(static_cast<double>((*in_.amplitude)(x, y)), static_cast<double>((*in_.phase)(x, y)));
  const double turn_rad = turn_per_px(x, y);
  for (int k = kFirstHarmonic; k <= kLastHarmonic; ++k)
    waves.segment<2>(2 * (k - kFirstHarmonic)) *=
        -4.0 / std::sqrt(6.0) * std::pow(std::sin(0.5 * k * turn_rad), 2);
  return coefficients_.transpose() * waves;
}

}  // namespace fringetwin::measure
