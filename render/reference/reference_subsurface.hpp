// SPDX-License-Identifier: Apache-2.0
// What light that has been below a surface leaves of a pattern (docs/PHYSICS.md, "Subsurface light"), for the
// reference renderer: any pattern along an axis, by its Fourier series.
#pragma once
#include <Eigen/Core>
#include <complex>
#include <functional>
#include <vector>

#include "render/reference/reference_pattern.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// A place of a surface where light comes out that went in around it. Tangential parts by two axes of the
/// tangent plane.
struct BelowSurface {
  double mean_free_path_mm = 0.0;
  double scattered_share = 0.0;                         ///< reference_scattered_share()
  Eigen::Vector2d to_light = Eigen::Vector2d::Zero();   ///< tangential part of the unit vector
  Eigen::Vector2d to_viewer = Eigen::Vector2d::Zero();  ///< the same
  Eigen::Matrix2d px_per_mm = Eigen::Matrix2d::Zero();  ///< projector's x, y by the two axes
};

/// Returns the share of the light that a scattering event leaves, for a half space of isotropic ones that
/// reflects so much of diffuse light: van de Hulst's formula A = (1 - s)(1 - 0.139 s)/(1 + 1.17 s), s^2 = 1 -
/// share, by Newton.
double reference_scattered_share(double albedo);

/// Returns what a pattern exp(i k.q) of the projector's px becomes, relative to itself at the place: sizes
/// below 1, and the angle by which it lies beside.
std::complex<double> reference_kept_below(const BelowSurface& place, const Eigen::Vector2d& k_per_px);

/// A pattern of one axis as its Fourier series.
class PatternSpectrum {
 public:
  /// `value`: of the pattern at px of the axis, with so long a period.
  PatternSpectrum(const std::function<double(double)>& value, double period_px, int samples);
  /// Returns the pattern at px of the axis as light shows it that has been below the surface. `axis`: unit
  /// vector.
  double value(double at_px, const Eigen::Vector2d& axis, const BelowSurface& place) const;

 private:
  double period_px_;
  std::vector<std::complex<double>> terms_;  ///< of exp(2 pi i h x/period), from h = 0
};

/// Returns the spectra of the patterns of a twin's sequence, which must be the same all over the projector's
/// image. A code repeats beyond its last word.
std::vector<PatternSpectrum> pattern_spectra(const Twin& twin, const std::vector<ReferencePattern>& patterns);

}  // namespace fringetwin::render
