// SPDX-License-Identifier: Apache-2.0
// What a fit believes of its parameters before any image is seen.
#include <map>
#include <set>

#include "compare/causes/group_fit.hpp"

namespace fringetwin::compare {
namespace {

/// Of full scale: how far the mean of what single images have of their own may be from none where that of all
/// of them is fitted, too. A tenth of what images tell.
constexpr double kNoMean = 1e-5;

}  // namespace

bool is_geometric(const std::string& group) { return prior_steps(group) > 0.0; }

double prior_steps(const std::string& group) {
  if (group == "pose" || group == "size") return 500.0;  // 5 mm, 50 mrad
  if (group == "rig") return 1000.0;                     // 10 mm, 10 mrad
  if (group == "intrinsics") return 250.0;               // 5 px of a principal point, 12 px of a focal length
  if (group == "lens") return 100.0;                     // 0.1
  if (group == "image_shift") return 30.0;
  if (group == "motion") return 50.0;  // 0.5 mm, 5 mrad
  return 0.0;
}

double prior_of(const Parameter& parameter) {
  return parameter.expected > 0.0 ? parameter.expected : prior_steps(parameter.group) * parameter.step;
}

/// Returns those of each parameter that stands for all images, which do as it does in one image each: all of
/// the images that are compared, so that their mean would be what that one is.
std::vector<std::vector<std::size_t>> GroupFit::shares_of_others() const {
  std::map<std::string, std::vector<std::size_t>> shares;
  for (std::size_t k = 0; k < parameters_.size(); ++k)
    if (const Parameter& p = parameters_[k]; p.only_image && p.does_as && known_[k].told)
      shares[p.does_as->name].push_back(k);
  if (shares.empty()) return {};
  const std::vector<PatternSpec> patterns = expand_sequence(twin_.fringes);
  std::set<int> steps;
  for (const GridSamples& s : sensitivity_.samples())
    for (const int image : s.images)
      if (patterns[static_cast<std::size_t>(image)].kind == PatternSpec::Kind::phase_step)
        steps.insert(image);
  std::vector<std::vector<std::size_t>> out;
  for (std::size_t k = 0; k < parameters_.size(); ++k)
    if (const auto of = shares.find(parameters_[k].name);
        of != shares.end() && known_[k].told && of->second.size() == steps.size())
      out.push_back(of->second);
  return out;
}

/// Returns what is believed: of each parameter by itself, and of the mean of those that share in another.
std::vector<GroupFit::Belief> GroupFit::beliefs() const {
  std::vector<Belief> out;
  for (std::size_t k = 0; k < parameters_.size(); ++k)
    if (const double prior = prior_of(parameters_[k]); prior > 0.0) out.push_back({{k}, prior});
  for (std::vector<std::size_t>& shares : shares_of_others()) out.push_back({std::move(shares), kNoMean});
  return out;
}

/// Returns how far the mean of some values is from that of their starts.
double GroupFit::off_start(const Belief& belief, const Eigen::VectorXd& values) const {
  double sum = 0.0;
  for (const std::size_t k : belief.mean_of) sum += values[k] - parameters_[k].start;
  return sum / static_cast<double>(belief.mean_of.size());
}

/// Returns the squares that the prior adds to chi2.
double GroupFit::prior_chi2(const Eigen::VectorXd& values) const {
  double sum = 0.0;
  for (const Belief& belief : beliefs()) {
    const double off = off_start(belief, values) / belief.sigma;
    sum += off * off;
  }
  return sum;
}

const NormalEquations& GroupFit::sums(FreePerPixel free) {
  if (!columns_) render_columns();
  std::vector<double> standing = sensitivity_.standing();
  if (!last_sums_ || last_sums_->of_base != n_bases_ || last_sums_->of_columns != n_columns_ ||
      last_sums_->free != free || last_sums_->standing != standing)
    last_sums_ = Sums{n_bases_, n_columns_, free, std::move(standing),
                      sensitivity_.equations_at(base_, *columns_, free)};
  return last_sums_->equations;
}

/// Returns the equations of a block where the fit is, with the prior of its parameters.
NormalEquations GroupFit::equations_with_prior(FreePerPixel free) {
  NormalEquations e = sums(free);
  for (const Belief& belief : beliefs()) {
    const double part = 1.0 / static_cast<double>(belief.mean_of.size()),
                 variance = belief.sigma * belief.sigma, off = off_start(belief, values_);
    for (const std::size_t i : belief.mean_of) {
      for (const std::size_t j : belief.mean_of) e.normal(i, j) += part * part / variance;
      e.right[i] -= part * off / variance;
    }
  }
  return e;
}

}  // namespace fringetwin::compare
