// SPDX-License-Identifier: Apache-2.0
// Makes Sobol's low-discrepancy sequence from the direction numbers of S. Joe and F. Y. Kuo, "Constructing
// Sobol sequences with better two-dimensional projections", SIAM J. Sci. Comput. 30 (2008), table
// new-joe-kuo-6.
#pragma once
#include <array>
#include <cstdint>

namespace fringetwin::render {

constexpr int kSobolDimensions = 40;

/// Returns the direction numbers of a dimension, 0 ... kSobolDimensions - 1; dimension 0 is van der Corput's
/// sequence.
std::array<std::uint32_t, 32> sobol_directions(int dimension);

/// Returns the coordinate of point `index` in the dimension of these direction numbers, in units of 2^-32.
inline std::uint32_t sobol_coordinate(const std::array<std::uint32_t, 32>& directions, std::uint32_t index) {
  std::uint32_t x = 0;
  for (std::uint32_t bit = 0; index != 0; ++bit, index >>= 1)
    if (index & 1U) x ^= directions[bit];
  return x;
}

}  // namespace fringetwin::render
