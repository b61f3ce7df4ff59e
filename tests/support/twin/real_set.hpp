// SPDX-License-Identifier: Apache-2.0
// Loads a data set of datasets/ with its real images. For *_test.cpp only.
#pragma once
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "twin/base/paths.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing {

struct RealSet {
  Twin twin;
  std::vector<CameraImages> images;  ///< order of twin.cameras
};

/// nullopt where the captures are not on this machine.
inline std::optional<RealSet> load_real_set(const std::string& name) {
  const char* source = std::getenv("FRINGETWIN_SOURCE");
  const std::filesystem::path toml =
      std::filesystem::path(source != nullptr ? source : ".") / "datasets" / name / "twin.toml";
  if (!std::filesystem::exists(captures_root() / name) || !std::filesystem::exists(toml)) return std::nullopt;
  RealSet set{load_twin(toml), {}};
  const CaptureSet captures =
      read_capture_set(*set.twin.real.captures, static_cast<int>(expand_sequence(set.twin.fringes).size()));
  for (const Camera& camera : set.twin.cameras)
    set.images.push_back(load_camera_images(captures, camera, set.twin.fringes));
  return set;
}

}  // namespace fringetwin::testing
