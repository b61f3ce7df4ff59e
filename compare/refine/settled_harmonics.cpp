// SPDX-License-Identifier: Apache-2.0
#include "compare/refine/settled_harmonics.hpp"

#include <algorithm>
#include <utility>

#include "compare/causes/group_fit.hpp"
#include "compare/parameters/parameters.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kMostSettlingSteps = 2;  // all but linear

/// Returns the places of the harmonics of all fringes.
std::vector<std::size_t> places_of_harmonics(const std::vector<Parameter>& parameters,
                                             const std::vector<bool>& told) {
  std::vector<std::size_t> at;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (told[k] && parameters[k].harmonic > 0) at.push_back(k);
  return at;
}

}  // namespace

bool can_settle_harmonics(const Twin& twin, const std::vector<Parameter>& parameters,
                          const std::vector<bool>& told) {
  return twin.render.bounces == 0 && !places_of_harmonics(parameters, told).empty() &&
         std::ranges::all_of(parameters, [](const Parameter& p) { return p.change && !p.is_of_sensor; });
}

Eigen::VectorXd with_settled_harmonics(Sensitivity& all, const Twin& twin,
                                       const std::vector<Parameter>& parameters,
                                       const std::vector<bool>& told, const Eigen::VectorXd& values,
                                       bool hold_gain) {
  const std::vector<std::size_t> at = places_of_harmonics(parameters, told);
  std::vector<Parameter> harmonics;
  for (const std::size_t k : at) {
    harmonics.push_back(parameters[k]);
    harmonics.back().start = values[static_cast<Eigen::Index>(k)];
  }
  GroupFit fit(all, with_values(twin, parameters, values), std::move(harmonics),
               {.hold_gain = hold_gain, .tells = false, .most_steps = kMostSettlingSteps});
  fit.run();
  Eigen::VectorXd settled = values;
  for (std::size_t i = 0; i < at.size(); ++i)
    settled[static_cast<Eigen::Index>(at[i])] = fit.values()[static_cast<Eigen::Index>(i)];
  return settled;
}

}  // namespace fringetwin::compare
