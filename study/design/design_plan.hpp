// SPDX-License-Identifier: Apache-2.0
// The plan of a study of kind "design": what it varies and how, and the points that follow from it.
#pragma once
#include <cstdint>
#include <vector>

#include "study/plan/study_point.hpp"
#include "study/plan/study_tables.hpp"

namespace fringetwin::study {

enum class Design { grid, list, latin_hypercube, sobol };

struct DesignPlan {
  Design design = Design::grid;
  int points = 0;  ///< of latin_hypercube and sobol
  std::uint64_t seed = 1;
  int noise_seeds = 1;
  std::uint64_t first_noise_seed = 1;
  std::vector<Variation> vary;

  /// True where the values are drawn, not listed.
  bool is_sampled() const { return design == Design::latin_hypercube || design == Design::sobol; }
};

/// Returns all points in their order: the first [[vary]] slowest, noise seeds fastest.
std::vector<StudyPoint> design_points(const DesignPlan& plan);

}  // namespace fringetwin::study
