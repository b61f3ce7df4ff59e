// SPDX-License-Identifier: Apache-2.0
// Simulates a capture: a twin goes in, the images that its cameras would record come out, before the sensor
// (irradiance) and after it (gray values). They are the simulated side of every comparison.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/result/provenance.hpp"
#include "render/renderer.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cosim {

/// What a run asks of the rendering; whatever it leaves open, the twin's own [render] says.
struct RenderRequest {
  std::optional<int> samples;
  std::optional<std::string> sampler;  ///< adaptive | gauss | multi-jittered | sobol
  std::optional<double> phase_error_rad, gray_error;
  std::optional<std::uint64_t> seed;  ///< none: kDefaultSeed (other_noise.hpp), or what choose_seed() says
  std::string device;                 ///< a part of its name; empty = the default
};

/// Returns the twin's own options of rendering with those of the request in their place. Throws
/// UserError(usage) for an unknown sampler, and for numbers that the keys of [render] may not have.
RenderOptions render_options(const Twin& twin, const RenderRequest& request);

/// What rendered the simulated images, and how exact they are.
struct Rendering {
  std::string device = {};
  std::uint64_t seed = 0;
  std::vector<compare::RenderNote> notes = {};  ///< order of twin.cameras
};

/// Returns what the result records of a camera's rendering: sampler, samples, precision, estimated errors.
compare::RenderNote note_of(const render::RenderedCamera& rendered);

/// The images of the simulated cameras, before and after the sensor; order of twin.cameras.
struct Simulated {
  std::vector<CameraImages> captures;    ///< DN
  std::vector<CameraImages> irradiance;  ///< E
  Rendering rendering;
};

/// Renders and exposes all cameras. Throws UserError(usage) when no camera sees any object; warns
/// for an object that no camera sees, and where the renderer's error is estimated above what was asked for.
Simulated simulate(const Twin& twin, const RenderRequest& request, render::Renderer& renderer);

}  // namespace fringetwin::cosim
