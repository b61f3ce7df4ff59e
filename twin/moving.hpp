// SPDX-License-Identifier: Apache-2.0
// Objects that move at constant speed while the images of a sequence are taken (Object::motion).
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin {

/// Returns whether an object of the twin moves while the images are taken.
bool has_motion(const Twin& twin);

/// Returns the twin as it is when image `image` of a sequence of `n_images` is taken, its objects at rest:
/// each has gone by (image/(n_images - 1) - 1/2) of its motion from its place in the twin, which is that of
/// the middle of the sequence. A fraction of an image is a time between two of them.
Twin twin_at_image(const Twin& twin, double image, std::size_t n_images);

/// A key of `motion` in twin.toml, and which of the shape's motions() its numbers are, in their order:
/// "center_mm" of "center_mm.x", "center_mm.y", "center_mm.z".
struct MotionKey {
  std::string key;
  std::vector<std::size_t> at;
};
std::vector<MotionKey> motion_keys(const Shape& shape);

/// Returns the motion in the words of twin.toml: "{ center_mm = [0.05, 0, 0] }"; "{}" at rest.
std::string motion_text(const Object& object);

}  // namespace fringetwin
