// SPDX-License-Identifier: Apache-2.0
// What a GroupFit shows of values that are fitted at one gain and told at another
// (Parameter::grows_with_gain).
#include <algorithm>
#include <cmath>

#include "compare/causes/group_fit.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kSameGain = 1e-4;  ///< as that at which curves are told: 0.02 DN of 200

}  // namespace

/// Returns which of the samples holds the gain that the value of a parameter grows with; none where it grows
/// with no gain.
std::optional<std::size_t> GroupFit::grows_with(std::size_t parameter) const {
  const Parameter& p = parameters_[parameter];
  const auto& all = sensitivity_.samples();
  const auto found = std::ranges::find_if(
      all, [&](const GridSamples& s) { return p.grows_with_gain && s.camera == p.camera; });
  if (found == all.end()) return std::nullopt;
  return static_cast<std::size_t>(found - all.begin());
}

/// Returns by how much more the value of a parameter is shown than it is fitted.
double GroupFit::growth_of(std::size_t parameter) const {
  const std::optional<std::size_t> c = grows_with(parameter);
  return c ? sensitivity_.samples()[*c].gain_dn / sensitivity_.samples()[*c].curve_gain_dn() : 1.0;
}

Eigen::VectorXd GroupFit::shown_values() const {
  Eigen::VectorXd shown = values_;
  for (std::size_t k = 0; k < parameters_.size(); ++k)
    if (known_[k].told) shown[k] *= growth_of(k);
  return shown;
}

/// Tells curves at the gain as it is now, where that matters; returns whether it does. A camera whose gray
/// values the twin's own curve has straightened bends them, in the fit, at levels that grow with the gain.
bool GroupFit::refers_curves_to_gain() {
  const auto is_far = [](const GridSamples& s) {
    return std::abs(s.gain_dn / s.curve_gain_dn() - 1.0) > kSameGain;
  };
  const auto matters = [&](const Parameter& p) {
    if (!p.camera) return false;
    const bool is_told =
        p.told_at_gain || (p.grows_with_gain && !twin_.cameras[*p.camera].sensor.response.straight());
    return is_told && std::ranges::any_of(sensitivity_.samples(), [&](const GridSamples& s) {
             return s.camera == *p.camera && is_far(s);
           });
  };
  if (given_up_ || std::ranges::none_of(parameters_, matters)) return false;
  const Eigen::VectorXd values = shown_values();
  sensitivity_.refer_curves_to_gain();
  set_values(values);
  columns_.reset();
  return true;
}

/// Returns the derivatives of the shown values of these parameters by all unknowns, which begin with them.
Eigen::MatrixXd GroupFit::shown_by_unknowns(const std::vector<std::size_t>& told,
                                            const std::vector<std::size_t>& unknowns) const {
  Eigen::MatrixXd by(static_cast<Eigen::Index>(told.size()), static_cast<Eigen::Index>(unknowns.size()));
  by.setIdentity();
  for (std::size_t i = 0; i < told.size(); ++i) {
    const std::optional<std::size_t> c = grows_with(told[i]);
    if (!c) continue;
    by(i, i) = growth_of(told[i]);
    const auto gain = std::ranges::find(unknowns, parameters_.size() + 2 * *c);
    if (gain != unknowns.end())
      by(i, gain - unknowns.begin()) = values_[told[i]] / sensitivity_.samples()[*c].curve_gain_dn();
  }
  return by;
}

}  // namespace fringetwin::compare
