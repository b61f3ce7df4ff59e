// SPDX-License-Identifier: Apache-2.0
#include "study/optimise/foreknowledge.hpp"

#include <fmt/format.h>

#include <cmath>

#include "compare/verdict/limits.hpp"
#include "measure/measurement.hpp"
#include "study/noise/noise_theory.hpp"
#include "study/optimise/evaluation.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

constexpr std::size_t kScreenPixels = 4000;  // of the first camera: settings are put in order, no more

/// Returns what `fits.OBJECT.measured.NUMBER` scatters by; nothing for a number that theory does not have.
std::optional<double> sigma_of(const NoiseTheory& theory, const Object& object, const std::string& result) {
  const std::string fit = "fits." + object.name + ".measured.";
  if (result == fit + "radius_mm") return theory.radius_sigma_mm;
  for (int k = 0; k < 3; ++k) {
    if (result == fmt::format("{}center_mm[{}]", fit, k)) return theory.center_sigma_mm[k];
    // the centroid of a plane that lies across this axis moves along it
    const auto* plane = std::get_if<PlaneShape>(&object.shape);
    if (plane != nullptr && std::abs(plane->normal[k]) > 0.9 &&
        result == fmt::format("{}point_mm[{}]", fit, k))
      return theory.offset_sigma_mm;
  }
  return std::nullopt;
}

std::optional<double> closed_form(const OptimisePlan& plan, const Settings& values) {
  const Twin twin = load_twin(plan.twin, values);
  for (const Object& object : twin.objects) {
    if (!plan.result.starts_with("fits." + object.name + ".")) continue;
    try {
      return sigma_of(noise_theory(twin, object.name, kScreenPixels), object, plan.result);
    } catch (const UserError&) {
      return std::nullopt;  // the twin has what the theory does not know
    }
  }
  return std::nullopt;
}

}  // namespace

Foreknowledge foreknowledge(const OptimisePlan& plan) {
  Foreknowledge out;
  out.fault = [&plan](const Settings& values) {
    throw_if_cancelled();
    try {
      measure::check_fringes(compare::load_checked_twin(plan.twin, values));
    } catch (const UserError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  if (plan.statistic == Statistic::sigma && plan.inputs.factors() == std::vector<std::string>{"noise"})
    out.theory = [&plan](const Settings& values) {
      throw_if_cancelled();
      return closed_form(plan, values);
    };
  return out;
}

}  // namespace fringetwin::study
