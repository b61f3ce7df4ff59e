// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/group_fit.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "compare/causes/cause_regions.hpp"
#include "compare/causes/scaled_eigen.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kSettledSigmas = 0.05, kSettledChi2 = 0.5;
constexpr double kNearlySettled =
    0.5;  ///< standard errors, where derivatives are too rough for a better step
constexpr double kFirstDamping = 0.01, kLittleDamping = 1.0, kMostDamping = 1e3;
constexpr double kPoorColumns = 0.5;   ///< of the predicted fall of the loss, by which a step's may be off
constexpr int kMostPasses = 6;         ///< over both kinds of groups
constexpr double kFarSteps = 2.0;      ///< of a parameter: a fiftieth of a fringe
constexpr double kTooFarSteps = 10.0;  ///< where a quick derivative at another place stands for that here
constexpr double kOfQuick = 0.01;      ///< of chi2
constexpr double kNotNear = 0.1;       ///< of what a fit lacks: less than that more is not worth a step
constexpr int kMostRounds = 5;         ///< of a fit with curves told at another gain

}  // namespace

GroupFit::GroupFit(Sensitivity& sensitivity, const Twin& twin, std::vector<Parameter> parameters,
                   GroupFitOptions options, const Eigen::VectorXd& begin, Sensitivity::Values base)
    : sensitivity_(sensitivity),
      twin_(twin),
      parameters_(std::move(parameters)),
      options_(options),
      values_(begin.size() > 0 ? begin : start_values(parameters_)),
      known_(parameters_.size()) {
  Block geometry{FreePerPixel::factor_and_offset, {}}, others{FreePerPixel::nothing, {}};
  for (std::size_t k = 0; k < parameters_.size(); ++k)
    (is_geometric(parameters_[k].group) && !options_.free ? geometry : others).at.push_back(k);
  if (options_.free) others.free = *options_.free;
  // Where every pixel has its own brightness and offset anyway, both kinds are told from the same. Together
  // with shifts of the images, for one after the other creeps: an image's light and its fringes' place are
  // nearly the same.
  const bool are_shifts = std::ranges::all_of(
      geometry.at, [this](std::size_t k) { return parameters_[k].group == "image_shift"; });
  if (free_of(others) == free_of(geometry) && are_shifts && !geometry.at.empty() && !others.at.empty()) {
    std::ranges::copy(others.at, std::back_inserter(geometry.at));
    std::ranges::sort(geometry.at);
    others.at.clear();
  }
  if (!geometry.at.empty()) blocks_.push_back(geometry);
  if (!others.at.empty() || blocks_.empty()) blocks_.push_back(others);
  if (base.empty())
    set_values(values_);
  else
    take_base(std::move(base));
}

void GroupFit::take_base(Sensitivity::Values base) {
  base_ = std::move(base);
  ++n_bases_;
}

Sensitivity::Values GroupFit::predict(const Eigen::VectorXd& values) {
  sensitivity_.take_exposures(with_values(twin_, parameters_, values));
  return sensitivity_.predicted(twin_, parameters_, values);
}

void GroupFit::set_values(const Eigen::VectorXd& values) {
  values_ = values;
  take_base(predict(values_));
}

void GroupFit::set_values_and_chi2(const Eigen::VectorXd& values) {
  set_values(values);
  chi2_ = settled_chi2(base_, free_of(blocks_.back()), false) / static_cast<double>(n_);
}

FreePerPixel GroupFit::free_of(const Block& block) const { return sensitivity_.with_own(block.free); }

std::vector<std::size_t> GroupFit::sensors_of(FreePerPixel free) const {
  std::vector<std::size_t> all;
  const std::size_t first = parameters_.size();
  for (std::size_t c = 0; c < sensitivity_.samples().size(); ++c) {
    if (!options_.hold_gain && !frees_factor(free)) all.push_back(first + 2 * c);
    if (!frees_offset(free)) all.push_back(first + 2 * c + 1);
    std::ranges::copy(sensitivity_.lights_at(c, first), std::back_inserter(all));
  }
  return all;
}

/// Returns chi2 and the loss of a prediction with the best gain and black level; puts these into the samples
/// where they are to settle.
GroupFit::Settled GroupFit::settled(const Sensitivity::Values& base, FreePerPixel free, bool settle) {
  if (&base == &base_) sensitivity_.take_exposures(twin());  // others come from predict()
  NormalEquations e = sensitivity_.equations_at(base, {base, {}}, free);
  std::vector<std::size_t> sensors = sensors_of(free);
  for (std::size_t& at : sensors) at -= parameters_.size();
  const Step step = solve_step(e, sensors);
  n_ = e.n;
  if (settle) sensitivity_.move_sensors(step.change);
  return {step.chi2, step.chi2 + e.beyond};
}

