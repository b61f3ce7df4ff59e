// SPDX-License-Identifier: Apache-2.0
#include "calib/photometry/photometry.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "calib/photometry/exposure_linearity.hpp"
#include "measure/decode/decode_input.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::calib {
namespace {

constexpr std::size_t kMaxSamples = 4'000'000;
// Second differences of every second triple along the stripes: they share a pixel, and 1 + 2 (1/6)^2 of them
// are worth one.
constexpr double kStepOverlap = 1.0 + 2.0 / 36.0;
constexpr double kQuadratureNews = 0.01, kBlurMisfitNews = 0.05;

std::vector<const GrayImage*> pointers(const std::vector<GrayImage>& images) {
  std::vector<const GrayImage*> out;
  for (const GrayImage& image : images) out.push_back(&image);
  return out;
}

double mean_of(const GrayImage& image) {
  double sum = 0.0;
  image.for_each([&sum](float v) { sum += static_cast<double>(v); });
  return sum / static_cast<double>(image.size());
}

/// Black level and noise in the dark.
void add_dark(const std::vector<GrayImage>& dark, double saturation_dn, CameraPhotometry& out,
              std::vector<std::string>& warnings) {
  if (dark.empty()) return;
  std::size_t zeros = 0, n = 0;
  std::vector<double> means;
  for (const GrayImage& image : dark) {
    image.for_each([&zeros](float v) { zeros += v == 0.0F ? 1 : 0; });
    n += image.size();
    means.push_back(mean_of(image));
  }
  if (static_cast<double>(zeros) > 0.01 * static_cast<double>(n)) {
    warnings.push_back(
        fmt::format("camera {}: {:.0f} % of the dark values are 0, so their noise is cut off and neither "
                    "black level nor read noise is taken from them; raise the camera's offset",
                    out.camera, 100.0 * static_cast<double>(zeros) / static_cast<double>(n)));
    return;
  }
  double mean = 0.0, spread = 0.0;
  for (const double m : means) mean += m / static_cast<double>(means.size());
  for (const double m : means) spread += std::pow(m - mean, 2);
  const auto k = static_cast<double>(means.size());
  // From image to image; a single one says no better than the rounding.
  out.black_level_dn = {mean, k > 1.0 ? std::sqrt(spread / (k * (k - 1.0))) : std::sqrt(kRoundingVariance)};
  out.black_measured = true;
  if (dark.size() < 2) return;
  std::vector<NoiseSample> samples;
  add_repeat_noise(pointers(dark), saturation_dn, kMaxSamples, samples);
  const Estimate variance = noise_variance(samples);
  if (!(variance.value > kRoundingVariance)) return;
  out.dark_noise_dn.value = std::sqrt(variance.value - kRoundingVariance);
  out.dark_noise_dn.sigma = 0.5 * variance.sigma / out.dark_noise_dn.value;
}

/// All that is there more than once; true when anything is.
bool collect_repeats(const CameraFrames& frames, double saturation_dn, bool dark_usable,
                     std::vector<NoiseSample>& samples, double& flicker) {
  std::vector<std::vector<const GrayImage*>> groups;
  if (frames.captures.size() > 1)
    for (std::size_t k = 0; k < frames.captures[0].images.size(); ++k) {
      groups.emplace_back();
      for (const CameraImages& capture : frames.captures) groups.back().push_back(&capture.images[k]);
    }
  for (const StillSeries& series : frames.series)
    if (series.images.size() > 1) groups.push_back(pointers(series.images));
  if (groups.empty()) return false;
  if (dark_usable && frames.dark.size() > 1) groups.push_back(pointers(frames.dark));
  double sum = 0.0;
  for (const auto& group : groups)
    sum += std::pow(add_repeat_noise(group, saturation_dn, kMaxSamples / groups.size(), samples), 2);
  flicker = std::sqrt(sum / static_cast<double>(groups.size()));
  return true;
}

void collect_step_noise(const Twin& twin, const CameraImages& capture, double saturation_dn,
                        std::vector<NoiseSample>& samples) {
  const std::vector<int> used = measure::all_steps(twin.fringes.steps);
  const measure::StepSolver solver(used, twin.fringes.steps);
  std::size_t sets = 0;
  for (const DirectionFringes& d : twin.fringes.directions) sets += d.pitches_px.size();
  for (std::size_t d = 0; d < twin.fringes.directions.size(); ++d) {
    const auto images = measure::collect_direction(capture, twin.fringes, static_cast<int>(d), used);
    for (const auto& steps : images.steps)
      add_step_noise(steps, solver, twin.fringes.directions[d].axis, saturation_dn, kMaxSamples / sets,
                     samples);
  }
}

void measure_transfer(const Twin& twin, const CameraFrames& frames, double saturation_dn,
                      CameraPhotometry& out, std::vector<std::string>& warnings) {
  std::vector<NoiseSample> samples;
  TransferOptions options;
  options.black_level_dn = out.black_measured ? out.black_level_dn.value : out.sensor.black_level_dn;
  if (collect_repeats(frames, saturation_dn, out.black_measured, samples, out.flicker)) {
    out.noise_from = "repeats";
  } else if (!frames.captures.empty() && twin.fringes.steps > 3) {
    collect_step_noise(twin, frames.captures[0], saturation_dn, samples);
    out.noise_from = "phase steps";
    options.samples_per_independent = kStepOverlap;
  } else {
    warnings.push_back(fmt::format(
        "camera {}: no photon transfer: it needs repeated captures or series, or 4 phase steps and more",
        out.camera));
    return;
  }
  try {
    out.transfer = photon_transfer(samples, options, "camera " + out.camera);
  } catch (const UserError& e) {
    if (e.code() != ExitCode::input) throw;
    warnings.push_back(std::string("no photon transfer: ") + e.what());
    out.noise_from.clear();
  }
}

/// Fits the camera's response to the series with an exposure; a warning where their curve is none.
void measure_response(const CameraFrames& frames, double saturation_dn, CameraPhotometry& out,
                      std::vector<std::string>& warnings) {
  std::vector<ExposedBlocks> images;
  for (const StillSeries& series : frames.series)
    if (series.exposure_ms)
      images.push_back(exposed_blocks(series.images, *series.exposure_ms, saturation_dn));
  const double black_dn = out.black_measured ? out.black_level_dn.value : out.sensor.black_level_dn;
  try {
    out.response = fit_response(std::move(images), black_dn, "camera " + out.camera);
  } catch (const UserError& e) {
    if (e.code() != ExitCode::input) throw;
    warnings.push_back(std::string("no camera response: ") + e.what());
  }
  if (out.response) out.sensor.response = out.response->response;
}

void warn_of_fringes(const ProjectorPhotometry& p, const std::string& where,
                     std::vector<std::string>& warnings) {
  for (const PitchHarmonics& pitch : p.harmonics.pitches)
    for (std::size_t k = 1; k < pitch.quadrature.size(); ++k) {
      const Estimate q = pitch.quadrature[k];
      if (std::abs(q.value) < kQuadratureNews || std::abs(q.value) < 5.0 * q.sigma) continue;
      warnings.push_back(
          fmt::format("{}, pitch {:.6g}: harmonic {} is out of phase by {:.1f} % of the fundamental; are the "
                      "phase steps equal, and was everything at rest?",
                      where, pitch.pitch_px, k + 1, 100.0 * q.value));
    }
  if (p.blur_misfit > kBlurMisfitNews)
    warnings.push_back(
        fmt::format("{}: the contrast does not fall with the pitch as a Gaussian blur lets it (off by {:.0f} "
                    "%); blur_px is a compromise",
                    where, 100.0 * p.blur_misfit));
}

void measure_projector(const Twin& twin, std::size_t camera, const CameraFrames& frames, double saturation_dn,
                       CameraPhotometry& out, std::vector<std::string>& warnings) {
  if (frames.captures.empty() || twin.fringes.steps < 3) return;
  for (std::size_t d = 0; d < twin.fringes.directions.size(); ++d) {
    const DirectionFringes& direction = twin.fringes.directions[d];
    const auto images = measure::collect_direction(frames.captures[0], twin.fringes, static_cast<int>(d),
                                                   measure::all_steps(twin.fringes.steps));
    HarmonicsOptions options{.min_modulation_dn = twin.measure.min_modulation_dn,
                             .saturation_dn = saturation_dn,
                             .pixel_fill = twin.sampled_side_px(twin.cameras[camera]),
                             .psf_px = twin.cameras[camera].psf_px * twin.cameras[camera].pixel_side_px()};
    const std::string where = fmt::format("camera {}, direction {}", out.camera, axis_name(direction.axis));
    if (twin.fringes.waveform.kind != Waveform::Kind::sine) {
      warnings.push_back(
          where + ": the projector's response is found from sinusoids alone, [fringes] waveform is none");
      continue;
    }
    FringeHarmonics harmonics = fringe_harmonics(images.steps, direction, options);
    if (harmonics.n < 1000) {
      warnings.push_back(
          fmt::format("{}: only {} pixels are modulated by {:.4g} DN at every pitch and not saturated; too "
                      "few for the projector's response",
                      where, harmonics.n, options.min_modulation_dn));
      continue;
    }
    out.directions.push_back(
        projector_photometry(std::move(harmonics), twin.fringes.mean, twin.fringes.amplitude));
    out.directions.back().blur_of_twin_px = twin.projector ? twin.projector->blur_px : 0.0;
    warn_of_fringes(out.directions.back(), where, warnings);
  }
}

/// The twin's sensor with what was measured.
void update_sensor(CameraPhotometry& out) {
  if (out.black_measured) out.sensor.black_level_dn = out.black_level_dn.value;
  if (!out.transfer) {
    if (std::isfinite(out.dark_noise_dn.value)) out.sensor.read_noise_dn = out.dark_noise_dn.value;
    return;
  }
  PhotonTransfer& t = *out.transfer;
  if (std::isfinite(out.dark_noise_dn.value)) {  // directly, not by extrapolation
    t.read_noise_dn = out.dark_noise_dn;
    t.read_noise_electrons = {t.read_noise_dn.value * t.electrons_per_dn.value,
                              t.read_noise_dn.sigma * t.electrons_per_dn.value};
  }
  if (!out.black_known) t.read_noise_dn = t.read_noise_electrons = t.read_variance_dn2 = {};
  out.sensor.electrons_per_dn = t.electrons_per_dn.value;
  if (out.black_known) out.sensor.read_noise_dn = t.read_noise_dn.value;
}

/// Says what is not told, or wrong, because nothing says the black level.
void warn_of_unknown_black(const CameraPhotometry& camera, std::vector<std::string>& warnings) {
  if (camera.black_known) return;
  std::vector<std::string> without;
  if (camera.transfer) without.push_back("the read noise, which is the noise at that level, is not told");
  if (camera.flat)
    without.push_back(
        "vignetting and prnu are too small by the black level's share of the gray values, and --into "
        "leaves them out");
  if (camera.light && camera.light->differ())
    without.push_back(
        "light_factors and exposure_factors are nearer to 1 than those of the light, by that share of the "
        "gray values");
  if (!without.empty())
    warnings.push_back(fmt::format(
        "camera {}: neither dark images nor the twin, which has no black_level_dn, say the black level: {}; "
        "give --dark, or state black_level_dn",
        camera.camera, fmt::join(without, "; ")));
}

void measure_flat(const CameraFrames& frames, double saturation_dn,
                  const std::optional<MosaicChannel>& channel, CameraPhotometry& out) {
  if (frames.flat.empty()) return;
  ImageF mean(frames.flat[0].width, frames.flat[0].height);
  bool clipped = false;
  for (const GrayImage& image : frames.flat) {
    if (!image.same_size(mean))
      throw UserError(ExitCode::input, "--flat", "the images of camera " + out.camera + " differ in size");
    for (std::size_t i = 0; i < mean.size(); ++i) {
      clipped = static_cast<double>(image[i]) >= saturation_dn;
      // One clipped image spoils the mean of a pixel.
      mean.data[i] = clipped ? std::numeric_limits<float>::infinity()
                             : mean.data[i] + image[i] / static_cast<float>(frames.flat.size());
    }
  }
  out.flat = fit_flat_field(mean, out.black_measured ? out.black_level_dn.value : out.sensor.black_level_dn,
                            saturation_dn, "camera " + out.camera, channel);
}

/// Says of a map that it is no better than none.
std::string no_map(const std::string& key, const PixelMapEstimate& map, double scale, const std::string& unit,
                   const std::string& camera) {
  return fmt::format(
      "camera {}: the pixels differ by {:.2g} {}, which the means of {} images tell to {:.2g}: no {} map is "
      "written; give more images",
      camera, scale * map.rms, unit, map.n_images, scale * map.noise, key);
}

/// What each pixel has of its own, from repeated dark and flat images.
void measure_maps(const CameraFrames& frames, double saturation_dn, CameraPhotometry& out,
                  std::vector<std::string>& warnings) {
  if (out.black_measured) out.offsets = pixel_offsets(frames.dark);
  if (out.offsets && !out.offsets->is_told())
    warnings.push_back(no_map("dsnu", *out.offsets, 1.0, "DN", out.camera));
  if (!out.flat) return;
  out.factors = pixel_factors(
      frames.flat,
      {.black_level_dn = out.black_measured ? out.black_level_dn.value : out.sensor.black_level_dn,
       .saturation_dn = saturation_dn,
       .response = out.sensor.response,
       .offsets = out.offsets && out.offsets->is_told() ? &*out.offsets : nullptr,
       .field = *out.flat});
  if (out.factors && !out.factors->is_told())
    warnings.push_back(no_map("prnu", *out.factors, 100.0, "%", out.camera));
  if (out.factors && !out.offsets)
    warnings.push_back(fmt::format(
        "camera {}: without two dark images the pixels' offsets are in their factors (prnu)", out.camera));
}

/// The light of each image, by the phase steps; black level and noise as far as they are known by now.
void measure_light(const Twin& twin, const CameraFrames& frames, CameraPhotometry& out) {
  if (frames.captures.empty()) return;
  CameraImages images = frames.captures[0];
  images.clip = Clip{out.saturation.level_dn, 0};
  out.light = measure::estimate_light(images, twin.fringes,
                                      measure::light_options(out.sensor, twin.measure.min_modulation_dn));
}

/// Returns whether two cameras say the same of every image, but for chance.
bool say_the_same(const measure::LightFactors& a, const measure::LightFactors& b) {
  constexpr double kSigmas = 4.0;
  for (std::size_t k = 0; k < a.factor.size(); ++k)
    if (std::abs(std::log(a.factor[k] / b.factor[k])) > kSigmas * std::hypot(a.sigma[k], b.sigma[k]))
      return false;
  return true;
}

void choose_projector(Photometry& out) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < out.cameras.size(); ++c)
    for (std::size_t d = 0; d < out.cameras[c].directions.size(); ++d) {
      const ProjectorPhotometry& p = out.cameras[c].directions[d];
      const double sigma = std::isfinite(p.gamma.sigma)     ? p.gamma.sigma
                           : std::isfinite(p.blur_px.sigma) ? 1e3 + p.blur_px.sigma
                                                            : 1e9;
      if (!(sigma < best)) continue;
      best = sigma;
      out.projector_camera = static_cast<int>(c);
      out.projector_direction = static_cast<int>(d);
    }
}

}  // namespace

