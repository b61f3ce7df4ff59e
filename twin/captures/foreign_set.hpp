// SPDX-License-Identifier: Apache-2.0
// Describes images that another program recorded as a capture set (docs/formats/captures.md) where they lie,
// without copying them.
#pragma once
#include "twin/captures/capture_set.hpp"

namespace fringetwin {

/// Throws UserError(input) with the labels of the sequence when a camera has another number of images, and as
/// load_camera_images() does. `camera.pattern` is how the user named the images.
void check_foreign_set(const CaptureSet& set, const Twin& twin);

/// Writes set.file, sealed (twin/base/seal.hpp): the channel, the images one by one, relative to the file,
/// `provenance` and the SHA-256 of each image.
void write_foreign_set(const CaptureSet& set);

}  // namespace fringetwin
