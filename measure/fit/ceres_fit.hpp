// SPDX-License-Identifier: Apache-2.0
// Minimises the squared distances of points to a shape, robustly if asked, and gives the covariance at the
// minimum.
#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "measure/fit/fit_types.hpp"
#include "measure/fit/point_set.hpp"

namespace fringetwin::measure {

/// A shape of at most kMostParameters parameters.
struct DistanceModel {
  static constexpr int kMostParameters = 8;
  virtual ~DistanceModel() = default;
  virtual int parameters() const = 0;
  /// Signed distance of p from the shape x, mm; with its derivatives unless dr_dx is null.
  virtual double distance(const double* x, const Eigen::Vector3d& p, double* dr_dx) const = 0;
};

/// Minimises by Levenberg-Marquardt on sqrt(weight_k) * distance(x, p_mm[index_k]) from x. Returns false when
/// not converged.
bool minimise(const DistanceModel& model, const std::vector<Eigen::Vector3d>& p_mm,
              const std::vector<std::size_t>& index, const std::vector<double>& weight, int max_iterations,
              double* x);

struct FitCovariance {
  Eigen::MatrixXd covariance;  ///< parameters squared; NaN without redundancy
  double rms_mm = 0.0;
};

/// Returns s^2 (J^T J)^-1 at x with s^2 = sum r^2/(n - parameters), raised by block_covariance() when the
/// points' blocks are given (one per point of p_mm). nullopt when J^T J is singular (columns scaled to unit
/// length; reciprocal condition < 1e-13).
std::optional<FitCovariance> covariance_at(const DistanceModel& model,
                                           const std::vector<Eigen::Vector3d>& p_mm,
                                           const std::vector<std::size_t>& index,
                                           const std::vector<int>& block, const double* x);

/// Moves the parameters from where they are to the minimum over some points with their weights; false when
/// degenerate or not converged.
using SolveWeighted =
    std::function<bool(const std::vector<std::size_t>& index, const std::vector<double>& weight)>;

/// Fits the model to the points by `solve`, which acts on x. Returns the covariance of x and sets fit.usable,
/// n and rms_mm; nullopt, with fit.message, where the points do not determine the shape ("a sphere").
std::optional<Eigen::MatrixXd> fit_robustly(const DistanceModel& model, const CentredPoints& points,
                                            const FitOptions& options, const std::string& shape,
                                            const SolveWeighted& solve, const double* x, FitSummary& fit);

}  // namespace fringetwin::measure
