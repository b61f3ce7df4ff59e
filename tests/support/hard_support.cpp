// SPDX-License-Identifier: Apache-2.0
#include "tests/support/hard_support.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>
#include <random>

#include "twin/base/errors.hpp"

namespace fringetwin::testing {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// ---------------------------------------------------------------- rigs

Twin bench_rig(double camera_f_px, int width, int height, double baseline_mm) {
  Twin twin = only_camera(paper_rig(), 0);
  twin.cameras[0].lens =
      Lens("LENSMODEL_PINHOLE", {camera_f_px, camera_f_px, (width - 1) / 2.0, (height - 1) / 2.0},
           {width, height}, "camera");
  twin.projector->lens = Lens("LENSMODEL_PINHOLE", {1700, 1700, 639.5, 359.5}, {1280, 720}, "projector");
  twin.projector->T_proj_world.rotation.setIdentity();
  twin.projector->T_proj_world.translation_mm = {-baseline_mm, 0.0, 0.0};
  return twin;
}

Twin scaled(Twin rig, double k) {
  for (Camera& c : rig.cameras) c.T_cam_world.translation_mm *= k;
  rig.projector->T_proj_world.translation_mm *= k;
  return rig;
}

Twin zoomed(Twin rig, const Vector3d& point_world_mm, double factor, int width, int height) {
  for (Camera& camera : rig.cameras) {
    std::vector<double> k = camera.lens.intrinsics();
    const auto q = camera.lens.project(camera.T_cam_world * point_world_mm);
    FT_CHECK(q.has_value(), "the point lies outside the camera's view");
    for (const std::size_t axis : {0, 1}) {
      const double tangent = ((*q)[static_cast<Eigen::Index>(axis)] - k[2 + axis]) / k[axis];
      k[axis] *= factor;
      k[2 + axis] = 0.5 * (axis == 0 ? width : height) - k[axis] * tangent;
    }
    camera.lens = Lens(camera.lens.model(), k, {width, height}, camera.name + " zoomed");
  }
  return rig;
}

Twin moved(Twin twin, const Pose& T_new_old) {
  const Pose T_old_new = T_new_old.inverse();
  for (Camera& c : twin.cameras) c.T_cam_world = c.T_cam_world * T_old_new;
  twin.projector->T_proj_world = twin.projector->T_proj_world * T_old_new;
  for (Object& object : twin.objects) {
    if (auto* s = std::get_if<SphereShape>(&object.shape)) s->center_mm = T_new_old * s->center_mm;
    if (auto* p = std::get_if<PlaneShape>(&object.shape)) {
      p->point_mm = T_new_old * p->point_mm;
      p->normal = T_new_old.rotation * p->normal;
      p->u_axis = T_new_old.rotation * p->u_axis;
    }
    if (auto* m = std::get_if<MeshShape>(&object.shape)) m->T_world_object = T_new_old * m->T_world_object;
  }
  return twin;
}

// ---------------------------------------------------------------- meshes

namespace {

void add_cells(Mesh* mesh, int columns, int rows) {
  const auto at = [&](int i, int j) { return j * columns + i; };
  for (int j = 0; j + 1 < rows; ++j)
    for (int i = 0; i + 1 < columns; ++i) {
      mesh->triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      mesh->triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
}

}  // namespace

Mesh height_field(double x0, double y0, double dx, double dy, int nx, int ny,
                  const std::function<double(double, double)>& height) {
  Mesh mesh;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const double x = x0 + i * dx, y = y0 + j * dy;
      mesh.vertices_mm.push_back(Vector3d(x, y, height(x, y)).cast<float>());
    }
  add_cells(&mesh, nx + 1, ny + 1);
  return mesh;
}

Mesh aimed_sheet(const Lens& lens, const Vector2d& offset_px, double z_mm, double bump_mm,
                 const Pose& T_cam_object) {
  constexpr int margin = 3;
  const Pose T_object_cam = T_cam_object.inverse();
  Mesh mesh;
  const int columns = lens.width() + 2 * margin, rows = lens.height() + 2 * margin;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const Vector2d q(i - margin + offset_px.x(), j - margin + offset_px.y());
      const double z = z_mm + bump_mm * std::sin(0.7 * i + 0.3 * j) * std::cos(0.5 * j - 0.2 * i);
      const auto d = lens.unproject(q);
      FT_CHECK(d.has_value(), "a pixel without a ray");
      mesh.vertices_mm.push_back((T_object_cam * (*d * (z / d->z()))).cast<float>());
    }
  add_cells(&mesh, columns, rows);
  return mesh;
}

MeshShape as_shape(Mesh mesh, const Pose& T_world_object, bool smooth) {
  return {{}, "mm", T_world_object, smooth, std::make_shared<Mesh>(std::move(mesh))};
}

