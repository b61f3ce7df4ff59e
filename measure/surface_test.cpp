// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   3e-5 mm    noiseless plane: vertices are floats near 260 (rounding 1.5e-5)
//   1.5e-4 mm  in the pixel beyond the points it goes on as a line of 1/z, which the lens bends by
//              3 k1 x (px/f)^2 = 3e-7: 5e-5 mm on this slope, from a window on one side, whose slope is off
//              by as much again
//   16 %       of variances over 8 draws of some 900 windows that share nothing (4.5 sqrt(2/7000) = 8 %), and
//              what Tukey's weights are off by (8 %: depth_fit_test.cpp)
//   noise / 2  a quadratic on a disc of radius 3 (29 points) leaves 0.45 of the noise at its centre
#include "measure/surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <random>

#include "measure/fit/closest_point.hpp"
#include "measure/measurement.hpp"
#include "tests/support/measure/measure_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure::surface_test {
namespace {

using namespace testing;

TEST(Surface, PlaneStaysPlaneAndFacesTheCamera) {
  const Twin twin = scaled_paper_rig(0.25);
  const Eigen::Vector3d n = Eigen::Vector3d(0.5, -0.2, -1).normalized(), at(0, 0, 260);
  const PointCloud cloud = triangulate_projector(twin, 0, ideal_decode(twin, 0, plane_surface(at, n)));
  const auto mesh = build_surface(twin, 0, cloud, MeasuredShape{.smoothing_px = 3.0}).mesh;
  EXPECT_GE(mesh->vertices_mm.size(), cloud.size());
  EXPECT_GT(mesh->triangles.size(), 19 * cloud.size() / 10);
  const Camera& camera = twin.cameras[0];
  const Image<int> points = point_grid(cloud, camera.lens.width(), camera.lens.height());
  std::size_t beyond = 0, beyond_image = 0;
  for (const auto& v : mesh->vertices_mm) {
    const auto q = camera.lens.project(camera.T_cam_world * v.cast<double>());
    ASSERT_TRUE(q);
    const int x = static_cast<int>(std::lround(q->x())), y = static_cast<int>(std::lround(q->y()));
    const bool is_inside = x >= 0 && y >= 0 && x < points.width && y < points.height,
               has_point = is_inside && points(x, y) >= 0;
    beyond += has_point ? 0 : 1;
    beyond_image += is_inside ? 0 : 1;
    ASSERT_LT(std::abs(n.dot(v.cast<double>() - at)), has_point ? 3e-5 : 1.5e-4);
  }
  EXPECT_GT(beyond, 0U);
  EXPECT_GT(beyond_image, 0U) << "the plane reaches the image's border";
  for (const auto& t : mesh->triangles) {
    const Eigen::Vector3d a = mesh->vertices_mm[t[0]].cast<double>(),
                          b = mesh->vertices_mm[t[1]].cast<double>(),
                          c = mesh->vertices_mm[t[2]].cast<double>();
    ASSERT_GT((b - a).cross(c - a).normalized().dot(n), 0.99);
  }
  ASSERT_EQ(mesh->vertex_normals.size(), mesh->vertices_mm.size());
  EXPECT_GT(mesh->vertex_normals[100].cast<double>().dot(n), 0.999);
}

/// Returns the pixel that sees a point in its middle.
Eigen::Vector2i pixel_of(const Camera& camera, const Eigen::Vector3d& p_world_mm) {
  const auto q = camera.lens.project(camera.T_cam_world * p_world_mm);
  return {static_cast<int>(std::lround(q->x())), static_cast<int>(std::lround(q->y()))};
}

/// Returns the mean over a pixel of what goes evenly from vertex to vertex, one in the middle of each pixel.
double mean_over_pixel(const ImageD& of_vertex, int x, int y) {
  constexpr double kAlong[] = {0.125, 0.75, 0.125};
  double sum = 0.0;
  for (int v = -1; v <= 1; ++v)
    for (int u = -1; u <= 1; ++u) sum += kAlong[u + 1] * kAlong[v + 1] * of_vertex(x + u, y + v);
  return sum;
}

/// Returns the rms of what the mean over a pixel of the mesh's depth lies beside the pixel's own depth.
double off_in_pixels_mm(const Mesh& mesh, const PointCloud& points, const Camera& camera) {
  ImageD depth_mm(camera.lens.width(), camera.lens.height(), std::nan(""));
  for (const Eigen::Vector3f& v : mesh.vertices_mm) {
    const Eigen::Vector2i q = pixel_of(camera, v.cast<double>());
    if (q.x() >= 0 && q.y() >= 0 && q.x() < depth_mm.width && q.y() < depth_mm.height)
      depth_mm(q.x(), q.y()) = (camera.T_cam_world * v.cast<double>()).z();
  }
  double sum = 0.0, n = 0.0;
  for (const Eigen::Vector3d& p : points.p_world_mm) {
    const Eigen::Vector2i q = pixel_of(camera, p);
    if (q.x() < 1 || q.y() < 1 || q.x() > depth_mm.width - 2 || q.y() > depth_mm.height - 2) continue;
    const double off_mm = mean_over_pixel(depth_mm, q.x(), q.y()) - (camera.T_cam_world * p).z();
    if (std::isfinite(off_mm)) sum += off_mm * off_mm, n += 1.0;
  }
  return std::sqrt(sum / n);
}

TEST(Surface, SmoothingTakesTheNoiseNotTheShape) {
  const Twin twin = scaled_paper_rig(0.5);
  const Eigen::Vector3d center(0, 0, 260);
  const double radius = 30;
  MapOptions noisy;
  noisy.noise_px = 0.1;
  const RaySurface scene = sphere_surface(center, radius);
  const PointCloud cloud = triangulate_projector(twin, 0, ideal_decode(twin, 0, scene, noisy));
  const PointCloud clean = triangulate_projector(twin, 0, ideal_decode(twin, 0, scene));
  const auto rms = [&](const Mesh& mesh) {
    double sum = 0.0;
    std::size_t n = 0;
    for (const auto& v : mesh.vertices_mm) {
      const Eigen::Vector3d d = v.cast<double>() - center;
      if (d.z() > -0.6 * radius) continue;  // away from the rim
      sum += std::pow(d.norm() - radius, 2);
      ++n;
    }
    return std::sqrt(sum / static_cast<double>(n));
  };
  const double raw = rms(*build_surface(twin, 0, cloud, MeasuredShape{.smoothing_px = 0.0}).mesh),
               smoothed = rms(*build_surface(twin, 0, cloud, MeasuredShape{.smoothing_px = 3.0}).mesh);
  PointCloud inner;  // away from the rim
  for (const Eigen::Vector3d& p : clean.p_world_mm)
    if (p.z() - center.z() < -0.6 * radius) inner.p_world_mm.push_back(p);
  const double bias = off_in_pixels_mm(
      *build_surface(twin, 0, clean, MeasuredShape{.smoothing_px = 3.0}).mesh, inner, twin.cameras[0]);
  std::printf("surface: raw %.4f, smoothed %.4f, bias %.1e mm\n", raw, smoothed, bias);
  EXPECT_LT(smoothed, 0.55 * raw);
  EXPECT_LT(bias, 1e-4);
}

/// Returns the cloud with noise along the rays, as its sigmas state it.
PointCloud drawn(const PointCloud& clean, const Eigen::Vector3d& camera_mm, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  PointCloud cloud = clean;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d ray_mm = cloud.p_world_mm[i] - camera_mm;
    cloud.p_world_mm[i] += static_cast<double>(cloud.sigma_mm[i]) * normal(random) * ray_mm.normalized();
  }
  return cloud;
}

