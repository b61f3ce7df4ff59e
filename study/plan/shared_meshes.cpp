// SPDX-License-Identifier: Apache-2.0
#include "study/plan/shared_meshes.hpp"

namespace fringetwin::study {

void load_meshes(Twin* twin, const Twin* known) {
  for (Object& object : twin->objects) {
    auto* mesh = std::get_if<MeshShape>(&object.shape);
    if (known == nullptr || !mesh || mesh->mesh) continue;
    for (const Object& other : known->objects)
      if (const auto* read = std::get_if<MeshShape>(&other.shape);
          read && read->file == mesh->file && read->unit == mesh->unit)
        mesh->mesh = read->mesh;
  }
  fringetwin::load_meshes(*twin);
}

}  // namespace fringetwin::study
