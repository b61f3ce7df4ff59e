// SPDX-License-Identifier: Apache-2.0
// Geometric (orthogonal-distance) fits with covariance, and mesh registration.
#pragma once
#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "measure/points/points.hpp"
#include "twin/twin.hpp"

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
struct SphereFit : FitSummary {
  Eigen::Vector3d center_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< cx cy cz r
};
struct PlaneFit : FitSummary {
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< centroid of the points used
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   ///< towards the viewer
  double offset_sigma_mm = 0.0, tilt_sigma_rad[2] = {0.0, 0.0};
};
struct CylinderFit : FitSummary {
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< on the axis, nearest the centroid
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();
  double radius_mm = 0.0, radius_sigma_mm = 0.0;
  double axis_sigma_rad[2] = {0.0, 0.0};  ///< tilts about two directions across the axis
};
struct MeshFit : FitSummary {
  Pose T_object_measured;           ///< maps measured points (world) onto the CAD surface (world)
  double within_10um = 0.0;         ///< fraction of |deviation| <= 0.010 mm
  std::vector<float> deviation_mm;  ///< signed distance to the CAD SURFACE, per used point
  std::vector<std::size_t> index;   ///< used points
};

SphereFit fit_sphere(const std::vector<Eigen::Vector3d>& p_mm, const SphereShape& start, const FitOptions& o);
PlaneFit fit_plane(const std::vector<Eigen::Vector3d>& p_mm, const FitOptions& o);
CylinderFit fit_cylinder(const std::vector<Eigen::Vector3d>& p_mm, const CylinderShape& start,
                         const FitOptions& o);
/// PCL ICP, then point-to-plane, then Gauss-Newton on the exact closest surface points: not usable when
/// its last step still moved the points (1e-4 mm).
MeshFit register_mesh(const std::vector<Eigen::Vector3d>& p_mm, const MeshShape& cad, double gate_mm,
                      int gauss_newton_steps = 30);

/// RANSAC (PCL) for the largest planes, each refined by fit_plane on its inliers.
std::vector<PlaneFit> find_planes(const std::vector<Eigen::Vector3d>& p_mm, int count, double threshold_mm,
                                  std::vector<std::vector<std::size_t>>* inliers = nullptr);

/// One row of result.json "fits": numbers, vectors and sigmas by their key.
struct ObjectFit {
  std::string object, kind;  ///< kind: sphere, plane, cylinder, mesh
  bool usable = false;
  std::string warning;
  std::size_t n = 0;
  std::map<std::string, double> numbers;           ///< radius_mm, radius_sigma_mm, rms_mm ...
  std::map<std::string, Eigen::Vector3d> vectors;  ///< center_mm, center_sigma_mm ...
  std::vector<std::size_t> index;                  ///< points used
  std::vector<float> deviation_mm;                 ///< signed, per used point
};
/// All [[measure.fit]] of the twin: points within gate_mm of the object's nominal surface, then
/// robust. Too few points: listed with n, usable = false and a warning.
std::vector<ObjectFit> fit_objects(const Twin& twin, const PointCloud& cloud);

/// Signed distance of a world point to an object's nominal surface (mesh: closest surface point).
double surface_distance_mm(const Object& object, const Eigen::Vector3d& p_world_mm);

}  // namespace fringetwin::measure
