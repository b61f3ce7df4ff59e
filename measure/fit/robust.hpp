// SPDX-License-Identifier: Apache-2.0
// Fits any shape robustly: reweighting with a MAD scale, then an unweighted refit to the inliers.
#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "measure/fit/fit_types.hpp"

namespace fringetwin::measure {

/// Points farther than this many robust sigmas from the fit are outliers.
inline constexpr double kInlierSigmas = 4.0;

/// Returns Tukey's weight at u = r / scale, c = 4.685 (95 % efficiency).
inline double tukey_weight(double u) {
  const double t = u / 4.685, inside = 1.0 - t * t;
  return inside > 0.0 ? inside * inside : 0.0;
}

/// Returns the weight of iteratively reweighted least squares at u = r / scale: Huber k = 1.345, Tukey c
/// = 4.685 (95 % efficiency), none = 1.
double robust_weight(RobustLoss loss, double u);

/// A model that can be refitted to weighted points and tell its signed orthogonal distances.
struct RobustModel {
  /// Weighted least squares from the present state; false when degenerate or not converged.
  /// `index` are the points to use, `weight` has their weights.
  std::function<bool(const std::vector<std::size_t>& index, const std::vector<double>& weight)> solve;
  std::function<double(std::size_t i)> distance;
  std::size_t n = 0;            ///< points
  std::size_t min_points = 0;   ///< number of parameters
  double smallest_scale = 0.0;  ///< rounding floor of the residual scale
};

struct RobustResult {
  bool ok = false;
  std::string message;
  std::vector<std::size_t> index;  ///< points of the final, unweighted fit
};

/// Fits the model. With loss none: one solve on all points. Otherwise Huber then (if asked) Tukey reweighting
/// on at most 20,000 points drawn with a fixed seed, scale = loss_scale_mm or 1.4826 MAD; then unweighted
/// refits on all points within kInlierSigmas scales until the set is stable.
RobustResult robust_fit(const RobustModel& model, const FitOptions& options);

}  // namespace fringetwin::measure
