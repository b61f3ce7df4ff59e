// SPDX-License-Identifier: Apache-2.0
// Describes the work of one trace of a camera: what all its steps read, and the transport that they fill.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "render/base/renderer_tuning.hpp"
#include "render/base/transport.hpp"
#include "render/pattern/formed_harmonics.hpp"
#include "render/scene/scene.hpp"
#include "render/scene/shortcuts.hpp"
#include "render/trace/lens_table.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

struct ProjectorSetup;

/// How the shaders find the cell of a place (shaders/cells.glsl).
struct CellLookup {
  Eigen::Vector3f middle_mm;  ///< of the grid, camera frame
  float per_mm;
  std::uint32_t table_mask;
};

struct TraceJob {
  const Twin& twin;
  const Camera& camera;
  const PackedScene& scene;
  const LensTable& lens;
  const ProjectorSetup& projector;
  const std::vector<std::uint32_t>& blocks;  ///< active_blocks()
  const Shortcuts& shortcuts;
  const RendererTuning& tuning;
  std::uint64_t seed;
  Transport* out;
  const HarmonicsPlan& harmonics;
  Eigen::Vector2d look_px = Eigen::Vector2d::Zero();  ///< Params::look
  std::optional<CellLookup> cells = std::nullopt;     ///< of light over two surfaces and more
  std::uint32_t mirrors = 0;  ///< places of shiny surfaces that the device has (indirect/mirror_places.hpp)
};

}  // namespace fringetwin::render
