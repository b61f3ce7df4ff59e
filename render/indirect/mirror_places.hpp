// SPDX-License-Identifier: Apache-2.0
// Chooses places of surfaces that mirror the projector's light, from which the ways of mirrored light to
// other places are looked for (shaders/mirror_ways.comp). Internal to render/ (includes volk).
#pragma once
#include <cstdint>
#include <vector>

#include "render/indirect/gatherer.hpp"

namespace fringetwin::render {

/// Uploads some hundred places of shiny surfaces, of what the camera sees and of what that meets, and returns
/// how many: none where all lobes are so wide that directions over the hemisphere meet them. `seen`: what the
/// camera sees; the scene must have been uploaded.
std::uint32_t upload_mirrors(TraceDevice& device, const TraceJob& job, const std::vector<SurfacePlace>& seen);

}  // namespace fringetwin::render
