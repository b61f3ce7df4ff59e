// SPDX-License-Identifier: Apache-2.0
#include "cosim/shape/measured_shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "cosim/shape/known_light.hpp"
#include "measure/decode/phase.hpp"
#include "measure/decode/plain_fringes.hpp"
#include "measure/light/harmonics_told.hpp"
#include "measure/measurement.hpp"
#include "measure/surface.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/captures/measured_steps.hpp"

namespace fringetwin::cosim {
namespace {

/// The coordinates stay as they were decoded: the surface is smoothed by itself, from noise that no
/// neighbours share.
constexpr double kUnsmoothed = 0.0;

/// The phase steps that an object is measured from, and those that tell what is to be taken out of them.
struct ShapeSteps {
  std::vector<int> used, telling;
};

/// Returns the steps of an object: all tell where none are asked for; else nothing of the others may reach
/// its shape.
ShapeSteps steps_of(const Twin& twin, const Object& object, const MeasuredShape& shape,
                    const std::vector<int>& asked) {
  if (!asked.empty()) return {asked, asked};
  return {built_from_steps(twin, object, shape), measure::all_steps(twin.fringes.steps)};
}

/// Warns, where that was not `told` before.
void warn_once(const std::string& sentence, std::set<std::string>* told) {
  if (told == nullptr || told->insert(sentence).second) warn(sentence);
}

/// Warns, where that was not told before, of harmonics that stay in a shape because the steps that are left,
/// where some are held out, take them for the fringe.
void warn_of_untold_orders(const Twin& twin, const Object& object, std::size_t camera,
                           const measure::LightFactors& light, std::set<std::string>* told) {
  if (light.steps.empty()) return;
  const auto highest = static_cast<std::size_t>(measure::highest_harmonic_told(twin.fringes.steps));
  for (const std::vector<double>& form : light.waveform)
    if (const std::size_t order = form.size() / 2 + 1; !form.empty() && order < highest)
      warn_once(
          fmt::format("object \"{}\", camera \"{}\": the phase steps that are left where some are held "
                      "out tell harmonics of the fringes up to order {} only: those above it stay in the "
                      "shape; more folds leave more steps",
                      object.name, twin.cameras[camera].name, order),
          told);
}

/// Returns the images that the object is measured from with the light and the shifts, where they differ by
/// more than chance, and the waveform taken out that the phase steps tell. Warns where they do not, and
/// leaves a camera's images as they are.
std::vector<CameraImages> with_plain_fringes(const Twin& twin, const Object& object,
                                             const std::vector<CameraImages>& real, const ShapeSteps& steps,
                                             std::set<std::string>* told) {
  std::vector<CameraImages> out = real;
  for (std::size_t c = 0; c < out.size(); ++c) {
    measure::LightOptions options =
        measure::light_options(twin.cameras[c].sensor, twin.measure.min_modulation_dn);
    options.with_shifts = true;
    auto light = measure::estimate_light(real[c], twin.fringes, options, steps.telling);
    if (!light) {  // beside shifts, factors are less certain where a pitch is seen at few phases
      options.with_shifts = false;
      light = measure::estimate_light(real[c], twin.fringes, options, steps.telling);
    }
    // what differs by chance alone would stand in the shape as a ripple
    if (light && !light->differ()) std::ranges::fill(light->factor, 1.0);
    if (light && !light->are_shifted()) light->shift_rad.clear();
    if (light) {
      warn_of_untold_orders(twin, object, c, *light, told);
      out[c] = measure::with_plain_fringes(std::move(out[c]), twin.fringes, *light, options, steps.used);
    } else {
      warn_once(
          fmt::format("object \"{}\", camera \"{}\": the phase steps{} do not tell light and waveform of "
                      "the fringes, which correct_fringes is to take out: the shape is measured without",
                      object.name, twin.cameras[c].name,
                      static_cast<int>(steps.telling.size()) == twin.fringes.steps
                          ? ""
                          : " that are left where some are held out"),
          told);
    }
  }
  return out;
}

/// Returns where the projector's image lights each pixel of a camera: along the fringes' axes as decoded,
/// along another as the points say, which only the first camera has; else in the middle. NaN where it is not
/// known.
std::vector<Eigen::Vector2f> places_px(const Twin& twin, std::size_t camera, const measure::Measurement& m) {
  const Projector& projector = *twin.projector;
  const Eigen::Vector2f middle(0.5F * static_cast<float>(projector.lens.width()),
                               0.5F * static_cast<float>(projector.lens.height()));
  const Lens& lens = twin.cameras[camera].lens;
  std::vector<Eigen::Vector2f> places(
      static_cast<std::size_t>(lens.width()) * static_cast<std::size_t>(lens.height()), middle);
  if (camera == 0) {
    const Image<int> point = measure::point_grid(m.cloud, lens.width(), lens.height());
    for (std::size_t i = 0; i < places.size(); ++i)
      if (point.data[i] >= 0)
        if (const auto q_px = projector.lens.project(
                projector.T_proj_world * m.cloud.p_world_mm[static_cast<std::size_t>(point.data[i])]))
          places[i] = q_px->cast<float>();
  }
  for (std::size_t d = 0; d < twin.fringes.directions.size(); ++d) {
    const ImageD& along = m.cameras[camera].directions[d].coordinate_px;
    const int axis = twin.fringes.directions[d].axis == Axis::x ? 0 : 1;
    for (std::size_t i = 0; i < places.size(); ++i)
      places[i][axis] =
          along.empty() ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(along.data[i]);
  }
  return places;
}

/// Returns the images without what the twin knows to be in their phase steps besides plain fringes.
std::vector<CameraImages> with_known_light_out(const Twin& twin, const std::vector<CameraImages>& real,
                                               const ShapeSteps& steps) {
  std::vector<CameraImages> out = real;
  if (std::ranges::none_of(twin.cameras, [&](const Camera& c) { return knows_light(twin, c); })) return out;
  const measure::Measurement m = measure::measure(twin, real, steps.used);
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  for (std::size_t c = 0; c < out.size(); ++c) {
    if (!knows_light(twin, twin.cameras[c])) continue;
    const std::vector<Eigen::Vector2f> places = places_px(twin, c, m);
    // the shape owes its noise to its own steps alone; the others only tell what is left
    CameraImages& all = out[c] = without_known_light(real[c], twin, twin.cameras[c], places, steps.telling);
    if (steps.used == steps.telling) continue;
    CameraImages own = without_known_light(real[c], twin, twin.cameras[c], places, steps.used);
    for (std::size_t k = 0; k < sequence.size(); ++k)
      if (std::ranges::find(steps.used, sequence[k].step) != steps.used.end())
        all.images[k] = std::move(own.images[k]);
  }
  return out;
}

/// Returns the phase steps from which the first measured shape of the twin is built; others take the same.
std::vector<int> steps_of_measured_shape(const Twin& twin) {
  for (const Object& object : twin.objects)
    if (const auto* measured = std::get_if<MeasuredShape>(&object.shape))
      return built_from_steps(twin, object, *measured);
  return {};
}

/// Returns the share of the compared steps (none named: all) that a shape was built from, too.
double share_in(const std::vector<int>& built_from, const std::vector<int>& compared, int steps) {
  const std::vector<int> of = compared.empty() ? measure::all_steps(steps) : compared;
  if (of.empty()) return 1.0;  // a code alone, which is decoded whole
  const auto both = std::ranges::count_if(
      of, [&](int step) { return std::ranges::find(built_from, step) != built_from.end(); });
  return static_cast<double>(both) / static_cast<double>(of.size());
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
                                                           const std::vector<int>& steps,
                                                           std::set<std::string>* told) {
  std::optional<measure::SurfaceNoise> noise;
  for (Object& object : twin.objects) {
    const auto* measured = std::get_if<MeasuredShape>(&object.shape);
    if (!measured) continue;
    const ShapeSteps of = steps_of(twin, object, *measured, steps);
    const measure::Measurement m =
        measured->correct_fringes
            ? measure::measure(
                  twin, with_plain_fringes(twin, object, with_known_light_out(twin, real, of), of, told),
                  of.used, kUnsmoothed)
            : measure::measure(twin, real, of.used, kUnsmoothed);
    const measure::MeasuredSurface surface = measure::build_surface(twin, 0, m.cloud, *measured);
    if (noise)
      put_larger(surface.noise, *noise);
    else
      noise = surface.noise;
    object.shape = MeshShape{.smooth = true, .mesh = surface.mesh};
  }
  return noise;
}

std::shared_ptr<const compare::ShapeNoise> build_compared_shapes(Twin& twin,
                                                                 const std::vector<CameraImages>& real,
                                                                 const std::vector<int>& compared) {
  const std::vector<int> built_from = steps_of_measured_shape(twin);
  auto noise = build_measured_shapes(twin, real);
  if (!noise) return nullptr;
  return std::make_shared<const compare::ShapeNoise>(compare::ShapeNoise{
      .surface = std::move(*noise), .steps_in_shape = share_in(built_from, compared, twin.fringes.steps)});
}

}  // namespace fringetwin::cosim
