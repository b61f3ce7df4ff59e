// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "measure/points/points.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::measure {
namespace {

static_assert(std::endian::native == std::endian::little, "the PLY is written as it lies in memory");

constexpr std::size_t kRecord = 3 * sizeof(double) + 6 * sizeof(float);

std::string header(std::size_t n) {
  return "ply\nformat binary_little_endian 1.0\ncomment unit mm, world frame; pixel (0,0) is a pixel centre\n"
         "element vertex " +
         std::to_string(n) +
         "\nproperty double x\nproperty double y\nproperty double z\n"
         "property float nx\nproperty float ny\nproperty float nz\n"
         "property float pixel_x\nproperty float pixel_y\nproperty float sigma_mm\nend_header\n";
}

}  // namespace

void write_points_ply(const std::filesystem::path& file, const PointCloud& cloud) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<char> bytes(cloud.size() * kRecord);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f n =
        cloud.normal_world.empty() ? Eigen::Vector3f::Constant(nan) : cloud.normal_world[i];
    Eigen::Matrix<float, 6, 1> rest;
    rest << n, cloud.q_cam_px[i], cloud.sigma_mm.empty() ? nan : cloud.sigma_mm[i];
    std::memcpy(&bytes[i * kRecord], cloud.p_world_mm[i].data(), 3 * sizeof(double));
    std::memcpy(&bytes[i * kRecord + 3 * sizeof(double)], rest.data(), 6 * sizeof(float));
  }
  const std::string head = header(cloud.size());
  write_whole_file(file, {std::as_bytes(std::span(head)), std::as_bytes(std::span(bytes))});
}

}  // namespace fringetwin::measure
