// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "fmt/format.h"
#include "measure/decode/unwrap.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void set_beats(HeterodynePlan& p) {
  const double f[3] = {1.0 / p.pitch_px[0], 1.0 / p.pitch_px[1], 1.0 / p.pitch_px[2]};
  double offset[3];  // x/pitch = order + t + origin/pitch
  for (int i = 0; i < 3; ++i) offset[i] = p.origin_px[i] * f[i];
  const double f12 = f[0] - f[1], f23 = f[1] - f[2], f123 = f12 - f23;
  p.beat12_px = 1.0 / f12;
  p.beat23_px = 1.0 / f23;
  p.origin12_px = (offset[0] - offset[1]) / f12;
  p.origin23_px = (offset[1] - offset[2]) / f23;
  p.synthetic_px = 1.0 / std::fabs(f123);
  p.sign_synthetic = f123 < 0.0 ? -1.0 : 1.0;
  p.origin_synthetic_px = (offset[0] - 2.0 * offset[1] + offset[2]) / f123;
}

/// Equal noise at every pitch: var(x12) = 2 b12^2, var(x23) = 2 b23^2, covariance -b12 b23 (pitch 2 is
/// in both), all times (sigma/2pi)^2.
void set_tolerances(HeterodynePlan& p) {
  const double v12 = 2.0 * p.beat12_px * p.beat12_px, v23 = 2.0 * p.beat23_px * p.beat23_px;
  const double c = -p.beat12_px * p.beat23_px;
  p.weight12 = (v23 - c) / (v12 + v23 - 2.0 * c);
  p.gate_beat_px = 0.5 * std::fabs(p.beat23_px - p.beat12_px);
  p.gate_pitch_px = 0.25 * (p.pitch_px[2] - p.pitch_px[0]);

  const auto limit = [](double noise_factor_cycles) {  // 3 sigma = half an order
    return 0.5 / (3.0 * noise_factor_cycles * kPerCycle);
  };
  // Error of the order of beat 12 (coefficients of the three phases), in its cycles; then of beat 23.
  const double r12 = p.sign_synthetic * p.synthetic_px / p.beat12_px,
               r23 = p.sign_synthetic * p.synthetic_px / p.beat23_px;
  const double first =
      std::sqrt((r12 - 1.0) * (r12 - 1.0) + (1.0 - 2.0 * r12) * (1.0 - 2.0 * r12) + r12 * r12);
  const double second =
      std::sqrt(r23 * r23 + (2.0 * r23 + 1.0) * (2.0 * r23 + 1.0) + (r23 + 1.0) * (r23 + 1.0));
  const double w = p.weight12;
  const double fused =
      std::sqrt(w * w * v12 + (1 - w) * (1 - w) * v23 + 2.0 * w * (1 - w) * c) / p.pitch_px[0];
  // The gates must pass 3 sigma, too: of x12 - x23, and of one pitch against the mean of three.
  const double b12 = p.beat12_px, b23 = p.beat23_px;
  const double beats = std::sqrt(b12 * b12 + (b12 + b23) * (b12 + b23) + b23 * b23) / (2.0 * p.gate_beat_px);
  const double spread = std::sqrt(2.0 / 3.0) * p.pitch_px[2] / (2.0 * p.gate_pitch_px);
  p.tolerance_rad = std::min({limit(first), limit(second), limit(fused), limit(beats), limit(spread)});
}

struct Combined {
  double x_px, variance_px2, spread_px;
};

/// Finds the orders of the three pitches from a coordinate, then their inverse-variance mean.
inline Combined combine(const HeterodynePlan& p, const double* inverse_pitch, const double* t,
                        const double* v, double coarse_px) {
  double x[3], sum_w = 0.0, sum_wx = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double order = round_even((coarse_px - p.origin_px[i]) * inverse_pitch[i] - t[i]);
    x[i] = p.origin_px[i] + p.pitch_px[i] * (order + t[i]);
    const double scale = p.pitch_px[i] * kPerCycle;
    const double w = 1.0 / (v[i] * scale * scale);
    sum_w += w;
    sum_wx += w * x[i];
  }
  const double mean = sum_wx / sum_w;
  const double spread = std::max({std::fabs(x[0] - mean), std::fabs(x[1] - mean), std::fabs(x[2] - mean)});
  return {mean, 1.0 / sum_w, spread};
}

}  // namespace