/// Returns the projector's column that lights a point.
double column_of(const Twin& twin, const Eigen::Vector3d& p_world_mm) {
  return twin.projector->lens.project(twin.projector->T_proj_world * p_world_mm)->x();
}

// A checker of noise, four times as much on its dark squares: what is said of a vertex holds for that vertex.
TEST(Surface, SaysWhatNoiseEachPixelHas) {
  const Twin twin = scaled_paper_rig(0.25);
  const Eigen::Vector3d n = Eigen::Vector3d(0.2, -0.2, -1).normalized(), at_mm(0, 0, 260);
  PointCloud clean = triangulate_projector(twin, 0, ideal_decode(twin, 0, plane_surface(at_mm, n)));
  const auto dark = [](const Eigen::Vector2f& q) {
    return (static_cast<int>(q.x()) / 2 + static_cast<int>(q.y()) / 2) % 2 == 1;
  };
  for (std::size_t i = 0; i < clean.size(); ++i) clean.sigma_mm[i] = dark(clean.q_cam_px[i]) ? 0.04F : 0.01F;
  const Camera& camera = twin.cameras[0];
  const Eigen::Vector3d camera_mm = camera.T_cam_world.inverse() * Eigen::Vector3d::Zero(),
                        light_mm = twin.projector->T_proj_world.inverse() * Eigen::Vector3d::Zero();
  constexpr double kRadiusPx = 3.0;
  const PixelShares in_pixel = shares_in_pixel(kRadiusPx);  // what is said is of a pixel's mean
  const int width = camera.lens.width(), height = camera.lens.height();
  // over what is said; quiet, noisy
  double depth[2] = {}, depths[2] = {}, shading[2] = {}, count[2] = {};
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const PointCloud cloud = drawn(clean, camera_mm, seed);
    const MeasuredSurface surface = build_surface(twin, 0, cloud, MeasuredShape{.smoothing_px = kRadiusPx});
    const SurfaceNoiseInView& said = surface.noise.of_camera[0];
    ImageD off_px(width, height, std::nan(""));
    for (std::size_t v = 0; v < surface.mesh->vertices_mm.size(); ++v) {
      const Eigen::Vector3d p_mm = surface.mesh->vertices_mm[v].cast<double>();
      const Eigen::Vector2i q = pixel_of(camera, p_mm);
      if (q.x() < 0 || q.y() < 0 || q.x() >= width || q.y() >= height) continue;
      const Eigen::Vector3d ray = (p_mm - camera_mm).normalized();
      const double off_mm = n.dot(p_mm - at_mm) / n.dot(ray);
      off_px(q.x(), q.y()) = column_of(twin, p_mm) - column_of(twin, p_mm - off_mm * ray);
      ASSERT_FALSE(off_px(q.x(), q.y()) * static_cast<double>(said.moved_px[0](q.x(), q.y())) * off_mm < 0.0)
          << "the sign is that of a depth which is too large";
      const double light = static_cast<double>(said.shading(q.x(), q.y())) / std::sqrt(in_pixel.slope);
      if (q.x() % 7 != 0 || q.y() % 7 != 0 || std::isnan(light)) continue;
      const Eigen::Vector3d to_light = (light_mm - p_mm).normalized();
      const double caught =
          surface.mesh->vertex_normals[v].cast<double>().dot(to_light) / n.dot(to_light) - 1.0;
      const bool noisy = dark(q.cast<float>());
      shading[noisy] += std::pow(caught / light, 2);
      count[noisy] += 1.0;
    }
    for (int y = 7; y < height - 1; y += 7)
      for (int x = 7; x < width - 1; x += 7) {
        const double off = mean_over_pixel(off_px, x, y) / static_cast<double>(said.moved_px[0](x, y));
        if (std::isnan(off)) continue;
        const bool noisy = dark(Eigen::Vector2i(x, y).cast<float>());
        depth[noisy] += off * off, depths[noisy] += 1.0;
      }
  }
  for (const int noisy : {0, 1}) {
    std::printf("surface: %s pixels: variance over that said: depth %.3f, light %.3f (%.0f values)\n",
                noisy == 1 ? "noisy" : "quiet", depth[noisy] / depths[noisy], shading[noisy] / count[noisy],
                count[noisy]);
    EXPECT_GT(count[noisy], 7000.0);
    EXPECT_NEAR(depth[noisy] / depths[noisy], 1.0, 0.16);
    EXPECT_NEAR(shading[noisy] / count[noisy], 1.0, 0.16);
  }
}

