// SPDX-License-Identifier: Apache-2.0
// A plane or a rectangle in the world frame, with an image of its reflectivity if it has one.
#pragma once
#include <Eigen/Core>
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
std::vector<Motion<PlaneShape>> motions(const PlaneShape& plane);
std::vector<PlaceKey> place_keys(const PlaneShape& plane);
void make_units(PlaneShape& plane);
inline std::optional<Eigen::Vector3d> place_mm(const PlaneShape& plane) { return plane.point_mm; }
inline bool shades_itself(const PlaneShape&) { return false; }
inline std::vector<std::filesystem::path> shape_files(const PlaneShape& plane) { return {plane.albedo_file}; }

}  // namespace fringetwin
