// SPDX-License-Identifier: Apache-2.0
#include "render/scene/pack_scene.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <variant>

#include "render/scene/visible_range.hpp"
#include "twin/base/errors.hpp"
#include "twin/mesh/most_triangles.hpp"

namespace fringetwin::render {
namespace {

using Eigen::Vector3d;

Double4 pack(const Vector3d& v, double w) { return {v.x(), v.y(), v.z(), w}; }

// The winding number is 1 inside a closed mesh, a little less with small holes; inside an open bowl one may
// look around.
constexpr double kClosedWinding = 0.9;

[[noreturn]] void camera_inside(const Camera& camera, const Object& object) {
  throw UserError(ExitCode::usage, fmt::format("camera \"{}\"", camera.name),
                  fmt::format("it is inside the {} \"{}\"", shape_kind(object.shape), object.name),
                  "check rt_cam_world, the object's place and their units");
}

// Packs the objects of one shape after the other, in the order of the Shape variant: the shaders know a
// primitive's kind by its index (shaders/shared.h). A shape without an add() does not compile. One that is of
// no kind that is there needs a line in ANALYTIC_KINDS; where it reaches to infinity, visible_range.cpp has
// to know its depths.
class Packer {
 public:
  Packer(const Camera& camera, MeshStore& store)
      : camera_(camera),
        store_(store),
        T_cam_world_(camera.T_cam_world),
        lens_mm_(lens_radius_mm(camera.optics)) {}

  void add(const SphereShape& s, const Object& object) {
    const Vector3d c = T_cam_world_ * s.center_mm;
    if (c.norm() <= s.radius_mm + lens_mm_) camera_inside(camera_, object);
    const double c2 = (c.norm() - s.radius_mm) * (c.norm() + s.radius_mm);
    push(KIND_SPHERES, {pack(c, s.radius_mm), {c2}, {}, {}});
    scene.finite.push_back({c, s.radius_mm});
  }

  void add(const PlaneShape& s, const Object& object) {
    const Vector3d n = T_cam_world_.rotation * s.normal.normalized(), p = T_cam_world_ * s.point_mm;
    const Vector3d along = T_cam_world_.rotation * s.u_axis;
    const Vector3d u = (along - along.dot(n) * n).normalized(), v = n.cross(u);
    constexpr double kInfinite = std::numeric_limits<float>::max();
    const double half_u = s.size_mm ? 0.5 * s.size_mm->x() : kInfinite;
    const double half_v = s.size_mm ? 0.5 * s.size_mm->y() : kInfinite;
    push(KIND_PLANES, {pack(n, n.dot(p)), pack(u, half_u), pack(v, half_v), pack(p, add_map(s, object))});
    end(s.size_mm.has_value(), {p, s.size_mm ? 0.5 * s.size_mm->norm() : 0.0, false});
  }

  void add(const CylinderShape& s, const Object& object) {
    const Vector3d axis = (T_cam_world_.rotation * s.axis).normalized(), p = T_cam_world_ * s.point_mm;
    const double center = p.dot(axis);
    const Vector3d foot = p - center * axis;
    constexpr double kInfinite = std::numeric_limits<float>::max();
    const double half = s.length_mm ? 0.5 * *s.length_mm : kInfinite;
    if (foot.norm() <= s.radius_mm + lens_mm_ && std::abs(center) <= half + lens_mm_)
      camera_inside(camera_, object);
    const double c2 = (foot.norm() - s.radius_mm) * (foot.norm() + s.radius_mm);
    push(KIND_CYLINDERS, {pack(foot, s.radius_mm), pack(axis, half), {center, c2}, {}});
    end(s.length_mm.has_value(), {p, std::hypot(half, s.radius_mm), false});
  }

