// SPDX-License-Identifier: Apache-2.0
// Represents a fringe behind the projector's response as a short cosine series in its phase, and a table
// holds these series for all pitches of a twin.
#pragma once
#include <vector>

namespace fringetwin::render {

/// The function a[0] + sum_k a[k] cos(k t) of the phase t.
struct CosineSeries {
  std::vector<double> a;
  double operator()(double t_rad) const;  ///< evaluates it by Clenshaw's recurrence
};

/// Per [direction][pitch] the series of response(mean + amplitude cos t) before blur. An empty `a` says that
/// each step is evaluated directly. A linear response has {mean, amplitude}.
using SeriesTable = std::vector<std::vector<CosineSeries>>;

}  // namespace fringetwin::render
