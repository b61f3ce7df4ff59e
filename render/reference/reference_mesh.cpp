// SPDX-License-Identifier: Apache-2.0
#include "render/reference/reference_mesh.hpp"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

// A ray through a shared edge must not slip between two triangles by a rounding error.
constexpr double kEdgeTolerance = 1e-12;
// Embree's float ray may lag behind the double one; relative and absolute (mm) room for its far end.
constexpr double kFloatRoom = 1e-6;

struct Triangles {
  std::shared_ptr<const Mesh> mesh;
  double padding_mm = 0.0;  // of the boxes: more than the float ray may stray

  Eigen::Vector3d vertex(int triangle, int corner) const {
    const auto& indices = mesh->triangles[triangle];
    return mesh->vertices_mm[static_cast<std::size_t>(indices[static_cast<std::size_t>(corner)])]
        .cast<double>();
  }
};

// A double-precision query travels with Embree's context; Embree's own ray only steers.
struct Query {
  RTCIntersectContext context;  // first member: the callbacks cast it back
  const Ray* ray = nullptr;
  double t_min = 0.0, t_max = 0.0;
  int skipped_triangle = -1;
  std::optional<MeshHit> best;
};

// Möller-Trumbore in double.
std::optional<MeshHit> intersect_triangle(const Triangles& triangles, int triangle, const Query& query) {
  if (triangle == query.skipped_triangle) return std::nullopt;
  const Ray& ray = *query.ray;
  const Eigen::Vector3d a = triangles.vertex(triangle, 0);
  const Eigen::Vector3d e1 = triangles.vertex(triangle, 1) - a, e2 = triangles.vertex(triangle, 2) - a;
  const Eigen::Vector3d p = ray.direction.cross(e2);
  const double determinant = e1.dot(p);
  if (determinant == 0.0) return std::nullopt;
  const Eigen::Vector3d s = ray.origin_mm - a;
  const double u = s.dot(p) / determinant;
  const Eigen::Vector3d q = s.cross(e1);
  const double v = ray.direction.dot(q) / determinant;
  if (u < -kEdgeTolerance || v < -kEdgeTolerance || u + v > 1.0 + kEdgeTolerance) return std::nullopt;
  const double t = e2.dot(q) / determinant;
  if (!(t > query.t_min && t < query.t_max)) return std::nullopt;
  return MeshHit{t, triangle, u, v};
}

// True when `hit` replaces `best`: nearer, or the same distance and a lower index.
bool replaces(const MeshHit& hit, const std::optional<MeshHit>& best) {
  if (!best) return true;
  const double same = 1e-12 * std::max(1.0, std::abs(best->t_mm));
  if (hit.t_mm < best->t_mm - same) return true;
  return hit.t_mm <= best->t_mm + same && hit.triangle < best->triangle;
}

float round_up(double value) { return std::nextafter(static_cast<float>(value), INFINITY); }
float far_end(double t) {
  return std::isfinite(t) ? round_up(t * (1.0 + kFloatRoom) + kFloatRoom) : INFINITY;
}

void bounds_callback(const RTCBoundsFunctionArguments* args) {
  const auto& triangles = *static_cast<const Triangles*>(args->geometryUserPtr);
  const auto index = static_cast<int>(args->primID);
  Eigen::Vector3d low = triangles.vertex(index, 0), high = low;
  for (int corner : {1, 2}) {
    low = low.cwiseMin(triangles.vertex(index, corner));
    high = high.cwiseMax(triangles.vertex(index, corner));
  }
  low.array() -= triangles.padding_mm;
  high.array() += triangles.padding_mm;
  RTCBounds& b = *args->bounds_o;
  b.lower_x = -round_up(-low.x());
  b.lower_y = -round_up(-low.y());
  b.lower_z = -round_up(-low.z());
  b.upper_x = round_up(high.x());
  b.upper_y = round_up(high.y());
  b.upper_z = round_up(high.z());
}

void intersect_callback(const RTCIntersectFunctionNArguments* args) {
  if (args->valid[0] != -1) return;
  auto& query = *reinterpret_cast<Query*>(args->context);
  const auto hit = intersect_triangle(*static_cast<const Triangles*>(args->geometryUserPtr),
                                      static_cast<int>(args->primID), query);
  if (!hit || !replaces(*hit, query.best)) return;
  query.best = hit;
  auto* ray_hit = reinterpret_cast<RTCRayHit*>(args->rayhit);
  ray_hit->ray.tfar = far_end(hit->t_mm);
  ray_hit->hit.geomID = args->geomID;
  ray_hit->hit.primID = args->primID;
}

void occluded_callback(const RTCOccludedFunctionNArguments* args) {
  if (args->valid[0] != -1) return;
  const auto& query = *reinterpret_cast<const Query*>(args->context);
  if (intersect_triangle(*static_cast<const Triangles*>(args->geometryUserPtr),
                         static_cast<int>(args->primID), query))
    reinterpret_cast<RTCRay*>(args->ray)->tfar = -INFINITY;
}

