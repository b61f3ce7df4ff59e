// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/seen_image.hpp"

#include <algorithm>
#include <cmath>

namespace fringetwin::render {

bool on_one_surface(const SurfacePlace& a, const SurfacePlace& b, const SurfaceLimits& limits) {
  if (a.n.dot(b.n) < limits.least_cosine) return false;
  if (limits.of_one_primitive && a.primitive != b.primitive) return false;
  const Eigen::Vector3f way = b.p_mm - a.p_mm;
  const float out = std::max(std::abs(way.dot(a.n)), std::abs(way.dot(b.n)));
  return out <= limits.most_out_of_plane * way.norm();
}

}  // namespace fringetwin::render
