// SPDX-License-Identifier: Apache-2.0
// Solves N-step phase shifting by linear least squares: the images of the phase steps go in; wrapped phase,
// amplitude, mean and residual of every pixel come out.
#pragma once
#include <complex>
#include <cstddef>
#include <vector>

namespace fringetwin::measure {

/// Returns the numbers of a full set of steps, 0...steps_total-1.
std::vector<int> all_steps(int steps_total);

/// Holds the least-squares weights of the phase steps in the model I_n = mean + c cos(2 pi n/N) - s sin(2 pi
/// n/N), c = amplitude cos(phase), s = amplitude sin(phase). The solution makes mean, c and s linear in the
/// images; the weights come from the 3x3 normal equations of the steps used (for the full set they are 1/N,
/// 2/N cos, -2/N sin).
class StepSolver {
 public:
  /// steps_n: at least 3 different numbers in 0...steps_total-1. Throws UserError(usage) otherwise.
  StepSolver(const std::vector<int>& steps_n, int steps_total);

  int count() const { return static_cast<int>(mean_.size()); }
  const std::vector<float>& mean_weights() const { return mean_; }
  const std::vector<float>& cos_weights() const { return cos_; }
  const std::vector<float>& sin_weights() const { return sin_; }
  /// Value of step i (index into steps_n) = mean + c*basis_cos + s*basis_sin.
  double basis_cos(int i) const { return basis_cos_[i]; }
  double basis_sin(int i) const { return basis_sin_[i]; }

  /// Returns amplitude e^(i phase) of a pixel whose value in step i is value(i).
  template <class Value>
  std::complex<double> fringe(const Value& value) const {
    double c = 0.0, s = 0.0;
    for (std::size_t i = 0; i < cos_.size(); ++i) {
      c += static_cast<double>(cos_[i]) * value(i);
      s += static_cast<double>(sin_[i]) * value(i);
    }
    return {c, s};
  }

  /// Variance of the phase for unit gray-value variance and unit amplitude: g^T (A^T A)^-1 g with
  /// g = (-sin phase, cos phase). 2/N for the full set.
  double phase_variance(double cos_phase, double sin_phase) const {
    return cov_cc_ * sin_phase * sin_phase - 2.0 * cov_cs_ * sin_phase * cos_phase +
           cov_ss_ * cos_phase * cos_phase;
  }
  /// Returns whether phase_variance() is the same for every phase, as with a full set of steps.
  bool isotropic() const { return isotropic_; }

 private:
  std::vector<float> mean_, cos_, sin_;
  std::vector<double> basis_cos_, basis_sin_;
  double cov_cc_ = 0.0, cov_cs_ = 0.0, cov_ss_ = 0.0;
  bool isotropic_ = false;
};

/// The largest number of rows for which an image is solved in one thread: fewer are not worth a team.
inline constexpr int kSerialRows = 32;

/// Points at the outputs of one row; any pointer but phase_rad may be null.
struct PhaseRow {
  float* phase_rad = nullptr;  ///< (-pi, pi]
  float* amplitude = nullptr;
  float* mean = nullptr;
  float* maximum = nullptr;   ///< largest of the step values, for the saturation mask
  float* residual = nullptr;  ///< sqrt(sum r^2 / (steps - 3)), NaN with 3 steps
};

/// Solves n neighbouring pixels; steps[i] points at the first of them in step image i.
void solve_row(const StepSolver& solver, const float* const* steps, int n, const PhaseRow& out);

}  // namespace fringetwin::measure