bool GroupFit::start_at(const Eigen::VectorXd& values) {
  const FreePerPixel free = free_of(blocks_.front());
  const Settled here = settled(base_, free, false);
  chi2_ = here.chi2 / static_cast<double>(n_);
  Sensitivity::Values base = predict(values);
  const Settled there = settled(base, free, false);
  if (!(there.loss < here.loss)) {
    sensitivity_.take_exposures(twin());
    return false;
  }
  values_ = values;
  take_base(std::move(base));
  chi2_ = there.chi2 / static_cast<double>(n_);
  return true;
}

void GroupFit::move_to(const Eigen::VectorXd& values) {
  set_values_and_chi2(values);
  for (std::size_t k = 0; k < known_.size(); ++k)
    if (known_[k].told) known_[k].value = values[static_cast<Eigen::Index>(k)];
}

void GroupFit::use_columns(Sensitivity::Columns columns, const Eigen::VectorXd& at) {
  columns_ = std::move(columns);
  columns_at_ = at;
  ++n_columns_;
}

std::optional<std::pair<Sensitivity::Columns, Eigen::VectorXd>> GroupFit::give_columns() {
  if (!columns_) return std::nullopt;
  std::pair given{std::move(*columns_), columns_at_};
  columns_.reset();
  return given;
}

void GroupFit::render_columns() {
  columns_ = sensitivity_.columns(twin_, parameters_, values_, derivative_,
                                  columns_ ? columns_->steps : std::vector<Sensitivity::DerivativeStep>{});
  columns_at_ = values_;
  ++n_columns_;
}

std::vector<std::size_t> GroupFit::told_of(const Block& block) const {
  std::vector<std::size_t> told;
  for (const std::size_t k : block.at)
    if (known_[k].told) told.push_back(k);
  return told;
}

double GroupFit::null_of(const std::vector<std::size_t>& parameters) const {
  return std::ranges::all_of(parameters, [&](std::size_t k) { return prior_of(parameters_[k]) > 0.0; })
             ? ScaledEigen::kNullWithPrior
             : ScaledEigen::kNull;
}

GroupFit::Damped GroupFit::solve(const NormalEquations& e, std::vector<std::size_t> unknowns,
                                 FreePerPixel free, double damping) const {
  const double null = null_of(unknowns);
  const std::size_t n_parameters = unknowns.size();
  const std::vector<std::size_t> sensors = sensors_of(free);
  unknowns.insert(unknowns.end(), sensors.begin(), sensors.end());
  Eigen::MatrixXd normal = e.normal_of(unknowns);
  const auto m = static_cast<Eigen::Index>(unknowns.size());
  Eigen::VectorXd right(m);
  for (Eigen::Index i = 0; i < m; ++i) right[i] = e.right[unknowns[i]];
  for (std::size_t i = 0; i < n_parameters; ++i) normal(i, i) *= 1.0 + damping;
  const ScaledEigen scaled(normal);
  Damped out;
  out.covariance = scaled.inverse(null);
  out.change = out.covariance * right;
  out.fall = out.change.dot(right);
  out.sigma = out.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  out.unknowns = std::move(unknowns);
  for (std::size_t i = 0; i < n_parameters; ++i)
    out.null.push_back(!(normal(i, i) > 0.0) || scaled.is_in_null_direction(i, null));
  return out;
}

/// Returns whether a parameter lies at a bound that this change would cross.
bool GroupFit::leads_outside(std::size_t parameter, double change) const {
  const Parameter& p = parameters_[parameter];
  const double value = values_[static_cast<Eigen::Index>(parameter)];
  return (value <= p.smallest && change < 0.0) || (value >= p.largest && change > 0.0);
}

/// Returns the step that these equations ask for, within the bounds: what its bound stops does not steer the
/// others.
GroupFit::Stride GroupFit::stride(const NormalEquations& e, std::vector<std::size_t> told, FreePerPixel free,
                                  double damping, double chi2) const {
  Damped solved = solve(e, told, free, damping);
  for (std::vector<std::size_t> inside; !told.empty(); inside.clear()) {
    for (std::size_t i = 0; i < told.size(); ++i)
      if (!leads_outside(told[i], solved.change[static_cast<Eigen::Index>(i)])) inside.push_back(told[i]);
    if (inside.size() == told.size()) break;
    told = inside;
    if (!told.empty()) solved = solve(e, told, free, damping);
  }
  Stride out{values_, chi2 - (e.chi2 + prior_chi2(values_) - solved.fall), 0.0};
  const double inflation = std::sqrt(std::max(1.0, chi2 / static_cast<double>(e.n)));
  for (std::size_t i = 0; i < told.size(); ++i) {
    const Parameter& p = parameters_[told[i]];
    const auto at = static_cast<Eigen::Index>(i);
    out.next[told[i]] = std::clamp(values_[told[i]] + solved.change[at], p.smallest, p.largest);
    if (solved.sigma[at] > 0.0 && std::abs(solved.change[at]) > p.settled)
      out.sigmas = std::max(out.sigmas, std::abs(solved.change[at]) / solved.sigma[at] / inflation);
  }
  return out;
}

