// SPDX-License-Identifier: Apache-2.0
// The only door to libmrcal: its C API changes with each major release and carries no version macro,
// so every call is made in mrcal_facade.cpp and no mrcal type leaves it.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fringetwin {

/// A configured mrcal lens model (without intrinsics). Cheap to copy.
class MrcalModel {
 public:
  /// Returns the model of a full name with its configuration, e.g.
  /// "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=11_Ny=8_fov_x_deg=44". nullopt for a name that libmrcal does
  /// not know or whose configuration is missing, malformed or out of range (lens_name.hpp).
  static std::optional<MrcalModel> from_name(const std::string& name);
  /// Returns all names, configuration as "...".
  static std::vector<std::string> supported_names();

  int intrinsics_count() const;
  bool has_gradients() const;
  bool can_project_behind_camera() const;
  /// Returns the half sizes of the knot grid |u|, u = 2 tan(theta/2) (cos, sin); splined models only.
  std::optional<Eigen::Vector2d> spline_half_size() const;

  /// Projects a point, without the gradients that are null. Returns false when the result is not finite.
  /// Where libmrcal has no gradients (CAHVORE) dq_dp is made of central differences, good to about 1e-9, and
  /// dq_dintrinsics (2 x intrinsics_count()) must be null.
  bool project(const std::vector<double>& intrinsics, const Eigen::Vector3d& p_cam, Eigen::Vector2d* q_px,
               Eigen::Matrix<double, 2, 3>* dq_dp, Eigen::Matrix2Xd* dq_dintrinsics = nullptr) const;
  /// Finds the direction of a pixel, of any length; for CAHVOR, CAHVORE and splines only a first guess.
  /// Returns false on failure.
  bool unproject(const std::vector<double>& intrinsics, const Eigen::Vector2d& q_px,
                 Eigen::Vector3d* direction_cam) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace fringetwin
