// SPDX-License-Identifier: Apache-2.0
// Gives the pixels of a refined twin the numbers of their own that a refinement asked for: real and simulated
// images go in, the twin's textures come out (docs/metrics/causes.md, "Refinement").
#pragma once
#include <vector>

#include "compare/result/refined.hpp"
#include "compare/result/side.hpp"

namespace fringetwin::compare {

inline constexpr const char* kTextureSpread = "texture_spread";  ///< as --refine has it

/// Takes the textures away that apply_texture() will tell anew in whole, so that the twin is rendered without
/// them: what changes within a pixel is told by the light before any texture.
void drop_texture_told_anew(const Refinement& refinement, Twin& twin);

/// Gives every camera of the refined twin the factor and the offset of each pixel, of those that "texture"
/// and "offset" asked for, that bring the irradiance of that twin closest to the real gray values of `images`
/// (sequence indices), and the irradiance the same. A texture that a camera has already is part of the new
/// one. With "texture_spread" the cameras' texture_spread_px is fitted besides (texture_spread.hpp) and has a
/// row in the refinement; where the images do not tell it, it stays, with a note. Nothing without.
void apply_texture(Refinement& refinement, const std::vector<CameraImages>& real,
                   const std::vector<int>& images, Twin& twin, std::vector<CameraImages>& irradiance);

}  // namespace fringetwin::compare
