// SPDX-License-Identifier: Apache-2.0
// Fits parameters of a twin to the real gray values by Gauss-Newton steps through the renderer.
#pragma once
#include "compare/causes/sensitivity.hpp"

namespace fringetwin::compare {

/// Steps of the normal equations, halved until chi2 falls; gain (unless held) and black level of each camera
/// are solved with the parameters. Chi2 is per gray value, with the best gain and black level.
class GaussNewton {
 public:
  GaussNewton(Sensitivity& sensitivity, const Twin& twin, std::vector<Parameter> parameters, bool hold_gain);

  /// Begins at these values instead, if they fit better; returns whether they do.
  bool start_at(const Eigen::VectorXd& values);
  enum class Outcome {
    moved,
    settled,  ///< all values to 0.05 standard errors, or to 0.5 where no step is better
    stuck     ///< no step or part of it lowers chi2
  };
  /// Takes one step. `keep_scale`: the robust scale stays, so that chi2 can be compared with one before.
  Outcome step(bool keep_scale = false, Sensitivity::Derivative derivative = Sensitivity::Derivative::quick);

  Twin twin() const { return with_values(twin_, parameters_, values_); }
  const std::vector<Parameter>& parameters() const { return parameters_; }
  const Eigen::VectorXd& values() const { return values_; }
  const NormalEquations& equations() const { return equations_; }  ///< at the values before the last step
  double chi2() const { return chi2_; }
  /// Returns the indices of the parameters, then of what is solved of the sensors.
  std::vector<std::size_t> unknowns() const;
  /// Returns the chi2 of a twin with the gain and black level that fit it best.
  double chi2_of(const Twin& twin) const;
  /// Puts the best gain and black level at the values reached into the samples.
  void settle_sensors();

 private:
  double chi2_of(const NormalEquations& without_parameters) const;
  void settle_sensors(const NormalEquations& without_parameters);
  std::vector<std::size_t> sensors_of(const NormalEquations& e) const;
  /// Returns true where all parameters move by so many standard errors at most.
  bool is_within(const Step& step, double sigmas) const;
  bool take(const Step& step);

  Sensitivity& sensitivity_;
  Twin twin_;
  std::vector<Parameter> parameters_;
  bool hold_gain_;
  Eigen::VectorXd values_;
  NormalEquations equations_;
  double chi2_ = 0.0;
};

}  // namespace fringetwin::compare
