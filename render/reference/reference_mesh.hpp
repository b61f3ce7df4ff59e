// SPDX-License-Identifier: Apache-2.0
// Ray against triangle mesh in double precision. Embree's BVH (built over padded float boxes) only
// proposes triangles; every test is ours, in double, so nothing of float precision is left in a hit.
#pragma once
#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>

#include "render/reference/reference_shapes.hpp"
#include "twin/base/not_copyable.hpp"
#include "twin/mesh/mesh.hpp"

namespace fringetwin::render {

struct MeshHit {
  double t_mm = 0.0;
  int triangle = -1;
  double u = 0.0, v = 0.0;  ///< barycentric weights of the triangle's second and third vertex
};

/// One mesh in its own frame; instances transform their rays into it. Thread-safe.
class ReferenceMesh : NotCopyable {
 public:
  /// `reach_mm`: how far rays start from the mesh at most; sets the padding of the boxes.
  ReferenceMesh(std::shared_ptr<const Mesh> mesh, double reach_mm);
  ~ReferenceMesh();

  const Mesh& mesh() const;
  /// The nearest hit with t_min < t < t_max; the lower index wins on a shared edge.
  std::optional<MeshHit> nearest(const Ray& ray, double t_min, double t_max) const;
  /// The same by testing every triangle.
  std::optional<MeshHit> nearest_brute_force(const Ray& ray, double t_min, double t_max) const;
  bool occluded(const Ray& ray, double t_min, double t_max, int skipped_triangle) const;

  Eigen::Vector3d geometric_normal(int triangle) const;      ///< unit, by winding
  Eigen::Vector3d shading_normal(const MeshHit& hit) const;  ///< unit, interpolated; 0 where normals cancel
  double albedo(const MeshHit& hit) const;                   ///< 1 without vertex_albedo

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fringetwin::render
