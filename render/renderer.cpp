// SPDX-License-Identifier: Apache-2.0
#include "render/renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "render/indirect/indirect_trace.hpp"
#include "render/pattern/camera_effects.hpp"
#include "render/pattern/exposure_mix.hpp"
#include "render/pattern/form_images.hpp"
#include "render/pattern/formed_harmonics.hpp"
#include "render/pattern/projector_places.hpp"
#include "render/pattern/raster_waves.hpp"
#include "render/pattern/response_series.hpp"
#include "render/pattern/transport_images.hpp"
#include "render/scene/pack_scene.hpp"
#include "render/scene/shortcuts.hpp"
#include "render/trace/adaptive_trace.hpp"
#include "render/trace/fixed_trace.hpp"
#include "render/trace/lens_table.hpp"
#include "render/trace/pixel_blocks.hpp"
#include "render/trace/trace_device.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/stopwatch.hpp"
#include "twin/moving.hpp"

namespace fringetwin::render {

// Everything on the host that serves a renderer from one trace to the next, because it is dear to make and
// depends only on the lens or the mesh.
struct SceneStores {
  LensTableStore lenses;
  MeshStore meshes;
  VisibilityStore visibility;
};

namespace {

// With more triangles than these the links between them are not worth their making: rays then search through
// the BVH. The adaptive trace clips facets, up to some hundred in a pixel.
constexpr std::size_t kTrianglesPerTracedPixel = 2, kTrianglesPerClippedPixel = 512;

// Throws where the twin cannot be traced or the sampling cannot be followed.
void check_traceable(const Twin& twin, std::size_t camera_index, const Sampling& sampling) {
  FT_CHECK(camera_index < twin.cameras.size(), "camera index");
  if (!twin.projector)
    throw UserError(ExitCode::usage, twin.file.string(),
                    "the twin has no projector, so nothing lights the scene", "add a [projector] section");
  check_sampling(sampling, twin.render.pixel_fill);
}

// Traces adaptively and returns true; or returns false, warns, and leaves a transport as empty as before
// where the driver cuts loops short.
bool trace_adaptively_if_possible(TraceDevice& device, const TraceJob& job,
                                  const std::vector<PassPlan>& passes, const Sampling& sampling) {
  try {
    trace_adaptively(device, job, passes, sampling);
    return true;
  } catch (const LoopLimit&) {
    const Sampling fixed = without_adaptation(sampling, job.twin, job.camera);
    warn(
        fmt::format("{}: the driver's limit of loop iterations stops the adaptive trace; a fixed rule of {} "
                    "samples is used (Mesa 25 has no such limit: make mesa25)",
                    job.camera.name, fixed.samples));
    const SeriesTable series = std::move(job.out->series);
    *job.out = empty_transport(job.twin, passes, series, job.camera.lens.width(), job.camera.lens.height());
    job.out->sampling = fixed;
    return false;
  }
}

// Throws where phase steps would be evaluated directly, which know no harmonics of a place or an image.
void refuse_direct_steps(const Twin& twin, const SeriesTable& series) {
  for (std::size_t d = 0; d < series.size(); ++d) {
    const bool of_places = twin.fringes.directions[d].has_harmonics_field();
    if ((of_places || twin.fringes.has_image_harmonics()) &&
        std::ranges::any_of(series[d], [](const PhaseSeries& s) { return s.a.empty(); }))
      throw UserError(
          ExitCode::usage, twin.file.string(),
          fmt::format("harmonics {} cannot be rendered here: the fringes have more than {} harmonics",
                      of_places ? "that vary over the projector's image" : "of single images", kMostPairs),
          fmt::format("leave out {}, or blur the pattern more",
                      of_places ? "harmonics_field" : "image_harmonics"));
  }
}

// Raises an estimate to that of another trace, where both have one.
void take_larger(const std::optional<ErrorEstimate>& other, std::optional<ErrorEstimate>& estimate) {
  if (!other || !estimate) return;
  for (double ErrorEstimate::*part :
       {&ErrorEstimate::phase_rad, &ErrorEstimate::gray, &ErrorEstimate::gray_inside})
    (*estimate).*part = std::max((*estimate).*part, (*other).*part);
}

}  // namespace

Renderer::Renderer(const std::string& device)
    : device_(std::make_unique<TraceDevice>(device)), stores_(std::make_unique<SceneStores>()) {}
Renderer::~Renderer() = default;
const DeviceInfo& Renderer::device() const { return device_->vulkan().info(); }
int Renderer::validation_messages() const { return device_->vulkan().instance().validation_messages(); }

// Chooses double precision where it is asked for and the device has it; warns where it lacks it.
void Renderer::choose_precision(const Twin& twin, const Sampling& sampling) {
  const VulkanDevice& vulkan = device_->vulkan();
  device_->set_precise(sampling.precise && vulkan.has_double());
  if (sampling.precise && !vulkan.has_double())
    warn(fmt::format(
        "{} has no double precision: rounding leaves up to {:.1e} rad of phase error, {} asked for",
        vulkan.info().name, single_precision_error_rad(twin), sampling.phase_error_rad));
}

Transport Renderer::trace(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                          std::uint64_t seed) {
  const Stopwatch watch;
  check_traceable(twin, camera_index, sampling);
  choose_precision(twin, sampling);
  const Camera& camera = twin.cameras[camera_index];
  const PackedScene scene = pack_scene(twin, camera, stores_->meshes);
  const LensTable& lens = stores_->lenses.get(camera.lens);
  const ProjectorSetup projector = setup_projector(*twin.projector);
  const std::vector<std::uint32_t> blocks = active_blocks(camera, scene, lens);
  const SeriesTable series = choose_series(twin, tuning_.pattern_method, sampling.phase_error_rad);
  const bool has_field = twin.fringes.has_harmonics_field() && twin.fringes.steps > 0;
  const bool varies = has_field || (twin.fringes.has_image_harmonics() && twin.fringes.steps > 0);
  const SeriesTable largest = varies ? largest_series(twin, series) : series;
  HarmonicsPlan harmonics;
  if (sampling.sampler == Sampler::adaptive && scene.maps.empty())
    harmonics = plan_harmonics(twin, camera, largest, sampling.phase_error_rad, projector.cx, projector.cy);
  const std::vector<PassPlan> passes =
      plan_passes(twin, harmonics.formed() ? fundamentals_of(largest) : largest, projector.cx, projector.cy);
  if (varies) refuse_direct_steps(twin, series);

  Transport out = empty_transport(twin, passes, series, camera.lens.width(), camera.lens.height());
  bool adaptive = sampling.sampler == Sampler::adaptive &&
                  can_trace_adaptively(twin, camera, scene, passes, device_->vulkan().limits());
  const std::size_t per_pixel = adaptive ? kTrianglesPerClippedPixel : kTrianglesPerTracedPixel;
  const Shortcuts shortcuts =
      tuning_.search_always ? Shortcuts{}
                            : make_shortcuts(twin, camera, scene, per_pixel * blocks.size() * BLOCK_PIXELS,
                                             stores_->visibility);
  const TraceJob job{twin, camera, scene, lens, projector, blocks, shortcuts, tuning_, seed, &out, harmonics};
  out.sampling = adaptive ? sampling : without_adaptation(sampling, twin, camera);
  if (!blocks.empty()) {
    device_->upload_scene(job);
    adaptive = adaptive && trace_adaptively_if_possible(*device_, job, passes, sampling);
    if (!adaptive) trace_by_fixed_rule(*device_, job, passes);
    if (twin.render.bounces > 0 && !scene.one_convex) add_indirect_light(*device_, job, passes);
    sort_harmonics(&out);
  }
  device_->kernels().stop_soon();
  out.sampling.precise = device_->precise();
  if (has_field) add_harmonics_field(twin, camera_index, out);
  if (twin.fringes.has_raster() && twin.fringes.steps > 0)
    take_waves(twin, trace(showing_waves(twin), camera_index, sampling_of_waves(twin, sampling), seed), out);
  out.trace_ms = 1e3 * watch.elapsed().wall_s;
  return out;
}

void Renderer::add_harmonics_field(const Twin& twin, std::size_t camera_index, Transport& transport) {
  constexpr int kPoints = 4;  // per pixel: the field is smooth
  transport.series_of_field = field_series(twin, transport.series);
  const Twin view = showing_places(twin);
  const std::vector<ImageF> images =
      form_images(view, camera_index, trace(view, camera_index, {Sampler::gauss, kPoints}));
  transport.field_terms.assign(kHarmonicsFieldTerms,
                               ImageF(transport.mean.width, transport.mean.height, 0.0F));
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < transport.mean.size(); ++i) {
    if (!(images[0].data[i] + images[2].data[i] > 0.0F)) continue;  // half a turn apart: no light, no place
    const auto terms = twin.projector->field_terms(place_in_projector_px(images, i, *twin.projector));
    for (std::size_t t = 0; t < terms.size(); ++t)
      transport.field_terms[t].data[i] = static_cast<float>(terms[t]);
  }
}

