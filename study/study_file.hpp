// SPDX-License-Identifier: Apache-2.0
// Reads a STUDY.toml (docs/formats/study.md): what every study says, and the plan of its kind. The kinds of
// studies are listed here and nowhere else.
#pragma once
#include <filesystem>
#include <memory>
#include <variant>

#include "study/design/design_plan.hpp"
#include "study/kind/kind.hpp"
#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/optimise/optimise.hpp"
#include "study/plan/study_head.hpp"
#include "study/volume_map/volume_map.hpp"

namespace fringetwin::study {

struct StudyFile {
  StudyHead head;
  std::variant<DesignPlan, MonteCarloPlan, VolumeMapPlan, OptimisePlan> plan;
};

/// Throws UserError(usage) with file, line and key.
StudyFile load_study(const std::filesystem::path& file);

/// Returns what runs this study, whose file must outlive it.
std::unique_ptr<Kind> kind_of(const StudyFile& file);

}  // namespace fringetwin::study
