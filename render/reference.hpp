// SPDX-License-Identifier: Apache-2.0
// The double-precision CPU reference of the same physics: the oracle of the tests. Own closed forms
// for analytic shapes; Embree finds mesh candidates, the hit is recomputed in double.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "render/renderer.hpp"

namespace fringetwin::render {

struct PixelSample {
  int object = -1;    ///< -1 = nothing hit
  int triangle = -1;  ///< meshes
  double t_mm = 0.0;  ///< distance along the unit ray
  Eigen::Vector3d point_world_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_world = Eigen::Vector3d::Zero();  ///< faces the viewer
  bool lit = false;     ///< N.L > 0, visible from the projector, inside its image
  double weight = 0.0;  ///< w: irradiance per unit pattern value
  Eigen::Vector2d projector_px = Eigen::Vector2d::Zero();
};

/// Per-pixel truth over an n x n Gauss-Legendre rule (and the lens disk when depth of field is on).
struct ReferencePixel {
  double mean = 0.0, ambient = 0.0;
  std::vector<std::vector<double>> cosine, sine;  ///< [direction][pitch], as in Transport
  std::vector<double> irradiance;                 ///< E per image of the sequence (any response, blur)
  bool interior = false;  ///< all 4x4 Gauss samples hit the same lit object (mesh: same triangle)
  int object = -1;
};

class Reference {
 public:
  explicit Reference(const Twin& twin);
  ~Reference();
  /// One camera ray through continuous pixel q (lens_uv in the unit disk for depth of field).
  PixelSample sample(std::size_t camera, const Eigen::Vector2d& q_px,
                     const Eigen::Vector2d& lens_uv = Eigen::Vector2d::Zero()) const;
  ReferencePixel pixel(std::size_t camera, int x, int y, int gauss_n = 8) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fringetwin::render
