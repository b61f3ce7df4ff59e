// SPDX-License-Identifier: Apache-2.0
// Makes the Kind of a study of kind "optimise": the settings with which a number is least uncertain.
#pragma once
#include <memory>

#include "study/kind/kind.hpp"
#include "study/optimise/optimise.hpp"

namespace fringetwin::study {

/// The head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const OptimisePlan& plan);

}  // namespace fringetwin::study
