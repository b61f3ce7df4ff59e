// SPDX-License-Identifier: Apache-2.0
// Fits groups of parameters of a twin to convergence, and says what they leave: one try of the search for
// causes.
#pragma once
#include <string>
#include <vector>

#include "compare/causes/cause_decision.hpp"
#include "compare/causes/sensitivity.hpp"

namespace fringetwin::compare {

/// What was fitted, and what it leaves.
struct CauseFit {
  Sensitivity sensors;            ///< with the gain and black level that go with the values
  std::vector<Parameter> fitted;  ///< without switches
  Eigen::VectorXd values = {};    ///< of them
  std::vector<CauseParameter> told =
      {};  ///< of them, as a user reads them; sigma 0: not told by these images
  std::vector<CauseGain> gain = {};
  double chi2 = kNaN;  ///< per value
  TriedCause tried = {};
  bool converged = false;
  std::vector<CauseRegion> regions = {};
};

/// Fits parameters with the gain and black level of each camera, and with what every pixel has of its own;
/// a switch is turned instead. `begin`: values of those that are no switches, where the fit begins;
/// `columns`: their derivatives at the twin, where it begins there. The sensitivity's robust scale stays.
CauseFit fit_cause(const Sensitivity& sensitivity, const Twin& twin, const std::vector<Parameter>& parameters,
                   FreePerPixel free, const Eigen::VectorXd* begin = nullptr,
                   Sensitivity::Columns columns = {});

}  // namespace fringetwin::compare
