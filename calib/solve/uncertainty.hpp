// SPDX-License-Identifier: Apache-2.0
// Returns what the noise of the corners leaves unknown of a solved calibration, as covariances: of a
// projection, of triangulated points, of a fitted sphere. The method is that of mrcal 2.2 (docs: "Uncertainty
// quantification", mean-pcam): propagate the corners' noise through the linearised solve. Frames are not
// known better than the boards, so a point is held fixed relative to the boards, not to a camera: what only
// turns or shifts the whole rig does not count.
#pragma once
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "calib/solve/calibration.hpp"

namespace fringetwin::calib {

/// A device's part in the triangulation of a point: both coordinates of a camera, one or both of a projector.
struct Sighting {
  int device = 0;
  bool use_x = true, use_y = true;
  double sigma_px = 1.0;  ///< of the measured coordinates: the weights of the triangulation
};

class Uncertainty {
 public:
  explicit Uncertainty(const Calibration& calibration);

  /// Standard deviation of the weighted residuals (mrcal's observed_pixel_uncertainty).
  double observed_sigma_px() const { return sigma_px_; }

  /// Covariance (px^2) of the projection of a point (mm, in the device's frame) due to the calibration.
  Eigen::Matrix2d projection(int device, const Eigen::Vector3d& p_device_mm) const;
  /// Returns the same for a point at infinity in this direction.
  Eigen::Matrix2d projection_at_infinity(int device, const Eigen::Vector3d& direction) const;

  /// Joint covariance (mm^2, 3n x 3n) of points (mm, reference frame) triangulated by least squares of the
  /// weighted pixel differences: due to the calibration only, the same for all pictures taken with it.
  Eigen::MatrixXd points(const std::vector<Eigen::Vector3d>& p_ref_mm,
                         const std::vector<Sighting>& sightings) const;
  /// Covariance (mm^2) of one such point due to the noise of its own picture.
  Eigen::Matrix3d point_noise(const Eigen::Vector3d& p_ref_mm, const std::vector<Sighting>& sightings) const;

  /// Covariance of the lens parameters of a device (state's units), for the parameters that were solved.
  Eigen::MatrixXd intrinsics(int device) const;
  /// Covariance of rt_device_ref (rad, mm) of a device other than the first.
  Eigen::Matrix<double, 6, 6> extrinsics(int device) const;
  /// Standard deviation (mm) of the distance between the centres of two devices.
  double baseline_sigma_mm(int first, int second) const;
  /// Covariance (mm^2) of the board's warp; zero where it was not solved.
  Eigen::Matrix2d warp() const;
  /// Joint covariance of the rig: per device its solved lens parameters and, but for the first, its
  /// rt_device_ref (rad, mm).
  Eigen::MatrixXd rig() const;
  /// Returns how much of the cameras' corner noise the projector's corners share, 0 to 1 (shared_noise.hpp).
  double shared() const { return share_; }

 private:
  Eigen::MatrixXd covariance(const Eigen::MatrixXd& dF_dstate) const;
  void add_board_motion(const Eigen::Vector3d& p_ref_m, bool at_infinity, const Eigen::MatrixX3d& dF_dpref,
                        Eigen::MatrixXd& dF_dstate) const;
  struct Projected;
  Projected project(int device, const Eigen::Vector3d& p_ref_m, bool at_infinity) const;
  void triangulate(const Eigen::Vector3d& p_ref_mm, const std::vector<Sighting>& sightings,
                   Eigen::MatrixXd& dp_dstate, Eigen::Matrix3d& noise_m2) const;

  MrcalProblem problem_;
  MrcalModel model_;
  MrcalLinearisation linear_;
  Eigen::LLT<Eigen::MatrixXd> JtJ_;    ///< packed states
  Eigen::MatrixXd regularisation_;     ///< L^-1 Jr^T
  Eigen::SparseMatrix<double> noise_;  ///< packed states x independent noises; empty: sigma_px_ on each row
  double sigma_px_ = 0.0, share_ = 0.0;
};

/// Largest standard deviation over all directions.
double worst_direction_sigma(const Eigen::Matrix2d& covariance);

/// rms over the points of their standard deviation (3D) after the best rigid motion is taken out: what the
/// calibration does to a shape, whatever it does to its place. Needs at least 3 points.
double aligned_shape_sigma_mm(const std::vector<Eigen::Vector3d>& p_mm,
                              const Eigen::MatrixXd& covariance_mm2);

}  // namespace fringetwin::calib
