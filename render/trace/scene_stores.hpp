// SPDX-License-Identifier: Apache-2.0
// Keeps everything on the host that serves a renderer from one trace to the next, because it is dear to make
// and depends only on the lens or the mesh.
#pragma once
#include "render/scene/mesh_geometry.hpp"
#include "render/scene/shortcuts.hpp"
#include "render/trace/lens_table.hpp"

namespace fringetwin::render {

struct SceneStores {
  LensTableStore lenses;
  MeshStore meshes;
  VisibilityStore visibility;
};

}  // namespace fringetwin::render