RenderedCamera Renderer::render(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                                std::uint64_t seed, bool references) {
  if (twin.cameras.at(camera_index).spreads_over_sensor())
    return render_of_whole_sensor(twin, camera_index, sampling, seed, references);
  const Stopwatch watch;
  RenderedCamera out = has_motion(twin) ? render_moving(twin, camera_index, sampling, seed, references)
                                        : form_camera(twin, camera_index,
                                                      trace(twin, camera_index, sampling, seed), references);
  out.total_ms = 1e3 * watch.elapsed().wall_s;
  return out;
}

KeptCamera Renderer::render_kept(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                                 std::uint64_t seed) {
  if (twin.cameras.at(camera_index).spreads_over_sensor() || has_motion(twin))
    return kept_as_floats(render(twin, camera_index, sampling, seed));
  const Stopwatch watch;
  KeptCamera out = keep_camera(twin, camera_index, trace(twin, camera_index, sampling, seed));
  out.rendered.total_ms = 1e3 * watch.elapsed().wall_s;
  return out;
}

RenderedCamera Renderer::render_of_whole_sensor(const Twin& twin, std::size_t camera_index,
                                                const Sampling& sampling, std::uint64_t seed,
                                                bool references) {
  const Camera& camera = twin.cameras[camera_index];
  Twin of_sensor = twin;
  Camera& whole = of_sensor.cameras[camera_index];
  whole.lens = camera.whole_lens();
  if (whole.timing && whole.timing->rows)  // of a part of the image
    whole.timing->rows = whole.timing->rows->part(-0.5 * camera.channel->first_px().y(), 0.5);
  whole.channel.reset();
  whole.texture = nullptr;  // of the image's pixels, after the point spread
  RenderedCamera out = render(of_sensor, camera_index, sampling, seed, references);
  const auto take_channel = [&](auto& image) { image = channel_image(image, *camera.channel); };
  std::ranges::for_each(out.irradiance, take_channel);
  for (auto* image : {&out.white, &out.black})
    if (*image) take_channel(**image);
  take_channel(out.object);
  apply_textures(camera, &out);
  return out;
}

