// SPDX-License-Identifier: Apache-2.0
#include "compare/refine/refined_budget.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "compare/parameters/parameters.hpp"
#include "compare/verdict/calibration_covariance.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::compare {
namespace {

/// Times its limit: a refinement looks at 40,000 pixels of a camera, fits of objects at all of up to some
/// millions. Beyond, something else is wrong, and the rigs need not be rendered.
constexpr double kFarBeyond = 100.0;

bool fails_by_little(double chi2, double limit) { return chi2 > limit && chi2 < kFarBeyond * limit; }

/// Single values hide what a few numbers that were fitted to many thousands of them are off by: of gray and
/// phase only regions can tell it.
bool may_be_reached(const ExplainedRow& row) {
  if (row.state != kNotExplained) return false;
  if (row.quantity == "geometry") return fails_by_little(row.chi2, row.chi2_limit);
  return (row.quantity == "gray" || row.quantity == "phase") && row.chi2 <= row.chi2_limit &&
         fails_by_little(row.regional_chi2, row.regional_limit);
}

}  // namespace

std::vector<Twin> one_error_away(const Twin& fitted, const std::vector<Parameter>& parameters,
                                 const Eigen::MatrixXd& covariance) {
  if (parameters.empty() || !covariance.allFinite()) return {};
  const Eigen::MatrixXd changes = one_sigma_changes(covariance);
  std::vector<Twin> out;
  for (Eigen::Index i = 0; i < changes.cols(); ++i) {
    for (const double sign : {1.0, -1.0}) {  // where no lens is that far, one on the other side may be
      try {
        // the fitted twin has the values: a change is told from the start
        out.push_back(with_values(fitted, parameters, start_values(parameters) + sign * changes.col(i)));
        break;
      } catch (const UserError&) {
      }
    }
  }
  return out;
}

std::vector<Twin> places_one_error_away(const GroupFit& fit, const std::vector<GridSamples>& samples,
                                        const Refined& refined) {
  std::vector<Parameter> places;
  std::vector<Eigen::Index> at;  // of those that are told
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < fit.parameters().size(); ++k) {
    if (!fit.known()[k].told) continue;
    const Parameter& p = fit.parameters()[k];
    if (is_geometric(p.group) && p.group != "image_shift" && p.change) {
      places.push_back(p);
      at.push_back(row);
    }
    ++row;
  }
  int apart_px = std::numeric_limits<int>::max();  // pixels that were fitted, along a row or column
  for (const GridSamples& s : samples) apart_px = std::min(apart_px, s.grid.stride * s.grid.keep);
  // The fits of objects have 1/k of the refinement's variance V. As its pixels are among theirs, the two
  // differ by V - V/k; the budget holds V/k already.
  const double beyond_fits = 1.0 - 2.0 / (static_cast<double>(apart_px) * apart_px);
  if (beyond_fits <= 0.0) return {};
  return one_error_away(refined.twin, places, beyond_fits * refined.report.covariance(at, at));
}

RigBudgetOptions rig_budget_options(const Twin& twin, const Side& simulated, const CompareOptions& options) {
  static const std::vector<CameraImages> kNone;
  return {.renderer = *options.renderer,
          .sampling = render::choose_sampling(twin, options.render.value_or(twin.render)),
          .seed = options.seed,
          .use_steps = options.use_steps,
          .nominal = options.textured() ? kNone : simulated.irradiance};
}

std::optional<RigBudget> refined_budget(const Twin& twin, const Side& simulated,
                                        const CompareOptions& options,
                                        const std::vector<ExplainedRow>& rows) {
  if (options.one_error_away.empty() || !options.renderer || !std::ranges::any_of(rows, may_be_reached))
    return std::nullopt;
  std::vector<Twin> changed = options.one_error_away;
  for (Twin& rig : changed)  // what pixels have of their own was told after the places
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      rig.cameras[c].texture = twin.cameras[c].texture;
      rig.cameras[c].texture_file = twin.cameras[c].texture_file;
      rig.cameras[c].texture_spread_px = twin.cameras[c].texture_spread_px;
    }
  say(fmt::format("{} rigs within the standard errors of the refined places are measured", changed.size()));
  return rig_budget(twin, changed, kRefinedLine, rig_budget_options(twin, simulated, options));
}

}  // namespace fringetwin::compare