const ProjectorPhotometry* Photometry::projector() const {
  if (projector_camera < 0) return nullptr;
  return &cameras[projector_camera].directions[projector_direction];
}

std::optional<LightOfImages> light_of_images(const Photometry& photometry) {
  std::vector<const measure::LightFactors*> told;
  bool differ = false, same = true;
  for (const CameraPhotometry& c : photometry.cameras) {
    told.push_back(c.light ? &*c.light : nullptr);
    differ = differ || (c.light && c.light->differ());
    same = same &&
           (!c.light || !photometry.cameras[0].light || say_the_same(*photometry.cameras[0].light, *c.light));
  }
  if (!differ) return std::nullopt;
  LightOfImages out;
  if (!same) {
    out.light_factors = told[0]->factor, out.sigma = told[0]->sigma;
    for (const measure::LightFactors* camera : told) {
      std::vector<double>& exposure = out.exposure_factors.emplace_back();
      for (std::size_t k = 0; camera && camera != told[0] && k < camera->factor.size(); ++k)
        exposure.push_back(camera->factor[k] / told[0]->factor[k]);
    }
    return out;
  }
  std::erase(told, nullptr);
  for (std::size_t k = 0; k < told[0]->factor.size(); ++k) {
    double weights = 0.0, sum = 0.0;
    bool is_step = false;
    for (const measure::LightFactors* camera : told)
      if (camera->sigma[k] > 0.0) {
        is_step = true;
        const double weight = 1.0 / (camera->sigma[k] * camera->sigma[k]);
        weights += weight, sum += weight * std::log(camera->factor[k]);
      }
    out.light_factors.push_back(weights > 0.0 ? std::exp(sum / weights) : 1.0);
    out.sigma.push_back(is_step ? 1.0 / std::sqrt(weights) : 0.0);
  }
  return out;
}

