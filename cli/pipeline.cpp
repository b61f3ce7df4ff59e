// SPDX-License-Identifier: Apache-2.0
#include "cli/pipeline.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "render/sensor.hpp"
#include "twin/errors.hpp"
#include "twin/progress.hpp"

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
  if (flags.phase_error_rad) {
    options.phase_error_rad = *flags.phase_error_rad;
    // A target on the command line replaces a scheme fixed in the file.
    options.samples.reset();
    options.sampler.reset();
  }
  if (flags.samples) options.samples = flags.samples;
  if (flags.sampler) {
    if (*flags.sampler == "gauss")
      options.sampler = Sampler::gauss;
    else if (*flags.sampler == "multi-jittered")
      options.sampler = Sampler::multi_jittered;
    else
      options.sampler = Sampler::sobol;
  }
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

namespace {

std::vector<int> steps_with_parity(int steps, const std::string& which, bool complement) {
  std::vector<int> chosen;
  for (int n = 0; n < steps; ++n) {
    const bool is_even = n % 2 == 0;
    const bool used = which == "all" || (which == "even") == is_even;
    if (used != complement) chosen.push_back(n);
  }
  return chosen;
}

}  // namespace

std::vector<int> build_measured_shapes(Twin& twin, const std::vector<CameraImages>& real) {
  std::vector<int> left_over;
  for (Object& object : twin.objects) {
    const auto* measured = std::get_if<MeasuredShape>(&object.shape);
    if (!measured) continue;
    const std::vector<int> used = steps_with_parity(twin.fringes.steps, measured->steps, false);
    left_over = steps_with_parity(twin.fringes.steps, measured->steps, true);
    if (used.size() < 3)
      throw UserError(ExitCode::usage, "[[object]] " + object.name,
                      fmt::format("building it from the {} steps leaves {} of {}, and a phase needs 3",
                                  measured->steps, used.size(), twin.fringes.steps),
                      "use more phase steps or steps = \"all\"");
    const measure::Measurement m = measure::measure(twin, real, used);
    MeshShape mesh;
    mesh.smooth = true;
    mesh.mesh = measure::build_surface(twin, 0, m.cloud, measured->smoothing_px);
    object.shape = mesh;
  }
  return left_over;
}

Simulated simulate(const Twin& twin, const RenderFlags& flags) {
  if (!twin.projector)
    throw UserError(ExitCode::usage, twin.file.string(),
                    "the twin has no [projector], so nothing can be rendered",
                    "add the projector, or use `fringetwin measure` on real captures");
  if (twin.objects.empty())
    throw UserError(ExitCode::usage, twin.file.string(),
                    "the twin has no [[object]], so nothing can be rendered",
                    "add one, e.g. shape = \"sphere\"");
  RenderOptions options = twin.render;
  apply_flags(flags, options);
  Simulated out;
  out.sampling = render::choose_sampling(options);

  render::Renderer renderer(flags.device);
  out.device = renderer.device().name;
  std::vector<bool> seen(twin.objects.size(), false);
  Progress progress("render", twin.cameras.size());
  for (std::size_t i = 0; i < twin.cameras.size(); ++i) {
    render::RenderedCamera rendered = renderer.render(twin, i, out.sampling, flags.seed);
    for (const int object : rendered.object.data)
      if (object >= 0) seen[static_cast<std::size_t>(object)] = true;
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
                     std::uint64_t seed, const std::string& twin_name) {
  const std::map<std::string, std::string> provenance = {
      {"device", "fringetwin renderer on " + simulated.device},
      {"twin", twin_name},
      {"seed", std::to_string(seed)},
      {"samples_per_pixel", std::to_string(simulated.sampling.samples)}};
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
  } else {
    // What an earlier run left must not pass for this run's irradiance.
    std::filesystem::remove(dir / "radiance" / "capture.toml");
  }
  write_capture_toml(dir, cameras, provenance, "png");
}

}  // namespace fringetwin::cli
