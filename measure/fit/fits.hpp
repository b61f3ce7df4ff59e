// SPDX-License-Identifier: Apache-2.0
// Fits one shape to points by their orthogonal distances, with covariance, and registers points to a mesh.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "measure/fit/fit_types.hpp"
#include "twin/base/constants.hpp"
#include "twin/lens/pose.hpp"
#include "twin/shape/shape.hpp"

namespace fringetwin::measure {

struct SphereFit : FitSummary {
  Eigen::Vector3d center_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< cx cy cz r
};
struct PlaneFit : FitSummary {
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< centroid of the points used
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   ///< towards the viewer
  double offset_sigma_mm = 0.0;
  Eigen::Matrix3d tilt_covariance = Eigen::Matrix3d::Zero();  ///< rad^2 along the directions of the world
};
struct CylinderFit : FitSummary {
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< on the axis, nearest the centroid
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();
  double radius_mm = 0.0, radius_sigma_mm = 0.0;
  /// Of the axis's direction and of its place at point_mm, along the directions of the world: rad^2, mm^2.
  Eigen::Matrix3d tilt_covariance = Eigen::Matrix3d::Constant(kNaN);
  Eigen::Matrix3d shift_covariance = tilt_covariance;
};
struct MeshFit : FitSummary {
  Pose T_object_measured;  ///< maps measured points (world) onto the CAD surface (world)
  /// Of a turn about turned_about_mm and of a shift after it, both of the registered points in the object's
  /// frame: rad, mm. kUndeterminedMm along directions in which the surface slides in itself; NaN if unusable.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Constant(kNaN);
  Eigen::Vector3d turned_about_mm = Eigen::Vector3d::Zero();
  double within_10um = 0.0;         ///< fraction of |deviation| <= 0.010 mm
  std::vector<float> deviation_mm;  ///< signed distance to the CAD SURFACE, per used point
  std::vector<std::size_t> index;   ///< used points
};

inline constexpr double kUndeterminedMm = 1e6;

SphereFit fit_sphere(const std::vector<Eigen::Vector3d>& p_mm, const SphereShape& start, const FitOptions& o);
PlaneFit fit_plane(const std::vector<Eigen::Vector3d>& p_mm, const FitOptions& o);
CylinderFit fit_cylinder(const std::vector<Eigen::Vector3d>& p_mm, const CylinderShape& start,
                         const FitOptions& o);
/// PCL ICP, then point-to-plane, then Gauss-Newton on the exact closest surface points: not usable when
/// its last step still moved the points (1e-4 mm). `block`: as in FitOptions.
MeshFit register_mesh(const std::vector<Eigen::Vector3d>& p_mm, const MeshShape& cad, double gate_mm,
                      const std::vector<int>& block = {}, int gauss_newton_steps = 30);

}  // namespace fringetwin::measure
