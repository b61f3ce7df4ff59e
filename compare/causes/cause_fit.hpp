// SPDX-License-Identifier: Apache-2.0
// Fits groups of parameters of a twin to convergence, and says what they leave: one try of the search for
// causes.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compare/causes/cause_decision.hpp"
#include "compare/causes/sensitivity.hpp"

namespace fringetwin::compare {

/// What was fitted, and what it leaves.
struct CauseFit {
  Sensitivity sensors;                 ///< with the gain and black level that go with the values
  std::vector<Parameter> fitted;       ///< without switches
  Eigen::VectorXd values = {};         ///< of them
  Eigen::MatrixXd covariance = {};     ///< of the values; 0 of what is not told
  Sensitivity::Values predicted = {};  ///< by them
  Sensitivity::Columns columns = {};   ///< the derivatives by them that were used last; may be empty
  Eigen::VectorXd columns_at = {};     ///< the values that those belong to
  std::vector<CauseParameter> told =
      {};  ///< of them, as a user reads them; sigma 0: not told by these images
  std::vector<CauseGain> gain = {};
  double chi2 = kNaN;   ///< per value
  std::uint64_t n = 0;  ///< values, less those that pixels have of their own
  TriedCause tried = {};
  bool converged = false;
  std::vector<CauseRegion> regions = {};
  double fit_z = kNaN;  ///< hold_against_fits()
  bool fits_agree = true;
};

/// Where a fit begins, as far as it is known.
struct CauseStart {
  Eigen::VectorXd values = {};         ///< of the parameters that are no switches; empty: those of the twin
  Sensitivity::Values predicted = {};  ///< there
  Sensitivity::Columns columns = {};   ///< derivatives by these parameters; empty: to be rendered
  Eigen::VectorXd columns_at = {};     ///< the values that those belong to; empty: those of the twin
  bool only_values = false;  ///< nothing is asked of the fit but values, what they predict, gain and black
};

/// Fits parameters with the gain and black level of each camera, and with what every pixel has of its own;
/// a switch is turned instead. The sensitivity's robust scale stays. A fit that cannot explain the
/// difference does not go on to its end.
CauseFit fit_cause(const Sensitivity& sensitivity, const Twin& twin, const std::vector<Parameter>& parameters,
                   FreePerPixel free, CauseStart start = {});

/// Returns the values of these parameters, which move or grow objects, that bring the fits of both sides
/// together (|z| as below): where a linear step of gray values does not reach. Nothing where no values do, or
/// the fits agree as they are.
std::optional<Eigen::VectorXd> values_of_fits(const std::vector<FitRow>& fits, const Twin& twin,
                                              const std::vector<Parameter>& parameters);

/// Lets a cause pass no more that moves or grows objects and does not bring the fits of both sides together:
/// with its values the largest |z| of a number, the values' own covariance counted, must be within the limit
/// of the largest of all fits' numbers together (most_sigmas_of()), or at most a quarter of what it is
/// without and within three times that limit. Keeps that |z| as `fit_z`.
void hold_against_fits(const std::vector<FitRow>& fits, const Twin& twin, CauseFit& cause);

}  // namespace fringetwin::compare
