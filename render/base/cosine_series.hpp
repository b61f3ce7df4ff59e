// SPDX-License-Identifier: Apache-2.0
// Represents a fringe behind the projector's response as a short cosine series in its phase, and a table
// holds these series for all pitches of a twin.
#pragma once
#include <cmath>
#include <cstddef>
#include <vector>

namespace fringetwin::render {

/// The function a[0] + sum_k a[k] cos(k t) of the phase t.
struct CosineSeries {
  std::vector<double> a;

  /// Evaluates it by Clenshaw's recurrence.
  double operator()(double t_rad) const {
    const double c = std::cos(t_rad);
    double b1 = 0.0, b2 = 0.0;
    for (std::size_t k = a.size(); k-- > 1;) {
      const double b0 = a[k] + 2.0 * c * b1 - b2;
      b2 = b1;
      b1 = b0;
    }
    return a.empty() ? 0.0 : a[0] + c * b1 - b2;
  }
};

/// Per [direction][pitch] the series of response(mean + amplitude cos t) before blur. An empty `a` says that
/// each step is evaluated directly. A linear response has {mean, amplitude}.
using SeriesTable = std::vector<std::vector<CosineSeries>>;

}  // namespace fringetwin::render
