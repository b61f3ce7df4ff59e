// SPDX-License-Identifier: Apache-2.0
#include "cli/results.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "cli/version.hpp"
#include "compare/causes/causes.hpp"
#include "compare/page/report_page.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {

compare::Provenance make_provenance(const Invocation& invocation, const Twin& twin,
                                    const std::vector<std::filesystem::path>& more_inputs,
                                    const std::string& device, std::uint64_t seed) {
  compare::Provenance provenance;
  provenance.argv = invocation.argv;
  provenance.version = version_string();
  provenance.input_files = twin.input_files;
  provenance.input_files.insert(provenance.input_files.end(), more_inputs.begin(), more_inputs.end());
  provenance.device = device;
  provenance.seed = seed;
  return provenance;
}

std::vector<std::filesystem::path> capture_files(const Twin& twin, const std::filesystem::path& dir) {
  const CaptureSet set = read_capture_set(dir, static_cast<int>(expand_sequence(twin.fringes).size()));
  std::vector<std::filesystem::path> files = {set.file};
  for (const CaptureCamera& camera : set.cameras) {
    files.insert(files.end(), camera.files.begin(), camera.files.end());
    if (camera.white) files.push_back(*camera.white);
    if (camera.black) files.push_back(*camera.black);
  }
  return files;
}

int exit_code_for(const std::vector<measure::ObjectFit>& fits, int otherwise) {
  // Fewer points than this is "too few", which is a warning and no failure (docs/formats/results.md, "Fits").
  constexpr std::size_t kEnoughPoints = 20;
  for (const auto& fit : fits)
    if (!fit.usable && fit.n >= kEnoughPoints) {
      warn(fmt::format("the fit of \"{}\" did not converge: {}", fit.object, fit.warning));
      return static_cast<int>(ExitCode::no_convergence);
    }
  return otherwise;
}

std::string measured_shape_note(const Twin& twin, const std::vector<int>& compared_steps) {
  for (const Object& object : twin.objects) {
    const auto* measured = std::get_if<MeasuredShape>(&object.shape);
    if (!measured) continue;
    if (compared_steps.empty())
      return fmt::format(
          "The object \"{}\" was built from all phase steps of this same capture, so it agrees with its "
          "phase by "
          "construction: only the gray levels are evidence here.",
          object.name);
    return fmt::format(
        "The object \"{}\" was built from the {} phase steps of this same capture (smoothed over {:g} px) "
        "and is compared "
        "with the other steps ({}). This can show photometric errors (gain, response, noise, reflectivity), "
        "phase noise, "
        "harmonics and errors of the rendering chain. It cannot show errors of the calibration or of the "
        "shape that "
        "are common to all steps: those moved the object along with the images. A harmonic of the projected "
        "fringe one order beside the number of steps used leaves a ripple of opposite sign in even and odd "
        "steps, "
        "so it shows here with twice its size (table \"phase difference, split\").",
        object.name, measured->steps, measured->smoothing_px, fmt::join(compared_steps, ", "));
  }
  return "";
}

namespace {

// Was the object's nominal size and place taken from the published result?
bool is_published_result(const Object& object, const PublishedFit& fit) {
  const auto same = [&fit](const char* key, const Eigen::Vector3d& nominal) {
    const auto it = fit.vectors.find(key);
    return it != fit.vectors.end() && it->second == nominal;
  };
  const auto* sphere = std::get_if<SphereShape>(&object.shape);
  if (!sphere) return false;
  const auto radius = fit.numbers.find("radius_mm");
  return same("center_mm", sphere->center_mm) && radius != fit.numbers.end() &&
         radius->second == sphere->radius_mm;
}

}  // namespace

std::string published_results_note(const Twin& twin) {
  if (twin.real.results.empty()) return "";
  std::string note =
      "No images of the physical measurement are at hand, only its published numbers: gray levels and phase "
      "are not compared.";
  for (const PublishedFit& fit : twin.real.results) {
    const Object* object = twin.find_object(fit.object);
    if (object && is_published_result(*object, fit))
      note += fmt::format(
          " The virtual object \"{}\" IS the published result, so its place and size agree by construction: "
          "the differences are the error of rendering and measuring, not the agreement of twin and rig. "
          "Its rms against the published rms is evidence: the twin lacks what the difference is made of.",
          object->name);
  }
  return note;
}

