// SPDX-License-Identifier: Apache-2.0
// A plane or a rectangle in the world frame, with an image of its reflectivity if it has one.
#pragma once
#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "twin/image/image.hpp"
#include "twin/shape/motion.hpp"

namespace fringetwin {

/// Infinite unless size_mm is given: then a rectangle size_mm[0] x size_mm[1] centred at point_mm,
/// first side along u_axis (made orthogonal to the normal).
struct PlaneShape {
  static constexpr const char* kKind = "plane";
  static constexpr bool kHasFiles = true, kLightsItself = false;
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit
  std::optional<Eigen::Vector2d> size_mm;
  Eigen::Vector3d u_axis = Eigen::Vector3d::UnitX();  ///< unit, orthogonal to normal
  /// Factors of the diffuse reflectivity over the rectangle: columns along u_axis, rows along
  /// normal x u_axis, from the corner at -u, -v.
  std::filesystem::path albedo_file = {};
  std::shared_ptr<const ImageF> albedo_map = nullptr;  ///< 0...1; filled by load_meshes()
};

/// Returns the shift along its normal and the tilts about its point.
inline std::vector<Motion<PlaneShape>> motions(const PlaneShape& plane) {
  const Eigen::Vector3d normal = plane.normal, u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Motion<PlaneShape>> out;
  out.push_back({"offset_mm", "mm", 0.0, [normal](PlaneShape& s, double d) { s.point_mm += d * normal; }});
  int i = 0;
  for (const Eigen::Vector3d& way : {u, v})
    out.push_back({std::string("tilt_rad.") + "uv"[i++], "rad", 0.0,
                   [way](PlaneShape& s, double d) { s.normal += d * way; }});
  return out;
}

inline std::vector<PlaceKey> place_keys(const PlaneShape& plane) {
  const Eigen::Vector3d &p = plane.point_mm, &n = plane.normal, &u = plane.u_axis;
  std::vector<PlaceKey> out{{"point_mm", {p.begin(), p.end()}}, {"normal", {n.begin(), n.end()}}};
  if (plane.size_mm) out.push_back({"u_axis", {u.begin(), u.end()}});
  return out;
}

inline void make_units(PlaneShape& plane) {
  plane.normal.normalize();
  plane.u_axis = (plane.u_axis - plane.u_axis.dot(plane.normal) * plane.normal).normalized();
}

inline std::optional<Eigen::Vector3d> place_mm(const PlaneShape& plane) { return plane.point_mm; }
inline bool shades_itself(const PlaneShape&) { return false; }
inline std::vector<std::filesystem::path> shape_files(const PlaneShape& plane) { return {plane.albedo_file}; }
inline bool has_albedo(const PlaneShape& plane) { return plane.albedo_map != nullptr; }
inline void remove_albedo(PlaneShape& plane) {
  plane.albedo_map = nullptr;
  plane.albedo_file.clear();
}

}  // namespace fringetwin
