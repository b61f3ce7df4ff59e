// SPDX-License-Identifier: Apache-2.0
// Fits one pixel's fringe over the steps of a pitch, whose waveform all pixels have in common, and says what
// its values owe to it to first order: the equations of light_factors.cpp.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include "twin/base/constants.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::measure {

/// A fringe over the steps: mean + amplitude w(phase + d_k) with w(t) = cos t + harmonics.
struct StepFringe {
  double mean = 0.0, amplitude = 0.0, phase = 0.0;
};

/// All steps of a pitch, and the waveform and the errors of the steps that its fringes have in common.
class LightSteps {
 public:
  static constexpr int kMostHarmonic = 7;

  explicit LightSteps(int n, bool with_shifts = false) : n_(n) {
    waveform = Eigen::VectorXd::Zero(of_harmonics());
    if (with_shifts && n >= kFewestShiftSteps) shift_basis = contrasts_of(n);
    move_by(Eigen::VectorXd::Zero(shift_basis.cols()));
  }

  int count() const { return n_; }
  /// Cosine and sine of the harmonics 2, 3, ... that the steps tell.
  int of_harmonics() const { return 2 * (std::min(kMostHarmonic, n_ - 2) - 1); }
  int of_shifts() const { return static_cast<int>(shift_basis.cols()); }
  /// Factors, then harmonics, then shifts.
  int unknowns() const { return n_ + of_harmonics() + of_shifts(); }
  double freedom() const { return n_ - 3.0; }

  /// Returns the sinusoid nearest to the values.
  StepFringe sinusoid(const Eigen::VectorXd& values) const {
    std::complex<double> sum;
    for (int k = 0; k < n_; ++k) sum += values[k] * std::conj(turn_[static_cast<std::size_t>(k)]);
    return {values.mean(), 2.0 / n_ * std::abs(sum), std::arg(sum)};
  }

  /// Moves the steps by shifts of this basis.
  void move_by(const Eigen::VectorXd& change) {
    if (shift_rad.size() == 0) shift_rad = Eigen::VectorXd::Zero(n_);
    if (change.size() > 0) shift_rad += shift_basis * change;
    turn_.clear();
    for (int k = 0; k < n_; ++k) turn_.push_back(std::polar(1.0, kTwoPi * k / n_ + shift_rad[k]));
  }

  Eigen::VectorXd waveform;   ///< cosine and sine of each harmonic, over the amplitude
  Eigen::VectorXd shift_rad;  ///< what each step's phase is ahead of 2 pi k/N
  /// The shifts that these steps tell. A common one is a phase of the pixel, and shifts sin(2 pi k/N - t) do
  /// what factors cos(2 pi k/N - t) do: those are the light's.
  Eigen::MatrixXd shift_basis = {};

 private:
  friend struct PixelEquations;
  static constexpr int kFewestShiftSteps = 6;
  /// Returns an orthonormal basis of what N steps have besides a constant and their first harmonic.
  static Eigen::MatrixXd contrasts_of(int n) {
    Eigen::MatrixXd own(n, 3);
    for (int k = 0; k < n; ++k) own.row(k) << 1.0, std::cos(kTwoPi * k / n), std::sin(kTwoPi * k / n);
    return orthonormal_complement(own);
  }
  int n_;
  std::vector<std::complex<double>> turn_;  ///< e^(i d_k)
};

/// What a pixel's values owe to its own fringe, to the factors and to the waveform, to first order. One
/// object serves all pixels of a thread: memory asked for at every pixel is most of the time.
struct PixelEquations {
  Eigen::VectorXd residual, signal;  ///< values less the fringe; the fringe
  Eigen::VectorXd by_phase;          ///< of the fringe
  Eigen::MatrixXd harmonics;         ///< by the waveform
  Eigen::MatrixX3d own;              ///< orthonormal, of what mean, amplitude and phase do
  Eigen::Matrix3d own_size;          ///< own * own_size: by mean, amplitude and phase

  /// Writes the equations of a pixel that has these values, with this fringe.
  void set(const LightSteps& steps, const StepFringe& fringe, const Eigen::VectorXd& values) {
    const int n = steps.count(), m = steps.of_harmonics();
    harmonics.resize(n, m);
    own.resize(n, 3);
    // by parts: the product of std::complex looks for values that are no numbers, and is most of this then
    const auto product = [](const std::complex<double>& a, const std::complex<double>& b) {
      return std::complex<double>(a.real() * b.real() - a.imag() * b.imag(),
                                  a.real() * b.imag() + a.imag() * b.real());
    };
    const std::complex<double> turn = std::polar(1.0, fringe.phase);
    for (int k = 0; k < n; ++k) {
      const std::complex<double> first = product(turn, steps.turn_[static_cast<std::size_t>(k)]);
      std::complex<double> power = first;
      double w = first.real(), slope = -first.imag();
      for (int h = 0; h < m; h += 2) {
        power = product(power, first);
        const double order = 2.0 + h / 2, a = steps.waveform[h], b = steps.waveform[h + 1];
        w += a * power.real() + b * power.imag();
        slope += order * (b * power.real() - a * power.imag());
        harmonics(k, h) = fringe.amplitude * power.real();
        harmonics(k, h + 1) = fringe.amplitude * power.imag();
      }
      own.row(k) << 1.0, w, fringe.amplitude * slope;
    }
    by_phase = own.col(2);
    signal = fringe.mean + fringe.amplitude * own.col(1).array();
    residual = values - signal;
    own_size.setZero();
    for (int c = 0; c < 3; ++c) {  // Gram and Schmidt
      for (int b = 0; b < c; ++b) {
        own_size(b, c) = own.col(b).dot(own.col(c));
        own.col(c) -= own_size(b, c) * own.col(b);
      }
      own_size(c, c) = std::max(own.col(c).norm(), std::numeric_limits<double>::min());
      own.col(c) /= own_size(c, c);
    }
  }

  /// Returns the fringe that fits the values better.
  StepFringe better(const StepFringe& fringe) const {
    const Eigen::Vector3d step = own_size.triangularView<Eigen::Upper>().solve(own.transpose() * residual);
    const bool is_wild = !(std::abs(step[1]) < 0.5 * fringe.amplitude && std::abs(step[2]) < 0.5);
    return is_wild ? fringe
                   : StepFringe{fringe.mean + step[0], fringe.amplitude + step[1], fringe.phase + step[2]};
  }
  /// Writes columns over the steps without what the pixel's own fringe may take.
  template <class Columns>
  void contrasts(const Columns& columns, Columns& without) const {
    without = columns;
    for (int c = 0; c < 3; ++c)
      for (Eigen::Index j = 0; j < columns.cols(); ++j)
        without.col(j) -= own.col(c).dot(columns.col(j)) * own.col(c);
  }
};

}  // namespace fringetwin::measure
