// SPDX-License-Identifier: Apache-2.0
#include "measure/measurement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "measure/decode/mixed_pixels.hpp"
#include "measure/decode/phase_exr.hpp"
#include "measure/decode/smooth_coordinates.hpp"
#include "measure/decode/unwrap.hpp"
#include "measure/fit/gate_warnings.hpp"
#include "measure/fit/method_bias.hpp"
#include "measure/noise_free_coordinates.hpp"
#include "measure/points/points_ply.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/stopwatch.hpp"

namespace fringetwin::measure {
namespace {

constexpr double kFewBelowBlack = 0.01;  ///< share of the decoded pixels that may lie below the black level

/// Shot noise is taken from the gray value above black: says so where there is none.
void warn_of_black_level(const Camera& camera, const CameraDecode& decode,
                         std::vector<std::string>& warnings) {
  if (!camera.sensor.electrons_per_dn || camera.sensor.black_level_dn <= 0.0) return;
  std::size_t below = 0, valid = 0;
  for (const DirectionDecode& d : decode.directions) {
    if (d.noise_source != NoiseSource::known) continue;
    for (std::size_t i = 0; i < d.coordinate_px.size(); ++i) {
      if (!std::isfinite(d.coordinate_sigma_px.data[i])) continue;
      ++valid;
      below += static_cast<double>(d.mean_dn.data[i]) < camera.sensor.black_level_dn ? 1u : 0u;
    }
  }
  if (static_cast<double>(below) > kFewBelowBlack * static_cast<double>(valid))
    warnings.push_back(
        fmt::format("camera \"{}\": {:.0f} % of the decoded pixels are darker on average than the twin's "
                    "black_level_dn = "
                    "{:g}; their sigma holds read noise and rounding only: check black_level_dn",
                    camera.name, 100.0 * static_cast<double>(below) / static_cast<double>(valid),
                    camera.sensor.black_level_dn));
}

void warn_of_clip(const Camera& camera, const CameraDecode& decode, std::vector<std::string>& warnings) {
  if (decode.clip)
    warnings.push_back(fmt::format(
        "camera \"{}\": the values stop at {:g} DN, below the sensor's {:g} ({} values of the phase "
        "steps stand there): they are taken as saturated",
        camera.name, decode.clip->dn, camera.sensor.max_dn(), decode.clip->n));
}

/// Says where the steps do not tell the light that was to be taken out.
void warn_of_light(const Twin& twin, const CameraDecode& decode, std::vector<std::string>& warnings) {
  if (!twin.measure.correct_light || decode.light) return;
  warnings.push_back(fmt::format(
      "camera \"{}\": [measure] light = \"corrected\" has no effect: {}", decode.camera,
      twin.fringes.steps < kFewestLightSteps || twin.fringes.steps > kMostLightSteps
          ? fmt::format("{} phase steps do not tell the light of their images, {} to {} do",
                        twin.fringes.steps, kFewestLightSteps, kMostLightSteps)
          : "the lit pixels are too few, or too alike in phase, to tell the light of the images"));
}

/// Says where most of the pixels that could have a point have none. Those of too large a sigma are neither.
void warn_of_rejected(const TriangulationSummary& t, std::vector<std::string>& warnings) {
  if (mostly_rejected(t))
    warnings.push_back(fmt::format(
        "{} of the {} pixels with a match ({:.0f} %) were rejected because their rays give no point; points "
        "left: {}. The images may not belong to these poses: check the poses of cameras and projector, and "
        "which images are whose",
        missing_pixels(t), judged_pixels(t), 100.0 * rejected_share(t), t.n_points));
}

/// Returns the decodes that points are made of, without their mixed pixels.
std::vector<CameraDecode> unmixed(const Twin& twin, const std::vector<CameraDecode>& decodes,
                                  std::size_t& n_mixed) {
  std::vector<CameraDecode> cameras;
  for (std::size_t i = 0; i < (twin.triangulate() == Triangulate::stereo ? 2u : 1u); ++i)
    cameras.push_back(without_mixed_pixels(decodes[i], n_mixed));
  return cameras;
}

PointCloud find_points(const Twin& twin, std::vector<CameraDecode> cameras, double smoothing_px,
                       TriangulationSummary& summary) {
  for (CameraDecode& camera : cameras)
    if (smoothing_px > 0.0) smooth_coordinates(camera, smoothing_px);
  return cameras.size() > 1 ? triangulate_stereo(twin, cameras[0], cameras[1], &summary)
                            : triangulate_projector(twin, 0, cameras[0], &summary);
}

/// Returns whether a fit is of a shape whose method bias is known (measure/fit/method_bias.cpp).
bool can_have_bias(const ObjectFit& fit) {
  return fit.usable && fit.kind != MeshShape::kKind && fit.kind != MeasuredShape::kKind;
}

void triangulate(const Twin& twin, double smoothing_px, Measurement& m) {
  std::size_t n_mixed = 0;
  std::vector<CameraDecode> cameras = unmixed(twin, m.cameras, n_mixed);
  m.cloud = find_points(twin, std::move(cameras), smoothing_px, m.triangulation);
  m.triangulation.n_mixed = n_mixed;
  estimate_normals(m.cloud, m.cameras[0].width(), m.cameras[0].height(), twin.cameras[0].center_world_mm());
  if (m.cloud.size() == 0)
    m.warnings.push_back("no point was triangulated: " + std::to_string(m.triangulation.n_candidates) +
                         " decoded pixels, " + std::to_string(m.triangulation.n_no_match) +
                         " without a match, " + std::to_string(m.triangulation.n_rejected) + " rejected");
  else
    warn_of_rejected(m.triangulation, m.warnings);
}

}  // namespace

bool can_triangulate(const Twin& twin) {
  if (twin.fringes.unwrap == Unwrap::none) return false;
  return twin.triangulate() == Triangulate::stereo ? twin.cameras.size() >= 2 : twin.projector.has_value();
}

DecodeOptions decode_options(const Twin& twin, const Camera& camera, const CameraImages& images,
                             const std::vector<int>& use_steps) {
  DecodeOptions options;
  options.min_modulation_dn = twin.measure.min_modulation_dn;
  options.use_steps = use_steps;
  if (twin.projector) {
    options.projector_width_px = twin.projector->lens.width();
    options.projector_height_px = twin.projector->lens.height();
  }
  const Sensor& sensor = camera.sensor;
  if (twin.measure.correct_light)
    options.light = images.radiance
                        ? LightOptions{.black_level_dn = 0.0, .min_amplitude = options.min_modulation_dn}
                        : light_options(sensor, options.min_modulation_dn);
  if (sensor.has_noise() && !images.radiance) {
    // docs/CONVENTIONS.md, "Light": variance = gain E / electrons_per_dn + read_noise^2; decode() adds the
    // rounding
    const double per_dn = sensor.electrons_per_dn ? 1.0 / *sensor.electrons_per_dn : 0.0;
    const double read = std::pow(sensor.read_noise_dn.value_or(0.0), 2);
    options.variance_per_dn = per_dn;
    options.variance_offset_dn2 = read - per_dn * sensor.black_level_dn;
    options.least_variance_dn2 = read;
  }
  return options;
}

Measurement measure(const Twin& twin, const std::vector<CameraImages>& images,
                    const std::vector<int>& use_steps, std::optional<double> smoothing_px) {
  if (images.size() != twin.cameras.size())
    throw UserError(ExitCode::input, twin.file.string(),
                    "the twin has " + std::to_string(twin.cameras.size()) + " cameras, the captures " +
                        std::to_string(images.size()));
  const Stopwatch watch;
  std::vector<CameraDecode> cameras;
  for (std::size_t i = 0; i < images.size(); ++i) {
    throw_if_cancelled();
    cameras.push_back(
        decode(images[i], twin.fringes, decode_options(twin, twin.cameras[i], images[i], use_steps)));
  }
  const double decode_s = watch.elapsed().wall_s;
  Measurement m = measure_decoded(twin, std::move(cameras), smoothing_px);
  m.timing_s["decode"] = decode_s;
  return m;
}

bool decodes_alike(const Twin& a, const Twin& b, const std::vector<CameraImages>& images) {
  if (a.fringes != b.fringes || a.cameras.size() != b.cameras.size()) return false;
  for (std::size_t i = 0; i < images.size(); ++i)
    if (decode_options(a, a.cameras[i], images[i]) != decode_options(b, b.cameras[i], images[i]))
      return false;
  return true;
}

Measurement measure_decoded(const Twin& twin, std::vector<CameraDecode> cameras,
                            std::optional<double> smoothing_px) {
  Measurement m;
  m.cameras = std::move(cameras);
  for (std::size_t i = 0; i < m.cameras.size(); ++i) {
    warn_of_black_level(twin.cameras[i], m.cameras[i], m.warnings);
    warn_of_clip(twin.cameras[i], m.cameras[i], m.warnings);
    warn_of_light(twin, m.cameras[i], m.warnings);
  }
  if (!can_triangulate(twin)) {
    m.warnings.push_back("decoded only: this rig and these fringes cannot be triangulated");
    return m;
  }
  throw_if_cancelled();
  const Stopwatch points_watch;
  triangulate(twin, smoothing_px.value_or(twin.measure.smoothing_px), m);
  m.timing_s["match"] = m.triangulation.match_s;
  m.timing_s["triangulate"] = points_watch.elapsed().wall_s - m.triangulation.match_s;
  throw_if_cancelled();
  const Stopwatch fit_watch;
  m.fits = fit_objects(twin, m.cloud);
  throw_if_cancelled();
  m.gate_warnings = gate_warnings(twin, m.cloud, m.fits);
  m.timing_s["fit"] = fit_watch.elapsed().wall_s;
  for (const ObjectFit& fit : m.fits)
    if (!fit.warning.empty()) m.warnings.push_back(fit.object + ": " + fit.warning);
  m.warnings.insert(m.warnings.end(), m.gate_warnings.begin(), m.gate_warnings.end());
  return m;
}

PointCloud noise_free_points(const Twin& twin, const std::vector<CameraImages>& noise_free,
                             const Measurement& of_twin, const std::vector<int>& use_steps) {
  if (!std::ranges::any_of(of_twin.fits, can_have_bias) || !can_triangulate(twin)) return {};
  std::size_t n_mixed = 0;
  std::vector<CameraDecode> cameras = unmixed(twin, of_twin.cameras, n_mixed);
  std::vector<DecodeOptions> options;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    options.push_back(decode_options(twin, twin.cameras[i], noise_free[i], use_steps));
    options.back().min_modulation_dn *= 0.5;  // the measurement has chosen the pixels
  }
  take_noise_free_coordinates(twin.fringes, noise_free, options, of_twin.cloud, of_twin.fits,
                              twin.measure.smoothing_px, cameras);
  TriangulationSummary summary;
  return find_points(twin, std::move(cameras), twin.measure.smoothing_px, summary);
}

