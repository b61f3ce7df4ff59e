// SPDX-License-Identifier: Apache-2.0
// Draws how a real sphere deviates from an ideal one: the rms and the range of degrees go in, a random sum of
// spherical harmonics comes out, and from it the mesh that the renderer traces.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "twin/mesh/mesh.hpp"

namespace fringetwin::study {

/// States the rms and the degrees of the harmonics of a form deviation. Degree 0 changes the radius and
/// degree 1 moves the sphere: neither is a deviation of form.
struct FormSpread {
  static constexpr int kLeastDegree = 2, kMostDegree = 40;
  double rms_mm = 0.0;     ///< expected rms of the deviation over the sphere
  int low = 2, high = 12;  ///< lowest and highest degree
};

/// h(n) = sum of c_lm Y_lm(n), l <= degree, with real orthonormal spherical harmonics: the deviation outward
/// in mm.
class SphereForm {
 public:
  /// Takes the (degree + 1)^2 coefficients, c_lm at index l^2 + l + m; those with m < 0 belong to the sines.
  SphereForm(int degree, std::vector<double> coefficients);

  /// Returns a form whose coefficients are drawn from normal distributions, such that each degree is expected
  /// to hold the same part of rms^2. A seed gives the same c_lm, up to their common scale, whichever degrees
  /// are asked for.
  static SphereForm draw(const FormSpread& spread, std::uint64_t seed);

  /// Returns h(n) for a unit vector n.
  double at(const Eigen::Vector3d& n) const;

 private:
  int degree_;
  std::vector<double> c_;
  std::vector<double> a_, b_;  ///< of the recurrence over l, at l^2 + l + m, m >= 0
};

/// Returns the rms distance, mm, between the flat facets of form_mesh() and the smooth surface that they
/// approximate. The number of facets is chosen so that this is small against the form's rms, up to the number
/// that can be traced quickly.
double facet_error_mm(double radius_mm, const FormSpread& spread);

/// Returns the sphere with this deviation, centred at the origin, as a mesh with vertex normals for smooth
/// shading. The vertices lie outside the surface by as much as flat facets lie inside it on average, so that
/// the mesh has no bias in its radius.
std::shared_ptr<const Mesh> form_mesh(double radius_mm, const FormSpread& spread, const SphereForm& form);

}  // namespace fringetwin::study
