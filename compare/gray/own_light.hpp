// SPDX-License-Identifier: Apache-2.0
// Tells from a pixel's real values what it has of its own beside the light that a twin predicts for it: a
// factor (texture, shading), an offset (room light, scattering), or both.
#pragma once
#include "compare/result/own_kinds.hpp"
namespace fringetwin::compare {

/// What a pixel has of its own: value over black = factor * (light of the twin) + offset_dn.
struct OwnLight {
  double factor = 1.0, offset_dn = 0.0;
};

/// Sums over the values of one pixel, and the line through them by least squares without weights.
class OwnLightSums {
 public:
  /// Takes a value over black and the light that is predicted for it, in any unit; `variance`: of the value's
  /// noise, where variance_of() is to be asked.
  void add(double light, double value_dn, double variance = 0.0) {
    n_ += 1.0, x_ += light, y_ += value_dn, xx_ += light * light, xy_ += value_dn * light;
    v_ += variance, vx_ += variance * light, vxx_ += variance * light * light;
  }

  /// Returns the line; `gain_dn`: of the unit of the light. A factor is at least 0, and 1 where the light
  /// does not tell it; an offset is 0 without values.
  OwnLight line(const OwnKinds& kinds, double gain_dn = 1.0) const;

  /// Returns the variance that the noise of the values gives this line at a predicted light.
  double variance_at(const OwnKinds& kinds, double light) const;

  /// Returns the share of a value's own weight in what the line says at its light (its leverage), which a fit
  /// takes of the square of its residual.
  double leverage_at(const OwnKinds& kinds, double light) const;

 private:
  /// Returns the sum of squares of the light about its mean; 0 where that is none that tells a factor.
  double spread() const;

  double n_ = 0.0, x_ = 0.0, y_ = 0.0, xx_ = 0.0, xy_ = 0.0, v_ = 0.0, vx_ = 0.0, vxx_ = 0.0;
};

}  // namespace fringetwin::compare
