// SPDX-License-Identifier: Apache-2.0
#include "measure/points/points_ply.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "measure/decode/phase_exr.hpp"

namespace fringetwin::measure {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

/// Returns one number of each of these points.
template <class T, class Number>
std::vector<T> column(const std::vector<std::size_t>& index, const Number& number) {
  std::vector<T> values;
  values.reserve(index.size());
  for (const std::size_t i : index) values.push_back(number(i));
  return values;
}

/// Returns an image's value at the pixel that a point comes from.
float at_pixel(const ImageF& image, const Eigen::Vector2f& q_px) {
  const long x = std::lround(q_px.x()), y = std::lround(q_px.y());
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return kUnknown;
  return image(static_cast<int>(x), static_cast<int>(y));
}

}  // namespace

PlyVertices ply_of_points(const PointCloud& cloud, const std::vector<std::size_t>& index) {
  PlyVertices ply(index.size());
  const char* axes[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k)
    ply.add(axes[k], column<double>(index, [&](std::size_t i) { return cloud.p_world_mm[i][k]; }));
  for (int k = 0; k < 3; ++k)
    ply.add(std::string("n") + axes[k], column<float>(index, [&](std::size_t i) {
              return cloud.normal_world.empty() ? kUnknown : cloud.normal_world[i][k];
            }));
  ply.add(kScalarField + std::string("sigma_mm"), column<float>(index, [&](std::size_t i) {
            return cloud.sigma_mm.empty() ? kUnknown : cloud.sigma_mm[i];
          }));
  return ply;
}

void write_points_ply(const std::filesystem::path& file, const PointCloud& cloud,
                      const CameraDecode* first_camera) {
  std::vector<std::size_t> all(cloud.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  PlyVertices ply = ply_of_points(cloud, all);
  ply.add(kScalarField + std::string("pixel_x"),
          column<float>(all, [&](std::size_t i) { return cloud.q_cam_px[i].x(); }));
  ply.add(kScalarField + std::string("pixel_y"),
          column<float>(all, [&](std::size_t i) { return cloud.q_cam_px[i].y(); }));
  if (first_camera)
    for (const auto& [name, image] : phase_channels(*first_camera)) {
      if (name.starts_with("wrapped_")) continue;
      const auto value = [&cloud, &channel = image](std::size_t i) {
        return at_pixel(channel, cloud.q_cam_px[i]);
      };
      ply.add(kScalarField + name, column<float>(all, value));
    }
  ply.write(file, "unit mm, world frame; pixel (0,0) is a pixel centre");
}

}  // namespace fringetwin::measure
