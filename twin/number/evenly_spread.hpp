// SPDX-License-Identifier: Apache-2.0
// Chooses some of many things from all over them, without the beat that equal steps have with rows of pixels.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

namespace fringetwin {

/// Returns at most `most` indices below n, spread evenly: the multiples of the golden ratio, modulo 1. All of
/// them where there are no more than asked for.
inline std::vector<std::size_t> evenly_spread(std::size_t n, std::size_t most) {
  constexpr double kGoldenPart = 0.6180339887498949;
  std::vector<std::size_t> out(std::min(n, most));
  std::iota(out.begin(), out.end(), std::size_t{0});
  if (n <= most) return out;
  for (std::size_t& i : out)
    i = static_cast<std::size_t>(std::fmod(static_cast<double>(i) * kGoldenPart, 1.0) *
                                 static_cast<double>(n));
  return out;
}

}  // namespace fringetwin
