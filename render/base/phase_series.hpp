// SPDX-License-Identifier: Apache-2.0
// Represents the light of a fringe as a short Fourier series in its phase, and a table holds these series for
// all pitches of a twin.
#pragma once
#include <cmath>
#include <cstddef>
#include <vector>

namespace fringetwin::render {

/// The function a[0] + sum_k (a[k] cos(k t) + b[k] sin(k t)) of the phase t.
struct PhaseSeries {
  std::vector<double> a;
  std::vector<double> b = {};  ///< as long as `a`, or empty: no sines

  double sine(std::size_t k) const { return k < b.size() ? b[k] : 0.0; }
  /// Returns the size of harmonic k.
  double size(std::size_t k) const { return b.empty() ? std::abs(a[k]) : std::hypot(a[k], b[k]); }

  /// Evaluates it by Clenshaw's recurrence.
  double operator()(double t_rad) const {
    const double c = std::cos(t_rad);
    double a1 = 0.0, a2 = 0.0, b1 = 0.0, b2 = 0.0;
    for (std::size_t k = a.size(); k-- > 1;) {
      const double a0 = a[k] + 2.0 * c * a1 - a2;
      a2 = a1;
      a1 = a0;
      if (b.empty()) continue;
      const double b0 = b[k] + 2.0 * c * b1 - b2;
      b2 = b1;
      b1 = b0;
    }
    const double cosines = a.empty() ? 0.0 : a[0] + c * a1 - a2;
    return b.empty() ? cosines : cosines + std::sin(t_rad) * b1;
  }
};

/// Per [direction][pitch] the series of the light of a phase step before blur. An empty `a` says that each
/// step is evaluated directly. Sinusoids behind a linear response have {mean, amplitude}.
using SeriesTable = std::vector<std::vector<PhaseSeries>>;
/// Per [direction][pitch][term] what the series have more where that term of a field is 1.
using SeriesOfField = std::vector<std::vector<std::vector<PhaseSeries>>>;

}  // namespace fringetwin::render