Pose random_pose(unsigned seed, const Vector3d& translation_mm) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
  return {q.normalized().toRotationMatrix(), translation_mm};
}

// ---------------------------------------------------------------- schoolbook

std::optional<float> schoolbook_sphere(const Vector3f& o, const Vector3f& d, const Vector3f& center,
                                       float radius) {
  const Vector3f f = o - center;
  const float a = d.dot(d), b = 2.0F * f.dot(d), c = f.dot(f) - radius * radius;
  const float discriminant = b * b - 4.0F * a * c;
  if (!(discriminant >= 0.0F)) return std::nullopt;
  const float t = (-b - std::sqrt(discriminant)) / (2.0F * a);
  return t > 0.0F ? std::optional(t) : std::nullopt;
}

std::optional<float> moeller_trumbore(const Vector3f& o, const Vector3f& d, const Vector3f& a,
                                      const Vector3f& b, const Vector3f& c) {
  const Vector3f e1 = b - a, e2 = c - a, h = d.cross(e2);
  const float inv_det = 1.0F / e1.dot(h);
  const Vector3f s = o - a;
  const float u = s.dot(h) * inv_det;
  const Vector3f q = s.cross(e1);
  const float v = d.dot(q) * inv_det, t = e2.dot(q) * inv_det;
  if (u >= 0.0F && v >= 0.0F && u + v <= 1.0F && t > 0.0F) return t;
  return std::nullopt;
}

bool pluecker_edges(const Vector3f& o, const Vector3f& d, const Vector3f& a, const Vector3f& b,
                    const Vector3f& c) {
  const Vector3f v0 = a - o, v1 = b - o, v2 = c - o;
  const float u = Vector3f(v2 - v1).cross(Vector3f(v2 + v1)).dot(d);
  const float v = Vector3f(v0 - v2).cross(Vector3f(v0 + v2)).dot(d);
  const float w = Vector3f(v1 - v0).cross(Vector3f(v1 + v0)).dot(d);
  const bool inside = std::min({u, v, w}) >= 0.0F || std::max({u, v, w}) <= 0.0F;
  return inside && u + v + w != 0.0F;
}

bool projected_edges(const Vector3f& o, const Vector3f& d, const Vector3f& a, const Vector3f& b,
                     const Vector3f& c) {
  Eigen::Index k = 0;
  d.cwiseAbs().maxCoeff(&k);
  const Eigen::Index i = (k + 1) % 3, j = (k + 2) % 3;
  float x[3], y[3];
  const Vector3f* vertices[3] = {&a, &b, &c};
  for (int n = 0; n < 3; ++n) {
    const Vector3f p = *vertices[n] - o;
    x[n] = d[k] * p[i] - d[i] * p[k];
    y[n] = d[k] * p[j] - d[j] * p[k];
  }
  const float u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2], w = x[1] * y[0] - y[1] * x[0];
  const bool inside = std::min({u, v, w}) >= 0.0F || std::max({u, v, w}) <= 0.0F;
  return inside && u + v + w != 0.0F;
}

// ---------------------------------------------------------------- measuring

PointError point_error(const render::Reference& reference, std::size_t camera, const PixelBlock& block,
                       const std::function<std::optional<double>(const Vector3d&)>& hit) {
  const Twin& twin = reference.twin();
  const Camera& c = twin.cameras.at(camera);
  const Pose T_world_cam = c.T_cam_world.inverse();
  const DirectionFringes& fringes = twin.fringes.directions.at(0);
  const double pitch = fringes.pitches_px[static_cast<std::size_t>(fringes.finest())];
  PointError out;
  for (int y = block.y0; y < block.y0 + block.height; y += block.stride)
    for (int x = block.x0; x < block.x0 + block.width; x += block.stride) {
      if (x < 0 || y < 0 || x >= c.lens.width() || y >= c.lens.height()) continue;
      const auto truth = reference.sample(camera, {x, y});
      if (!truth.lit) continue;
      const Vector3d d = (T_world_cam.rotation * *c.lens.unproject({x, y})).normalized();
      const auto t = hit(d);
      const auto q = t ? twin.projector->lens.project(twin.projector->T_proj_world *
                                                      (T_world_cam.translation_mm + *t * d))
                       : std::nullopt;
      if (!q) {
        ++out.missed;
        continue;
      }
      const double error = 2.0 * std::numbers::pi * (q->x() - truth.projector_px.x()) / pitch;
      ++out.n;
      out.rms_rad += error * error;
      out.max_rad = std::max(out.max_rad, std::abs(error));
    }
  out.rms_rad = std::sqrt(out.rms_rad / std::max(1, out.n));
  return out;
}

void report(const std::string& what, const std::string& schoolbook, const std::string& ours) {
  std::cout << fmt::format("HARD | {} | {} | {}\n", what, schoolbook, ours);
}

}  // namespace fringetwin::testing