  void add(const MeshShape& s, const Object& object) {
    if (!s.mesh)
      throw UserError(ExitCode::usage, fmt::format("object \"{}\"", object.name), "its mesh is not loaded");
    if (s.mesh->triangles.empty())
      throw UserError(ExitCode::input, s.file.string(),
                      fmt::format("the mesh of \"{}\" has no triangle", object.name));
    const MeshGeometry& g =
        store_.get(s.mesh, s.file.empty() ? fmt::format("object \"{}\"", object.name) : s.file.string());
    const Pose T_cam_object = T_cam_world_ * s.T_world_object;
    const Pose T_object_cam = T_cam_object.inverse();
    // Shift to the mesh's centre: small coordinates, small rounding errors.
    const Vector3d eye = T_object_cam.translation_mm - g.center_mm;
    const Vector3d lo = g.bvh.box_min.cast<double>().array() - lens_mm_;
    const Vector3d hi = g.bvh.box_max.cast<double>().array() + lens_mm_;
    if ((eye.array() >= lo.array()).all() && (eye.array() <= hi.array()).all() &&
        std::abs(winding_number(*s.mesh, T_object_cam.translation_mm)) > kClosedWinding)
      camera_inside(camera_, object);

    std::size_t first_node = 0, first_triangle = 0, which = 0;
    for (; which < scene.meshes.size() && scene.meshes[which] != &g; ++which) {
      first_node += scene.meshes[which]->bvh.nodes.size();
      first_triangle += scene.meshes[which]->bvh.order.size();
    }
    if (which == scene.meshes.size()) scene.meshes.push_back(&g);
    const bool albedo = !s.mesh->vertex_albedo.empty();
    const int flags = (s.smooth ? MESH_SMOOTH : 0) | (albedo ? MESH_ALBEDO : 0);
    scene.corners = scene.corners || flags != 0;
    const Eigen::Matrix3d& R = T_object_cam.rotation;
    push(KIND_MESHES,
         {pack(R.row(0), eye.x()),
          pack(R.row(1), eye.y()),
          pack(R.row(2), eye.z()),
          {static_cast<double>(first_node), static_cast<double>(first_triangle),
           static_cast<double>(n_links_), static_cast<double>(flags)}},
         g.bvh.order.size());
    n_links_ += g.bvh.order.size();
    // Numbers of triangles travel as floats; there are fewer nodes.
    if (n_links_ > kMostTriangles)
      throw UserError(ExitCode::input,
                      s.file.empty() ? fmt::format("object \"{}\"", object.name) : s.file.string(),
                      fmt::format("the meshes have {} triangles together, at most {} can be traced", n_links_,
                                  kMostTriangles),
                      "reduce the mesh");
    scene.instances.push_back({&g, {T_object_cam.rotation, eye}});
    for (const Eigen::Vector4f& c : g.covering)
      scene.finite.push_back({T_cam_object * (c.head<3>().cast<double>() + g.center_mm), c[3]});
  }

  void add(const MeasuredShape&, const Object& object) {
    throw UserError(ExitCode::usage, fmt::format("object \"{}\"", object.name),
                    "its shape is measured from real captures, and none were given");
  }

  void set_object(int index, const Material& material) {
    object_ = index;
    material_ = material;
  }

  PackedScene scene;

