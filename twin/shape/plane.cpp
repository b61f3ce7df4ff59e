// SPDX-License-Identifier: Apache-2.0
#include "twin/shape/plane.hpp"

#include <Eigen/Geometry>

namespace fringetwin {

std::vector<Motion<PlaneShape>> motions(const PlaneShape& plane) {
  const Eigen::Vector3d normal = plane.normal, u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Motion<PlaneShape>> out;
  out.push_back({"offset_mm", "mm", 0.0, [normal](PlaneShape& s, double d) { s.point_mm += d * normal; }});
  int i = 0;
  for (const Eigen::Vector3d& way : {u, v})
    out.push_back({std::string("tilt_rad.") + "uv"[i++], "rad", 0.0,
                   [way](PlaneShape& s, double d) { s.normal += d * way; }});
  return out;
}

std::vector<PlaceKey> place_keys(const PlaneShape& plane) {
  const Eigen::Vector3d &p = plane.point_mm, &n = plane.normal, &u = plane.u_axis;
  std::vector<PlaceKey> out{{"point_mm", {p.begin(), p.end()}}, {"normal", {n.begin(), n.end()}}};
  if (plane.size_mm) out.push_back({"u_axis", {u.begin(), u.end()}});
  return out;
}

void make_units(PlaneShape& plane) {
  plane.normal.normalize();
  plane.u_axis = (plane.u_axis - plane.u_axis.dot(plane.normal) * plane.normal).normalized();
}

}  // namespace fringetwin
