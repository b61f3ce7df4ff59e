// SPDX-License-Identifier: Apache-2.0
#include "tradeoff/needs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosim/fit_error.hpp"
#include "cosim/load.hpp"
#include "render/sensor/all_cameras.hpp"
#include "tradeoff/reference_values.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::tradeoff {
namespace {

void scale_images(CameraImages& images, double factor) {
  const auto scale = [factor](std::vector<float>& values) {
    for (float& v : values) v = static_cast<float>(factor * static_cast<double>(v));
  };
  for (GrayImage& image : images.images) scale(image.as_floats());
  if (images.white) scale(images.white->as_floats());
  if (images.black) scale(images.black->as_floats());
}

/// One model of the scene, rendered, exposed and measured; only what the comparison needs is kept.
struct ModelRun {
  std::vector<PixelValues> light_dn, sensor_dn;  // at the subset's pixels
  std::vector<measure::ObjectFit> fits;
  render::Sampling sampling;  // as done
  Elapsed time;
};

/// Runs models of one scene alike, and compares what they cost and show.
class ModelBench {
 public:
  ModelBench(const Twin& base, render::Renderer& renderer, const PixelSubset& subset,
             const NeedsOptions& options)
      : base_(base), renderer_(renderer), subset_(subset), options_(options) {}

  ModelRun run(const Twin& model) const {
    ModelRun out;
    const Stopwatch watch;
    const auto rendered = render::render_all(renderer_, model, options_.seed);
    const auto captures = expose_in_units_of(base_, model, rendered, options_.seed);
    out.time = watch.elapsed();
    out.sampling = rendered.front().sampling;
    for (const render::RenderedCamera& c : rendered)
      if (c.sampling.sampler != Sampler::adaptive) out.sampling = c.sampling;
    // the sensor's units are the base's for every model, so that gray values can be subtracted
    out.light_dn = dn_from_images(base_, subset_, rendered);
    for (std::size_t i = 0; i < captures.size(); ++i)
      out.sensor_dn.push_back(take_pixels(captures[i].images, subset_.cameras[i].pixels));
    if (cosim::can_fit(base_)) out.fits = cosim::fits_in_order(base_, measure::measure(base_, captures));
    return out;
  }
  Elapsed time(const Twin& model) const {
    const Stopwatch watch;
    expose_in_units_of(base_, model, render::render_all(renderer_, model, options_.seed), options_.seed);
    return watch.elapsed();
  }
  /// In turns; the smallest of each side. A side known to be slow is not repeated.
  void time_both(const Twin& with, const Twin& without, Elapsed& time_with, Elapsed& time_without) const {
    if (time_with.wall_s > options_.once_above_s || time_without.wall_s > options_.once_above_s) return;
    for (int round = 0; round < options_.rounds; ++round) {
      const Elapsed a = time(with), b = time(without);
      const auto smaller = [round](Elapsed& best, const Elapsed& now) {
        // the first run of a model also builds its pipeline: it does not count
        if (round == 0) best = now;
        best.wall_s = std::min(best.wall_s, now.wall_s);
        best.cpu_s = std::min(best.cpu_s, now.cpu_s);
      };
      smaller(time_with, a);
      smaller(time_without, b);
    }
  }
  ImageChange change(EffectStage stage, const ModelRun& a, const ModelRun& b) const {
    ChangeSum sum(base_.fringes, base_.measure.min_modulation_dn);
    for (std::size_t i = 0; i < subset_.cameras.size(); ++i)
      stage == EffectStage::light ? sum.add(subset_.cameras[i].pixels, a.light_dn[i], b.light_dn[i])
                                  : sum.add(subset_.cameras[i].pixels, a.sensor_dn[i], b.sensor_dn[i]);
    return sum.result();
  }
  double ratio(const Elapsed& a, const Elapsed& b) const {
    return renderer_.device().is_cpu ? a.cpu_s / b.cpu_s : a.wall_s / b.wall_s;
  }

