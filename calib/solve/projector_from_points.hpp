// SPDX-License-Identifier: Apache-2.0
// Solves a projector without a board: where points of a part are, as two cameras triangulate them, and which
// projector coordinates light them, tell its lens and its pose.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "twin/lens/pose.hpp"

namespace fringetwin::calib {

/// A point of the part that the projector lights.
struct LitPoint {
  Eigen::Vector3d p_world_mm = Eigen::Vector3d::Zero();
  /// Decoded projector coordinate (column, row); the row is NaN where only columns were projected.
  Eigen::Vector2d q_projector_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d sigma_px = Eigen::Vector2d::Ones();  ///< standard deviation of both
  double depth_sigma_mm = 0.0;  ///< standard deviation of the point along the camera's ray
  int tile = 0;                 ///< points of one tile share what the model and the shape get wrong
};

struct ProjectorFromOptions {
  std::array<int, 2> imagersize_px{};
  bool solve_k1 = false;  ///< radial distortion k1 (LENSMODEL_OPENCV4)
  /// A place of the world (mm), e.g. half way between the cameras. Without rows the projector's centre is
  /// only known up to a shift along its columns: the one nearest to this place is taken.
  Eigen::Vector3d near_world_mm = Eigen::Vector3d::Zero();
};

/// fx fy cx cy (px), then the rotation vector (rad) and the translation (mm) of T_projector_world, then k1.
struct ProjectorParameter {
  static constexpr int fx = 0, fy = 1, cx = 2, cy = 3, r = 4, t = 7, k1 = 10, count = 11;
  static const std::array<const char*, count>& names();
};

struct ProjectorFromPoints {
  bool rows = false;  ///< rows took part
  std::array<double, ProjectorParameter::count> parameters{};
  /// Standard errors; 0 for what was set by convention (without rows fy, cy, t2) or left out (k1). Robust
  /// against neighbours that share their errors: what whole tiles say (a "sandwich" of clusters, White 1980,
  /// Liang and Zeger 1986).
  std::array<double, ProjectorParameter::count> sigma{};
  std::size_t n_points = 0, n_outliers = 0;
  double rms_px = 0.0;            ///< of the residuals of all coordinates that took part
  double chi2 = 0.0;              ///< mean square of residual over its sigma
  double column_sigma_px = 0.0;   ///< standard error of the column that the projector gives a point, rms
  double tile_rms_px = 0.0;       ///< rms of the tiles' mean residuals: what does not average out
  double tile_expected_px = 0.0;  ///< what of it the noise makes
  std::map<int, double> tile_mean_px =
      {};                           ///< mean residual of the columns of each tile, found minus predicted
  std::array<double, 2> rows_px{};  ///< least and largest row of the points, by convention without rows
  Pose T_projector_world() const;
  /// Intrinsics as the lens model lists them: PINHOLE, or OPENCV4 where k1 was solved.
  std::string lensmodel = {};
  std::vector<double> intrinsics() const;
};

/// Solves by a closed form, then robust least squares (Huber, then without points beyond five robust sigmas).
/// A column u = fx X/Z + cx depends on seven numbers: fx, cx, the rotation and two of the translation.
/// Throws UserError(input), naming `where`, for fewer than 500 points or 30 tiles, where nine tenths of the
/// points leave a plane by less than a hundred times the noise of their depths, and where fx is not known to
/// 10 %; UserError(no_convergence).
ProjectorFromPoints projector_from_points(const std::vector<LitPoint>& points,
                                          const ProjectorFromOptions& options, const std::string& where);

}  // namespace fringetwin::calib