/// Returns whether the values moved by more than the end of a fit would.
bool GroupFit::fit(const Block& block) {
  const FreePerPixel free = free_of(block);
  const std::vector<std::size_t> told = told_of(block);
  if (!options_.keep_scale) sensitivity_.choose_scale(base_, free);
  double damping = 0.0, loss = settled(base_, free, told.empty()).loss + prior_chi2(values_);
  bool moved = false, nearly = false;
  converged_ = told.empty();
  for (int step = 0; step < options_.most_steps && !converged_; ++step) {
    throw_if_cancelled();
    const NormalEquations e = equations_with_prior(free);
    const double chi2 = loss - e.beyond, scale2 = std::max(1.0, chi2 / static_cast<double>(e.n));
    if (options_.on_step) options_.on_step(n_steps_, chi2 / static_cast<double>(e.n));
    const Stride ahead = stride(e, told, free, damping, chi2);
    const double little = kSettledChi2 * scale2, expected = ahead.expected;
    if (ahead.next == values_) {  // at their bounds
      converged_ = true;
      break;
    }
    const bool are_fresh = columns_at_ == values_, is_far = is_far_from_columns(kTooFarSteps);
    if (damping == 0.0 && ahead.sigmas <= kSettledSigmas && !is_far) {
      converged_ = true;
      break;
    }
    if (damping == 0.0 && cannot_come_near(chi2, expected, e.n)) {
      given_up_ = are_fresh;
      if (given_up_) break;
      render_columns();
      continue;
    }
    ++n_steps_;
    if (const double gained = try_values(ahead.next, free, loss); gained > 0.0) {
      // anew: with another gain and black level other values are outliers
      loss =
          sensors_of(free).empty() ? loss - gained : settled(base_, free, false).loss + prior_chi2(values_);
      moved = moved || gained > little;
      // where old columns are too long every step falls short of what they could predict
      const bool is_poor =
          std::abs(gained - expected) > kPoorColumns * expected && std::max(gained, expected) > little;
      converged_ = gained < little && damping <= kLittleDamping && (are_fresh || (!is_poor && !is_far));
      // at rest over old columns is no rest
      if (!converged_ && (is_poor || (!are_fresh && gained < little))) render_columns();
      damping = damping > kFirstDamping ? damping / 10.0 : 0.0;
    } else if (damping == 0.0 && expected < little && !is_far) {
      converged_ = true;
    } else if (damping == 0.0 && is_left_to_exact(expected, chi2)) {
      converged_ = true;  // and no shorter step would help
    } else if (!are_fresh) {
      render_columns();
      damping = 0.0;
    } else {
      if (damping == 0.0) nearly = ahead.sigmas <= kNearlySettled;
      damping = std::max(kFirstDamping, 10.0 * damping);
      if (damping <= kMostDamping) continue;
      converged_ = nearly;
      break;
    }
  }
  chi2_ = settled_chi2(base_, free, false) / static_cast<double>(n_);
  return moved;
}

/// Returns whether a refused step was to gain so little that it may be the error of a quick derivative that
/// asked for it: one of a tenth finds a hundredth of chi2 where there is nothing.
bool GroupFit::is_left_to_exact(double expected, double chi2) const {
  return options_.exact && derivative_ == Sensitivity::Derivative::quick && expected < kOfQuick * chi2;
}

/// Moves to these values if the loss falls there; returns by how much.
double GroupFit::try_values(const Eigen::VectorXd& next, FreePerPixel free, double loss) {
  try {
    Sensitivity::Values base = predict(next);
    const double now = settled(base, free, false).loss + prior_chi2(next);
    if (!(now < loss)) {
      sensitivity_.take_exposures(twin());
      return 0.0;
    }
    if (!sensors_of(free).empty()) settled_chi2(base, free, true);
    values_ = next;
    take_base(std::move(base));
    return loss - now;
  } catch (const UserError&) {
    sensitivity_.take_exposures(twin());
    return 0.0;  // no such lens: a smaller step
  }
}

