// SPDX-License-Identifier: Apache-2.0
// Says where a result comes from: command, version, input files, renderer and seed, enough to make it again.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fringetwin::compare {

/// How one camera's images were rendered, and how exact the renderer believes them to be.
struct RenderNote {
  std::string camera;
  std::string sampler;         ///< as in twin.toml
  std::optional<int> samples;  ///< per pixel; empty for "adaptive"
  bool double_precision = false;
  double rays_per_pixel = 0.0;  ///< primary and shadow rays over all pixels
  /// Estimated rms errors, of "adaptive" only: phase at the finest pitch without the pixels an edge crosses;
  /// gray over all pixels of the objects, fraction of full scale.
  std::optional<double> phase_error_rad, gray_error;
  std::optional<double> gray_inside_error;  ///< as gray_error, without the pixels an edge crosses
  std::string text() const;                 ///< "adaptive, 2.7 rays per pixel, error estimated ..."
};

/// What a result says of the run that made it.
struct Provenance {
  std::vector<std::string> argv;  ///< the command as typed
  std::string version;
  std::map<std::string, std::string> inputs_sha256;  ///< every file read (sha256_of_files())
  std::string device;                                ///< of the renderer; empty = nothing was rendered
  std::vector<RenderNote> rendered;                  ///< one per camera rendered in this run
  std::uint64_t seed = 0;
};

/// Returns path as given -> SHA-256 (twin/base/sha256.hpp), each file once. Throws UserError(input) when one
/// cannot be read.
std::map<std::string, std::string> sha256_of_files(const std::vector<std::filesystem::path>& files);

}  // namespace fringetwin::compare
