// SPDX-License-Identifier: Apache-2.0
#include "bench/rivals.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace fringetwin::bench {
namespace {

constexpr int kLanes = 8;
constexpr int kThreads = 2;
constexpr float kTwoPi = 6.28318530717958648F;
constexpr float kFar = std::numeric_limits<float>::max();

/// A run of rays and what they found, lane by lane.
struct Lanes {
  float dx[kLanes], dy[kLanes], dz[kLanes], inverse_norm[kLanes];
  float t[kLanes], nx[kLanes], ny[kLanes], nz[kLanes];  // unit normal where t is finite
  float lx[kLanes], ly[kLanes], lz[kLanes], distance[kLanes], cosine[kLanes];
  float visible[kLanes];  // 1 or 0
};

// Directions of the same sample of eight neighbouring pixels, of unit length.
void make_rays(const RivalView& v, const float* ray, float ox, float oy, Lanes& l) {
  for (int i = 0; i < kLanes; ++i) {
    const float* r = ray + 6 * i;
    const float x = r[0] + r[2] * ox + r[4] * oy, y = r[1] + r[3] * ox + r[5] * oy;
    const float n = 1.0F / std::sqrt(x * x + y * y + 1.0F);
    l.dx[i] = x * n;
    l.dy[i] = y * n;
    l.dz[i] = n;
  }
  (void)v;
}

// Towards the light; the normal faces the viewer, light from behind gives nothing.
void face_light(const RivalView& v, Lanes& l) {
  for (int i = 0; i < kLanes; ++i) {
    const float flip = l.nx[i] * l.dx[i] + l.ny[i] * l.dy[i] + l.nz[i] * l.dz[i] > 0.0F ? -1.0F : 1.0F;
    const float t = l.t[i] < kFar ? l.t[i] : 1.0F;
    const float x = v.light_mm[0] - t * l.dx[i], y = v.light_mm[1] - t * l.dy[i],
                z = v.light_mm[2] - t * l.dz[i];
    const float d = std::sqrt(x * x + y * y + z * z), inverse = 1.0F / d;
    l.lx[i] = x * inverse;
    l.ly[i] = y * inverse;
    l.lz[i] = z * inverse;
    l.distance[i] = d;
    l.cosine[i] = flip * (l.nx[i] * l.lx[i] + l.ny[i] * l.ly[i] + l.nz[i] * l.lz[i]);
    l.visible[i] = l.t[i] < kFar && l.cosine[i] > 0.0F ? 1.0F : 0.0F;
  }
}

// Projection through the projector's lens, the fringes, and the sums of eight pixels.
void add_fringes(const RivalView& v, const Lanes& l, float weight, float* sums) {
  float w[kLanes], u[kLanes];
  for (int i = 0; i < kLanes; ++i) {
    const float t = l.t[i] < kFar ? l.t[i] : 1.0F;
    const float x = t * l.dx[i], y = t * l.dy[i], z = t * l.dz[i];
    const float* T = v.T_proj_cam;
    const float inverse = 1.0F / (T[8] * x + T[9] * y + T[10] * z + T[11]);
    const float a = (T[0] * x + T[1] * y + T[2] * z + T[3]) * inverse;
    const float b = (T[4] * x + T[5] * y + T[6] * z + T[7]) * inverse;
    const float r2 = a * a + b * b, radial = 1.0F + r2 * (v.k1 + r2 * v.k2);
    const float p = v.fx * (a * radial + 2.0F * v.p1 * a * b + v.p2 * (r2 + 2.0F * a * a)) + v.cx;
    const float q = v.fy * (b * radial + v.p1 * (r2 + 2.0F * b * b) + 2.0F * v.p2 * a * b) + v.cy;
    const bool inside = inverse > 0.0F && p >= -0.5F && q >= -0.5F && p <= v.projector_width - 0.5F &&
                        q <= v.projector_height - 0.5F;
    u[i] = p;
    w[i] = inside ? weight * v.reflectance * l.cosine[i] * l.visible[i] : 0.0F;
  }
  for (int i = 0; i < kLanes; ++i) sums[i * kSums] += w[i];
  for (int k = 0; k < 3; ++k) {
    float c[kLanes], s[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const float turns = u[i] / v.pitches_px[k];
      const float angle = kTwoPi * (turns - std::floor(turns));
      c[i] = w[i] * std::cos(angle);
      s[i] = w[i] * std::sin(angle);
    }
    for (int i = 0; i < kLanes; ++i) {
      sums[i * kSums + 1 + 2 * k] += c[i];
      sums[i * kSums + 2 + 2 * k] += s[i];
    }
  }
}

/// All samples of every run of eight pixels; `hit` fills t and normal, `shade` clears `visible`.
template <class Hit, class Shade>
void trace_image(const RivalView& v, RivalImage& out, Hit hit, Shade shade) {
  out.assign(static_cast<std::size_t>(v.width * v.height * kSums), 0.0F);
  const int n_samples = static_cast<int>(v.offsets_px.size()) / 2;
  const float weight = 1.0F / static_cast<float>(n_samples);
#pragma omp parallel for schedule(dynamic, 4) num_threads(kThreads)
  for (int y = 0; y < v.height; ++y)
    for (int x = 0; x + kLanes <= v.width; x += kLanes) {
      const auto pixel = static_cast<std::size_t>(y * v.width + x);
      for (int s = 0; s < n_samples; ++s) {
        Lanes l;
        const auto k = static_cast<std::size_t>(2 * s);
        make_rays(v, &v.rays[6 * pixel], v.offsets_px[k], v.offsets_px[k + 1], l);
        hit(l);
        face_light(v, l);
        shade(l);
        add_fringes(v, l, weight, &out[static_cast<std::size_t>(kSums) * pixel]);
      }
    }
}

// Distance to a sphere by the stable form (Haines, Ray Tracing Gems ch. 7); kFar where it is missed.
float hit_sphere(const RivalSphere& s, float ox, float oy, float oz, float dx, float dy, float dz) {
  const float fx = ox - s.center_mm[0], fy = oy - s.center_mm[1], fz = oz - s.center_mm[2];
  const float b = -(fx * dx + fy * dy + fz * dz);
  const float gx = fx + b * dx, gy = fy + b * dy, gz = fz + b * dz;
  const float discriminant = s.radius_mm * s.radius_mm - (gx * gx + gy * gy + gz * gz);
  const float c = fx * fx + fy * fy + fz * fz - s.radius_mm * s.radius_mm;
  const float root = std::sqrt(std::max(discriminant, 0.0F));
  const float q = b + (b > 0.0F ? root : -root);
  const float t = b > 0.0F ? c / q : q;
  return discriminant > 0.0F && t > 0.0F ? t : kFar;
}

}  // namespace