 private:
  // Adds the plane's albedo map and returns 1 + its place in scene.maps, 0 without one. The place travels as
  // a float.
  double add_map(const PlaneShape& s, const Object& object) {
    if (!s.albedo_map) {
      if (!s.albedo_file.empty())
        throw UserError(ExitCode::usage, fmt::format("object \"{}\"", object.name),
                        "its albedo map is not loaded");
      return 0.0;
    }
    FT_CHECK(s.size_mm.has_value(), "an albedo map covers a rectangle");
    const auto found = maps_.find(s.albedo_map.get());
    if (found != maps_.end()) return found->second;
    const double place = 1.0 + static_cast<double>(scene.maps.size());
    scene.maps.push_back(static_cast<float>(s.albedo_map->width));
    scene.maps.push_back(static_cast<float>(s.albedo_map->height));
    scene.maps.insert(scene.maps.end(), s.albedo_map->data.begin(), s.albedo_map->data.end());
    if (scene.maps.size() >= (1U << 23))
      throw UserError(ExitCode::usage, fmt::format("object \"{}\"", object.name),
                      "the albedo maps have more than 8 million pixels together", "reduce their size");
    maps_[s.albedo_map.get()] = place;
    return place;
  }
  bool is_ggx() const { return material_.specular_model == Material::Specular::ggx; }
  // Returns Phong's exponent, or minus the alpha of a GGX lobe.
  double lobe_width() const {
    return is_ggx() ? -material_.roughness * material_.roughness : material_.shininess;
  }
  // Notes that a plane or cylinder ends within a sphere, or that it reaches to infinity.
  void end(bool ends, const BoundingSphere& within) {
    (ends ? scene.bounded : scene.unbounded) = true;
    if (ends) scene.finite.push_back(within);
  }
  void push(PrimitiveKind kind, const std::array<Double4, 4>& primitive, std::size_t n_triangles = 1) {
    FT_CHECK(std::all_of(scene.count.begin() + kind + 1, scene.count.end(), [](int n) { return n == 0; }),
             "the kinds of primitives have the order of the Shape variant");
    ++scene.count[kind];
    scene.primitives.push_back(primitive);
    scene.materials.push_back({static_cast<float>(material_.diffuse), static_cast<float>(material_.specular),
                               static_cast<float>(lobe_width()), 0.0F});
    scene.below_surfaces.push_back({static_cast<float>(material_.mean_free_path_mm), 0.0F, 0.0F, 0.0F});
    if (material_.specular > 0.0) scene.specular |= is_ggx() ? SPECULAR_GGX : SPECULAR_PHONG;
    scene.object_of_primitive.push_back(object_);
    scene.triangles_of_primitive.push_back(n_triangles);
  }

  const Camera& camera_;
  MeshStore& store_;
  Pose T_cam_world_;
  double lens_mm_;
  std::size_t n_links_ = 0;
  int object_ = 0;
  Material material_;
  std::map<const ImageF*, double> maps_;
};

// Gives each primitive its first place in the list of all surfaces (shaders/identity.glsl).
void number_surfaces(PackedScene* scene) {
  for (std::size_t i = 0; i < scene->materials.size(); ++i) {
    scene->materials[i].w = static_cast<float>(scene->n_surfaces);
    scene->n_surfaces += scene->triangles_of_primitive[i];
  }
}

// Packs all objects of the shape S.
template <class S>
void add_all(Packer& packer, const Twin& twin) {
  for (std::size_t i = 0; i < twin.objects.size(); ++i)
    if (const S* shape = std::get_if<S>(&twin.objects[i].shape)) {
      packer.set_object(static_cast<int>(i), twin.objects[i].material);
      packer.add(*shape, twin.objects[i]);
    }
}

}  // namespace

double lens_radius_mm(const std::optional<Optics>& optics) {
  return optics ? 0.5 * optics->focal_length_mm / optics->f_number : 0.0;
}

PackedScene pack_scene(const Twin& twin, const Camera& camera, MeshStore& store) {
  Packer packer(camera, store);
  for_every_shape([&]<class S>(const S&) { add_all<S>(packer, twin); });

  PackedScene scene = std::move(packer.scene);
  number_surfaces(&scene);
  if (std::ranges::none_of(scene.below_surfaces, [](const gpu::vec4& below) { return below.x > 0.0F; }))
    scene.below_surfaces.clear();
  const std::size_t n = scene.object_of_primitive.size();
  scene.one_convex =
      n == 1 && std::ranges::none_of(twin.objects, [](const Object& o) { return shades_itself(o.shape); });
  scene.shadow = twin.render.shadow && n > 0 && !scene.one_convex;
  for (const BoundingSphere& b : scene.finite)
    scene.far_mm = std::max(scene.far_mm, b.center_mm.norm() + b.radius_mm);
  const VisibleRange range = visible_range(camera, scene);
  scene.far_mm = std::max(scene.far_mm, std::min(range.far_mm, kFarthestAllowedMm));
  scene.z_min_mm = range.z_min_mm;
  scene.z_max_mm = range.z_max_mm;
  return scene;
}

}  // namespace fringetwin::render
