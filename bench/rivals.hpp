// SPDX-License-Identifier: Apache-2.0
// The same primary ray + shadow ray + fringe sums on the CPU, written for speed: what the Vulkan renderer is
// measured against. Plain floats only: rivals.cpp is compiled with -O3 -march=native -ffast-math.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

namespace fringetwin::bench {

/// Everything in the camera frame, mm.
struct RivalView {
  int width = 0, height = 0;
  /// Per pixel x/z, y/z of its centre and their derivatives along the row and the column (6 floats):
  /// undistorted before the clock starts, as the renderer's lens table is.
  std::vector<float> rays;
  std::vector<float> offsets_px;  ///< dx, dy of each sample of a pixel
  float T_proj_cam[12] = {};      ///< rows of [R | t]
  float light_mm[3] = {};         ///< projector centre
  float fx = 1, fy = 1, cx = 0, cy = 0, k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  float projector_width = 0, projector_height = 0;
  float pitches_px[3] = {1, 1, 1};
  float reflectance = 1;  ///< intensity x diffuse / pi
};

/// Per pixel: mean of w, then mean of w cos and w sin of each pitch.
inline constexpr int kSums = 7;
using RivalImage = std::vector<float>;

/// Sphere and frontal plane, in arrays the compiler turns into vector code; 2 OpenMP threads.
struct RivalSphere {
  float center_mm[3] = {}, radius_mm = 0, plane_z_mm = 0;
};
void trace_analytic(const RivalView& view, const RivalSphere& sphere, RivalImage& out);

/// Triangles through Embree's high-quality BVH.
class RivalMesh {
 public:
  RivalMesh(const std::vector<float>& vertices_mm, const std::vector<std::uint32_t>& triangles);
  ~RivalMesh();
  RivalMesh(const RivalMesh&) = delete;
  RivalMesh& operator=(const RivalMesh&) = delete;
  void trace_single(const RivalView& view, RivalImage& out) const;   ///< rtcIntersect1 + rtcOccluded1
  void trace_packets(const RivalView& view, RivalImage& out) const;  ///< rtcIntersect8 + rtcOccluded8

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fringetwin::bench
