// SPDX-License-Identifier: Apache-2.0
// Holds a twin's objects as one camera's trace needs them: in the camera's frame, in the layouts that the
// shaders read (shaders/shared.h), with bounds and switches that the host derives from them.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "render/base/split_float.hpp"
#include "render/scene/mesh_geometry.hpp"
#include "twin/lens/pose.hpp"

namespace fringetwin::render {

struct BoundingSphere {
  Eigen::Vector3d center_mm;  ///< camera frame
  double radius_mm;
  bool tells_depth = true;  ///< false: visible_range.cpp knows more of the shape's depths than this
};

/// All primitives of a kind follow one another (PrimitiveKind): the shaders know a primitive's kind by its
/// index.
struct PackedScene {
  std::vector<std::array<Double4, 4>> primitives;   ///< layouts: shaders/shapes.glsl, shaders/mesh.glsl
  std::vector<gpu::vec4> materials;                 ///< per primitive, BIND_MATERIALS
  std::vector<gpu::vec4> below_surfaces;            ///< per primitive, behind them where any lets light in
  std::vector<int> object_of_primitive;             ///< index in Twin::objects
  std::vector<std::size_t> triangles_of_primitive;  ///< 1 for analytic shapes
  std::size_t n_surfaces = 0;                       ///< all of them together
  std::array<int, KIND_COUNT> count{};              ///< primitives of each kind
  int specular = 0;                                 ///< SPECULAR_PHONG | SPECULAR_GGX: the lobes that occur
  bool bounded = false;                             ///< a plane or cylinder with an end
  bool corners = false;                             ///< a mesh with vertex normals or albedo
  std::vector<float> maps;  ///< albedo maps, each behind its width and height; empty without any
  bool one_convex = false;  ///< one convex object alone: it hides no light from itself and gives itself none
  bool shadow = true;       ///< false for that, or when the twin says so
  bool unbounded = false;   ///< something reaches to infinity: every block of pixels may see it
  std::vector<BoundingSphere> finite;  ///< around all bounded shapes; several around a mesh
  /// Farthest bounded geometry or visible point (a shadow ray's origin), for rounding allowances; at most
  /// kFarthestAllowedMm, as planes reach the horizon.
  double far_mm = 0.0;
  double z_min_mm = 0.0, z_max_mm = 0.0;    ///< depth range of what may be in view (visible_range.hpp)
  std::vector<const MeshGeometry*> meshes;  ///< distinct, in buffer order
  struct MeshInstance {
    const MeshGeometry* geometry;
    Pose T_object_cam;  ///< object frame relative to the geometry's centre
  };
  std::vector<MeshInstance> instances;

  /// Returns the primitives of one kind.
  std::span<const std::array<Double4, 4>> of_kind(PrimitiveKind kind) const {
    const auto first = std::accumulate(count.begin(), count.begin() + kind, 0);
    return {primitives.begin() + first, static_cast<std::size_t>(count[kind])};
  }
};

/// The largest PackedScene::far_mm.
constexpr double kFarthestAllowedMm = 1e5;

}  // namespace fringetwin::render
