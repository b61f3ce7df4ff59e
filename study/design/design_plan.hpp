// SPDX-License-Identifier: Apache-2.0
// A study of kind "design": reads what it varies and how (docs/formats/study.md), gives the points that
// follow from it, the Kind that runs them, and the page of their results.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "study/kind/kind.hpp"
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
PointSequence design_points(const DesignPlan& plan);

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> design_keys();

/// Reads the plan of a STUDY.toml. Throws UserError(usage) with file, line and key.
DesignPlan read_design(const TomlTable& root);

/// Returns what runs the study; the head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const DesignPlan& plan);

/// Returns the page and its drawings. Throws Cancelled.
StudyReport design_report(const StudyRecord& study, const DesignPlan& plan);

}  // namespace fringetwin::study