/// Returns whether a derivative may have changed since the columns were rendered, so many steps of a
/// parameter away.
bool GroupFit::is_far_from_columns(double steps) const {
  for (std::size_t k = 0; k < parameters_.size(); ++k)
    if (std::abs(values_[k] - columns_at_[k]) > steps * parameters_[k].step) return true;
  return false;
}

/// Returns whether a step that takes this much off chi2 brings the fit no nearer to what is wanted of it.
bool GroupFit::cannot_come_near(double chi2, double expected, std::uint64_t n) const {
  const double lacks = chi2 - options_.wanted_chi2 * static_cast<double>(n);
  return options_.wanted_chi2 > 0.0 && lacks > 0.0 && expected < kNotNear * lacks;
}

void GroupFit::run() {
  if (parameters_.empty()) {
    fit(blocks_.front());
    return;
  }
  do fit_all();
  while (leave_out_what_is_not_told() && !given_up_);
  for (int round = 0; round < kMostRounds && refers_curves_to_gain(); ++round) fit_all();
  covariance_.resize(0, 0);
  sensor_sigma_.resize(0);
  regions_.clear();
  unexplained_.clear();
  for (const Block& block : blocks_)
    if (options_.tells) tell(block);
}

void GroupFit::hold(const std::vector<std::size_t>& parameters) {
  Eigen::VectorXd values = values_;
  for (const std::size_t k : parameters) {
    known_[k].told = false;
    known_[k].value = values[k] = parameters_[k].start;
  }
  set_values(values);
}

void GroupFit::fit_all() {
  bool all_converged = false;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    bool moved = false;
    all_converged = true;
    for (const Block& block : blocks_) {
      moved = fit(block) || moved;
      all_converged = all_converged && converged_;
    }
    if (blocks_.size() == 1 || (pass > 0 && !moved)) break;
    if (pass + 1 == kMostPasses) all_converged = false;
  }
  if (options_.exact && (derivative_ != Sensitivity::Derivative::exact || is_far_from_columns(kFarSteps))) {
    derivative_ = Sensitivity::Derivative::exact;
    render_columns();
    all_converged = all_converged || blocks_.size() == 1;  // these derivatives decide
    for (const Block& block : blocks_) {
      fit(block);
      all_converged = all_converged && converged_;
    }
  }
  converged_ = all_converged;
}

CauseRegion GroupFit::shift_in_regions() const {
  return cause_regions(sensitivity_, twin_.fringes, base_, FreePerPixel::factor_and_offset).at(2);
}

std::vector<CauseRegion> GroupFit::light_in_regions() const {
  std::vector<CauseRegion> all = cause_regions(sensitivity_, twin_.fringes, base_, FreePerPixel::nothing);
  all.resize(2);
  return all;
}

double GroupFit::chi2_with(FreePerPixel free) {
  const std::uint64_t n = n_;
  const double chi2 = settled_chi2(base_, free_of({free, {}}), false) / static_cast<double>(n_);
  n_ = n;
  return chi2;
}

std::uint64_t GroupFit::n_of_all() const {
  return sensitivity_.equations_at(base_, {base_, {}}, free_of({FreePerPixel::nothing, {}})).n;
}

void GroupFit::settle_sensors() {
  const std::uint64_t n = n_;
  settled_chi2(base_, free_of({FreePerPixel::nothing, {}}), true);
  n_ = n;
}

Eigen::Vector2d GroupFit::sensor_sigma(std::size_t index) {
  if (sensor_sigma_.size() > 0) {
    const auto at = static_cast<Eigen::Index>(parameters_.size() + 2 * index);
    return sensor_sigma_.segment<2>(at);
  }
  const FreePerPixel free = free_of({FreePerPixel::nothing, {}});
  const NormalEquations e = sensitivity_.equations_at(base_, {base_, {}}, free);
  std::vector<std::size_t> sensors = sensors_of(free);
  for (std::size_t& at : sensors) at -= parameters_.size();
  const Step step = solve_step(e, sensors);
  const double inflation = std::sqrt(std::max(1.0, step.chi2 / static_cast<double>(e.n)));
  return inflation * Eigen::Vector2d(step.sigma[e.gain_at(index)], step.sigma[e.black_at(index)]);
}

bool GroupFit::changes_nothing(std::size_t parameter) {
  if (!columns_) render_columns();
  return std::ranges::all_of(columns_->each[parameter], [](const std::vector<float>& values) {
    return std::ranges::all_of(values, [](float v) { return v == 0.0F; });
  });
}

}  // namespace fringetwin::compare
