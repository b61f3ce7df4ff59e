// SPDX-License-Identifier: Apache-2.0
#include "compare/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "compare/causes/causes.hpp"
#include "compare/causes/sensitivity.hpp"
#include "compare/gain/gain_checks.hpp"
#include "compare/gain/gain_trust.hpp"
#include "compare/geometry/fit_rows.hpp"
#include "compare/gray/gain_fit.hpp"
#include "compare/gray/gray_budget.hpp"
#include "compare/gray/gray_noise.hpp"
#include "compare/gray/gray_rows.hpp"
#include "compare/gray/interior_mask.hpp"
#include "compare/gray/noise_check.hpp"
#include "compare/parameters/closed_columns.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/pattern/what_is_left.hpp"
#include "compare/phase/constant_shift.hpp"
#include "compare/phase/phase_budget.hpp"
#include "compare/phase/phase_rows.hpp"
#include "compare/phase/shift_field.hpp"
#include "compare/refine/refined_budget.hpp"
#include "compare/result/milestones.hpp"
#include "compare/strangers/other_surfaces.hpp"
#include "compare/verdict/calibration_covariance.hpp"
#include "compare/verdict/coverage.hpp"
#include "compare/verdict/explain_code.hpp"
#include "compare/verdict/explained.hpp"
#include "compare/verdict/indicators.hpp"
#include "compare/verdict/limits.hpp"
#include "compare/verdict/rig_budget.hpp"
#include "compare/verdict/smoothed_shape.hpp"
#include "twin/base/parallel.hpp"
#include "twin/captures/measured_steps.hpp"

