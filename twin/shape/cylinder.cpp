// SPDX-License-Identifier: Apache-2.0
#include "twin/shape/cylinder.hpp"

#include <Eigen/Geometry>

namespace fringetwin {

std::vector<Motion<CylinderShape>> motions(const CylinderShape& cylinder) {
  const Eigen::Vector3d axis = cylinder.axis, u = axis.unitOrthogonal(), v = axis.cross(u);
  std::vector<Motion<CylinderShape>> out;
  int i = 0;
  for (const Eigen::Vector3d& way : {u, v}) {
    out.push_back({std::string("shift_mm.") + "uv"[i], "mm", 0.0,
                   [way](CylinderShape& s, double d) { s.point_mm += d * way; }});
    out.push_back({std::string("tilt_rad.") + "uv"[i], "rad", 0.0,
                   [way](CylinderShape& s, double d) { s.axis += d * way; }});
    ++i;
  }
  return out;
}

std::vector<PlaceKey> place_keys(const CylinderShape& cylinder) {
  const Eigen::Vector3d &p = cylinder.point_mm, &a = cylinder.axis;
  return {{"point_mm", {p.begin(), p.end()}}, {"axis", {a.begin(), a.end()}}};
}

}  // namespace fringetwin
