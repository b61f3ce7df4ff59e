// SPDX-License-Identifier: Apache-2.0
#include "study/plan/random_draws.hpp"

#include <cmath>
#include <numbers>

#include "render/base/philox.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

/// Abramowitz and Stegun 26.2.23: within 4.5e-4 of the quantile of a tail 0 < tail <= 1/2, as a distance.
double tail_start(double tail) {
  const double t = std::sqrt(-2.0 * std::log(tail));
  return t -
         (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
}

/// Returns x >= 0 with P(X > x) = tail. Halley's steps on the tail itself, which keeps its relative
/// precision.
double upper_quantile(double tail) {
  double x = tail_start(tail);
  for (int step = 0; step < 2; ++step) {  // 4.5e-4 -> 1e-11 -> rounding
    const double excess = 0.5 * std::erfc(x / std::numbers::sqrt2) - tail;
    const double newton = excess * std::sqrt(2.0 * std::numbers::pi) * std::exp(0.5 * x * x);
    x += newton / (1.0 - 0.5 * x * newton);
  }
  return x;
}

}  // namespace

std::uint64_t random_bits(std::uint64_t seed, DrawStream stream, std::uint64_t trial,
                          std::uint32_t dimension) {
  const auto low = [](std::uint64_t v) { return static_cast<std::uint32_t>(v); };
  const auto words =
      render::philox4x32({low(trial), low(trial >> 32), dimension, static_cast<std::uint32_t>(stream)},
                         {low(seed), low(seed >> 32)});
  return (std::uint64_t{words[0]} << 32) | words[1];
}

double unit_draw(std::uint64_t seed, DrawStream stream, std::uint64_t trial, std::uint32_t dimension) {
  // 52 bits and a half: with 53 the largest would round to 1.
  return (static_cast<double>(random_bits(seed, stream, trial, dimension) >> 12) + 0.5) * 0x1p-52;
}

double normal_quantile(double u) {
  FT_CHECK(u > 0.0 && u < 1.0, "a probability inside (0, 1)");
  return u < 0.5 ? -upper_quantile(u) : upper_quantile(1.0 - u);
}

}  // namespace fringetwin::study
