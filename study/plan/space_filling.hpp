// SPDX-License-Identifier: Apache-2.0
// Places in the unit cube that fill it more evenly than random ones: a Latin hypercube and Sobol's sequence.
#pragma once
#include <cstdint>
#include <vector>

namespace fringetwin::study {

/// [point][dimension], each in [0, 1).
using UnitPoints = std::vector<std::vector<double>>;

/// n points, in every dimension one at a random place in each of n equal intervals; which goes with which is
/// drawn (McKay, Beckman and Conover 1979). It keeps that order alone, 4 bytes per coordinate.
class LatinHypercube {
 public:
  LatinHypercube(int n, int dimensions, std::uint64_t seed);
  std::vector<double> point(std::size_t index) const;

 private:
  std::uint32_t count_;
  std::uint64_t seed_;
  std::vector<std::uint32_t> order_;  ///< the interval of each point, one dimension after the other
};

/// Returns the first n points of Sobol's sequence, scrambled as Owen does it: each stays uniformly
/// distributed, and together they keep the net's property (of 2^k points one in each of 2^k equal intervals
/// of each dimension). A longer sequence begins with the shorter one. At most render::kSobolDimensions.
UnitPoints scrambled_sobol(int n, int dimensions, std::uint64_t seed);
/// Returns the point of that index.
std::vector<double> scrambled_sobol_point(std::size_t index, int dimensions, std::uint64_t seed);

/// Returns which of n equal shares of [0, 1] has the place u.
std::size_t share_of(double u, std::size_t n);
/// Returns the middle of the i-th of n equal shares of [0, 1].
double middle_of_share(std::size_t i, std::size_t n);

}  // namespace fringetwin::study
