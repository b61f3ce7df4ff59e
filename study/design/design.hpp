// SPDX-License-Identifier: Apache-2.0
// Which points a study runs.
#pragma once
#include <cstdint>
#include <vector>

#include "study/plan/study_point.hpp"
#include "study/study_file.hpp"

namespace fringetwin::study {

/// [point][dimension], each in [0, 1).
using UnitPoints = std::vector<std::vector<double>>;

/// In every dimension one point, at a random place, in each of n equal intervals; which goes with which is
/// drawn (McKay, Beckman and Conover 1979).
UnitPoints latin_hypercube(int n, int dimensions, std::uint64_t seed);

/// The first n points of Sobol's sequence, scrambled as Owen does it: each stays uniformly distributed, and
/// together they keep the net's property (of 2^k points one in each of 2^k equal intervals of each
/// dimension). A longer sequence begins with the shorter one. At most render::kSobolDimensions.
UnitPoints scrambled_sobol(int n, int dimensions, std::uint64_t seed);

/// Which of n equal shares of [0, 1] has the place u, and the middle of the i-th.
std::size_t share_of(double u, std::size_t n);
double middle_of_share(std::size_t i, std::size_t n);

/// The values of one [[vary]] as TOML text; of a range without `count` none.
std::vector<std::string> listed_values(const Variation& variation);
/// Its value at a place u in [0, 1]: along the range, or of the list the one in whose equal share u lies.
std::string value_at(const Variation& variation, double u);

/// Gives all its keys what they take there.
void assign_at(const Variation& variation, double u, Settings* settings);

/// All points in their order: the first [[vary]] slowest, noise seeds fastest.
std::vector<StudyPoint> design_points(const StudyFile& study);

}  // namespace fringetwin::study