void trace_analytic(const RivalView& view, const RivalSphere& sphere, RivalImage& out) {
  trace_image(
      view, out,
      [&sphere](Lanes& l) {
        for (int i = 0; i < kLanes; ++i) {
          const float ts = hit_sphere(sphere, 0, 0, 0, l.dx[i], l.dy[i], l.dz[i]);
          const float tp = sphere.plane_z_mm / l.dz[i];
          const bool on_sphere = ts < tp;
          const float inverse = 1.0F / sphere.radius_mm;
          l.t[i] = on_sphere ? ts : tp;
          l.nx[i] = on_sphere ? (ts * l.dx[i] - sphere.center_mm[0]) * inverse : 0.0F;
          l.ny[i] = on_sphere ? (ts * l.dy[i] - sphere.center_mm[1]) * inverse : 0.0F;
          l.nz[i] = on_sphere ? (ts * l.dz[i] - sphere.center_mm[2]) * inverse : -1.0F;
          l.inverse_norm[i] = on_sphere ? 1.0F : 0.0F;  // where the ray ended
        }
      },
      [&sphere](Lanes& l) {
        for (int i = 0; i < kLanes; ++i) {
          // a sphere does not shade its own lit side, nor the plane behind it the sphere
          const float t = l.t[i];
          const float ts =
              hit_sphere(sphere, t * l.dx[i], t * l.dy[i], t * l.dz[i], l.lx[i], l.ly[i], l.lz[i]);
          const bool shaded = l.inverse_norm[i] == 0.0F && ts < l.distance[i];
          l.visible[i] = shaded ? 0.0F : l.visible[i];
        }
      });
}

struct RivalMesh::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

RivalMesh::RivalMesh(const std::vector<float>& vertices_mm, const std::vector<std::uint32_t>& triangles)
    : impl_(std::make_unique<Impl>()) {
  impl_->device = rtcNewDevice("threads=2");
  impl_->scene = rtcNewScene(impl_->device);
  rtcSetSceneBuildQuality(impl_->scene, RTC_BUILD_QUALITY_HIGH);
  RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* v = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                    vertices_mm.size() / 3);
  std::memcpy(v, vertices_mm.data(), vertices_mm.size() * sizeof(float));
  void* i = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    3 * sizeof(std::uint32_t), triangles.size() / 3);
  std::memcpy(i, triangles.data(), triangles.size() * sizeof(std::uint32_t));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(impl_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(impl_->scene);
}

