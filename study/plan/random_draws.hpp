// SPDX-License-Identifier: Apache-2.0
// Draws random numbers without a state: seed, stream, trial and dimension go in, and the same number comes
// out on every machine, in any order of the calls and after any interruption.
#pragma once
#include <cstdint>

namespace fringetwin::study {

/// Names independent sequences of random numbers of one seed.
enum class DrawStream : std::uint32_t {
  trials = 0,
  sensitivity_a = 1,
  sensitivity_b = 2,
  bootstrap = 3,
  form = 4
};

/// Returns 64 random bits (Philox4x32-10).
std::uint64_t random_bits(std::uint64_t seed, DrawStream stream, std::uint64_t trial,
                          std::uint32_t dimension);
/// Returns a number drawn uniformly from (0, 1), with 52 bits; never an end.
double unit_draw(std::uint64_t seed, DrawStream stream, std::uint64_t trial, std::uint32_t dimension);

/// Returns x with P(X <= x) = u of the standard normal distribution, 0 < u < 1; relative error below 1e-14
/// out to 8 sigma. Quantiles, not Box-Muller: quasi-random points stay what they are.
double normal_quantile(double u);

}  // namespace fringetwin::study
