// SPDX-License-Identifier: Apache-2.0
// What a camera sees of a sphere or plane in the light of the projector: point, fringes and their noise, in
// closed form (docs/metrics/study.md, "Theory of the noise"); internal to study/.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>

#include "twin/twin.hpp"

namespace fringetwin::study {

/// A point of the object as one camera sees it.
struct SurfacePoint {
  using Vector3 = Eigen::Vector3d;
  Vector3 p_mm, n, d;  ///< world frame; n towards the camera, d the ray, both unit
  double range_mm = 0.0;
  double coordinate_px = 0.0;                               ///< of the projector
  Vector3 gradient = Vector3::Zero();                       ///< of the coordinate in space, px/mm
  double variance_px2 = 0.0;                                ///< of the decoded coordinate
  double amplitude_dn = 0.0;                                ///< of the finest fringes
  Vector3 edge_mm[2] = {Vector3::Zero(), Vector3::Zero()};  ///< a pixel's sides on the tangent plane
};

class NoiseScene {
 public:
  /// Throws UserError(usage) naming what the twin has that is not in the theory. The twin must outlive it.
  NoiseScene(const Twin& twin, const std::string& object);

  /// Nothing where the ray of image point `q_px` meets no point of the object with a usable fringe.
  std::optional<SurfacePoint> see(const Camera& camera, const Eigen::Vector2d& q_px) const;

  /// Is the pixel decoded, and none that measurement leaves out at borders (measure/decode/mixed_pixels.hpp)?
  /// One at the outline is taken for three quarters full; where less than half of the next one is on the
  /// object, it is full in truth.
  bool is_used(const Camera& camera, int x, int y) const;
  /// Are all four pixels around the point? What is read there needs them (measure/points/coordinate_map.hpp).
  bool is_readable(const Camera& camera, const Eigen::Vector2d& q_px) const;

  bool is_sphere() const { return std::holds_alternative<SphereShape>(object_.shape); }

 private:
  /// The object, lit or not: point, normal and ray alone.
  std::optional<SurfacePoint> meet(const Camera& camera, const Eigen::Vector2d& q_px) const;
  bool locate(SurfacePoint* s) const;
  bool set_noise(const Camera& camera, SurfacePoint* s) const;
  /// The pixels x ... x + width, y ... y + width: by the corners, as what is lit of a sphere or plane is
  /// convex. False at the image's edge.
  bool sees_all(const Camera& camera, int x, int y, int width) const;

  const Twin& twin_;
  const Object& object_;
  int axis_;  ///< of the projector's coordinate
};

}  // namespace fringetwin::study
