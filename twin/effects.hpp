// SPDX-License-Identifier: Apache-2.0
// Lists every effect that the renderer and the sensor know, as one table: a new effect is one more row.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin {

/// Where an effect acts; decides which images show it without rounding noise.
enum class EffectStage {
  light,  ///< in the irradiance: compared before the sensor, in DN without rounding
  sensor  ///< in the gray value: compared after the sensor
};

struct Effect {
  std::string name;
  EffectStage stage = EffectStage::light;
  std::string without;  ///< what a model without it does instead
  std::function<bool(const Twin&)> is_on;
  std::function<void(Twin&)> switch_off;
  std::string switch_on;         ///< what to write into twin.toml
  bool in_noise_theory = false;  ///< the closed form of the noise (study/noise/) counts with it
};

/// Returns the table. `is_on` after `switch_off` is false for every row.
const std::vector<Effect>& effects();

}  // namespace fringetwin
