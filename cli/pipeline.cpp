// SPDX-License-Identifier: Apache-2.0
#include "cli/pipeline.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "measure/surface.hpp"
#include "render/sensor/sensor.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"
#include "twin/captures/measured_steps.hpp"

namespace fringetwin::cli {

void StageTimer::start(const std::string& stage) {
  stop();
  stage_ = stage;
  begin_ = std::chrono::steady_clock::now();
}

void StageTimer::stop() {
  if (stage_.empty()) return;
  seconds[stage_] += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  stage_.clear();
}

void apply_flags(const RenderFlags& flags, RenderOptions& options) {
  if (flags.phase_error_rad || flags.gray_error) {
    options.phase_error_rad = flags.phase_error_rad.value_or(options.phase_error_rad);
    options.gray_error = flags.gray_error.value_or(options.gray_error);
    // A target on the command line replaces a scheme fixed in the file.
    options.samples.reset();
    options.sampler.reset();
  }
  if (flags.samples) options.samples = flags.samples;
  if (flags.sampler) {
    for (const Sampler s : {Sampler::adaptive, Sampler::gauss, Sampler::multi_jittered, Sampler::sobol})
      if (*flags.sampler == render::sampler_name(s)) options.sampler = s;
  }
}

Twin load_for_run(const std::filesystem::path& file) {
  Twin twin = load_twin(file);
  measure::check_fringes(twin);
  load_meshes(twin);
  return twin;
}

std::vector<CameraImages> load_captures(const Twin& twin, const std::filesystem::path& dir) {
  const int n_images = static_cast<int>(expand_sequence(twin.fringes).size());
  const CaptureSet set = read_capture_set(dir, n_images);
  std::vector<CameraImages> all;
  for (const Camera& camera : twin.cameras) all.push_back(load_camera_images(set, camera, twin.fringes));
  return all;
}

bool has_measured_shape(const Twin& twin) {
  return std::any_of(twin.objects.begin(), twin.objects.end(), [](const Object& object) {
    return std::holds_alternative<MeasuredShape>(object.shape);
  });
}

void build_measured_shapes(Twin& twin, const std::vector<CameraImages>& real) {
  for (Object& object : twin.objects) {
    const auto* measured = std::get_if<MeasuredShape>(&object.shape);
    if (!measured) continue;
    const measure::Measurement m = measure::measure(twin, real, built_from_steps(twin, object, *measured));
    MeshShape mesh;
    mesh.smooth = true;
    mesh.mesh = measure::build_surface(twin, 0, m.cloud, measured->smoothing_px);
    object.shape = mesh;
  }
}

Twin load_renderable_twin(const std::filesystem::path& file) {
  Twin twin = load_for_run(file);
  if (!has_measured_shape(twin)) return twin;
  if (!twin.real.captures)
    throw UserError(ExitCode::usage, file.string(),
                    "an object has shape = \"measured\" but [real] names no captures",
                    "add [real] captures = \"FOLDER\"");
  build_measured_shapes(twin, load_captures(twin, *twin.real.captures));
  return twin;
}

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
  }
  return note;
}

// The estimate is an upper bound: up to twice the target it is no news.
void warn_of_missed_targets(const compare::RenderNote& note, const render::Sampling& asked) {
  if (note.phase_error_rad.value_or(0.0) > 2.0 * asked.phase_error_rad)
    warn(fmt::format(
        "camera \"{}\": the phase error is estimated at {:.1e} rad, above phase_error_rad = {:.1e}",
        note.camera, *note.phase_error_rad, asked.phase_error_rad));
  if (note.gray_error.value_or(0.0) > 2.0 * asked.gray_error)
    warn(fmt::format(
        "camera \"{}\": the gray error is estimated at {:.1e} of full scale, above gray_error = {:.1e}",
        note.camera, *note.gray_error, asked.gray_error));
}

void check_renderable(const Twin& twin) {
  if (!twin.projector)
    throw UserError(ExitCode::usage, twin.file.string(),
                    "the twin has no [projector], so nothing can be rendered",
                    "add the projector, or use `fringetwin measure` on real captures");
  if (twin.objects.empty())
    throw UserError(ExitCode::usage, twin.file.string(),
                    "the twin has no [[object]], so nothing can be rendered",
                    "add one, e.g. shape = \"sphere\"");
}

Simulated simulate(const Twin& twin, const RenderFlags& flags, render::Renderer& renderer) {
  check_renderable(twin);
  RenderOptions options = twin.render;
  apply_flags(flags, options);
  Simulated out;
  const render::Sampling sampling = render::choose_sampling(twin, options);

  out.device = renderer.device().name;
  std::vector<bool> seen(twin.objects.size(), false);
  Progress progress("render", twin.cameras.size());
  for (std::size_t i = 0; i < twin.cameras.size(); ++i) {
    render::RenderedCamera rendered = renderer.render(twin, i, sampling, flags.seed);
    out.notes.push_back(note_of(rendered));
    warn_of_missed_targets(out.notes.back(), sampling);
    for (const int object : rendered.object.data)
      if (object >= 0) seen[static_cast<std::size_t>(object)] = true;
    throw_if_cancelled();
    out.captures.push_back(render::expose(rendered, twin.cameras[i], i, flags.seed));
    out.irradiance.push_back(render::as_radiance(std::move(rendered)));
    progress.advance();
  }
  if (std::none_of(seen.begin(), seen.end(), [](bool s) { return s; }))
    throw UserError(
        ExitCode::usage, twin.file.string(), "no camera sees any object",
        "check the objects' positions (mm, world = first camera unless rt_cam_world says otherwise)");
  for (std::size_t k = 0; k < seen.size(); ++k)
    if (!seen[k]) warn("object \"" + twin.objects[k].name + "\" is outside the view of every camera");
  return out;
}

void write_simulated(const std::filesystem::path& dir, const Simulated& simulated, bool radiance,
                     std::uint64_t seed, const Twin& twin) {
  std::map<std::string, std::string> provenance = {
      {"device", "fringetwin renderer on " + simulated.device},
      {"twin", twin.name},
      {"seed", std::to_string(seed)},
  };
  for (const compare::RenderNote& note : simulated.notes) provenance["rendered " + note.camera] = note.text();
  for (const Camera& camera : twin.cameras)
    if (camera.sensor.exposure_ms)
      provenance["exposure_ms " + camera.name] = fmt::format("{}", *camera.sensor.exposure_ms);
  begin_output(dir, {"capture.toml", "radiance/capture.toml"});
  std::vector<const CameraImages*> cameras, irradiance;
  for (const CameraImages& images : simulated.captures) {
    write_camera_images(dir, images);
    cameras.push_back(&images);
  }
  if (radiance) {
    for (const CameraImages& images : simulated.irradiance) {
      write_camera_radiance(dir, images);
      irradiance.push_back(&images);
    }
    write_capture_toml(dir / "radiance", irradiance, provenance, "exr", "..");
  }
  write_capture_toml(dir, cameras, provenance, "png");
}

}  // namespace fringetwin::cli
