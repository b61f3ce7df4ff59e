// SPDX-License-Identifier: Apache-2.0
#include "render/reference/reference_scene.hpp"

#include <algorithm>
#include <type_traits>
#include <variant>

#include "render/reference/reference_material.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Surfaces closer to each other than 1e-6 of the way to them count as one (shaders/shapes.glsl).
constexpr double kInFront = 1.0 - 1e-6;

// One visitor of a std::variant out of several lambdas, one per alternative.
template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

}  // namespace

ReferenceScene::ReferenceScene(const Twin& twin, double reach_mm) : twin_(twin) {
  for (const Object& object : twin_.objects) {
    FT_CHECK(!std::holds_alternative<MeasuredShape>(object.shape), "measured shapes must be built first");
    Instance instance;
    if (const auto* m = std::get_if<MeshShape>(&object.shape)) {
      auto& mesh = meshes_[m->mesh.get()];
      if (!mesh)
        mesh = std::make_unique<ReferenceMesh>(m->mesh, reach_mm + m->T_world_object.translation_mm.norm());
      instance = {mesh.get(), m->T_world_object, m->T_world_object.inverse(), m->smooth};
    }
    instances_.push_back(instance);
    order_.push_back(static_cast<int>(order_.size()));
  }
  // The order of the shaders: meshes behind the analytic shapes; what is measured has become a mesh.
  static_assert(std::is_same_v<std::variant_alternative_t<std::variant_size_v<Shape> - 2, Shape>, MeshShape>);
  std::ranges::stable_sort(order_, [this](int a, int b) {
    const auto kind = [this](int i) { return twin_.objects[i].shape.index(); };
    return kind(a) < kind(b);
  });
}

std::optional<SceneHit> ReferenceScene::hit_object(int object, const Ray& ray, double t_min,
                                                   double t_max) const {
  const auto index = static_cast<std::size_t>(object);
  const Instance& instance = instances_[index];
  if (instance.mesh) {
    const auto hit = instance.mesh->nearest(instance.to_object(ray), t_min, t_max);
    if (!hit) return std::nullopt;
    const auto& R = instance.T_world_object.rotation;
    SceneHit out{.t_mm = hit->t_mm,
                 .object = object,
                 .triangle = hit->triangle,
                 .normal = R * instance.mesh->geometric_normal(hit->triangle),
                 .albedo = instance.mesh->albedo(*hit)};
    if (instance.smooth) out.shading = R * instance.mesh->shading_normal(*hit);
    // Vertex normals of both windings may cancel: then the facet's own counts.
    if (!(out.shading.squaredNorm() > 0.0)) out.shading = out.normal;
    return out;
  }
  using Hit = std::optional<ShapeHit>;
  const Hit hit = std::visit(
      Overloaded{[](const MeshShape&) { return Hit(); }, [](const MeasuredShape&) { return Hit(); },
                 [&](const auto& shape) { return intersect(shape, ray, t_min, t_max); }},
      twin_.objects[index].shape);
  if (!hit) return std::nullopt;
  const auto* plane = std::get_if<PlaneShape>(&twin_.objects[index].shape);
  const double albedo = plane ? reference_map_albedo(*plane, ray.origin_mm + hit->t_mm * ray.direction) : 1.0;
  return SceneHit{hit->t_mm, object, -1, hit->normal, hit->normal, albedo};
}

std::optional<SceneHit> ReferenceScene::nearest(const Ray& ray) const {
  std::optional<SceneHit> best;
  for (const int i : order_) {
    const auto hit = hit_object(i, ray, 0.0, best ? kInFront * best->t_mm : kInfinity);
    if (hit) best = hit;
  }
  return best;
}

bool ReferenceScene::in_shadow(const SceneHit& own, bool outside, const Ray& to_light,
                               double distance_mm) const {
  for (int i = 0; i < static_cast<int>(instances_.size()); ++i) {
    if (const ReferenceMesh* mesh = instances_[i].mesh) {
      const int skipped = i == own.object ? own.triangle : -1;
      if (mesh->occluded(instances_[i].to_object(to_light), kShadowStartMm, distance_mm, skipped))
        return true;
      continue;
    }
    const bool can_meet =
        i != own.object ||
        std::visit(
            Overloaded{[](const MeshShape&) { return true; }, [](const MeasuredShape&) { return true; },
                       [&](const auto& shape) { return meets_own_shadow_ray(shape, outside); }},
            twin_.objects[i].shape);
    if (!can_meet) continue;
    if (hit_object(i, to_light, kShadowStartMm, distance_mm)) return true;
  }
  return false;
}

}  // namespace fringetwin::render
