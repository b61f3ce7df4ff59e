// SPDX-License-Identifier: Apache-2.0
// Renders a twin with every camera, and exposes every camera's sensor to what was rendered.
#pragma once
#include <cstdint>
#include <vector>

#include "render/renderer.hpp"
#include "twin/base/progress.hpp"
#include "twin/captures/capture_set.hpp"

namespace fringetwin::render {

/// Renders all cameras, in their order; `progress` advances by one each. Throws Cancelled between them.
std::vector<RenderedCamera> render_all(Renderer& renderer, const Twin& twin, const Sampling& sampling,
                                       std::uint64_t seed, Progress* progress = nullptr);
/// Does the same with the sampling that the twin itself asks for.
std::vector<RenderedCamera> render_all(Renderer& renderer, const Twin& twin, std::uint64_t seed);

/// Returns the gray values that the twin's cameras record of their rendered images. Throws Cancelled between
/// the cameras.
std::vector<CameraImages> expose_all(const std::vector<RenderedCamera>& rendered, const Twin& twin,
                                     std::uint64_t seed);

}  // namespace fringetwin::render