// A second camera sees some vertices of a plane in each pixel, and takes the one next to its middle: the
// nearest would be one whose noise lies towards the camera, so that what smoothing has changed would not be 0
// on average.
TEST(Surface, AnotherCameraSeesVerticesAsTheyCome) {
  Twin twin = scaled_paper_rig(0.25);
  twin.cameras.push_back(twin.cameras[0]);
  twin.cameras[1].T_cam_world.translation_mm += Eigen::Vector3d(-40.0, 3.0, 0.0);
  const Eigen::Vector3d n = Eigen::Vector3d(0.2, -0.2, -1).normalized(), at_mm(0, 0, 260);
  const PointCloud plane = triangulate_projector(twin, 0, ideal_decode(twin, 0, plane_surface(at_mm, n)));
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, 1.0);
  constexpr double kNoise_mm = 0.05;
  NoiseInView other(twin, 1, 0);
  const Eigen::Vector3d camera_mm = twin.cameras[0].center_world_mm();
  for (const Eigen::Vector3d& p_mm : plane.p_world_mm) {
    const double off = normal(random);
    other.add({.p_mm = p_mm + kNoise_mm * off * (p_mm - camera_mm).normalized(),
               .normal = n,
               .depth_mm = kNoise_mm,
               .smoothed_depth_mm = {-kNoise_mm * off, kNoise_mm}});
  }
  const SurfaceNoiseInView seen = std::move(other).finish();
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < seen.smoothed_px[0].value.size(); i += 3) {  // a vertex is in up to four pixels
    if (std::isnan(seen.moved_px[0].data[i])) continue;
    sum += static_cast<double>(seen.smoothed_px[0].value.data[i]) /
           std::abs(static_cast<double>(seen.moved_px[0].data[i]));
    count += 1.0;
  }
  EXPECT_GT(count, 3000.0);
  EXPECT_NEAR(sum / count, 0.0, 4.5 * 2.0 / std::sqrt(count));  // two pixels may share a draw
}

