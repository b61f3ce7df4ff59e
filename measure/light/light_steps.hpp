// SPDX-License-Identifier: Apache-2.0
// Fits one pixel's fringe over the steps of a pitch, whose waveform all pixels have in common, and says what
// its values owe to it to first order: the equations of light_factors.cpp.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>
#include <vector>

#include "measure/light/harmonics_told.hpp"
#include "twin/base/constants.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::measure {

/// A fringe over the steps: mean + amplitude w(phase + d_k) with w(t) = cos t + harmonics.
struct StepFringe {
  double mean = 0.0, amplitude = 0.0, phase = 0.0;
};

/// The steps of a pitch that are looked at, all or some of them, and the waveform and the errors of the steps
/// that its fringes have in common.
class LightSteps {
 public:
  /// `steps`: which of the `total` steps of a period these are, four at least.
  LightSteps(std::vector<int> steps, int total, bool with_shifts = false)
      : step_(std::move(steps)), total_(total), n_(static_cast<int>(step_.size())), highest_(highest_told()) {
    waveform = Eigen::VectorXd::Zero(of_harmonics());
    if (with_shifts && n_ >= kFewestShiftSteps) shift_basis = orthonormal_complement(first_harmonic());
    move_by(Eigen::VectorXd::Zero(shift_basis.cols()));
  }

  int count() const { return n_; }
  /// Returns whether none of the period's steps is missing: they are evenly spaced then.
  bool are_all() const { return n_ == total_; }
  /// Cosine and sine of the harmonics 2, 3, ... that the steps tell.
  int of_harmonics() const { return 2 * (highest_ - 1); }
  int of_shifts() const { return static_cast<int>(shift_basis.cols()); }
  /// Factors, then harmonics, then shifts.
  int unknowns() const { return n_ + of_harmonics() + of_shifts(); }
  double freedom() const { return n_ - 3.0; }

  /// Returns the mean of the sinusoid nearest to the values.
  double mean(const Eigen::VectorXd& values) const {
    return are_all() ? values.mean() : nearest_.row(0).dot(values);
  }
  /// Returns the sinusoid nearest to the values.
  StepFringe sinusoid(const Eigen::VectorXd& values) const {
    if (!are_all()) {
      const Eigen::Vector3d of = nearest_ * values;
      return {of[0], std::hypot(of[1], of[2]), std::atan2(of[2], of[1])};
    }
    std::complex<double> sum;
    for (int k = 0; k < n_; ++k) sum += values[k] * std::conj(turn_[static_cast<std::size_t>(k)]);
    return {values.mean(), 2.0 / n_ * std::abs(sum), std::arg(sum)};
  }

  /// Moves the steps by shifts of this basis.
  void move_by(const Eigen::VectorXd& change) {
    if (shift_rad.size() == 0) shift_rad = Eigen::VectorXd::Zero(n_);
    if (change.size() > 0) shift_rad += shift_basis * change;
    turn_.clear();
    for (int k = 0; k < n_; ++k) turn_.push_back(std::polar(1.0, angle_rad(k) + shift_rad[k]));
    if (are_all()) return;
    Eigen::MatrixX3d by_own(n_, 3);  // mean, amplitude times cosine and sine of the phase
    for (int k = 0; k < n_; ++k) {
      const std::complex<double>& turn = turn_[static_cast<std::size_t>(k)];
      by_own.row(k) << 1.0, turn.real(), -turn.imag();
    }
    nearest_ = solve_symmetric(by_own.transpose() * by_own, by_own.transpose());
  }

  Eigen::VectorXd waveform;   ///< cosine and sine of each harmonic, over the amplitude
  Eigen::VectorXd shift_rad;  ///< what each step's phase is ahead of 2 pi step/N
  /// The shifts that these steps tell. A common one is a phase of the pixel, and shifts sin(2 pi step/N - t)
  /// do what factors cos(2 pi step/N - t) do: those are the light's.
  Eigen::MatrixXd shift_basis = {};

 private:
  friend struct PixelEquations;
  static constexpr int kFewestShiftSteps = 6;
  /// Of a harmonic's square: what a pixel's own fringe must leave of it in these steps to tell it.
  static constexpr double kLeastLeft = 0.01;

  double angle_rad(int k) const { return kTwoPi * step_[static_cast<std::size_t>(k)] / total_; }
  /// Returns a constant and the first harmonic of the steps.
  Eigen::MatrixXd first_harmonic() const {
    Eigen::MatrixXd own(n_, 3);
    for (int k = 0; k < n_; ++k) own.row(k) << 1.0, std::cos(angle_rad(k)), std::sin(angle_rad(k));
    return own;
  }
  /// Returns the highest harmonic that the steps tell, with all below it: all N tell N - 2; a part of them
  /// may take one for a pixel's own fringe, as every second of twelve takes the fifth.
  int highest_told() const {
    const int highest = highest_harmonic_told(total_);
    if (are_all()) return highest;
    const Eigen::MatrixXcd contrasts = orthonormal_complement(first_harmonic()).cast<std::complex<double>>();
    for (int order = 2; order <= highest; ++order) {
      Eigen::VectorXcd wave(n_);
      for (int k = 0; k < n_; ++k) wave[k] = std::polar(1.0, order * angle_rad(k));
      if ((contrasts.transpose() * wave).squaredNorm() < kLeastLeft * n_) return order - 1;
    }
    return highest;
  }

  std::vector<int> step_;
  int total_, n_, highest_;
  Eigen::Matrix3Xd nearest_;                ///< what each value adds to the nearest sinusoid, of some steps
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
