// SPDX-License-Identifier: Apache-2.0
// Packs a twin's objects, as one camera sees them, for the shaders.
#pragma once
#include "render/scene/mesh_geometry.hpp"
#include "render/scene/scene.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Transforms the objects in double precision into the camera's frame and packs them; `store` keeps the
/// meshes' geometries, to which the scene points. Throws UserError(usage) when the camera is inside an
/// object, a mesh is not loaded, or a measured shape was not replaced.
PackedScene pack_scene(const Twin& twin, const Camera& camera, MeshStore& store);

/// Returns the radius of a thin lens, 0 without depth of field.
double lens_radius_mm(const std::optional<Optics>& optics);

}  // namespace fringetwin::render
