// SPDX-License-Identifier: Apache-2.0
// Makes the Kind of a study of kind "monte-carlo": trials until the numbers are known well enough.
#pragma once
#include <memory>

#include "study/kind/kind.hpp"
#include "study/monte_carlo/monte_carlo_study.hpp"

namespace fringetwin::study {

/// The head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const MonteCarloPlan& plan);

}  // namespace fringetwin::study