namespace fringetwin::compare {
namespace {

using measure::DirectionDecode;

constexpr std::size_t kCausePixels = 10'000;  ///< per camera: enough for causes that act on whole surfaces
constexpr double kFarPeriods = 0.4;  ///< further than this gray values say nothing of a small change's effect
constexpr double kManyOrders = 0.01;  ///< share of order disagreements that noise and outlines do not make

/// Adds the scatter of the directions that bounces take to what is known of how exactly a camera was
/// rendered.
void add_bounces(const Twin& twin, const CompareOptions& options, std::size_t camera, double gain_dn,
                 RenderingError& error) {
  if (!options.renderer || twin.render.bounces == 0) return;
  error.scatter_dn2 = gain_dn * gain_dn * bounce_scatter(*options.renderer, twin, camera);
  error.scatters_alike = kPixelsOfOneGathering;
  error.estimated = true;
}

/// Returns what every pixel of a camera has of its own, and what that was fitted to: by the refinement of
/// this run, or in the twin's own texture, which may be of these images or of others.
OwnOfPixels own_of_pixels(const Twin& twin, const CompareOptions& options, std::size_t camera) {
  OwnOfPixels own;
  const std::vector<PatternSpec> patterns = expand_sequence(twin.fringes);
  for (std::size_t k = 0; k < patterns.size(); ++k)
    if (patterns[k].kind == PatternSpec::Kind::phase_step) own.images.push_back(static_cast<int>(k));
  const PixelTexture* texture = twin.cameras[camera].texture.get();
  if (options.textured() && options.refinement->texture[camera])
    own.kinds = options.refinement->own;
  else if (texture) {
    own.kinds = {.factor = !texture->factor.empty(), .offset = !texture->offset.empty()};
    own.from_here = false;
  }
  return own;
}

/// Returns what the noise of a measured shape does to the shading of each pixel; nothing without one.
ShadingNoise shading_noise(const ShapeInView& shape) {
  if (!shape.noise || !shape.shades) return {};
  return {[shape](std::size_t pixel) { return shape.shading_at(pixel); }, shape.ambient};
}

/// What causes are fitted to, a camera each: the images that the gain is fitted on, and those with the images
/// of a code; the latter empty where no camera has more.
struct CauseSamples {
  std::vector<GridSamples> of_steps, with_codes;
};

/// Puts the verdict on a camera's code, if there is one, among the others, and what is to be said of its
/// light.
void take_code(std::optional<CodeVerdict> code, const GrayPair& pair, const Fringes& fringes,
               Comparison& out) {
  if (!code) return;
  if (std::string text = light_text(*code, pair, fringes); !text.empty())
    out.warnings.push_back(std::move(text));
  out.explained.push_back(std::move(code->row));
}

/// Fills the gray tables. It also collects the samples for a search for causes. A camera whose gain cannot be
/// fitted is judged along its provisional line: that is when budget and causes are needed.
CauseSamples compare_gray(const Twin& twin, const Side& real, const Side& simulated,
                          const CompareOptions& options, const RigBudget* rig, Milestones& progress,
                          Comparison& out) {
  CauseSamples samples;
  bool any_code = false;
  const std::vector<GrayPair> pairs = pair_gray(twin, real, simulated, options, out.warnings);
  std::vector<std::optional<GrayNoise>> noises(pairs.size());
  for_each_parallel(static_cast<int>(pairs.size()),
                    [&](int c) { noises[c].emplace(pairs[c], decode_of(real, c), options.use_steps); });
  for (std::size_t c = 0; c < pairs.size(); ++c) {
    progress.step();
    const GrayPair& pair = pairs[c];
    const measure::CameraDecode *real_decode = decode_of(real, c),
                                *simulated_decode = decode_of(simulated, c);
    const GrayNoise& noise = *noises[c];
    const GainFit fit = fit_gain(pair, out.warnings, &noise);
    out.gain.push_back(published_row(fit));
    if (!fit.has_line()) {
      if (!pair.real->radiance) out.explained.push_back(not_compared("gray", pair.camera->name, fit.row.why));
      continue;
    }
    for (GrayRow& row : gray_rows(twin, pair, fit)) out.gray.push_back(std::move(row));
    const OwnOfPixels own = own_of_pixels(twin, options, c);
    const ShapeInView shape = shape_in_view(options.shape_noise.get(), twin, c, real_decode);
    const auto budget = gray_budget(pair, fit, real_decode, simulated_decode, noise,
                                    shading_noise(shape_in_budget(shape, own)));
    if (budget) out.gray_budget.push_back(*budget);
    if (budget && !budget->waveform.empty())
      out.warnings.push_back(pair.camera->name + ": " + budget->waveform);
    if (twin.fringes.steps > 0)
      out.shift.push_back(shift_field(pairs[c], fit, noise_line(pairs[c], fit, budget)));
    if (pair.real->radiance) {  // no gray values, no noise model: nothing to judge against
      out.gain.back().state = "not offered";
      out.gain.back().why = "the real images are irradiance: there is no sensor";
      continue;
    }
    const ImageU8 interior = interior_mask(pair.mask, real_decode, simulated_decode);
    RenderingError rendering = rendering_error(*pair.camera, options.rendered, fit.row.gain_dn);
    add_bounces(twin, options, c, fit.row.gain_dn, rendering);
    ExplainedRow row = explain_gray(pair, fit, noise, interior, simulated_decode, rendering,
                                    rig ? RigVariance{&rig->irradiance[c], rig->line} : RigVariance{},
                                    seen_pixels(real_decode, simulated_decode), own, shape);
    if (!fit.row.usable && row.state != kNotCompared)  // along a provisional line nothing is explained
      row.worsen(kNotExplained, fit.row.why);
    out.explained.push_back(std::move(row));
    if (real_decode && simulated_decode && fit.row.usable)
      take_code(explain_code(pair, fit, noise,
                             {*real_decode, *simulated_decode, interior, pair.camera->texture.get(),
                              pair.camera->pixel_side_px()},
                             rendering, own, shape),
                pair, twin.fringes, out);
    if (fit.row.usable) {
      GainParts parts = gain_checks(twin.fringes, pair, fit, noise, interior);
      out.gain.back().dropped_fraction = parts.dropped_fraction;
      std::move(parts.rows.begin(), parts.rows.end(), std::back_inserter(out.gain_checks));
    }
    if (!options.renderer) continue;
    GridSamples grid = grid_samples(pair, c, fit, noise, interior, rendering.with_edges_dn, kCausePixels);
    if (grid.n_pixels() == 0) continue;
    find_texture_edges(pair, fit.usable, noise, grid);
    if (const std::vector<int> images = pair.gain_and_code_images(); images.size() > grid.images.size()) {
      any_code = true;
      samples.with_codes.push_back(
          grid_samples(pair, c, fit, noise, interior, rendering.with_edges_dn, kCausePixels, images));
      samples.with_codes.back().at_texture_edge = grid.at_texture_edge;
    } else
      samples.with_codes.push_back(grid);  // its steps say what they say beside another camera's code
    samples.of_steps.push_back(std::move(grid));
  }
  if (!any_code) samples.with_codes.clear();
  return samples;
}

/// Returns what a refinement was asked for, and each group of which it fitted all parameters: those of a ball
/// are its pose. A refinement knows all steps that no object was built from, whichever are compared.
std::vector<std::string> refined_groups(const Refinement& refinement, const Twin& twin) {
  std::vector<std::string> groups = refinement.asked;
  const auto is_fitted = [&refinement](const Parameter& p) {
    return std::ranges::find(refinement.rows, p.name, &RefinedRow::name) != refinement.rows.end();
  };
  for (const ParameterGroup& group : parameter_groups()) {
    const std::vector<Parameter> parameters = parameters_of(twin, group.name, left_over_steps(twin));
    if (!parameters.empty() && std::ranges::all_of(parameters, is_fitted)) groups.push_back(group.name);
  }
  return groups;
}

Sensitivity sensitivity_of(const Twin& twin, const CompareOptions& options,
                           std::vector<GridSamples> samples) {
  find_projector_places(*options.renderer, twin, samples);
  find_room_light(*options.renderer, twin, samples);
  Sensitivity sensitivity(*options.renderer, std::move(samples));
  sensitivity.add_scatter_of(twin);
  // what the pixels have of their own is taken from these images: no evidence
  if (options.textured()) sensitivity.free_in_all(free_per_pixel(options.refinement->own));
  return sensitivity;
}

bool names_blur(const Causes& causes) {
  return std::ranges::any_of(causes.together, [](const std::string& together) {
    const std::vector<std::string> groups = groups_in(together);
    return std::ranges::find(groups, "blur") != groups.end();
  });
}

/// Looks for the causes again with the images of a code: from the steps of one pitch a blur and a halo are
/// one number, its contrast, of which the edges of a code tell more. What they name is the answer; where they
/// name nothing, what the steps have named stays and the reader is told.
void look_at_codes(const Twin& twin, const CompareOptions& options, std::vector<GridSamples> samples,
                   Comparison& out) {
  Sensitivity sensitivity = sensitivity_of(twin, options, std::move(samples));
  Causes causes = find_causes(sensitivity, twin, out.fits, options.use_steps);
  if (causes.rows.empty()) return;
  if (!causes.together.empty() || out.causes.together.empty()) {
    out.causes = std::move(causes);
    return;
  }
  out.warnings.push_back(fmt::format(
      "{} explains the phase steps but not the images of the code (chi2 {:.3g} of a gray value with them): "
      "the light may be spread in another way, or these images lit in another",
      out.causes.together.front(), causes.chi2));
}

/// Does nothing where gray values are explained, those of a code, too. `other_fringes`: the warnings say that
/// other fringes were shown than described, or far from where; the best of wrong causes would be named.
void look_for_causes(const Twin& twin, const CompareOptions& options, CauseSamples samples,
                     bool other_fringes, Comparison& out) {
  // Causes are fitted to gray values: where these are explained, what fails (ripples, noise that the twin
  // understates, objects that it lacks) is none of them, and the best of wrong ones would be named.
  const bool any = std::ranges::any_of(out.explained, [](const ExplainedRow& row) {
    return row.state == kNotExplained && row.quantity != "coverage";
  });
  const std::string gray = worst_state(out.explained, "gray");
  const bool steps_fail = gray != kExplained && gray != kTooWide,
             code_fails = worst_state(out.explained, "code") == kNotExplained && !samples.with_codes.empty();
  if (!any || !(steps_fail || code_fails) || samples.of_steps.empty() || !twin.projector) return;
  if (other_fringes) {
    out.warnings.emplace_back(
        "no cause is looked for: the real images show other fringes than the twin, or show them "
        "elsewhere (see above)");
    return;
  }
  if (steps_fail) {
    Sensitivity sensitivity = sensitivity_of(twin, options, std::move(samples.of_steps));
    out.causes = find_causes(sensitivity, twin, out.fits, options.use_steps);
    if (!out.causes.rows.empty() && out.causes.together.empty())
      out.causes.pattern = pattern_of_rest(sensitivity, twin);
  }
  if (!samples.with_codes.empty() && (steps_fail ? names_blur(out.causes) : code_fails))
    look_at_codes(twin, options, std::move(samples.with_codes), out);
  if (options.refinement) out.causes.refined = refined_groups(*options.refinement, twin);
}

/// Holds against the verdict on a phase that the fringe orders of the two sides disagree on many pixels.
void judge_orders(const PhaseRow& phase, double farthest, ExplainedRow& row,
                  std::vector<std::string>& warnings) {
  if (!(phase.order_disagree_fraction() > kManyOrders)) return;
  const std::string share = fmt::format(
      "on {:.1f} % of the pixels valid on both sides the fringe orders disagree ({} pixels, "
      "|difference| > {})",
      100.0 * phase.order_disagree_fraction(), phase.n_order_disagree,
      farthest > std::numbers::pi ? "4.5 words" : "pi");
  row.worsen(kNotExplained, share);
  warnings.push_back(
      fmt::format("{} {}: {}; they are in no phase number, so the phase rows describe the rest only",
                  phase.camera, phase.direction, share));
}

/// Returns what a reader must know of fringes that all lie beside the twin's by the same distance.
std::string shift_text(const PhaseRow& phase, double shift_px, const DirectionDecode& real,
                       double origin_px) {
  const double pitch_px = real.pitches_px[real.finest];
  return fmt::format(
      "{} {}: the real fringes lie {:+.4g} px of the projector ({:.3g} of a period) beside those of the "
      "twin, all alike: phase_origin_px = {:.4g} in place of {:.4g} would fit, unless the projector's "
      "principal point or the pose is off by as much",
      phase.camera, phase.direction, shift_px, std::abs(shift_px) / pitch_px, origin_px - shift_px,
      origin_px);
}

/// The light of one camera's real images, told from them when it is first asked for.
class LightOfReal {
 public:
  LightOfReal(const Twin& twin, std::size_t camera, const Side& real)
      : twin_(twin), camera_(camera), real_(real) {}
  const std::optional<measure::LightFactors>& operator()() {
    if (is_known_) return light_;
    is_known_ = true;
    light_ = real_.measurement->cameras[camera_].light;  // where the decode looked for it
    if (!light_)
      light_ = measure::estimate_light(
          real_.images[camera_], twin_.fringes,
          measure::light_options(twin_.cameras[camera_].sensor, twin_.measure.min_modulation_dn));
    return light_;
  }

