// SPDX-License-Identifier: Apache-2.0
// A sphere in the world frame.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

#include "twin/shape/motion.hpp"

namespace fringetwin {

struct SphereShape {
  static constexpr const char* kKind = "sphere";
  Eigen::Vector3d center_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;
};

/// Returns the three shifts of its centre.
std::vector<Motion<SphereShape>> motions(const SphereShape& sphere);
std::vector<PlaceKey> place_keys(const SphereShape& sphere);
inline void make_units(SphereShape&) {}
inline std::optional<Eigen::Vector3d> place_mm(const SphereShape& sphere) { return sphere.center_mm; }
inline bool shades_itself(const SphereShape&) { return false; }
inline std::vector<std::filesystem::path> shape_files(const SphereShape&) { return {}; }

}  // namespace fringetwin