void state_method_bias(const Twin& twin, const PointCloud& noise_free, Measurement& m) {
  if (!std::ranges::any_of(m.fits, can_have_bias) || !can_triangulate(twin)) return;
  state_method_bias(twin, noise_free, m.cloud, m.fits);
  if (!twin.measure.correct_pixel_area) return;
  for (const ObjectFit& fit : m.fits)
    if (can_have_bias(fit) && fit.bias.empty() && fit.bias_vectors.empty())
      m.warnings.push_back(
          fit.object +
          ": [measure] correct_pixel_area has no effect on this fit: the twin has too few "
          "noise-free points at its pixels (move the twin's object nearer to where it was measured)");
}

void check_fringes(const Twin& twin) {
  if (!twin.projector) return;
  for (const DirectionFringes& direction : twin.fringes.directions) {
    const Lens& lens = twin.projector->lens;
    CoordinateRange range{-0.5, (direction.axis == Axis::x ? lens.width() : lens.height()) - 0.5, true};
    switch (twin.fringes.unwrap) {
      case Unwrap::heterodyne:
        plan_heterodyne(direction, range);
        break;
      case Unwrap::hierarchical:
        plan_hierarchical(direction, range);
        break;
      case Unwrap::gray:
        plan_gray(direction, twin.fringes.steps, range);
        break;
      case Unwrap::none:
        break;
    }
  }
}

void write_measurement(const std::filesystem::path& dir, const Measurement& measurement) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error)
    throw UserError(ExitCode::usage, dir.string(), "cannot make the folder: " + error.message(),
                    "choose another --out");
  for (const CameraDecode& camera : measurement.cameras) {
    throw_if_cancelled();
    write_phase_exr(dir, camera);
  }
  throw_if_cancelled();
  write_points_ply(dir / "points.ply", measurement.cloud,
                   measurement.cameras.empty() ? nullptr : &measurement.cameras.front());
}

}  // namespace fringetwin::measure
