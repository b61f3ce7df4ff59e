// SPDX-License-Identifier: Apache-2.0
// A sphere in the world frame.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "twin/shape/motion.hpp"

namespace fringetwin {

struct SphereShape {
  static constexpr const char* kKind = "sphere";
  static constexpr bool kHasFiles = false, kLightsItself = false;
  Eigen::Vector3d center_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;
};

/// Returns the three shifts of its centre.
inline std::vector<Motion<SphereShape>> motions(const SphereShape& sphere) {
  std::vector<Motion<SphereShape>> out;
  for (int i = 0; i < 3; ++i)
    out.push_back({std::string("center_mm.") + "xyz"[i], "mm", sphere.center_mm[i],
                   [i](SphereShape& s, double d) { s.center_mm[i] += d; }});
  return out;
}

inline std::vector<PlaceKey> place_keys(const SphereShape& sphere) {
  const Eigen::Vector3d& c = sphere.center_mm;
  return {{"center_mm", {c.begin(), c.end()}}};
}

inline void make_units(SphereShape&) {}
inline std::optional<Eigen::Vector3d> place_mm(const SphereShape& sphere) { return sphere.center_mm; }
inline bool shades_itself(const SphereShape&) { return false; }

}  // namespace fringetwin