RTCRay steering_ray(const Query& query) {
  const Eigen::Vector3f o = query.ray->origin_mm.cast<float>(), d = query.ray->direction.cast<float>();
  RTCRay r{};
  r.org_x = o.x(), r.org_y = o.y(), r.org_z = o.z();
  r.dir_x = d.x(), r.dir_y = d.y(), r.dir_z = d.z();
  r.tnear = 0.0f;  // t_min is applied in double
  r.tfar = far_end(query.t_max);
  r.mask = ~0u;
  return r;
}

RTCScene build_scene(const Triangles& triangles) {
  static const RTCDevice device = rtcNewDevice(nullptr);
  FT_CHECK(device != nullptr, "Embree gives no device");
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(triangles.mesh->triangles.size()));
  rtcSetGeometryUserData(geometry, const_cast<Triangles*>(&triangles));  // Embree's API is not const
  rtcSetGeometryBoundsFunction(geometry, bounds_callback, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_callback);
  rtcSetGeometryOccludedFunction(geometry, occluded_callback);
  rtcCommitGeometry(geometry);
  const RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  FT_CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE, "Embree could not build the scene");
  return scene;
}

double largest_coordinate(const Mesh& mesh) {
  double largest = 0.0;
  for (const Eigen::Vector3f& v : mesh.vertices_mm)
    largest = std::max(largest, static_cast<double>(v.cwiseAbs().maxCoeff()));
  return largest;
}

template <class T>
T interpolate(const std::vector<T>& values, const std::array<int, 3>& corners, double u, double v) {
  const auto at = [&](int i) {
    return values[static_cast<std::size_t>(corners[static_cast<std::size_t>(i)])];
  };
  return at(0) * (1.0 - u - v) + at(1) * u + at(2) * v;
}

}  // namespace

struct ReferenceMesh::Impl {
  Triangles triangles;
  std::vector<Eigen::Vector3d> normals;
  std::vector<double> albedo;
  RTCScene scene = nullptr;
  ~Impl() {
    if (scene) rtcReleaseScene(scene);
  }
};

ReferenceMesh::ReferenceMesh(std::shared_ptr<const Mesh> mesh, double reach_mm)
    : impl_(std::make_unique<Impl>()) {
  FT_CHECK(mesh && !mesh->triangles.empty(), "a mesh must be loaded before rendering");
  // float: origin and direction are each off by half an ulp, 6e-8 of the distances involved
  impl_->triangles.padding_mm = 5e-7 * (reach_mm + largest_coordinate(*mesh));
  const auto normals = mesh->vertex_normals.empty() ? compute_vertex_normals(*mesh) : mesh->vertex_normals;
  for (const Eigen::Vector3f& n : normals) impl_->normals.push_back(n.cast<double>());
  impl_->albedo.assign(mesh->vertex_albedo.begin(), mesh->vertex_albedo.end());
  impl_->triangles.mesh = std::move(mesh);
  impl_->scene = build_scene(impl_->triangles);
}
ReferenceMesh::~ReferenceMesh() = default;

const Mesh& ReferenceMesh::mesh() const { return *impl_->triangles.mesh; }

std::optional<MeshHit> ReferenceMesh::nearest(const Ray& ray, double t_min, double t_max) const {
  Query query{.context = {}, .ray = &ray, .t_min = t_min, .t_max = t_max, .skipped_triangle = -1, .best = {}};
  rtcInitIntersectContext(&query.context);
  RTCRayHit ray_hit{};
  ray_hit.ray = steering_ray(query);
  ray_hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->scene, &query.context, &ray_hit);
  return query.best;
}

std::optional<MeshHit> ReferenceMesh::nearest_brute_force(const Ray& ray, double t_min, double t_max) const {
  Query query{.context = {}, .ray = &ray, .t_min = t_min, .t_max = t_max, .skipped_triangle = -1, .best = {}};
  for (int i = 0; i < static_cast<int>(mesh().triangles.size()); ++i) {
    const auto hit = intersect_triangle(impl_->triangles, i, query);
    if (hit && replaces(*hit, query.best)) query.best = hit;
  }
  return query.best;
}

bool ReferenceMesh::occluded(const Ray& ray, double t_min, double t_max, int skipped_triangle) const {
  Query query{.context = {},
              .ray = &ray,
              .t_min = t_min,
              .t_max = t_max,
              .skipped_triangle = skipped_triangle,
              .best = {}};
  rtcInitIntersectContext(&query.context);
  RTCRay steering = steering_ray(query);
  rtcOccluded1(impl_->scene, &query.context, &steering);
  return steering.tfar < 0.0f;
}

Eigen::Vector3d ReferenceMesh::geometric_normal(int triangle) const {
  const Eigen::Vector3d a = impl_->triangles.vertex(triangle, 0);
  return (impl_->triangles.vertex(triangle, 1) - a)
      .cross(impl_->triangles.vertex(triangle, 2) - a)
      .normalized();
}

Eigen::Vector3d ReferenceMesh::shading_normal(const MeshHit& hit) const {
  const auto& corners = mesh().triangles[hit.triangle];
  const Eigen::Vector3d n = interpolate(impl_->normals, corners, hit.u, hit.v);
  return n.squaredNorm() > 1e-6 ? n.normalized() : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

double ReferenceMesh::albedo(const MeshHit& hit) const {
  if (impl_->albedo.empty()) return 1.0;
  return interpolate(impl_->albedo, mesh().triangles[hit.triangle], hit.u, hit.v);
}

}  // namespace fringetwin::render
