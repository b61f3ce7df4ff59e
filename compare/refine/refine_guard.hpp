// SPDX-License-Identifier: Apache-2.0
// Refuses a refinement, or says what it made worse and takes it back: a twin may only get better by one
// (docs/metrics/causes.md, "Refinement").
#pragma once
#include <string>
#include <vector>

#include "compare/parameters/parameter.hpp"
#include "compare/result/refined.hpp"
#include "compare/result/rows.hpp"
#include "compare/result/side.hpp"

namespace fringetwin::compare {

struct RigBudget;

/// What is compared of a twin before and after a refinement.
struct Standing {
  double chi2 = kNaN;           ///< of a gray value, with the best gain and black level
  double chi2_of_place = kNaN;  ///< the same with a factor and an offset per pixel; NaN: nothing was moved
  std::uint64_t n = 0;          ///< values
  CauseRegion shift = {};       ///< of the places of the fringes
  std::vector<CauseRegion> light = {};  ///< of level and contrast, with gain and black level alone
  bool fits_light = false;  ///< nothing was moved: what is fitted are gray values, and they must get better
  bool scatters = false;    ///< its noise has the scatter of bounces
  std::vector<ExplainedRow> rows{};  ///< of coverage, phase and the objects' fits
};

/// Throws UserError(usage) where a twin has too few phase steps for `--refine timing`: of three, what a late
/// exposure does is what a light and a shift of the image do. Lets the light of images be rendered beside it:
/// an exposure that reaches into another pattern sees that one's light, too.
void make_ready_for_timing(const Twin& twin, std::vector<Parameter>& chosen);

/// Returns the rows of coverage and geometry of two measured sides. `rig`: what is uncertain of it, or null.
std::vector<ExplainedRow> measured_rows(const Twin& twin, const Side& real, const Side& simulated,
                                        const RigBudget* rig = nullptr);

/// Puts rows that are explained with a budget (refined_budget()) in the place of those that fail without it.
void excuse(std::vector<ExplainedRow>& rows, const std::vector<ExplainedRow>& with_budget);

/// Returns in words what is worse after a refinement by more than its own standard deviation; empty where
/// nothing is. Chi2: root of 2/n; regions of shift: two roots of 2/n, below 1 as from 1 where the
/// noise has the scatter of bounces; regions of light: beyond their limit, and not before, or where light was
/// fitted two roots of 2/n; rows of coverage and phase: no longer explained; of phase that was not explained:
/// beyond its limit two roots of 2/n and 2 %; geometry: the largest |z| larger by 1.
std::string what_got_worse(const Standing& before, const Standing& after);

/// Returns whether a fit by the fringes left them nothing, and of the light of regions more than chance does
/// in two of three: of what fringes tell poorly, as a projector's place along its columns, light may tell
/// more.
bool leaves_light_alone(const Standing& standing);

/// Returns whether a fit by fringes and light is better than one by fringes: no worse for these, with less of
/// the light left than chance takes from it by `n_fitted` values, and nothing beyond its limits. Where
/// something is, places that fringes tell poorly went where they make up for light that the twin has not (a
/// texture, a lamp).
bool is_better_lit(const Standing& by_fringes, const Standing& lit, std::size_t n_fitted);

/// Returns a warning where the objects' fits disagree after a refinement: something else is wrong besides,
/// and the values are not to be trusted. Empty where they agree.
std::string warning_of_what_is_left(const Refinement& refinement, const std::vector<ExplainedRow>& rows);

/// Puts the twin as it was `before` back and says so in notes and warnings.
void take_back(Refined& refined, const Twin& before, const std::string& why);

}  // namespace fringetwin::compare
