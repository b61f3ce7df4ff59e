// SPDX-License-Identifier: Apache-2.0
#include "twin/shape/mesh_shape.hpp"

namespace fringetwin {

std::vector<Motion<MeshShape>> motions(const MeshShape& shape) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  if (shape.mesh && !shape.mesh->vertices_mm.empty()) {
    for (const auto& p : shape.mesh->vertices_mm) middle += p.cast<double>();
    middle /= static_cast<double>(shape.mesh->vertices_mm.size());
  }
  const Eigen::Vector3d about = shape.T_world_object * middle;
  std::vector<Motion<MeshShape>> out;
  for (int i = 0; i < 3; ++i)
    out.push_back({std::string("shift_mm.") + "xyz"[i], "mm", 0.0,
                   [i](MeshShape& s, double d) { s.T_world_object.translation_mm[i] += d; }});
  for (int i = 0; i < 3; ++i)
    out.push_back({std::string("turn_rad.") + "xyz"[i], "rad", 0.0, [i, about](MeshShape& s, double d) {
                     s.T_world_object = turned(s.T_world_object, Eigen::Vector3d::Unit(i), d, about);
                   }});
  return out;
}

std::vector<PlaceKey> place_keys(const MeshShape& shape) {
  const RotTrans rt = rt_from_pose(shape.T_world_object);
  return {{"rt_world_object", {rt.begin(), rt.end()}}};
}

}  // namespace fringetwin