 private:
  const Twin& base_;
  render::Renderer& renderer_;
  const PixelSubset& subset_;
  const NeedsOptions& options_;
};

std::vector<FitChange> fit_changes(const ModelRun& with, const ModelRun& without) {
  std::vector<FitChange> out;
  for (std::size_t k = 0; k < with.fits.size(); ++k)
    out.push_back({with.fits[k].object, cosim::fit_distance_mm(with.fits[k], without.fits[k]), with.fits[k].n,
                   without.fits[k].n});
  return out;
}

/// Returns the twin with the sampling of this run. Where an effect keeps the adaptive trace from the scene,
/// all models are rendered by the fixed rule that stands in for it: else the effect would be charged with the
/// difference between the two.
Twin with_sampling_of(const Twin& twin, const ModelRun& run) {
  Twin out = twin;
  if (render::choose_sampling(twin).sampler == run.sampling.sampler) return out;
  out.render.sampler = run.sampling.sampler;
  out.render.samples = run.sampling.samples;
  return out;
}

double largest_mm(const std::vector<FitChange>& fits) {
  double largest = kNaN;
  for (const FitChange& f : fits)
    largest = std::isnan(largest) ? f.change_mm : std::max(largest, f.change_mm);
  return largest;
}

/// Returns the change of the phase, +inf where no pixel is modulated on both sides though the sequence has
/// phase steps: the phases are lost.
double judged_phase(const ImageChange& change, bool has_phase) {
  return has_phase && change.n_phase == 0 ? std::numeric_limits<double>::infinity() : change.phase_rms_rad;
}

Twin without_effects(const Twin& twin, const NeedsResult& result) {
  Twin reduced = twin;
  for (std::size_t i = 0; i < result.rows.size(); ++i)
    if (result.rows[i].leave_off) effects()[i].switch_off(reduced);
  return reduced;
}

/// Chooses what to leave off. Effects need not superpose: the chosen model is measured as a whole, and what
/// was chosen last goes back in until it is within the tolerance.
void settle_recommendation(const Twin& twin, const ModelBench& bench, const ModelRun& full, bool has_phase,
                           const NeedsOptions& options, NeedsResult& result) {
  std::vector<std::size_t> rows;
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < result.rows.size(); ++i)
    if (result.rows[i].on) {
      rows.push_back(i);
      // costs closer than the timing can tell apart are equal
      candidates.push_back({result.rows[i].judged(), std::round(20.0 * result.rows[i].cost) / 20.0});
    }
  std::vector<std::size_t> chosen = leave_off(candidates, options.tolerance);
  for (const std::size_t k : chosen) result.rows[rows[k]].leave_off = true;
  result.full_time = full.time;
  result.reduced_time = full.time;
  for (; !chosen.empty(); chosen.pop_back()) {
    const Twin reduced = without_effects(twin, result);
    const ModelRun run = bench.run(reduced);
    const ImageChange light = bench.change(EffectStage::light, full, run),
                      sensor = bench.change(EffectStage::sensor, full, run);
    // rounding noise in the sensor's values must not be charged to a model that keeps the sensor
    bool touches_sensor = false;
    for (const EffectRow& row : result.rows)
      touches_sensor = touches_sensor || (row.leave_off && row.stage == EffectStage::sensor);
    const ImageChange& change = touches_sensor ? sensor : light;
    result.reduced = {judged_phase(change, has_phase), change.gray_rms_dn,
                      largest_mm(fit_changes(full, run))};
    if (within(result.reduced, options.tolerance)) {
      result.reduced_time = run.time;
      bench.time_both(twin, reduced, result.full_time, result.reduced_time);
      result.reduced_cost = bench.ratio(result.full_time, result.reduced_time);
      return;
    }
    result.rows[rows[chosen.back()]].leave_off = false;
    result.warnings.push_back(fmt::format(
        "left off together, the effects change more than each by itself: \"{}\" stays in the model",
        result.rows[rows[chosen.back()]].name));
  }
  result.reduced = {};
  if (!result.has_fits) result.reduced.fit_mm = kNaN;
}

}  // namespace

std::vector<CameraImages> expose_in_units_of(const Twin& units, const Twin& model,
                                             const std::vector<render::RenderedCamera>& rendered,
                                             std::uint64_t seed) {
  std::vector<CameraImages> out = render::expose_all(rendered, model, seed);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Sensor &from = model.cameras[i].sensor, &to = units.cameras[i].sensor;
    if (const double factor = to.gain_dn / from.gain_dn; factor != 1.0) scale_images(out[i], factor);
    out[i].bit_depth = to.bit_depth;
  }
  return out;
}

double EffectRow::fit_change_mm() const { return largest_mm(fits); }

Change EffectRow::judged() const {
  // phase_rms_rad is NaN where the sequence has no phase steps and +inf where none can be compared
  return {change.phase_rms_rad, change.gray_rms_dn, fit_change_mm()};
}

