// SPDX-License-Identifier: Apache-2.0
// Counts the standard errors of refined places among what a verdict allows: a fit of some pixels leaves a rig
// less certain than fits of all points are (docs/metrics/verdict.md, "Refined values in the budget").
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "compare/causes/group_fit.hpp"
#include "compare/parameters/parameter.hpp"
#include "compare/result/options.hpp"
#include "compare/result/refined.hpp"
#include "compare/result/rows.hpp"
#include "compare/result/side.hpp"
#include "compare/verdict/rig_budget.hpp"

namespace fringetwin::compare {

/// Returns a twin that has fitted values of these parameters changed along each principal direction of their
/// covariance, one standard error far. A change of which no lens can be made on either side is left out;
/// nothing for a covariance that is not finite.
std::vector<Twin> one_error_away(const Twin& fitted, const std::vector<Parameter>& parameters,
                                 const Eigen::MatrixXd& covariance);

/// Returns the twin of a refinement with its places changed as their standard errors allow beyond those of
/// the fits of objects: of k pixels that these look at, `fit` looked at one. `samples`: of that fit.
std::vector<Twin> places_one_error_away(const GroupFit& fit, const std::vector<GridSamples>& samples,
                                        const Refined& refined);

/// Returns how the rigs of a budget are rendered and measured; `simulated` must outlive it.
RigBudgetOptions rig_budget_options(const Twin& twin, const Side& simulated, const CompareOptions& options);

/// Returns what the standard errors of the refined places leave uncertain, where one of these rows fails by
/// no more than they may reach; nothing where none does, or no place was refined. Throws Cancelled.
std::optional<RigBudget> refined_budget(const Twin& twin, const Side& simulated,
                                        const CompareOptions& options, const std::vector<ExplainedRow>& rows);

}  // namespace fringetwin::compare
