// SPDX-License-Identifier: Apache-2.0
// The deviation of a real sphere from its form: random spherical harmonics, and the sphere with them as a
// mesh that can be traced.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "twin/mesh/mesh.hpp"

namespace fringetwin::study {

/// Degrees and size of a deviation. Degree 0 is the radius, 1 the place: neither is form.
struct FormSpread {
  static constexpr int kLeastDegree = 2, kMostDegree = 40;
  double rms_mm = 0.0;  ///< over the sphere, in expectation
  int low = 2, high = 12;
};

/// h(n) = sum of c_lm Y_lm(n), l <= degree, with real orthonormal spherical harmonics: the deviation outward
/// in mm.
class SphereForm {
 public:
  /// `coefficients`: (degree + 1)^2, c_lm at l^2 + l + m; m < 0: sines.
  SphereForm(int degree, std::vector<double> coefficients);

  /// Returns a form with normal coefficients; each degree has the same part of rms^2 in expectation. The same
  /// seed gives the same c_lm but for their size, whichever degrees are asked for.
  static SphereForm draw(const FormSpread& spread, std::uint64_t seed);

  /// Returns h(n) for a unit vector n.
  double at(const Eigen::Vector3d& n) const;

 private:
  int degree_;
  std::vector<double> c_;
  std::vector<double> a_, b_;  ///< of the recurrence over l, at l^2 + l + m, m >= 0
};

/// Returns how far, rms, the facets of a form_mesh lie from the surface they stand for (about 0 on average):
/// what the form asks for, within what can be traced quickly.
double facet_error_mm(double radius_mm, const FormSpread& spread);

/// Returns the sphere with this deviation about the origin, for smooth shading. Its vertices stand as far
/// outside as its facets lie inside on average.
std::shared_ptr<const Mesh> form_mesh(double radius_mm, const FormSpread& spread, const SphereForm& form);

}  // namespace fringetwin::study
