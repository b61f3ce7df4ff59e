// SPDX-License-Identifier: Apache-2.0
// The side of a cylinder in the world frame.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

#include "twin/shape/motion.hpp"

namespace fringetwin {

/// Open (no caps), infinite unless length_mm is given: then centred at point_mm.
struct CylinderShape {
  static constexpr const char* kKind = "cylinder";
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  ///< unit
  double radius_mm = 0.0;
  std::optional<double> length_mm;
};

/// Returns the shifts across its axis and the tilts of the axis about its point.
std::vector<Motion<CylinderShape>> motions(const CylinderShape& cylinder);
std::vector<PlaceKey> place_keys(const CylinderShape& cylinder);
inline void make_units(CylinderShape& cylinder) { cylinder.axis.normalize(); }
inline std::optional<Eigen::Vector3d> place_mm(const CylinderShape& cylinder) { return cylinder.point_mm; }
inline bool shades_itself(const CylinderShape& cylinder) {
  return cylinder.length_mm.has_value();
}  // one sees in
inline std::vector<std::filesystem::path> shape_files(const CylinderShape&) { return {}; }

}  // namespace fringetwin