RivalMesh::~RivalMesh() {
  rtcReleaseScene(impl_->scene);
  rtcReleaseDevice(impl_->device);
}

namespace {

constexpr float kShadowStart = 4e-6F;  // of the distance, along the normal, as the renderer's

// Start of a shadow ray: off the surface on the light's side.
void shadow_origin(const Lanes& l, int i, float* o) {
  const float side = l.nx[i] * l.lx[i] + l.ny[i] * l.ly[i] + l.nz[i] * l.lz[i] > 0.0F ? 1.0F : -1.0F;
  const float off = side * kShadowStart * l.t[i];
  o[0] = l.t[i] * l.dx[i] + off * l.nx[i];
  o[1] = l.t[i] * l.dy[i] + off * l.ny[i];
  o[2] = l.t[i] * l.dz[i] + off * l.nz[i];
}

void set_normal(Lanes& l, int i, float x, float y, float z) {
  const float n = 1.0F / std::sqrt(std::max(x * x + y * y + z * z, 1e-30F));
  l.nx[i] = x * n;
  l.ny[i] = y * n;
  l.nz[i] = z * n;
}

}  // namespace

void RivalMesh::trace_single(const RivalView& view, RivalImage& out) const {
  RTCScene scene = impl_->scene;
  trace_image(
      view, out,
      [scene](Lanes& l) {
        for (int i = 0; i < kLanes; ++i) {
          RTCIntersectContext context;
          rtcInitIntersectContext(&context);
          context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
          RTCRayHit r{};
          r.ray.dir_x = l.dx[i];
          r.ray.dir_y = l.dy[i];
          r.ray.dir_z = l.dz[i];
          r.ray.tfar = kFar;
          r.ray.mask = ~0U;
          r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
          rtcIntersect1(scene, &context, &r);
          l.t[i] = r.hit.geomID == RTC_INVALID_GEOMETRY_ID ? kFar : r.ray.tfar;
          set_normal(l, i, r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z);
        }
      },
      [scene](Lanes& l) {
        for (int i = 0; i < kLanes; ++i) {
          if (l.visible[i] == 0.0F) continue;
          RTCIntersectContext context;
          rtcInitIntersectContext(&context);
          context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
          RTCRay r{};
          float o[3];
          shadow_origin(l, i, o);
          r.org_x = o[0];
          r.org_y = o[1];
          r.org_z = o[2];
          r.dir_x = l.lx[i];
          r.dir_y = l.ly[i];
          r.dir_z = l.lz[i];
          r.tfar = l.distance[i];
          r.mask = ~0U;
          rtcOccluded1(scene, &context, &r);
          if (r.tfar < 0.0F) l.visible[i] = 0.0F;
        }
      });
}

void RivalMesh::trace_packets(const RivalView& view, RivalImage& out) const {
  RTCScene scene = impl_->scene;
  trace_image(
      view, out,
      [scene](Lanes& l) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        alignas(32) RTCRayHit8 r{};
        alignas(32) int valid[kLanes];
        for (int i = 0; i < kLanes; ++i) {
          valid[i] = -1;
          r.ray.dir_x[i] = l.dx[i];
          r.ray.dir_y[i] = l.dy[i];
          r.ray.dir_z[i] = l.dz[i];
          r.ray.tfar[i] = kFar;
          r.ray.mask[i] = ~0U;
          r.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcIntersect8(valid, scene, &context, &r);
        for (int i = 0; i < kLanes; ++i) {
          l.t[i] = r.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? kFar : r.ray.tfar[i];
          set_normal(l, i, r.hit.Ng_x[i], r.hit.Ng_y[i], r.hit.Ng_z[i]);
        }
      },
      [scene](Lanes& l) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        alignas(32) RTCRay8 r{};
        alignas(32) int valid[kLanes];
        int any = 0;
        for (int i = 0; i < kLanes; ++i) {
          valid[i] = l.visible[i] != 0.0F ? -1 : 0;
          any |= valid[i];
          float o[3];
          shadow_origin(l, i, o);
          r.org_x[i] = o[0];
          r.org_y[i] = o[1];
          r.org_z[i] = o[2];
          r.dir_x[i] = l.lx[i];
          r.dir_y[i] = l.ly[i];
          r.dir_z[i] = l.lz[i];
          r.tfar[i] = l.distance[i];
          r.mask[i] = ~0U;
        }
        if (any == 0) return;
        rtcOccluded8(valid, scene, &context, &r);
        for (int i = 0; i < kLanes; ++i)
          if (valid[i] != 0 && r.tfar[i] < 0.0F) l.visible[i] = 0.0F;
      });
}

}  // namespace fringetwin::bench
