// SPDX-License-Identifier: Apache-2.0
// Reads the header of an EXR file, attribute by attribute, before OpenEXR does: OpenEXR believes each size in
// it, and takes the memory at once.
#pragma once
#include <cstdint>
#include <filesystem>

#include "twin/image/image_limits.hpp"

namespace fringetwin {

/// Returns size and number of channels of a flat EXR with one part. Throws UserError(input) where it is
/// none that is read: cut off, deep, of several parts, cropped, subsampled, without channels, or tiled in
/// tiles that take more memory than its pixels.
PromisedImage read_exr_header(const std::filesystem::path& file);

}  // namespace fringetwin
