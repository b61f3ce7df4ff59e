// SPDX-License-Identifier: Apache-2.0
#include "compare/refine/refined_budget.hpp"

#include <algorithm>

#include "compare/parameters/parameters.hpp"
#include "compare/verdict/calibration_covariance.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

/// Times its limit: a fit looks at 40,000 pixels of a camera, of up to some millions, and the fits of objects
/// at all. Beyond, something else is wrong, and the rigs need not be rendered.
constexpr double kFarBeyond = 100.0;

bool fails_by_little(double chi2, double limit) { return chi2 > limit && chi2 < kFarBeyond * limit; }

bool may_be_reached(const ExplainedRow& row) {
  if (row.state != kNotExplained) return false;
  return (row.quantity == "gray" || row.quantity == "phase" || row.quantity == "geometry") &&
         (fails_by_little(row.chi2, row.chi2_limit) ||
          fails_by_little(row.regional_chi2, row.regional_limit));
}

}  // namespace

std::vector<Twin> one_error_away(const Twin& fitted, const std::vector<Parameter>& parameters,
                                 const Eigen::MatrixXd& covariance) {
  if (parameters.empty() || !covariance.allFinite()) return {};
  const Eigen::MatrixXd changes = one_sigma_changes(covariance);
  std::vector<Twin> out;
  for (Eigen::Index i = 0; i < changes.cols(); ++i) {
    try {
      // the fitted twin has the values: a change is told from the start
      out.push_back(with_values(fitted, parameters, start_values(parameters) + changes.col(i)));
    } catch (const UserError&) {
    }
  }
  return out;
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
  return rig_budget(twin, options.one_error_away, kRefinedLine, rig_budget_options(twin, simulated, options));
}

}  // namespace fringetwin::compare
