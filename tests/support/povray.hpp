// SPDX-License-Identifier: Apache-2.0
// Renders a twin's images by another program, POV-Ray 3.7 (Debian package povray). Spheres and infinite
// planes, the fringe as a function of space, a light at the projector's centre. Nothing of our renderer is in
// them.
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::testing {

/// POV-Ray's own supersampling (+AM1 -J +A0.0, n x n) is the n x n regular samples AND the pixel's centre,
/// all of one weight: it exaggerates contrast by about 1/n^2 of what the pixel takes away (0.06 % of the gain
/// and 0.7 DN of a 12-bit black level at n = 8). So the pixel is divided into cells x cells, each with 2 x 2
/// Gauss points, each point a ray of an image of its own without supersampling, and averaged here.
struct PovraySampling {
  int cells = 4;                              ///< 4 cells^2 rays a pixel; error of smooth shading ~ 1/cells^4
  std::optional<int> own_supersampling = {};  ///< instead: POV-Ray's n x n as above, 1 = none
  int processes = 0;  ///< at a time; 0 = two for each core: half of a run of a second is waiting
  int threads = 1;    ///< of each
};

/// E of the whole sequence, camera `camera`. nullopt where POV-Ray cannot be started. Pinhole cameras, a
/// projector with at most k1 k2 p1 p2 k3, linear or gamma response, blur_px, diffuse materials; the
/// projector's image must cover what the camera sees. `scratch` is an existing folder.
std::optional<std::vector<ImageF>> povray_irradiance(const Twin& twin, std::size_t camera,
                                                     const PovraySampling& sampling,
                                                     const std::filesystem::path& scratch);

/// The scene for image `pattern` of the sequence, its pixel grid moved by (dx, dy) px.
std::string povray_scene(const Twin& twin, std::size_t camera, const PatternSpec& pattern, double dx_px,
                         double dy_px);

}  // namespace fringetwin::testing
