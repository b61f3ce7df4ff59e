// SPDX-License-Identifier: Apache-2.0
// A number for each pixel of a camera's sensor: what its pixels have of their own (docs/PHYSICS.md, "Pixels
// of the sensor").
#pragma once
#include <filesystem>
#include <memory>
#include <string>

#include "twin/image/image.hpp"

namespace fringetwin {

/// A map of a sensor; nothing where the twin names no file.
struct PixelMap {
  std::filesystem::path file = {};                 ///< an EXR of one channel; empty: none
  std::shared_ptr<const ImageF> values = nullptr;  ///< filled by load_meshes()
  bool given() const { return values != nullptr || !file.empty(); }
};

/// The camera that a map is of, for its size and for the words of a refusal.
struct MappedCamera {
  std::string name;
  int width = 0, height = 0;
};

/// Reads factors of pixels (`prnu`): finite, above 0, their mean within 1 % of 1. Throws UserError(usage)
/// that names key and file.
std::shared_ptr<const ImageF> read_pixel_factors(const std::filesystem::path& file,
                                                 const MappedCamera& camera);
/// Reads offsets of pixels (`dsnu`), DN: finite, no larger than full scale. Throws likewise.
std::shared_ptr<const ImageF> read_pixel_offsets(const std::filesystem::path& file,
                                                 const MappedCamera& camera, double full_scale_dn);

}  // namespace fringetwin
