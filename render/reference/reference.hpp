// SPDX-License-Identifier: Apache-2.0
// The double-precision CPU reference of the same physics: the oracle of the tests. Own closed forms
// for analytic shapes; Embree only finds mesh candidates, every hit is computed in double.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "render/reference/reference_subsurface.hpp"
#include "twin/base/not_copyable.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Light that reaches a sample over another surface, or from below a surface.
struct IndirectLight {
  double weight = 0.0;
  Eigen::Vector2d projector_px, defocus_px;
  std::optional<BelowSurface> below = {};  ///< light that has been below the surface that it is seen on
};

struct PixelSample {
  int object = -1;    ///< -1 = nothing hit
  int triangle = -1;  ///< meshes
  double t_mm = 0.0;  ///< distance along the unit ray
  Eigen::Vector3d point_world_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_world = Eigen::Vector3d::Zero();  ///< geometric, faces the viewer
  bool lit = false;     ///< N.L > 0, visible from the projector, inside its image
  double weight = 0.0;  ///< w: irradiance per unit pattern value
  double lamp = 0.0;    ///< irradiance by the room's lamp
  Eigen::Vector2d projector_px = Eigen::Vector2d::Zero();  ///< where lit
  Eigen::Vector2d defocus_px = Eigen::Vector2d::Zero();    ///< circle of confusion, radius per axis
  std::vector<IndirectLight> indirect = {};  ///< with bounces or mean free paths, in pixel() only
};

/// n x n Gauss-Legendre nodes over the pixel's square; with depth of field also lens_rings x
/// lens_spokes nodes over the lens disk (Gauss in r^2, equal angles).
struct ReferenceQuadrature {
  int gauss_n = 8;
  int lens_rings = 4;
  int lens_spokes = 12;
  int bounce_n = 16;  ///< with bounces: n x 2n directions over the hemisphere (Gauss in sin^2, equal angles)
  int paths = 1;      ///< with more than one bounce: paths at random from what each direction meets
  /// Glossy bounces leave surfaces in the middle of a path by their lobes, too, which the renderer does not
  /// have.
  bool middle_lobes = false;
};

/// Per-pixel truth over a quadrature rule.
struct ReferencePixel {
  double mean = 0.0, ambient = 0.0;
  std::vector<std::vector<double>> cosine = {}, sine = {};  ///< [direction][pitch], as in Transport
  std::vector<double> irradiance = {};  ///< E per image of the sequence (any response, blur)
  bool interior = false;  ///< all 4x4 Gauss samples hit the same lit object (mesh: same triangle)
  int object = -1;        ///< at the pixel centre
};

class Reference : NotCopyable {
 public:
  /// Meshes must be loaded and MeasuredShapes replaced; keeps a copy of the twin.
  explicit Reference(const Twin& twin);
  ~Reference();

  const Twin& twin() const;
  /// One camera ray through continuous pixel q (lens_uv in the unit disk for depth of field).
  PixelSample sample(std::size_t camera, const Eigen::Vector2d& q_px,
                     const Eigen::Vector2d& lens_uv = Eigen::Vector2d::Zero()) const;
  /// Thread-safe.
  ReferencePixel pixel(std::size_t camera, int x, int y, const ReferenceQuadrature& quadrature = {}) const;
  /// The 4x4 test alone, without erosion (with depth of field also from eight points of the lens rim).
  bool is_whole(std::size_t camera, int x, int y) const;

 private:
  /// pixel() before the texture of the camera's pixels.
  ReferencePixel without_texture(std::size_t camera, int x, int y,
                                 const ReferenceQuadrature& quadrature) const;
  /// Adds to each irradiance the light that a texture which changes within the pixel takes from its brighter
  /// or darker side: spread^2 (factor_x E_x + factor_y E_y), slopes by the neighbours' pixels; none falls
  /// below 0 by it.
  void add_within_pixel(const Camera& camera, std::size_t index, int x, int y,
                        const ReferenceQuadrature& quadrature, std::vector<double>& irradiance) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fringetwin::render
