// SPDX-License-Identifier: Apache-2.0
#include "cosim/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "cosim/load.hpp"
#include "cosim/other_noise.hpp"
#include "render/sensor/all_cameras.hpp"
#include "render/sensor/sensor.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cosim {
namespace {

Sampler sampler_of(const std::string& name) {
  for (const Sampler s : {Sampler::adaptive, Sampler::gauss, Sampler::multi_jittered, Sampler::sobol})
    if (name == render::sampler_name(s)) return s;
  throw UserError(ExitCode::usage, "sampler \"" + name + "\"", "is not known",
                  "use adaptive, gauss, multi-jittered or sobol");
}

template <class Number>
void check_range(const char* what, const std::optional<Number>& asked, Number min, Number max) {
  if (asked && !(*asked >= min && *asked <= max))
    throw UserError(ExitCode::usage, what, fmt::format("must be {} ... {}, is {}", min, max, *asked));
}

constexpr const char* kForLess =
    " (an upper bound, which a comparison's budget counts); for less of it give more --samples";

/// Warns where the estimated error is above twice its target: the estimate is an upper bound, so that a
/// smaller excess does not mean that the target was missed.
void warn_of_missed_targets(const compare::RenderNote& note, const render::Sampling& asked) {
  if (note.phase_error_rad.value_or(0.0) > 2.0 * asked.phase_error_rad)
    warn(fmt::format(
        "camera \"{}\": the phase error is estimated at {:.1e} rad, above phase_error_rad = {:.1e}{}",
        note.camera, *note.phase_error_rad, asked.phase_error_rad, kForLess));
  if (note.gray_error.value_or(0.0) > 2.0 * asked.gray_error)
    warn(fmt::format(
        "camera \"{}\": the gray error is estimated at {:.1e} of full scale, above gray_error = {:.1e}{}",
        note.camera, *note.gray_error, asked.gray_error, kForLess));
}

/// Throws UserError(usage) when no camera sees any object; warns for each object that no camera sees.
void check_view(const Twin& twin, const std::vector<render::KeptCamera>& kept) {
  std::vector<bool> seen(twin.objects.size(), false);
  for (const render::KeptCamera& camera : kept)
    for (const int object : camera.rendered.object.data)
      if (object >= 0) seen[object] = true;
  if (std::ranges::none_of(seen, [](bool s) { return s; }))
    throw UserError(
        ExitCode::usage, twin.file.string(), "no camera sees any object",
        "check the objects' positions (mm, world = first camera unless rt_cam_world says otherwise)");
  for (std::size_t k = 0; k < seen.size(); ++k)
    if (!seen[k]) warn("object \"" + twin.objects[k].name + "\" is outside the view of every camera");
}

}  // namespace

compare::RenderNote note_of(const render::RenderedCamera& rendered) {
  compare::RenderNote note;
  note.camera = rendered.camera;
  note.sampler = render::sampler_name(rendered.sampling.sampler);
  if (rendered.sampling.sampler != Sampler::adaptive) note.samples = rendered.sampling.samples;
  note.double_precision = rendered.sampling.precise;
  note.rays_per_pixel = static_cast<double>(rendered.rays) / static_cast<double>(rendered.object.size());
  if (rendered.estimate) {
    note.phase_error_rad = rendered.estimate->phase_rad;
    note.gray_error = rendered.estimate->gray;
    note.gray_inside_error = rendered.estimate->gray_inside;
  }
  return note;
}

RenderOptions render_options(const Twin& twin, const RenderRequest& request) {
  check_range("samples", request.samples, 1, 65536);
  check_range("phase error", request.phase_error_rad, 1e-8, 1.0);
  check_range("gray error", request.gray_error, 1e-8, 1.0);
  RenderOptions options = twin.render;
  if (request.phase_error_rad || request.gray_error) {
    options.phase_error_rad = request.phase_error_rad.value_or(options.phase_error_rad);
    options.gray_error = request.gray_error.value_or(options.gray_error);
    // A target that is asked for replaces a scheme fixed in the file.
    options.samples.reset();
    options.sampler.reset();
  }
  if (request.samples) options.samples = request.samples;
  if (request.sampler) options.sampler = sampler_of(*request.sampler);
  return options;
}

Simulated simulate(const Twin& twin, const RenderRequest& request, render::Renderer& renderer) {
  check_renderable(twin);
  const render::Sampling sampling = render::choose_sampling(twin, render_options(twin, request));
  Simulated out;
  out.rendering.device = renderer.device().name;
  const std::uint64_t seed = request.seed.value_or(kDefaultSeed);
  out.rendering.seed = seed;
  Progress progress("render", twin.cameras.size());
  std::vector<render::KeptCamera> kept;
  for (std::size_t c = 0; c < twin.cameras.size(); ++c) {
    throw_if_cancelled();
    kept.push_back(renderer.render_kept(twin, c, sampling, seed));
    progress.advance();
  }
  for (const render::KeptCamera& camera : kept) {
    out.rendering.notes.push_back(note_of(camera.rendered));
    warn_of_missed_targets(out.rendering.notes.back(), sampling);
  }
  check_view(twin, kept);
  for (std::size_t c = 0; c < kept.size(); ++c) {
    throw_if_cancelled();
    out.captures.push_back(render::expose(kept[c], twin.cameras[c], c, seed));
    out.irradiance.push_back(render::as_radiance(std::move(kept[c])));
  }
  return out;
}

}  // namespace fringetwin::cosim
