// SPDX-License-Identifier: Apache-2.0
// Describes what a twin can be wrong about as parameters, numbers with a start value that change a twin:
// those of
// `--refine` and of the search for causes.
#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::compare {

/// One number of the twin. `value` is what is fitted; a user reads its root where it is a variance.
struct Parameter {
  std::string group;         ///< one of parameter_groups()
  std::string name;          ///< "ball.center_mm.x", "projector.k1"
  std::string unit;          ///< "mm", "rad", "px" or empty
  double start = 0.0;        ///< value in the twin it was made for
  double step = 0.0;         ///< where the search for a difference step begins
  bool is_variance = false;  ///< shown as its root
  bool is_switch = false;    ///< an effect that is on (1) or off (0): differences are taken between the two
  double largest = 1e300, smallest = -1e300;
  /// Changes a twin by value - start. Throws UserError(usage) where no lens can be built from it.
  std::function<void(Twin&, double)> change;

  /// Returns the value, or its standard error, as a user reads it: of a variance the root.
  double shown(double value) const;
  double shown_sigma(double value, double sigma) const;
};

/// Parameters that are fitted together and named together.
struct ParameterGroup {
  std::string name;     ///< what `--refine` calls it
  std::string meaning;  ///< of its parameters
  std::string cause;    ///< how a report names it when the twin is wrong about it
};
/// Returns the groups that can be asked for: pose, rig, lens, response, harmonics, blur, vignetting, albedo,
/// bounce. Gain and black level of each camera come besides.
const std::vector<ParameterGroup>& parameter_groups();
const ParameterGroup& parameter_group(const std::string& name);

/// Returns all parameters of a group that this twin has; none where it lacks what they describe (a response
/// given as a table, objects that cannot light each other ...).
std::vector<Parameter> parameters_of(const Twin& twin, const std::string& group);

/// Returns the twin with these values in place of the start values; parameters change it one after the other.
Twin with_values(const Twin& twin, const std::vector<Parameter>& parameters, const Eigen::VectorXd& values);
Eigen::VectorXd start_values(const std::vector<Parameter>& parameters);

}  // namespace fringetwin::compare
