// SPDX-License-Identifier: Apache-2.0
#include "cosim/measured_shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosim/load.hpp"
#include "measure/decode/plain_fringes.hpp"
#include "measure/measurement.hpp"
#include "measure/surface.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/captures/measured_steps.hpp"

namespace fringetwin::cosim {
namespace {

/// Returns the images that the object is measured from with the light and the shifts, where they differ by
/// more than chance, and the waveform taken out that all their phase steps tell. Warns where they do not, and
/// leaves a camera's images as they are.
std::vector<CameraImages> with_plain_fringes(const Twin& twin, const Object& object,
                                             const std::vector<CameraImages>& real,
                                             const std::vector<int>& steps) {
  std::vector<CameraImages> out = real;
  for (std::size_t c = 0; c < out.size(); ++c) {
    measure::LightOptions options =
        measure::light_options(twin.cameras[c].sensor, twin.measure.min_modulation_dn);
    options.with_shifts = true;
    auto light = measure::estimate_light(real[c], twin.fringes, options);
    if (!light) {  // beside shifts, factors are less certain where a pitch is seen at few phases
      options.with_shifts = false;
      light = measure::estimate_light(real[c], twin.fringes, options);
    }
    // what differs by chance alone would stand in the shape as a ripple
    if (light && !light->differ()) std::ranges::fill(light->factor, 1.0);
    if (light && !light->are_shifted()) light->shift_rad.clear();
    if (light)
      out[c] = measure::with_plain_fringes(std::move(out[c]), twin.fringes, *light, options, steps);
    else
      warn(
          fmt::format("object \"{}\", camera \"{}\": the phase steps do not tell light and waveform of the "
                      "fringes, which correct_fringes is to take out: the shape is measured without",
                      object.name, twin.cameras[c].name));
  }
  return out;
}

/// Puts the larger one of both into each pixel of `to`, which may be empty; NaN is none.
void put_larger(const ImageF& from, ImageF& to) {
  if (to.empty()) to = from;
  for (std::size_t i = 0; i < from.size(); ++i) to.data[i] = std::fmax(to.data[i], from.data[i]);
}

}  // namespace

bool has_measured_shape(const Twin& twin) {
  return std::ranges::any_of(
      twin.objects, [](const Object& object) { return std::holds_alternative<MeasuredShape>(object.shape); });
}

void check_measured_shapes(const Twin& twin) {
  if (has_measured_shape(twin) && !twin.real.captures)
    throw UserError(ExitCode::usage, twin.file.string(),
                    "an object has shape = \"measured\" but [real] names no captures",
                    "add [real] captures = \"FOLDER\"");
}

std::optional<measure::SurfaceNoise> build_measured_shapes(Twin& twin, const std::vector<CameraImages>& real,
                                                           const std::vector<int>& steps) {
  std::optional<measure::SurfaceNoise> noise;
  for (Object& object : twin.objects) {
    const auto* measured = std::get_if<MeasuredShape>(&object.shape);
    if (!measured) continue;
    const std::vector<int> used = steps.empty() ? built_from_steps(twin, object, *measured) : steps;
    const measure::Measurement m =
        measured->correct_fringes && steps.empty()
            ? measure::measure(twin, with_plain_fringes(twin, object, real, used), used)
            : measure::measure(twin, real, used);
    const measure::MeasuredSurface surface = measure::build_surface(twin, 0, m.cloud, *measured);
    if (!noise) noise = measure::SurfaceNoise{.leverage = 0.0, .shading = 0.0, .radius_px = 0.0};
    noise->leverage = std::max(noise->leverage, surface.noise.leverage);
    noise->shading = std::max(noise->shading, surface.noise.shading);
    noise->radius_px = std::max(noise->radius_px, surface.noise.radius_px);
    put_larger(surface.noise.leverage_of_pixel, noise->leverage_of_pixel);
    put_larger(surface.noise.shading_of_pixel, noise->shading_of_pixel);
    object.shape = MeshShape{.smooth = true, .mesh = surface.mesh};
  }
  return noise;
}

std::size_t steps_of_measured_shape(const Twin& twin) {
  for (const Object& object : twin.objects)
    if (const auto* measured = std::get_if<MeasuredShape>(&object.shape))
      return built_from_steps(twin, object, *measured).size();
  return 0;
}

Twin load_renderable_twin(const std::filesystem::path& file,
                          const std::map<std::string, std::string>& settings) {
  Twin twin = load_for_run(file, settings);
  check_measured_shapes(twin);
  if (has_measured_shape(twin)) build_measured_shapes(twin, load_captures(twin, *twin.real.captures).cameras);
  return twin;
}

}  // namespace fringetwin::cosim
