// SPDX-License-Identifier: Apache-2.0
#include "measure/points/points_ply.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "measure/decode/phase_exr.hpp"

namespace fringetwin::measure {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

/// Returns the index of an image's pixel that a point comes from; its size outside the image.
std::size_t pixel_of(const CameraDecode& camera, const Eigen::Vector2f& q_px) {
  const long x = std::lround(q_px.x()), y = std::lround(q_px.y());
  if (x < 0 || y < 0 || x >= camera.width() || y >= camera.height()) return camera.flags.size();
  return camera.flags.index(static_cast<int>(x), static_cast<int>(y));
}

/// `number(k)`: the point of vertex k.
template <class Number>
PlyVertices ply_of(const PointCloud& cloud, std::size_t n, const Number& number) {
  PlyVertices ply(n);
  const char* axes[] = {"x", "y", "z"};
  for (int c = 0; c < 3; ++c)
    ply.add_double(axes[c], [&cloud, number, c](std::size_t k) { return cloud.p_world_mm[number(k)][c]; });
  for (int c = 0; c < 3; ++c)
    ply.add_float(std::string("n") + axes[c], [&cloud, number, c](std::size_t k) {
      return cloud.normal_world.empty() ? kUnknown : cloud.normal_world[number(k)][c];
    });
  ply.add_float(kScalarField + std::string("sigma_mm"), [&cloud, number](std::size_t k) {
    return cloud.sigma_mm.empty() ? kUnknown : cloud.sigma_mm[number(k)];
  });
  return ply;
}

}  // namespace

PlyVertices ply_of_points(const PointCloud& cloud, const std::vector<std::size_t>& index) {
  return ply_of(cloud, index.size(), [&index](std::size_t k) { return index[k]; });
}

PlyVertices ply_of_points(const PointCloud& cloud) {
  return ply_of(cloud, cloud.size(), [](std::size_t k) { return k; });
}

void write_points_ply(const std::filesystem::path& file, const PointCloud& cloud,
                      const CameraDecode* first_camera) {
  PlyVertices ply = ply_of_points(cloud);
  ply.add_float(kScalarField + std::string("pixel_x"),
                [&cloud](std::size_t i) { return cloud.q_cam_px[i].x(); });
  ply.add_float(kScalarField + std::string("pixel_y"),
                [&cloud](std::size_t i) { return cloud.q_cam_px[i].y(); });
  if (first_camera)
    for (PhaseChannel& channel : phase_channel_values(*first_camera)) {
      if (channel.name.starts_with("wrapped_")) continue;
      ply.add_float(kScalarField + channel.name,
                    [&cloud, camera = first_camera, at = std::move(channel.at)](std::size_t i) {
                      const std::size_t pixel = pixel_of(*camera, cloud.q_cam_px[i]);
                      return pixel < camera->flags.size() ? at(pixel) : kUnknown;
                    });
    }
  ply.write(file, "unit mm, world frame; pixel (0,0) is a pixel centre");
}

}  // namespace fringetwin::measure
