// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "render/reference/reference_shapes.hpp"

namespace fringetwin::render {

// Haines, Günther, Akenine-Möller, "Precision improvements for ray/sphere intersection", Ray Tracing
// Gems (2019), ch. 7: the discriminant from the closest point, not from a difference of squares.
std::optional<ShapeHit> intersect(const SphereShape& sphere, const Ray& ray, double t_min, double t_max) {
  const Eigen::Vector3d from_center = ray.origin_mm - sphere.center_mm;
  const double along = -from_center.dot(ray.direction);
  const Eigen::Vector3d closest = from_center + along * ray.direction;
  const double h2 = sphere.radius_mm * sphere.radius_mm - closest.squaredNorm();
  if (h2 < 0.0) return std::nullopt;
  const double h = std::sqrt(h2);
  for (double t : {along - h, along + h})
    if (t > t_min && t < t_max)
      return ShapeHit{t, ((from_center + t * ray.direction) / sphere.radius_mm).normalized()};
  return std::nullopt;
}

bool meets_own_shadow_ray(const SphereShape&, bool lit_outside) { return !lit_outside; }

}  // namespace fringetwin::render
