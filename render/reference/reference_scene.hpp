// SPDX-License-Identifier: Apache-2.0
// What rays meet in the scene of a twin, in double precision: the nearest surface, and whether light is
// barred. World frame, mm.
#pragma once
#include <Eigen/Core>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "render/reference/reference_mesh.hpp"
#include "render/reference/reference_shapes.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// A shadow ray starts this far from its surface point: double rounding at 1 m is 1e-13 mm.
inline constexpr double kShadowStartMm = 1e-9;

struct SceneHit {
  double t_mm = std::numeric_limits<double>::infinity();
  int object = -1;
  int triangle = -1;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();   ///< geometric, the shape's own side
  Eigen::Vector3d shading = Eigen::Vector3d::Zero();  ///< the normal of the light formula
  double albedo = 1.0;
};

class ReferenceScene {
 public:
  /// `reach_mm`: of any ray's start from the world origin. Measured shapes must have been built; the twin
  /// must outlive the scene.
  ReferenceScene(const Twin& twin, double reach_mm);
  std::optional<SceneHit> nearest(const Ray& ray) const;
  /// Returns whether anything bars a hit's light on the way to it. `outside`: the lit side is the shape's own
  /// outer side.
  bool in_shadow(const SceneHit& own, bool outside, const Ray& to_light, double distance_mm) const;

 private:
  struct Instance {
    const ReferenceMesh* mesh = nullptr;  ///< nullptr for analytic shapes
    Pose T_world_object, T_object_world;
    bool smooth = false;
    Ray to_object(const Ray& world) const {
      return {T_object_world * world.origin_mm, T_object_world.rotation * world.direction};
    }
  };
  std::optional<SceneHit> hit_object(int object, const Ray& ray, double t_min, double t_max) const;

  const Twin& twin_;
  std::map<const Mesh*, std::unique_ptr<ReferenceMesh>> meshes_;
  std::vector<Instance> instances_;  ///< one per object
  std::vector<int> order_;           ///< of the search: spheres, planes, cylinders, meshes
};

}  // namespace fringetwin::render