NeedsResult run_needs(const Twin& full_twin, render::Renderer& renderer, const NeedsOptions& options) {
  cosim::check_renderable(full_twin);
  Twin twin = full_twin;
  NeedsResult result;
  result.device = renderer.device();
  result.has_fits = cosim::can_fit(twin);
  if (!result.has_fits)
    result.warnings.push_back(
        "the chain ends before a fit (no [[measure.fit]], or this rig cannot triangulate): only phase and "
        "gray are judged");
  const Stopwatch whole;
  result.subset = choose_subset(twin, renderer, options.subset);
  say("pixels: " + result.subset.text());

  const auto n_on = std::ranges::count_if(effects(), [&](const Effect& e) { return e.is_on(twin); });
  Progress progress("effects", static_cast<std::size_t>(n_on) + 2);
  const ModelBench bench(twin, renderer, result.subset, options);
  const ModelRun full = bench.run(twin);
  twin = with_sampling_of(twin, full);
  progress.advance();
  const bool has_phase = bench.change(EffectStage::light, full, full).n_phase > 0;
  for (const Effect& effect : effects()) {
    EffectRow row;
    row.name = effect.name;
    row.without = effect.without;
    row.switch_on = effect.switch_on;
    row.stage = effect.stage;
    row.on = effect.is_on(twin);
    if (row.on) {
      Twin without = twin;
      effect.switch_off(without);
      FT_CHECK(!effect.is_on(without), effect.name + " is off after switch_off");
      const ModelRun run = bench.run(without);
      row.change = bench.change(effect.stage, full, run);
      row.change.phase_rms_rad = judged_phase(row.change, has_phase);
      row.fits = fit_changes(full, run);
      row.with = full.time;
      row.without_time = run.time;
      bench.time_both(twin, without, row.with, row.without_time);
      row.cost = bench.ratio(row.with, row.without_time);
      if (std::isinf(row.change.phase_rms_rad) || std::isinf(row.fit_change_mm()))
        result.warnings.push_back(
            fmt::format("without \"{}\" no {} is left to compare", row.name,
                        std::isinf(row.change.phase_rms_rad) ? "modulated pixel" : "usable fit"));
      progress.advance();
    }
    result.rows.push_back(std::move(row));
  }
  settle_recommendation(twin, bench, full, has_phase, options, result);
  progress.advance();
  result.timing_s["models"] = whole.elapsed().wall_s;

  const Stopwatch reference_watch;
  const ReferenceValues reference = reference_values(twin, result.subset);
  result.floor = error_against(reference, twin, result.subset, full.light_dn);
  result.reference_uncertainty_dn = reference.edge_uncertainty_dn;
  result.timing_s["reference"] = reference_watch.elapsed().wall_s;
  return result;
}

std::string needs_table(const NeedsResult& result, const NeedsOptions& options) {
  std::string out = fmt::format("{:<24}{:>6}{:>13}{:>11}{:>11}{:>12}{:>9}  {}\n", "effect", "scene",
                                "phase rad", "gray DN", "edge DN", "fit mm", "x time", "for the tolerance");
  const auto cell = [](double v) { return std::isnan(v) ? std::string("-") : fmt::format("{:.2e}", v); };
  for (const EffectRow& r : result.rows) {
    if (!r.on) {
      out += fmt::format("{:<24}{:>6}{:>13}{:>11}{:>11}{:>12}{:>9}  {}\n", r.name, "off", "", "", "", "", "",
                         "to switch it on: " + r.switch_on);
      continue;
    }
    out +=
        fmt::format("{:<24}{:>6}{:>13}{:>11}{:>11}{:>12}{:>9.2f}  {}\n", r.name, "on",
                    cell(r.change.phase_rms_rad), cell(r.change.gray_rms_dn), cell(r.change.gray_edge_rms_dn),
                    cell(r.fit_change_mm()), r.cost, r.leave_off ? "can be left off" : "keep");
  }
  out += fmt::format("{:<24}{:>6}{:>13}{:>11}{:>11}\n", "renderer's own error", "",
                     cell(result.floor.phase_rms_rad), cell(result.floor.gray_rms_dn),
                     cell(result.floor.gray_edge_rms_dn));
  const Tolerance& t = options.tolerance;
  out += fmt::format("tolerance               {:>19.2e}{:>11.2e}{:>11}{:>12.2e}\n", t.phase_rad, t.gray_dn,
                     "", t.fit_mm);
  out += fmt::format(
      "smallest model          {:>19}{:>11}{:>11}{:>12}{:>9.2f}  {:.3f} s instead of {:.3f} s\n",
      cell(result.reduced.phase_rad), cell(result.reduced.gray_dn), "", cell(result.reduced.fit_mm),
      1.0 / result.reduced_cost, result.reduced_time.wall_s, result.full_time.wall_s);
  return out;
}

}  // namespace fringetwin::tradeoff
