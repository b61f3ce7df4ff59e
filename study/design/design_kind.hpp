// SPDX-License-Identifier: Apache-2.0
// Makes the Kind of a study of kind "design": every point of a grid, list, Latin hypercube or Sobol design.
#pragma once
#include <memory>

#include "study/design/design_plan.hpp"
#include "study/kind/kind.hpp"

namespace fringetwin::study {

/// The head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const DesignPlan& plan);

}  // namespace fringetwin::study
