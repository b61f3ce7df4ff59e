// SPDX-License-Identifier: Apache-2.0
// Holds what one parameter of a twin is: a number with a start value that changes the twin, or the irradiance
// that it predicts.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "compare/parameters/grid_view.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// What an effect on the irradiance of one camera is given.
struct EffectInput {
  const Twin& twin;    ///< what was rendered: with the values of all parameters but those that are closed
  const Twin& fitted;  ///< with the values of all parameters that change a twin
  const GridSamples& samples;        ///< of the camera
  const std::vector<float>& before;  ///< irradiance, laid out as GridSamples::real_dn, before any effect
  double from = 0.0, to = 0.0;       ///< values of the parameter
};

/// One number of the twin. `value` is what is fitted; a user reads its root where it is a variance.
struct Parameter {
  std::string group;         ///< one of parameter_groups() (parameters.hpp)
  std::string name;          ///< "ball.center_mm.x", "projector.k1"
  std::string unit;          ///< "mm", "rad", "px" or empty
  double start = 0.0;        ///< value in the twin it was made for
  double step = 0.0;         ///< where the search for a difference step begins
  bool is_variance = false;  ///< shown as its root
  double settled = 0.0;      ///< a step so small is none, whatever the standard error
  bool is_switch = false;    ///< an effect that is on (1) or off (0): differences are taken between the two
  double largest = 1e300, smallest = -1e300;
  /// Changes a twin by value - start. Throws UserError(usage) where no lens can be built from it. Empty where
  /// a twin has no such number: then `effect` alone says what the value does.
  std::function<void(Twin&, double)> change = {};
  /// Changes a predicted irradiance from one value to another without rendering. Beside `change` it only
  /// gives derivatives, to 1e-3 of them, unless `is_closed`.
  std::function<void(const EffectInput&, std::vector<float>&)> effect = {};
  /// `effect` takes the fringes for sinusoids; where they are none `does_as`, if there is one, is rendered
  /// for the derivative (Sensitivity::columns()).
  bool effect_of_sinusoids = false;
  bool is_closed = false;  ///< `effect` is all that `change` does to the images: nothing is rendered for it
  bool is_of_sensor = false;  ///< a camera's curve: its effect follows those of all light
  /// The value is in DN at GridSamples::curve_gain_dn(): with a gain twice as large it is twice as much.
  bool grows_with_gain = false;
  /// The value means what it does at GridSamples::curve_gain_dn(): fitted with another gain, it is fitted
  /// anew.
  bool told_at_gain = false;
  /// Changes nothing by itself: only where another parameter of its group has left its start.
  bool acts_beside_others = false;
  std::optional<std::size_t> camera = {};  ///< the only one whose images change; all without
  std::string instead = {};  ///< what to do where refined.toml cannot hold the value; empty where it can
  /// Standard deviation of a prior about the start; 0: none. It is weak: it settles what the images do not
  /// tell, as where other parameters do the same.
  double expected = 0.0;
  /// Another parameter of which this one does so many times as much, by the place in the projector's image
  /// that lights a pixel, or as much in one image of the sequence alone: several that do as the same one need
  /// one rendering for all of their derivatives. Empty: none.
  std::shared_ptr<const Parameter> does_as = {};
  std::function<double(const Eigen::Vector2d& projector_px)> times = {};
  std::optional<int> only_image = {};
  /// Order of the harmonic of the fringes that `effect` is made of, which needs GridSamples::harmonics up to
  /// there; 0: none.
  int harmonic = 0;
  /// Is fitted where its whole name is asked for, not with its group.
  bool only_by_name = false;

  /// Returns the value, or its standard error, as a user reads it: of a variance the root.
  double shown(double value) const { return is_variance ? std::sqrt(std::max(0.0, value)) : value; }
  double shown_sigma(double value, double sigma) const {
    if (!is_variance) return sigma;
    // near zero the root's error is no longer its derivative's
    return value > sigma ? 0.5 * sigma / std::sqrt(value)
                         : std::sqrt(std::max(0.0, value) + sigma) - shown(value);
  }
};

/// Collects the parameters of one group: what the lists of the groups have in common.
class GroupList {
 protected:
  explicit GroupList(std::string group) : group_(std::move(group)) {}

  /// Adds a parameter whose value changes the twin, (Twin&, double), or the irradiance, as Parameter::effect.
  template <class Does>
  Parameter& add(const std::string& name, const std::string& unit, double start, double step, Does does) {
    Parameter& p = list_.emplace_back(
        Parameter{.group = group_, .name = name, .unit = unit, .start = start, .step = step});
    if constexpr (std::is_invocable_v<Does, Twin&, double>)
      p.change = std::move(does);
    else
      p.effect = std::move(does);
    return p;
  }

  std::string group_;
  std::vector<Parameter> list_;
};

}  // namespace fringetwin::compare
