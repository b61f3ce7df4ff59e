// SPDX-License-Identifier: Apache-2.0
// What is known of a setting before anything is rendered: whether it is a valid twin, and its objective where
// theory has it in closed form.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "study/plan/study_point.hpp"

namespace fringetwin::study {

struct OptimisePlan;

struct Foreknowledge {
  /// Returns why the twin with these settings cannot be measured; an empty string where it can. Empty: all
  /// can.
  std::function<std::string(const Settings&)> fault = {};
  /// Returns the objective in closed form; NaN where too few points are expected, nothing where theory does
  /// not know the twin. Empty: there is none.
  std::function<std::optional<double>(const Settings&)> theory = {};
};

/// Returns what the twin's own check and the theory of the noise know. The theory is asked where the sensor's
/// noise alone makes the sigma of a fitted centre, radius or offset. The plan must outlive it.
Foreknowledge foreknowledge(const OptimisePlan& plan);

}  // namespace fringetwin::study