TEST(Surface, DepthStepsStayOpenAndPinholesAreFilled) {
  const Twin twin = scaled_paper_rig(0.25);
  const RaySurface scene = nearest({sphere_surface({0, 0, 220}, 10), plane_surface({0, 0, 300}, {0, 0, -1})});
  PointCloud cloud = triangulate_projector(twin, 0, ideal_decode(twin, 0, scene));
  const std::size_t whole = cloud.size();
  // a pinhole in the wall
  std::size_t hole = 0;
  for (std::size_t i = 0; i < whole; ++i)
    if ((cloud.q_cam_px[i] - Eigen::Vector2f(100, 130)).norm() < 0.1f) hole = i;
  ASSERT_GT(hole, 0u);
  const Eigen::Vector3d lost = cloud.p_world_mm[hole];
  cloud.p_world_mm.erase(cloud.p_world_mm.begin() + static_cast<std::ptrdiff_t>(hole));
  cloud.q_cam_px.erase(cloud.q_cam_px.begin() + static_cast<std::ptrdiff_t>(hole));
  cloud.sigma_mm.erase(cloud.sigma_mm.begin() + static_cast<std::ptrdiff_t>(hole));
  const auto mesh = build_surface(twin, 0, cloud, MeasuredShape{.smoothing_px = 3.0}).mesh;
  for (const auto& t : mesh->triangles)
    for (int k = 0; k < 3; ++k)
      ASSERT_LT(std::abs(mesh->vertices_mm[t[k]].z() - mesh->vertices_mm[t[(k + 1) % 3]].z()), 6.0f);
  EXPECT_LT(std::abs(MeshDistance(*mesh).query(lost).signed_distance_mm), 1e-3);
}

// Pixels on the edge of a step are mixed and have no points: both surfaces go on into the gap, and meet there
// without being joined, though no more than a few pixels lie between them in depth.
TEST(Surface, AGapAtALowStepStaysOpen) {
  const Twin twin = scaled_paper_rig(0.25);
  constexpr double kStep = 4.0;  // mm; a pixel is 0.44 mm wide there, and a slope of six still one surface
  const RaySurface low = plane_surface({0, 0, 260}, {0, 0, -1}),
                   high = plane_surface({0, 0, 260 + kStep}, {0, 0, -1});
  const PointCloud left = triangulate_projector(twin, 0, ideal_decode(twin, 0, low)),
                   right = triangulate_projector(twin, 0, ideal_decode(twin, 0, high));
  PointCloud cloud;
  const float edge_px = 180.0F;
  const auto take = [&](const PointCloud& from, bool is_left) {
    for (std::size_t i = 0; i < from.size(); ++i) {
      const float x = from.q_cam_px[i].x();
      if (is_left ? x > edge_px : x < edge_px + 3.0F) continue;  // two columns without points
      cloud.p_world_mm.push_back(from.p_world_mm[i]);
      cloud.q_cam_px.push_back(from.q_cam_px[i]);
      cloud.sigma_mm.push_back(from.sigma_mm[i]);
    }
  };
  take(left, true), take(right, false);
  const auto mesh = build_surface(twin, 0, cloud, MeasuredShape{.smoothing_px = 3.0}).mesh;
  for (const auto& t : mesh->triangles)
    for (int k = 0; k < 3; ++k)
      ASSERT_LT(std::abs(mesh->vertices_mm[t[k]].z() - mesh->vertices_mm[t[(k + 1) % 3]].z()), 0.5 * kStep);
}

TEST(Surface, NothingToBuildFrom) {
  const Twin twin = scaled_paper_rig(0.1);
  EXPECT_THROW(build_surface(twin, 0, {}, MeasuredShape{.smoothing_px = 3.0}), UserError);
  PointCloud one;
  one.p_world_mm = {{0, 0, 250}};
  one.q_cam_px = {{70, 50}};
  EXPECT_THROW(build_surface(twin, 0, one, MeasuredShape{.smoothing_px = 3.0}), UserError);
  EXPECT_THROW(build_surface(twin, 0, one, MeasuredShape{.smoothing_px = -1.0}), UserError);
}

}  // namespace
}  // namespace fringetwin::measure::surface_test
