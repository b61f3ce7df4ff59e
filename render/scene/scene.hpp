// SPDX-License-Identifier: Apache-2.0
// A twin's objects, seen from one camera: transformed in double into the CAMERA frame, then packed
// for the shaders (shaders/shared.h).
#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "render/base/split_float.hpp"
#include "render/scene/bvh.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

struct BoundingSphere {
  Eigen::Vector3d center_mm;  ///< camera frame
  double radius_mm;
};

/// A mesh ready for tracing: BVH and triangles in leaf order, relative to `center_mm` (object frame).
struct MeshGeometry {
  std::shared_ptr<const Mesh> mesh;
  Eigen::Vector3d center_mm;
  Bvh bvh;
  std::vector<gpu::vec4> triangles;         ///< 3 vertices each; w: the unit normal's x, y, z
  std::vector<gpu::vec4> corners;           ///< 3 x (normal, albedo) each
  std::vector<Eigen::Vector3f> vertices;    ///< relative to center_mm
  std::vector<std::array<int, 3>> indices;  ///< of the triangles' vertices, in leaf order
  std::vector<Eigen::Vector4f> covering;    ///< a few spheres (centre, radius) that cover it, for culling
};

/// Leaves out triangles without area. Throws UserError(input), naming `name`, when none is left or a
/// coordinate is not finite.
MeshGeometry build_mesh_geometry(std::shared_ptr<const Mesh> mesh, const std::string& name);

/// Generalised winding number of the mesh's surface around a point (object frame): 1 inside a closed
/// mesh, 0 outside, in between for an open one. Van Oosterom and Strackee's solid angles.
double winding_number(const Mesh& mesh, const Eigen::Vector3d& point_mm);

struct PackedScene {
  std::vector<std::array<Double4, 4>> primitives;
  std::vector<gpu::vec4> materials;
  std::vector<int> object_of_primitive;
  std::vector<std::size_t> triangles_of_primitive;  ///< 1 for analytic shapes
  std::size_t n_surfaces = 0;                       ///< all of them together
  int n_spheres = 0, n_planes = 0, n_cylinders = 0, n_meshes = 0;
  int specular = 0;         ///< SPECULAR_PHONG | SPECULAR_GGX: the lobes that occur
  bool bounded = false;     ///< a plane or cylinder with an end
  bool corners = false;     ///< a mesh with vertex normals or albedo
  std::vector<float> maps;  ///< albedo maps, each behind its width and height; empty without any
  bool one_convex = false;  ///< one convex object alone: it hides no light from itself and gives itself none
  bool shadow = true;       ///< false for that, or when the twin says so
  bool unbounded = false;   ///< something reaches to infinity: every block of pixels may see it
  std::vector<BoundingSphere> finite;
  std::size_t first_mesh_bound = 0;  ///< in `finite`
  /// Farthest bounded geometry or visible point (a shadow ray's origin), for rounding allowances; at most
  /// farthest_allowed_mm, as planes reach the horizon.
  double far_mm = 0.0;
  double z_min_mm = 0.0, z_max_mm = 0.0;    ///< depth range of what may be in view (visible_range.hpp)
  std::vector<const MeshGeometry*> meshes;  ///< distinct, in buffer order
  struct MeshInstance {
    const MeshGeometry* geometry;
    Pose T_object_cam;  ///< object frame relative to the geometry's centre
  };
  std::vector<MeshInstance> instances;
};

constexpr double farthest_allowed_mm = 1e5;

/// Finds (or builds) the geometry of a mesh.
class MeshStore {
 public:
  const MeshGeometry& get(const std::shared_ptr<const Mesh>& mesh, const std::string& name);

 private:
  std::vector<std::unique_ptr<MeshGeometry>> meshes_;
};

/// Throws UserError(usage) when the camera is inside an object, a mesh is not loaded, or
/// a measured shape was not replaced.
PackedScene pack_scene(const Twin& twin, const Camera& camera, MeshStore& store);

/// Radius of the thin lens, 0 without depth of field.
double lens_radius_mm(const Camera& camera);

}  // namespace fringetwin::render
