// SPDX-License-Identifier: Apache-2.0
// What all fits of a shape to points have in common: how to treat outliers, the summary of a fit, and the row
// of numbers that a fitted object gives.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace fringetwin::measure {

enum class RobustLoss { none, huber, tukey };

struct FitOptions {
  RobustLoss loss = RobustLoss::none;
  double loss_scale_mm = 0.0;  ///< 0 = 1.4826 MAD of the residuals, iterated
  int max_iterations = 100;
  /// One number per point: which points may share an error (image_blocks() of their source pixels).
  /// Empty: residuals count as independent.
  std::vector<int> block;
};

/// Common part. rms_mm: root mean square of the signed orthogonal distances of the n points used
/// (inliers); sigma from the covariance s^2 (J^T J)^-1 with s^2 = sum r^2/(n - parameters), or, where
/// larger, from the scatter between FitOptions::block (block_covariance.hpp).
struct FitSummary {
  bool usable = false;             ///< converged and enough points
  std::string message;             ///< why not, or a warning; may be empty
  std::size_t n = 0, n_gated = 0;  ///< used; within the gate before robust rejection
  double rms_mm = 0.0;
};

/// One row of result.json "fits": numbers, vectors and sigmas by their key.
struct ObjectFit {
  std::string object = {}, kind = {};  ///< kind: sphere, plane, cylinder, mesh
  bool usable = false;
  std::string warning = {};
  std::size_t n = 0;
  std::map<std::string, double> numbers = {};           ///< radius_mm, radius_sigma_mm, rms_mm ...
  std::map<std::string, Eigen::Vector3d> vectors = {};  ///< center_mm, center_sigma_mm ...
  /// What the method itself adds, by the keys of the numbers or of their differences (method_bias.hpp); empty
  /// where unknown.
  std::map<std::string, double> bias = {};
  std::map<std::string, Eigen::Vector3d> bias_vectors = {};
  std::vector<std::size_t> index = {};   ///< points used
  std::vector<float> deviation_mm = {};  ///< signed, per used point
};

}  // namespace fringetwin::measure
