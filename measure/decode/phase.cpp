// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/phase.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>

#include "twin/base/errors.hpp"

namespace fringetwin::measure {
namespace {

/// Largest float below pi, so that results stay inside (-pi, pi].
constexpr float kPiFloat = 3.14159250f;

/// Returns atan2(y, x), computed without branches, so that the compiler vectorises it; error below 4e-7 rad.
/// Polynomial: S. Moshier, Cephes atanf.c, |z| <= tan(pi/8). atan2(0, 0) = 0; atan2(-0, -1) = pi.
inline float atan2_select(float y, float x) {
  const float ax = std::fabs(x), ay = std::fabs(y);
  const float small = ax < ay ? ax : ay;
  const float large = ax < ay ? ay : ax;
  const bool upper = small > 0.41421356f * large;
  const float numerator = upper ? small - large : small;
  float denominator = upper ? small + large : large;
  denominator = denominator == 0.0f ? 1.0f : denominator;
  const float z = numerator / denominator;
  const float z2 = z * z;
  float a =
      (((8.05374449538e-2f * z2 - 1.38776856032e-1f) * z2 + 1.99777106478e-1f) * z2 - 3.33329491539e-1f) *
          z2 * z +
      z;
  a += upper ? 0.785398163397f : 0.0f;
  a = ax < ay ? 1.57079632679f - a : a;
  a = x < 0.0f ? kPiFloat - a : a;
  a = a > kPiFloat ? kPiFloat : a;
  return y < 0.0f ? -a : a;
}

constexpr int kBlock = 256;  ///< pixels solved together: their sums stay in the first-level cache

/// Solves n <= kBlock neighbouring pixels from `begin` on.
void solve_block(const StepSolver& solver, const float* const* steps, int begin, int n, const PhaseRow& out) {
  float mean[kBlock] = {}, c[kBlock] = {}, s[kBlock] = {}, maximum[kBlock];
  std::fill(maximum, maximum + n, -std::numeric_limits<float>::infinity());
  for (int i = 0; i < solver.count(); ++i) {
    const float wm = solver.mean_weights()[i], wc = solver.cos_weights()[i], ws = solver.sin_weights()[i];
    const float* value = steps[i] + begin;
    for (int x = 0; x < n; ++x) {
      const float v = value[x];
      mean[x] += wm * v;
      c[x] += wc * v;
      s[x] += ws * v;
      maximum[x] = v > maximum[x] ? v : maximum[x];
    }
  }
  for (int x = 0; x < n; ++x) out.phase_rad[begin + x] = atan2_select(s[x], c[x]);
  if (out.amplitude)
    for (int x = 0; x < n; ++x) out.amplitude[begin + x] = std::sqrt(c[x] * c[x] + s[x] * s[x]);
  if (out.mean) std::copy(mean, mean + n, out.mean + begin);
  if (out.maximum) std::copy(maximum, maximum + n, out.maximum + begin);
  if (!out.residual) return;

  const int freedom = solver.count() - 3;
  if (freedom == 0) {
    std::fill(out.residual + begin, out.residual + begin + n, std::numeric_limits<float>::quiet_NaN());
    return;
  }
  float sum[kBlock] = {};
  for (int i = 0; i < solver.count(); ++i) {
    const auto bc = static_cast<float>(solver.basis_cos(i)), bs = static_cast<float>(solver.basis_sin(i));
    const float* value = steps[i] + begin;
    for (int x = 0; x < n; ++x) {
      const float r = value[x] - (mean[x] + bc * c[x] + bs * s[x]);
      sum[x] += r * r;
    }
  }
  const float scale = 1.0f / static_cast<float>(freedom);
  for (int x = 0; x < n; ++x) out.residual[begin + x] = std::sqrt(sum[x] * scale);
}

}  // namespace

std::vector<int> all_steps(int steps_total) {
  std::vector<int> steps(static_cast<std::size_t>(steps_total));
  std::iota(steps.begin(), steps.end(), 0);
  return steps;
}

StepSolver::StepSolver(const std::vector<int>& steps_n, int steps_total) {
  std::vector<int> sorted = steps_n;
  std::ranges::sort(sorted);
  const bool distinct = std::ranges::adjacent_find(sorted) == sorted.end();
  if (steps_n.size() < 3 || !distinct || sorted.front() < 0 || sorted.back() >= steps_total)
    throw UserError(
        ExitCode::usage, "phase steps",
        "the phase needs at least 3 different steps out of 0..." + std::to_string(steps_total - 1),
        "name at least three distinct step numbers");
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (const int n : steps_n) {
    const double angle = 2.0 * std::numbers::pi * n / steps_total;
    basis_cos_.push_back(std::cos(angle));
    basis_sin_.push_back(-std::sin(angle));
    const Eigen::Vector3d a(1.0, basis_cos_.back(), basis_sin_.back());
    normal += a * a.transpose();
  }
  const Eigen::Matrix3d inverse = normal.inverse();  // three points of a circle: never singular
  for (std::size_t i = 0; i < steps_n.size(); ++i) {
    const Eigen::Vector3d w = inverse * Eigen::Vector3d(1.0, basis_cos_[i], basis_sin_[i]);
    mean_.push_back(static_cast<float>(w[0]));
    cos_.push_back(static_cast<float>(w[1]));
    sin_.push_back(static_cast<float>(w[2]));
  }
  cov_cc_ = inverse(1, 1);
  cov_cs_ = inverse(1, 2);
  cov_ss_ = inverse(2, 2);
  isotropic_ = std::fabs(cov_cc_ - cov_ss_) < 1e-12 && std::fabs(cov_cs_) < 1e-12;
}

void solve_row(const StepSolver& solver, const float* const* steps, int n, const PhaseRow& out) {
  for (int begin = 0; begin < n; begin += kBlock)
    solve_block(solver, steps, begin, std::min(kBlock, n - begin), out);
}

}  // namespace fringetwin::measure
