// SPDX-License-Identifier: Apache-2.0
// What a camera sees of a sphere or plane in the light of the projector: point, fringes and their noise, in
// closed form (docs/METRICS.md, "Theory of the noise"); internal to study/.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>

#include "twin/twin.hpp"

namespace fringetwin::study {

/// A point of the object as one camera sees it.
struct SurfacePoint {
  Eigen::Vector3d p_mm, n, d;  ///< world frame; n towards the camera, d the ray, both unit
  double range_mm = 0.0;
  double coordinate_px = 0.0;  ///< of the projector
  Eigen::Vector3d gradient;    ///< of the coordinate in space, px/mm
  double variance_px2 = 0.0;   ///< of the decoded coordinate
  double amplitude_dn = 0.0;   ///< of the finest fringes
  Eigen::Vector3d edge_mm[2];  ///< a pixel's sides on the tangent plane
};

class NoiseScene {
 public:
  /// Throws UserError(usage) naming what the twin has that is not in the theory. The twin must outlive it.
  NoiseScene(const Twin& twin, const std::string& object);

  /// Nothing where the ray of image point `q_px` meets no point of the object with a usable fringe.
  std::optional<SurfacePoint> see(const Camera& camera, const Eigen::Vector2d& q_px) const;

  /// Is the pixel decoded, and none that measurement leaves out at borders (measure/mixed_pixels.hpp)? A
  /// pixel at the object's outline whose centre sees it is three quarters full on average.
  bool is_used(const Camera& camera, int x, int y) const;

  bool is_sphere() const { return std::holds_alternative<SphereShape>(object_.shape); }

 private:
  bool hit(const Eigen::Vector3d& origin_mm, SurfacePoint* s) const;
  bool locate(SurfacePoint* s) const;
  bool set_noise(const Camera& camera, SurfacePoint* s) const;
  bool is_outline(const Camera& camera, const Eigen::Vector2d& q_px) const;

  const Twin& twin_;
  const Object& object_;
  int axis_;  ///< of the projector's coordinate
};

}  // namespace fringetwin::study
