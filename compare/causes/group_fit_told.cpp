// SPDX-License-Identifier: Apache-2.0
// What is known of the parameters after a fit: which of them these images tell, and how well.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/causes/cause_regions.hpp"
#include "compare/causes/group_fit.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kNotTold = 0.5;  ///< of the prior
constexpr std::size_t kFewestBlocks = 12, kFewestImages = 4;

/// Returns how much larger than `variance` a scatter of n sums must be to mean more than chance.
double beyond_chance(std::size_t n) { return 1.0 + 3.0 * std::sqrt(2.0 / (static_cast<double>(n) - 1.0)); }

}  // namespace

/// Returns which of the lights of which others do the same moved least: one is enough to hold, and the others
/// are told beside it.
std::optional<std::size_t> GroupFit::one_of_the_same(const std::vector<std::size_t>& told,
                                                     const std::vector<bool>& null,
                                                     const NormalEquations& e) const {
  std::optional<std::size_t> least;
  const auto moved = [this](std::size_t k) {
    return std::abs(values_[k] - parameters_[k].start) / parameters_[k].step;
  };
  for (std::size_t i = 0; i < told.size(); ++i)
    if (null[i] && prior_of(parameters_[told[i]]) == 0.0 && e.normal(told[i], told[i]) > 0.0 &&
        (!least || moved(told[i]) < moved(*least)))
      least = told[i];
  return least;
}

/// Puts back to the twin's values what these images do not tell; returns whether there was any.
bool GroupFit::leave_out_what_is_not_told() {
  bool any = false;
  Eigen::VectorXd values = values_;
  for (const Block& block : blocks_) {
    const FreePerPixel free = free_of(block);
    const std::vector<std::size_t> told = told_of(block);
    if (told.empty()) continue;
    const NormalEquations e = equations_with_prior(free);
    const Damped solved = solve(e, told, free, 0.0);
    const std::optional<std::size_t> one = one_of_the_same(told, solved.null, e);
    for (std::size_t i = 0; i < told.size(); ++i) {
      const double prior = prior_of(parameters_[told[i]]);
      // an expected one stays: what these images do not tell of it is taken for none
      if (parameters_[told[i]].expected > 0.0) continue;
      if (!solved.null[i] && !(prior > 0.0 && solved.sigma[i] >= kNotTold * prior)) continue;
      // what changes nothing at all has the prior's sigma, too
      const bool changes = e.normal(told[i], told[i]) - (prior > 0.0 ? 1.0 / (prior * prior) : 0.0) > 0.0;
      if (prior == 0.0 && changes && told[i] != one) continue;
      known_[told[i]] = {parameters_[told[i]].start, changes ? solved.sigma[i] : 0.0, solved.sigma[i], false};
      values[told[i]] = parameters_[told[i]].start;
      any = true;
    }
  }
  if (any) set_values_and_chi2(values);
  return any;
}

/// Writes down what is known of a block's parameters.
void GroupFit::tell(const Block& block) {
  if (covariance_.size() == 0)
    covariance_ = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(parameters_.size()),
                                        static_cast<Eigen::Index>(parameters_.size()));
  const FreePerPixel free = free_of(block);
  const std::vector<std::size_t> told = told_of(block);
  if (told.empty()) return;
  // what light is fitted for depends on where things are, and not the other way round
  std::vector<std::size_t> all = told;
  if (&block != &blocks_.front()) {
    const std::vector<std::size_t> before = told_of(blocks_.front());
    all.insert(all.end(), before.begin(), before.end());
  }
  const NormalEquations e = equations_with_prior(free);
  const Damped solved = solve(e, all, free, 0.0);
  const double chi2 = settled_chi2(base_, free, options_.settles_sensors && free == FreePerPixel::nothing) /
                      static_cast<double>(n_);
  double inflation2 = std::max(1.0, chi2);
  const auto hold_against = [&](const std::string& what, double left, double limit) {
    if (!(left > limit)) return;
    inflation2 = std::max(inflation2, left);
    unexplained_ +=
        fmt::format("{}{} {:.3g}, limit {:.3g}", unexplained_.empty() ? "" : "; ", what, left, limit);
  };
  hold_against("chi2", chi2, sensitivity_.chi2_limit(static_cast<double>(n_)));
  const auto is_told_of = [&](bool places) {
    return std::ranges::any_of(told,
                               [&](std::size_t k) { return is_geometric(parameters_[k].group) == places; });
  };
  regions_ = cause_regions(sensitivity_, twin_.fringes, base_, free);
  for (const CauseRegion& kind : regions_)
    if (kind.kind != "image" && is_told_of(kind.kind == "shift"))
      hold_against(kind.kind + " of regions", kind.chi2, kind.limit);
  Sensitivity::Scatter scatter;
  if (!(options_.wanted_chi2 > 0.0 && chi2 > options_.wanted_chi2))  // nobody takes its values
    scatter = sensitivity_.scatter_at(base_, *columns_, free);
  const Eigen::MatrixXd shown = shown_by_unknowns(all, solved.unknowns), spread = shown * solved.covariance,
                        covariance = spread * shown.transpose();
  const auto sandwich = [&](const Eigen::MatrixXd& scores, std::size_t n, std::size_t fewest,
                            Eigen::Index i) {
    if (n < fewest) return 0.0;
    const NormalEquations picked{scores, {}, 0.0, 0, parameters_.size()};
    const double variance = spread.row(i) * picked.normal_of(solved.unknowns) * spread.row(i).transpose();
    return variance * static_cast<double>(n) / (static_cast<double>(n) - 1.0);
  };
  for (std::size_t i = all.size(); i < solved.unknowns.size(); ++i) {
    if (sensor_sigma_.size() == 0) sensor_sigma_ = Eigen::VectorXd::Zero(e.right.size());
    sensor_sigma_[solved.unknowns[i]] = std::sqrt(inflation2) * solved.sigma[static_cast<Eigen::Index>(i)];
  }
  for (std::size_t i = 0; i < told.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double noise2 = std::max(0.0, covariance(at, at));
    double variance = inflation2 * noise2;
    for (const auto& [of, n] :
         {std::pair{sandwich(scatter.blocks, scatter.n_blocks, kFewestBlocks, at), scatter.n_blocks},
          std::pair{sandwich(scatter.images, scatter.n_images, kFewestImages, at), scatter.n_images}})
      if (n > 1 && of > std::max(variance, noise2 * beyond_chance(n))) variance = of;
    known_[told[i]] = {values_[told[i]] * growth_of(told[i]), std::sqrt(variance), std::sqrt(noise2), true};
    for (std::size_t j = 0; j < told.size(); ++j)
      covariance_(told[i], told[j]) = covariance(at, static_cast<Eigen::Index>(j));
  }
}

}  // namespace fringetwin::compare