HeterodynePlan plan_heterodyne(const DirectionFringes& direction, CoordinateRange& range) {
  HeterodynePlan p;
  const std::string where = fmt::format("[fringes] direction {}", axis_name(direction.axis));
  if (direction.pitches_px.size() != 3)
    throw UserError(
        ExitCode::usage, where,
        fmt::format("unwrap = \"heterodyne\" needs three pitches, there are {}", direction.pitches_px.size()),
        "give three pitches_px such as [13, 14, 15]");
  std::sort(p.index, p.index + 3,
            [&](int a, int b) { return direction.pitches_px[a] < direction.pitches_px[b]; });
  for (int i = 0; i < 3; ++i) {
    p.pitch_px[i] = direction.pitches_px[p.index[i]];
    p.origin_px[i] = direction.phase_origin_px[p.index[i]];
  }
  if (!(p.pitch_px[0] > 0.0) || p.pitch_px[0] == p.pitch_px[1] || p.pitch_px[1] == p.pitch_px[2])
    throw UserError(ExitCode::usage, where,
                    "the three pitches of unwrap = \"heterodyne\" must be positive and differ");
  set_beats(p);
  if (!range.known) range.end = range.begin + p.synthetic_px;
  // Slack: 13/14/15 and the like give their beats exactly only in exact arithmetic.
  if (!(p.synthetic_px >= range.size() * (1.0 - 1e-9)) || !std::isfinite(p.synthetic_px))
    throw UserError(
        ExitCode::usage, where,
        fmt::format(
            "the pitches {}, {}, {} repeat after {:.6g} px, which does not cover the projector's {:g} px",
            p.pitch_px[0], p.pitch_px[1], p.pitch_px[2], p.synthetic_px, range.size()),
        "choose pitches whose double beat 1/|1/p1 - 2/p2 + 1/p3| is at least the projector's size");
  p.begin_px = range.begin;
  p.end_px = range.end;
  set_tolerances(p);
  return p;
}

void unwrap_heterodyne_row(const HeterodynePlan& plan, const PitchRow (&pitches)[3], int n, double* x_px,
                           float* variance_px2) {
  const HeterodynePlan p = plan;
  const double inverse_pitch[3] = {1.0 / p.pitch_px[0], 1.0 / p.pitch_px[1], 1.0 / p.pitch_px[2]};
  const double largest_variance = 4.0 * p.tolerance_rad * p.tolerance_rad;
  const double center = 0.5 * (p.begin_px + p.end_px);
  const double inverse_gate_beat = 1.0 / p.gate_beat_px, inverse_gate_pitch = 1.0 / p.gate_pitch_px;
  const double from_center = (center - p.origin_synthetic_px) / p.synthetic_px;
  const double inverse12 = 1.0 / p.beat12_px, inverse23 = 1.0 / p.beat23_px;
  for (int x = 0; x < n; ++x) {
    const double t[3] = {kPerCycle * static_cast<double>(pitches[0].phase_rad[x]),
                         kPerCycle * static_cast<double>(pitches[1].phase_rad[x]),
                         kPerCycle * static_cast<double>(pitches[2].phase_rad[x])};
    const double b12 = t[0] - t[1], b23 = t[1] - t[2], b123 = p.sign_synthetic * (b12 - b23);
    const double v[3] = {static_cast<double>(pitches[0].variance_rad2[x]),
                         static_cast<double>(pitches[1].variance_rad2[x]),
                         static_cast<double>(pitches[2].variance_rad2[x])};
    double doubt = 0.0;  // squared disagreement in units of the gates
    const auto later_stages = [&](double coarse) {
      const double x12 =
          p.origin12_px + p.beat12_px * (b12 + round_even((coarse - p.origin12_px) * inverse12 - b12));
      const double x23 =
          p.origin23_px + p.beat23_px * (b23 + round_even((coarse - p.origin23_px) * inverse23 - b23));
      const double fused = p.weight12 * x12 + (1.0 - p.weight12) * x23;
      Combined c = combine(p, inverse_pitch, t, v, fused);
      const double beat_doubt = std::fabs(x12 - x23) * inverse_gate_beat,
                   pitch_doubt = c.spread_px * inverse_gate_pitch;
      const bool agree = beat_doubt <= 1.0 && pitch_doubt <= 1.0;
      if (!agree || !(c.x_px >= p.begin_px) || !(c.x_px < p.end_px)) c.x_px = kNaN;
      doubt = std::isnan(c.x_px) ? kInfinity : beat_doubt * beat_doubt + pitch_doubt * pitch_doubt;
      return c;
    };
    const double coarse = p.origin_synthetic_px + p.synthetic_px * (b123 + round_even(from_center - b123));
    Combined c = later_stages(coarse);
    // Near the ends noise may take the synthetic order to the other end: the pitches tell which it is.
    if (std::fabs(coarse - center) > 0.4 * p.synthetic_px) {
      const double first_doubt = doubt;
      const Combined other = later_stages(coarse + (coarse < center ? p.synthetic_px : -p.synthetic_px));
      if (doubt < first_doubt) c = other;
    }
    x_px[x] = std::max({v[0], v[1], v[2]}) <= largest_variance ? c.x_px : kNaN;
    variance_px2[x] = static_cast<float>(c.variance_px2);
  }
}

std::optional<double> resolve_heterodyne(const HeterodynePlan& plan, const double (&t)[3],
                                         const double (&variance_rad2)[3], double predicted_px) {
  const double inverse_pitch[3] = {1.0 / plan.pitch_px[0], 1.0 / plan.pitch_px[1], 1.0 / plan.pitch_px[2]};
  const Combined c = combine(plan, inverse_pitch, t, variance_rad2, predicted_px);
  if (!(c.spread_px <= plan.gate_pitch_px)) return std::nullopt;
  return c.x_px;
}

}  // namespace fringetwin::measure
