// SPDX-License-Identifier: Apache-2.0
#include "measure/measured_npz.hpp"

#include <algorithm>
#include <memory>

#include "measure/decode/phase_exr.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/npz_file.hpp"

namespace fringetwin::measure {
namespace {

/// Names the numbers of all points, each a row; nothing where they are not known.
template <class Number, class Row>
void add_rows(const std::string& name, const std::vector<Row>& rows, std::size_t n_points,
              std::vector<NpzArray>& arrays) {
  constexpr std::size_t kColumns = sizeof(Row) / sizeof(Number);
  if (rows.size() != n_points) return;
  std::vector<std::size_t> shape = {n_points};
  if constexpr (kColumns > 1) shape.push_back(kColumns);
  const auto* first = reinterpret_cast<const Number*>(rows.data());
  arrays.push_back(npz_array<Number>(name, std::move(shape), {first, n_points * kColumns}));
}

void add_points(const PointCloud& cloud, std::vector<NpzArray>& arrays) {
  add_rows<double>("p_world_mm", cloud.p_world_mm, cloud.size(), arrays);
  add_rows<float>("normal_world", cloud.normal_world, cloud.size(), arrays);
  add_rows<float>("q_cam_px", cloud.q_cam_px, cloud.size(), arrays);
  add_rows<float>("sigma_mm", cloud.sigma_mm, cloud.size(), arrays);
}

}  // namespace

std::string measured_npz_name(const std::string& camera) { return "measured_" + camera + ".npz"; }

void write_measured_npz(const std::filesystem::path& dir, const Measurement& measurement) {
  for (const CameraDecode& camera : measurement.cameras) {
    throw_if_cancelled();
    const auto channels = phase_channels(camera);
    std::vector<NpzArray> arrays;
    for (const auto& [name, image] : channels) arrays.push_back(npz_array(name, image));
    arrays.push_back(npz_array("flags", camera.flags));
    const auto mask = std::make_unique<bool[]>(camera.flags.size());
    std::ranges::transform(camera.flags.data, mask.get(),
                           [](unsigned char flags) { return flags == kValid; });
    arrays.push_back(
        npz_array("mask", arrays.back().shape, std::span<const bool>(mask.get(), camera.flags.size())));
    if (&camera == &measurement.cameras.front()) add_points(measurement.cloud, arrays);
    write_npz(dir / measured_npz_name(camera.camera), arrays);
  }
}

}  // namespace fringetwin::measure
