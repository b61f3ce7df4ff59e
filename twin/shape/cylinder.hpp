// SPDX-License-Identifier: Apache-2.0
// The side of a cylinder in the world frame.
#pragma once
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "twin/shape/motion.hpp"

namespace fringetwin {

/// Open (no caps), infinite unless length_mm is given: then centred at point_mm.
struct CylinderShape {
  static constexpr const char* kKind = "cylinder";
  static constexpr bool kHasFiles = false, kLightsItself = false;
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  ///< unit
  double radius_mm = 0.0;
  std::optional<double> length_mm;
};

/// Returns the shifts across its axis and the tilts of the axis about its point.
inline std::vector<Motion<CylinderShape>> motions(const CylinderShape& cylinder) {
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

inline std::vector<PlaceKey> place_keys(const CylinderShape& cylinder) {
  const Eigen::Vector3d &p = cylinder.point_mm, &a = cylinder.axis;
  return {{"point_mm", {p.begin(), p.end()}}, {"axis", {a.begin(), a.end()}}};
}

inline void make_units(CylinderShape& cylinder) { cylinder.axis.normalize(); }
inline std::optional<Eigen::Vector3d> place_mm(const CylinderShape& cylinder) { return cylinder.point_mm; }
inline bool shades_itself(const CylinderShape& cylinder) {
  return cylinder.length_mm.has_value();
}  // one sees in

}  // namespace fringetwin
