// SPDX-License-Identifier: Apache-2.0
// Reads what a run works on: the twin, checked before any work, and the captures of its cameras.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cosim {

/// Reads the twin and its meshes. It also refuses names in [limits] that no comparison has, and fringes that
/// a measurement could not unwrap over the projector's image, before anything is rendered. `settings`: values
/// in the place of some keys, as load_twin() takes them.
Twin load_for_run(const std::filesystem::path& file, const std::map<std::string, std::string>& settings = {});

/// Throws UserError(usage) for a twin without a projector or objects, which nothing can be rendered of.
void check_renderable(const Twin& twin);

/// The images of a capture folder.
struct Captures {
  std::vector<CameraImages> cameras;                ///< order of twin.cameras
  std::vector<std::filesystem::path> files;         ///< files_of() the folder's capture.toml
  std::optional<std::uint64_t> rendered_seed = {};  ///< seed_of_rendered() (cosim/other_noise.hpp)
};
Captures load_captures(const Twin& twin, const std::filesystem::path& dir);

/// Reads a twin with everything a renderer needs: its meshes, and measured shapes built from the captures
/// that [real] names. `settings`: as load_for_run() takes them.
Twin load_renderable_twin(const std::filesystem::path& file,
                          const std::map<std::string, std::string>& settings = {});

}  // namespace fringetwin::cosim
