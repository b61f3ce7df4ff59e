// SPDX-License-Identifier: Apache-2.0
// What parameters do to light and gray values where nothing is rendered for it.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "compare/parameters/grid_view.hpp"
#include "compare/parameters/parameters.hpp"

namespace fringetwin::compare {

/// What parameters do to the irradiance of a camera from their start to their values, where nothing is
/// rendered for it.
struct ParameterEffects {
  const Twin &rendered, &fitted;  ///< as EffectInput has them
  const std::vector<Parameter>& parameters;
  const Eigen::VectorXd& values;

  /// Does what is done to the light.
  void add_light(const GridSamples& s, const std::vector<float>& before, std::vector<float>& e) const {
    for (std::size_t k = 0; k < parameters.size(); ++k)
      if (!parameters[k].is_of_sensor && has_effect(k, s))
        parameters[k].effect({rendered, fitted, s, before, parameters[k].start, values[k]}, e);
  }
  /// Returns whether the sensors' curves bend light.
  bool bend(const GridSamples& s) const {
    for (std::size_t k = 0; k < parameters.size(); ++k)
      if (parameters[k].is_of_sensor && has_effect(k, s)) return true;
    return false;
  }
  /// Bends levels as the sensors' curves do, after all else.
  void see(const GridSamples& s, std::vector<float>& levels) const {
    for (std::size_t k = 0; k < parameters.size(); ++k)
      if (parameters[k].is_of_sensor && has_effect(k, s))
        parameters[k].effect({rendered, fitted, s, levels, parameters[k].start, values[k]}, levels);
  }
  /// Takes that back.
  void unsee(const GridSamples& s, std::vector<float>& levels) const {
    for (std::size_t k = parameters.size(); k-- > 0;)
      if (parameters[k].is_of_sensor && has_effect(k, s))
        parameters[k].effect({rendered, fitted, s, levels, values[k], parameters[k].start}, levels);
  }

 private:
  bool has_effect(std::size_t k, const GridSamples& s) const {
    const Parameter& p = parameters[k];
    return (!p.change || p.is_closed) && values[k] != p.start && (!p.camera || *p.camera == s.camera);
  }
};

}  // namespace fringetwin::compare