 private:
  const Twin& twin_;
  std::size_t camera_;
  const Side& real_;
  bool is_known_ = false;
  std::optional<measure::LightFactors> light_;
};

/// Puts what the light of the real images predicts into the phase budget, beside the ripple of brightness
/// that is in the difference.
void predict_brightness(const Twin& twin, std::size_t camera, const Side& real, const DirectionDecode& decode,
                        const CompareOptions& options, LightOfReal& light_of_real, Comparison& out) {
  if (out.phase_budget.empty() || real.images.empty() || real.images[camera].radiance ||
      real.measurement->cameras[camera].light_taken_out)
    return;
  const std::optional<measure::LightFactors>& light = light_of_real();
  PhaseBudget& budget = out.phase_budget.back();
  if (light && budget.camera == twin.cameras[camera].name && budget.direction == axis_name(decode.axis))
    budget.light_rad2 = predicted_brightness_rad2(twin, camera, decode, options.use_steps, *light);
}

/// Fills the phase tables, with their budgets or without. Returns whether the real fringes lie so far beside
/// the twin's that no cause can be fitted to gray values.
bool compare_phase(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options,
                   const RigBudget* rig, bool with_budgets, Milestones* progress, Comparison& out) {
  bool is_far_off = false;
  out.phase = phase_rows(twin, *real.measurement, *simulated.measurement);
  auto phase = out.phase.cbegin();  // has the same cameras and directions in the same order
  for (std::size_t c = 0; c < real.measurement->cameras.size(); ++c) {
    if (progress) progress->step();
    const measure::CameraDecode *real_decode = decode_of(real, c),
                                *simulated_decode = decode_of(simulated, c);
    const ImageU8 interior =
        interior_mask(valid_in_both(twin.cameras[c], c, real, simulated), real_decode, simulated_decode);
    const SeenPixels seen = seen_pixels(real_decode, simulated_decode);
    const RenderingError rendering = rendering_error(twin.cameras[c], options.rendered, 1.0);
    LightOfReal light(twin, c, real);
    const ShapeInView shape = shape_in_view(options.shape_noise.get(), twin, c, real_decode);
    for (std::size_t d = 0; d < real_decode->directions.size(); ++d) {
      const DirectionDecode& r = real_decode->directions[d];
      const DirectionDecode* s = simulated_decode->direction(r.axis);
      if (!s || r.coordinate_px.empty() || s->coordinate_px.empty() || r.pitches_px.empty()) continue;
      if (auto budget = with_budgets ? phase_budget(twin, r, *s, options.use_steps) : std::nullopt) {
        budget->camera = real_decode->camera;
        budget->direction = axis_name(r.axis);
        out.phase_budget.push_back(std::move(*budget));
      }
      const TextureShift texture =
          texture_shift(r, *s, twin.cameras[c].texture.get(), twin.cameras[c].pixel_side_px());
      out.explained.push_back(
          explain_phase(real_decode->camera, r, *s, interior, texture, rendering,
                        rig ? RigVariance{&rig->phase_rad2[c][d], rig->line} : RigVariance{}, seen, shape));
      if (auto ripple = test_ripple(twin, r, *s, options.use_steps, interior, texture)) {
        count_shape(shape, r, *s, interior, *ripple);
        judge_ripple(*ripple, rendering, r, *s, out.explained.back());
      }
      if (out.explained.back().brightness_chi2 > out.explained.back().ripple_limit)
        predict_brightness(twin, c, real, r, options, light, out);
      judge_orders(*phase, farthest_rad(r), out.explained.back(), out.warnings);
      if (const auto shift_px = r.unwrapped && s->unwrapped ? constant_shift_px(r, *s) : std::nullopt) {
        const double pitch_px = r.pitches_px[r.finest];
        is_far_off = is_far_off || std::abs(*shift_px) > kFarPeriods * pitch_px;
        out.warnings.push_back(shift_text(*phase, *shift_px, r, phase_origin_px(twin, r)));
      }
      ++phase;
    }
  }
  return is_far_off;
}

/// Returns the budget of the calibration; nothing where none is asked for, or nothing real is there to hold
/// it against. With `warnings` of what is in none.
std::optional<RigBudget> calibration_of(const Twin& twin, const Side& real, const Side& simulated,
                                        const CompareOptions& options, std::vector<std::string>& warnings) {
  if (!twin.calibration_uncertainty || (real.images.empty() && twin.real.results.empty()))
    return std::nullopt;
  if (!options.renderer) {
    warnings.emplace_back(
        "[uncertainty] calibration is in no budget: that takes renderings of changed rigs, which `cosim` "
        "makes");
    return std::nullopt;
  }
  return rig_budget(
      twin,
      one_sigma_away(twin, options.calibration ? *options.calibration : read_calibration_covariance(twin)),
      kCalibrationLine, rig_budget_options(twin, simulated, options));
}

std::vector<NoiseRow> all_noise_rows(const Twin& twin, const Side& real, const Side& simulated,
                                     const CompareOptions& options) {
  std::vector<NoiseRow> all;
  if (!real.measurement || real.images.empty()) return all;
  std::vector<std::vector<NoiseRow>> of_camera(twin.cameras.size());
  for_each_parallel(static_cast<int>(of_camera.size()), [&](int c) {
    of_camera[c] =
        noise_rows(twin.cameras[c], twin.fringes, real.images[c], real.measurement->cameras[c],
                   options.use_steps, simulated.irradiance.empty() ? nullptr : &simulated.irradiance[c]);
  });
  for (std::vector<NoiseRow>& rows : of_camera) std::ranges::move(rows, std::back_inserter(all));
  return all;
}

/// A comparison up to its verdicts, and what its causes are fitted to.
struct Judged {
  Comparison comparison;
  CauseSamples samples = {};
  bool is_far_off = false;  ///< no cause can be fitted to gray values
};

/// Compares two sides. `rig`: what is uncertain of the rig; null: nothing.
Judged judge(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options,
             const RigBudget* rig) {
  Judged judged;
  Comparison& out = judged.comparison;
  out.refinement = options.refinement;
  out.held_out = options.held_out;
  for (const Side* side : {&real, &simulated})
    if (side->measurement)
      for (const std::string& warning : side->measurement->warnings)
        out.warnings.push_back((side == &real ? "real: " : "simulated: ") + warning);
  if (out.refinement)
    out.warnings.insert(out.warnings.end(), out.refinement->warnings.begin(), out.refinement->warnings.end());
  if (rig) std::ranges::copy(rig->warnings, std::back_inserter(out.warnings));
  Milestones progress("compare",
                      2 * twin.cameras.size() + 3);  // gray and phase of each camera, and what is around
  out.fits = fit_rows(twin, real, simulated, out.warnings);
  out.indicators = indicators(twin, out.fits);
  if (real.measurement) add_light_rows(*real.measurement, "real", out.light);
  if (simulated.measurement) add_light_rows(*simulated.measurement, "simulated", out.light);
  progress.step();
  judged.samples = compare_gray(twin, real, simulated, options, rig, progress, out);
  out.noise = all_noise_rows(twin, real, simulated, options);
  judged.is_far_off = real.measurement && simulated.measurement &&
                      compare_phase(twin, real, simulated, options, rig, true, &progress, out);
  progress.step();
  out.coverage = coverage_rows(twin, real, simulated);
  for (ExplainedRow& row : explain_coverage(twin, out.coverage)) out.explained.push_back(std::move(row));
  out.other_surfaces = other_surfaces(twin, real, simulated);
  hold_against_surfaces(out.other_surfaces, out.explained);
  for (const OtherSurfaceRow& surface : out.other_surfaces)
    out.warnings.push_back(surface.camera + ": " + surface.why);
  for (std::string& warning : coverage_warnings(out.coverage, out.other_surfaces))
    out.warnings.push_back(std::move(warning));
  for (ExplainedRow& row : explain_geometry(out.fits, rig)) out.explained.push_back(std::move(row));
  hold_against_noise(out.noise, out.explained);
  std::vector<OwnKinds> own;
  for (const GainRow& row : out.gain)
    for (std::size_t c = 0; c < twin.cameras.size(); ++c)
      if (twin.cameras[c].name == row.camera) own.push_back(own_of_pixels(twin, options, c).kinds);
  trust_gains(out, own);
  progress.finish();
  return judged;
}

}  // namespace

Comparison compare(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options) {
  std::vector<std::string> warnings;
  std::optional<RigBudget> rig = calibration_of(twin, real, simulated, options, warnings);
  const auto add_refined = [&rig](const RigBudget& refined) {
    rig = rig ? together(std::move(*rig), refined) : refined;
  };
  if (options.refined_budget) add_refined(*options.refined_budget);
  Judged judged = judge(twin, real, simulated, options, rig ? &*rig : nullptr);
  if (!options.refined_budget)
    if (const auto refined = refined_budget(twin, simulated, options, judged.comparison.explained)) {
      add_refined(*refined);
      judged = judge(twin, real, simulated, options, &*rig);
    }
  Comparison out = std::move(judged.comparison);
  std::ranges::move(warnings, std::back_inserter(out.warnings));
  out.shows_other_fringes = options.shows_other_fringes || judged.is_far_off;
  out.smooths_a_form_away = doubt_smoothing(options.shape_noise.get(), out.explained, out.warnings);
  if (!out.smooths_a_form_away)
    look_for_causes(twin, options, std::move(judged.samples), out.shows_other_fringes, out);
  out.limits = check_limits(twin.limits, out);
  for (const LimitRow& row : out.limits)
    if (row.value != row.value)
      out.warnings.push_back("limit " + row.name + " cannot be checked: this comparison has no such number");
  out.pass = std::ranges::all_of(out.limits, [](const LimitRow& row) { return row.pass; });
  return out;
}

std::vector<ExplainedRow> explain_phases(const Twin& twin, const Side& real, const Side& simulated,
                                         const CompareOptions& options) {
  Comparison out;
  if (real.measurement && simulated.measurement)
    compare_phase(twin, real, simulated, options, options.refined_budget.get(), false, nullptr, out);
  return std::move(out.explained);
}

}  // namespace fringetwin::compare