namespace {

void say_summary(const compare::Comparison& c) {
  for (const auto& gain : c.gain)
    say(fmt::format("{}: gain {:.4f} DN, black {:.2f} DN, residual {} -> {:.2f} DN rms, R2 {:.3f}",
                    gain.camera, gain.gain_dn, gain.black_level_dn,
                    std::isfinite(gain.rms_before_dn) ? fmt::format("{:.2f}", gain.rms_before_dn) : "-",
                    gain.rms_after_dn, gain.r2));
  for (const auto& phase : c.phase)
    say(fmt::format("{} {}: phase difference {:.5f} rad rms, {:.4f} % relative mean, n {}", phase.camera,
                    phase.direction, phase.rms_rad, 100.0 * phase.mean_relative, phase.n));
  for (const auto& budget : c.phase_budget)
    say(fmt::format(
        "{} {}: brightness {:.4f}, harmonics {:.4f}, noise {:.4f} rad rms: {:.0f} % of the difference's "
        "variance",
        budget.camera, budget.direction, std::sqrt(budget.brightness_rad2), std::sqrt(budget.harmonic_rad2),
        std::sqrt(budget.noise_rad2), 100.0 * budget.explained()));
  for (const auto& row : c.explained)
    say(fmt::format("{} {}: {}, chi2 {:.3g} (limit {:.3g}){}", row.quantity, row.region,
                    row.explained ? "explained" : "NOT EXPLAINED by the budget", row.chi2, row.chi2_limit,
                    std::isfinite(row.regional_chi2)
                        ? fmt::format(", of regions {:.3g} ({:.3g})", row.regional_chi2, row.regional_limit)
                        : ""));
  if (const std::string cause = compare::sentence(c.causes); !cause.empty()) say(cause);
  for (const auto& fit : c.fits)
    if (fit.simulated && fit.simulated->usable && fit.simulated->numbers.contains("rms_all_mm"))
      say(fmt::format("{}: simulated rms {:.6f} mm on {} points, {:.6f} mm on all {:.0f} within the gate",
                      fit.object, fit.simulated->numbers.at("rms_mm"), fit.simulated->n,
                      fit.simulated->numbers.at("rms_all_mm"), fit.simulated->numbers.at("n_gated")));
  for (const auto& fit : c.fits)
    for (const auto& [key, value] : fit.difference)
      say(fmt::format("{}: {} simulated - real = {:.6f}", fit.object, key, value));
  for (const auto& limit : c.limits)
    say(fmt::format("limit {} = {:g}: {:.6g} {}", limit.name, limit.limit, limit.value,
                    limit.pass ? "pass" : "FAIL"));
}

}  // namespace

int finish_comparison(const std::filesystem::path& dir, const Twin& twin, const compare::Side& real,
                      const compare::Side& simulated, const compare::CompareOptions& options,
                      const compare::Provenance& provenance, StageTimer& timer) {
  timer.start("compare");
  throw_if_cancelled();
  const compare::Comparison comparison = compare::compare(twin, real, simulated, options);
  timer.start("write");
  throw_if_cancelled();
  begin_output(dir, {"result.json", "report.html"});
  if (simulated.measurement) measure::write_measurement(dir / "measured_simulated", *simulated.measurement);
  if (real.measurement) measure::write_measurement(dir / "measured_real", *real.measurement);
  timer.start("report");
  throw_if_cancelled();
  compare::write_report(dir, twin, real, simulated, comparison, options, provenance, timer.seconds);
  timer.stop();
  throw_if_cancelled();
  write_text_file(dir / "result.json", compare::comparison_json(twin, comparison, provenance, timer.seconds));

  for (const auto& warning : comparison.warnings) warn(warning);
  say_summary(comparison);
  say(fmt::format("verdict {}; report: {}",
                  comparison.limits.empty() ? "pass (no limits set)"
                  : comparison.pass         ? "pass"
                                            : "fail",
                  (dir / "report.html").string()));
  const int verdict = static_cast<int>(comparison.pass ? ExitCode::ok : ExitCode::limits_not_met);
  if (real.measurement) {
    const int code = exit_code_for(real.measurement->fits, verdict);
    if (code != verdict) return code;
  }
  return simulated.measurement ? exit_code_for(simulated.measurement->fits, verdict) : verdict;
}

}  // namespace fringetwin::cli
