// SPDX-License-Identifier: Apache-2.0
// Holds what a run has loaded, rendered and measured: a twin and the two sides of a comparison.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/result/options.hpp"
#include "compare/result/side.hpp"
#include "cosim/simulate.hpp"
#include "measure/points/points.hpp"
#include "render/renderer.hpp"
#include "twin/base/stopwatch.hpp"
#include "twin/merge/toml_block.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cosim {

struct Run {
  Twin twin;  ///< ready to be rendered; refined where that was asked for
  compare::Side real, simulated;
  std::optional<Twin> as_written;   ///< with its measured shapes still to be built; where images are held out
  compare::CompareOptions options;  ///< for compare::compare() on these sides
  std::vector<std::filesystem::path> capture_files;  ///< read besides those of the twin
  std::optional<std::uint64_t> real_seed;            ///< of the real images, where they were rendered
  Rendering rendering;                               ///< of the simulated side; without a device: none
  measure::PointCloud noise_free;                    ///< measure::noise_free_points() of the simulated side
  std::unique_ptr<render::Renderer> renderer;        ///< that options.renderer points to
  std::string refined_toml;               ///< the text of refined.toml; empty when nothing was refined
  std::vector<TomlBlock> refined_blocks;  ///< the same for a twin.toml that is there
  StageTimer timer;
};

}  // namespace fringetwin::cosim
