// SPDX-License-Identifier: Apache-2.0
// A lens model projects points to pixels and back, with mrcal's names and parameter order
// (docs/CONVENTIONS.md). Pixel (0,0) is the centre of the top-left pixel.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fringetwin {

/// A projection model with known domain of invertibility. Immutable and cheap to copy.
/// PINHOLE and OPENCV4/5/8/12 use our own closed forms (proven equal to libmrcal in the tests);
/// all other mrcal models (STEREOGRAPHIC, LONLAT, LATLON, CAHVOR, CAHVORE, SPLINED_STEREOGRAPHIC) call
/// libmrcal.
class Lens {
 public:
  /// Throws UserError(usage) for an unknown model name, a wrong number of intrinsics, non-finite
  /// values, non-positive focal length or imager size, and for a model whose image corners leave
  /// the domain of invertibility (`where` names the file or key in the message).
  Lens(const std::string& model, const std::vector<double>& intrinsics, const Eigen::Vector2i& imagersize_px,
       const std::string& where);

  const std::string& model() const;
  const std::vector<double>& intrinsics() const;
  int width() const;
  int height() const;

  /// Returns true for PINHOLE and OPENCV4/5/8/12: q = f * distort(x/z, y/z) + c.
  bool is_perspective() const;
  /// Returns the distortion in OpenCV order k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4, zero-padded; perspective
  /// only.
  const Eigen::Matrix<double, 12, 1>& opencv_distortion() const;
  /// Returns the square of the largest undistorted radius |(x/z, y/z)| up to which the distortion map is
  /// monotone (invertible), shrunk by a hair; +inf where there is no limit. Perspective only.
  double max_invertible_radius_sq() const;

  /// Returns the pixel of a point p_cam in any unit; nullopt behind the camera or outside the domain of
  /// invertibility. The result may lie outside the imager. Writes d q / d p_cam (px per unit of p_cam) unless
  /// dq_dp is null.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_cam,
                                         Eigen::Matrix<double, 2, 3>* dq_dp = nullptr) const;
  /// Returns the UNIT direction of a pixel in the camera frame, the inverse of project() to < 1e-9 px
  /// (Newton); nullopt where the pixel has no pre-image.
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& q_px) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace fringetwin
