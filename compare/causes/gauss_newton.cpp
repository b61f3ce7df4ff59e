// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/gauss_newton.hpp"

#include <algorithm>
#include <cmath>

#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kMostHalvings = 6;
constexpr double kAsGoodAsSettled = 0.5;  ///< where derivatives are too rough for a better step
constexpr double kSettled = 0.05;         ///< standard errors
constexpr double kWorthAStep = 0.01;      ///< of chi2, not per value

}  // namespace

GaussNewton::GaussNewton(Sensitivity& sensitivity, const Twin& twin, std::vector<Parameter> parameters,
                         bool hold_gain)
    : sensitivity_(sensitivity),
      twin_(twin),
      parameters_(std::move(parameters)),
      hold_gain_(hold_gain),
      values_(start_values(parameters_)),
      chi2_(chi2_of(twin)) {}

std::vector<std::size_t> GaussNewton::sensors_of(const NormalEquations& e) const {
  std::vector<std::size_t> all;
  for (std::size_t c = 0; c < sensitivity_.samples().size(); ++c) {
    if (!hold_gain_) all.push_back(e.gain_at(c));
    all.push_back(e.black_at(c));
  }
  return all;
}

std::vector<std::size_t> GaussNewton::unknowns() const {
  std::vector<std::size_t> all;
  for (std::size_t k = 0; k < parameters_.size(); ++k) all.push_back(k);
  const std::vector<std::size_t> sensors = sensors_of(equations_);
  all.insert(all.end(), sensors.begin(), sensors.end());
  return all;
}

double GaussNewton::chi2_of(const NormalEquations& e) const {
  return solve_step(e, sensors_of(e)).chi2 / static_cast<double>(e.n);
}

double GaussNewton::chi2_of(const Twin& twin) const {
  return chi2_of(sensitivity_.equations_without_parameters(twin));
}

bool GaussNewton::start_at(const Eigen::VectorXd& values) {
  const double chi2 = chi2_of(with_values(twin_, parameters_, values));
  if (!(chi2 < chi2_)) return false;
  values_ = values;
  chi2_ = chi2;
  return true;
}

void GaussNewton::settle_sensors() { settle_sensors(sensitivity_.equations_without_parameters(twin())); }

void GaussNewton::settle_sensors(const NormalEquations& e) {
  const Step step = solve_step(e, sensors_of(e));
  for (std::size_t c = 0; c < sensitivity_.samples().size(); ++c) {
    const GridSamples& s = sensitivity_.samples()[c];
    sensitivity_.set_sensor(c, s.gain_dn + step.change[e.gain_at(c)],
                            s.black_level_dn + step.change[e.black_at(c)]);
  }
}

GaussNewton::Outcome GaussNewton::step(bool keep_scale, Sensitivity::Derivative derivative) {
  throw_if_cancelled();
  equations_ = sensitivity_.equations(twin_, parameters_, values_, keep_scale, derivative);
  chi2_ = chi2_of(equations_);
  const Step step = solve_step(equations_, unknowns());
  if (parameters_.empty() || is_within(step, kSettled)) return Outcome::settled;
  if (!take(step)) return is_within(step, kAsGoodAsSettled) ? Outcome::settled : Outcome::stuck;
  return Outcome::moved;
}

bool GaussNewton::is_within(const Step& step, double sigmas) const {
  const double inflation = std::sqrt(std::max(1.0, chi2_));
  for (std::size_t k = 0; k < parameters_.size(); ++k)
    if (std::abs(step.change[k]) > sigmas * inflation * step.sigma[k]) return false;
  return true;
}

bool GaussNewton::take(const Step& step) {
  double factor = 1.0;
  for (int halving = 0; halving <= kMostHalvings; ++halving, factor *= 0.5) {
    Eigen::VectorXd next = values_;
    for (std::size_t k = 0; k < parameters_.size(); ++k)
      next[k] =
          std::clamp(values_[k] + factor * step.change[k], parameters_[k].smallest, parameters_[k].largest);
    try {
      const NormalEquations e =
          sensitivity_.equations_without_parameters(with_values(twin_, parameters_, next));
      const double chi2 = chi2_of(e);
      if (!(chi2 < chi2_ - kWorthAStep / static_cast<double>(equations_.n))) continue;
      values_ = next;
      chi2_ = chi2;
      settle_sensors(e);
      return true;
    } catch (const UserError&) {
      // no such lens: a smaller step
    }
  }
  return false;
}

}  // namespace fringetwin::compare
