// SPDX-License-Identifier: Apache-2.0
// Tabulates lenses once on the CPU in double precision, on a coarse grid that the shaders interpolate.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "render/base/split_float.hpp"
#include "twin/lens/lens.hpp"

namespace fringetwin::render {

/// The camera's lens from pixel to ray: residual (x/z, y/z) - (q - c)/f for perspective lenses, the unit
/// direction for others.
struct LensTable {
  int kind = CAMERA_PINHOLE;
  Double4 camera{};  ///< 1/fx, 1/fy, cx, cy
  gpu::vec4 grid;    ///< as Params::lens_grid
  gpu::uvec4 grid_n;
  std::vector<gpu::vec4> nodes;
  /// Largest error of the interpolated ray at the cells' centres and edges, camera px.
  double max_error_px = 0.0;
  double spacing_px = 0.0;
  /// Per block of pixels: unit direction of its centre and the angle to its farthest corner.
  std::vector<Eigen::Vector4d> block_cones;
  int blocks_x = 0, blocks_y = 0;
};
/// Tabulates a camera's lens. Throws UserError(usage) for a lens so rough that a grid of 1 px leaves more
/// than 0.01 px of error, and warns above 1e-4 px.
LensTable make_lens_table(const Lens& lens);

/// Keeps the tables of cameras' lenses, so that each lens is inverted once.
class LensTableStore {
 public:
  /// Finds the table of an equal lens or makes it; the reference stays valid as long as the store lives.
  const LensTable& get(const Lens& lens);

 private:
  std::vector<std::pair<Lens, std::unique_ptr<LensTable>>> tables_;
};

/// The projector's lens from ray to pixel, for lenses without a closed form in the shader:
/// pixel = f (x/z, y/z) + residual on a grid over (x/z, y/z).
struct ProjectorTable {
  double fx = 1.0, fy = 1.0, cx = 0.0, cy = 0.0;
  gpu::vec4 grid;
  gpu::uvec4 grid_n;
  std::vector<gpu::vec4> nodes;
  double max_error_px = 0.0;
};
/// Tabulates a projector's lens. Throws and warns as make_lens_table(), and throws UserError(usage) for a
/// lens that sees half the sphere or more.
ProjectorTable make_projector_table(const Lens& lens);

}  // namespace fringetwin::render
