// SPDX-License-Identifier: Apache-2.0
// A closed free-form test part whose true surface is known analytically: a sphere with smooth bumps.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "twin/mesh/mesh.hpp"

namespace fringetwin::testing {

/// Radius factor 1 + height exp(sharpness (n . direction - 1)) added up over all bumps.
struct Bump {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit
  double height = 0.1;                                   ///< relative to the radius; negative = a dent
  double sharpness = 10.0;
};
/// Nine bumps and dents facing all ways, most of them towards -z (the cameras).
std::vector<Bump> default_bumps();

/// The true surface's radius along unit direction n.
double bumpy_radius(double radius_mm, const std::vector<Bump>& bumps, const Eigen::Vector3d& n);

/// Geodesic icosphere, 20 x 4^subdivisions triangles (6: 81,920), outward winding, centred at the
/// origin, every vertex on the true surface (rounded to float).
Mesh make_bumpy_icosphere(int subdivisions, double radius_mm, const std::vector<Bump>& bumps);

}  // namespace fringetwin::testing