Photometry analyse_photometry(const Twin& twin, const std::vector<CameraFrames>& frames) {
  FT_CHECK(frames.size() == twin.cameras.size(), "frames of every camera");
  Photometry out;
  bool anything = false;
  for (std::size_t c = 0; c < frames.size(); ++c) {
    CameraPhotometry camera;
    camera.camera = twin.cameras[c].name;
    camera.sensor = twin.cameras[c].sensor;
    std::vector<const GrayImage*> all;
    for (const CameraImages& capture : frames[c].captures) {
      if (capture.radiance)
        throw UserError(ExitCode::input, "camera " + camera.camera,
                        "the captures are irradiance (EXR), which holds no gray values", "give PNG captures");
      for (const GrayImage& image : capture.images) all.push_back(&image);
      if (capture.white) all.push_back(&*capture.white);
    }
    for (const StillSeries& series : frames[c].series)
      for (const GrayImage& image : series.images) all.push_back(&image);
    camera.saturation = find_saturation(all, camera.sensor.bit_depth);
    const double saturation = camera.saturation.level_dn;
    add_dark(frames[c].dark, saturation, camera, out.warnings);
    // Dark images that are cut off at 0 say that it is about 0.
    camera.black_known =
        !frames[c].dark.empty() || camera.sensor.black_level_is_stated || camera.sensor.black_level_dn > 0.0;
    measure_transfer(twin, frames[c], saturation, camera, out.warnings);
    camera.linearity = exposure_linearity(frames[c].series, saturation, camera.camera, out.warnings);
    measure_response(frames[c], saturation, camera, out.warnings);
    measure_flat(frames[c], saturation, twin.cameras[c].channel, camera);
    measure_maps(frames[c], saturation, camera, out.warnings);
    measure_projector(twin, c, frames[c], saturation, camera, out.warnings);
    update_sensor(camera);
    measure_light(twin, frames[c], camera);
    warn_of_unknown_black(camera, out.warnings);
    anything = anything || camera.transfer || camera.response || camera.flat || camera.black_measured ||
               !camera.directions.empty();
    out.cameras.push_back(std::move(camera));
  }
  if (!anything)
    throw UserError(ExitCode::input, twin.file.string(),
                    "nothing can be told from these images" +
                        (out.warnings.empty() ? "" : " (" + out.warnings.front() + ")"));
  choose_projector(out);
  return out;
}

}  // namespace fringetwin::calib