RenderedCamera Renderer::render_moving(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                                       std::uint64_t seed, bool references) {
  const Camera& camera = twin.cameras[camera_index];
  RenderedCamera out = form_camera(twin, camera_index, trace(twin, camera_index, sampling, seed), references);
  const std::size_t n_images = out.irradiance.size();
  const auto formed_at = [&](double time, const auto& form) {
    throw_if_cancelled();
    const Twin then = twin_at_image(twin, time, n_images);
    const Transport transport = trace(then, camera_index, sampling, seed);
    out.trace_ms += transport.trace_ms;
    out.rays += transport.rays;
    take_larger(transport.estimate, out.estimate);
    return form(then, transport);
  };
  for (std::size_t image = 0; image < n_images; ++image) {
    const auto at = static_cast<double>(image);
    if (!camera.timing) {
      out.irradiance[image] = formed_at(at, [&](const Twin& then, const Transport& transport) {
        return std::move(form_camera(then, camera_index, transport, false, image).irradiance[0]);
      });
      continue;
    }
    const ImageRange own{image, 1}, seen = mixes_patterns(camera, own) ? with_neighbours(own, n_images) : own;
    const auto patterns = [&](const Twin& then, const Transport& transport) {
      return form_patterns(then, camera_index, transport, seen);
    };
    const ExposureTimes times = exposure_times(*camera.timing, image);
    const std::vector<ImageF> earlier = formed_at(at + times.middle - times.apart, patterns),
                              later = formed_at(at + times.middle + times.apart, patterns);
    RenderedCamera one;
    one.irradiance.push_back(exposed_moving(camera, image, seen_patterns(earlier, seen, image),
                                            seen_patterns(later, seen, image)));
    apply_textures(camera, &one, image);
    out.irradiance[image] = std::move(one.irradiance[0]);
  }
  return out;
}

}  // namespace fringetwin::render
