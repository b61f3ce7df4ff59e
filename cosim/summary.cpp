// SPDX-License-Identifier: Apache-2.0
#include "cosim/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "compare/causes/causes.hpp"
#include "compare/held_out/held_out.hpp"
#include "compare/pattern/pattern.hpp"
#include "measure/light/light_factors.hpp"

namespace fringetwin::cosim {

namespace {

/// Returns the state of a row of explained[] as the terminal shows it: in capitals where it is no pass.
std::string told_state(const std::string& state) {
  if (state == compare::kExplained) return state;
  if (state == compare::kNotExplained) return "NOT EXPLAINED by the budget";
  return state == compare::kTooWide ? "BUDGET TOO WIDE" : "NOT COMPARED";
}

/// Returns why a row is in its state. Of coverage, whose rows hold sentences on all objects, the three
/// furthest beyond their allowance: the page has all.
std::string told_reason(const compare::Comparison& c, const compare::ExplainedRow& row) {
  if (row.quantity != "coverage") return row.why;
  constexpr std::size_t kMost = 3;
  std::vector<std::pair<double, std::string>> reasons;
  for (const compare::OtherSurfaceRow& surface : c.other_surfaces)
    if (surface.camera == row.region)
      reasons.emplace_back(std::numeric_limits<double>::infinity(), surface.why);
  for (const compare::CoverageRow& counts : c.coverage)
    if (counts.camera == row.region && !counts.why.empty())
      reasons.emplace_back(
          counts.excess(),
          (counts.object.empty() ? "" : fmt::format("of \"{}\" ", counts.object)) + counts.why);
  if (reasons.size() <= kMost) return row.why;
  std::ranges::stable_sort(reasons, std::ranges::greater{}, &std::pair<double, std::string>::first);
  std::string text;
  for (std::size_t i = 0; i < kMost; ++i) text += reasons[i].second + "; ";
  return text + fmt::format("and {} more (see the page)", reasons.size() - kMost);
}

}  // namespace

std::vector<std::string> light_lines(const std::vector<compare::LightRow>& rows) {
  std::vector<std::string> out;
  for (const compare::LightRow& row : rows) {
    if (row.factor.empty()) continue;
    const auto [least, most] = std::ranges::minmax(row.factor);
    const double sigma = measure::largest_told(row.factor_sigma);
    out.push_back(fmt::format(
        "{}{}: light of the images {:+.2f} ... {:+.2f} % ({}): {}", row.side.empty() ? "" : row.side + " ",
        row.camera, 100.0 * (least - 1.0), 100.0 * (most - 1.0),
        std::isfinite(sigma) ? fmt::format("standard errors up to {:.3f} %", 100.0 * sigma)
                             : "standard errors unknown",
        row.corrected ? fmt::format("taken out, it moved the phase by {:.4f} rad rms", row.phase_rms_rad)
                      : "no more than chance, nothing is taken out"));
  }
  return out;
}

std::vector<std::string> summary_lines(const compare::Comparison& c) {
  std::vector<std::string> out;
  for (const auto& gain : c.gain) {
    if (!gain.usable) {
      out.push_back(
          fmt::format("{}: no gain fitted{}", gain.camera, gain.why.empty() ? "" : ": " + gain.why));
      continue;
    }
    out.push_back(fmt::format(
        "{}: gain {:.4f} +- {:.1g} DN, black {:.2f} DN ({}), residual {} -> {:.2f} DN rms, R2 {:.3f}",
        gain.camera, gain.gain_dn, gain.gain_sigma_dn, gain.black_level_dn, gain.state,
        std::isfinite(gain.rms_before_dn) ? fmt::format("{:.2f}", gain.rms_before_dn) : "-",
        gain.rms_after_dn, gain.r2));
  }
  for (std::string& line : light_lines(c.light)) out.push_back(std::move(line));
  for (std::string& sentence : compare::held_out_sentences(c.held_out)) out.push_back(std::move(sentence));
  for (const auto& phase : c.phase)
    out.push_back(
        phase.n == 0 ? fmt::format("{} {}: no pixel has a phase on both sides", phase.camera, phase.direction)
                     : fmt::format("{} {}: phase difference {:.5f} rad rms, {:.4f} % relative mean, n {}",
                                   phase.camera, phase.direction, phase.rms_rad, 100.0 * phase.mean_relative,
                                   phase.n));
  for (const auto& budget : c.phase_budget)
    out.push_back(fmt::format(
        "{} {}: brightness {:.4f}{}, harmonics {:.4f}, noise {:.4f} rad rms: {:.0f} % of the difference's "
        "variance",
        budget.camera, budget.direction, std::sqrt(budget.brightness_rad2),
        std::isfinite(budget.light_rad2)
            ? fmt::format(" (light of the images predicts {:.4f})", std::sqrt(budget.light_rad2))
            : "",
        std::sqrt(budget.harmonic_rad2), std::sqrt(budget.noise_rad2), 100.0 * budget.explained()));
  for (const auto& row : c.coverage)
    if (row.object.empty())
      out.push_back(fmt::format(
          "coverage {}: {:.1f} % of the pixels seen are measured on both sides, {:.2f} % of the measured on "
          "one side only",
          row.camera, 100.0 * row.covered_fraction(), 100.0 * row.one_sided_fraction()));
  for (const auto& row : c.explained) {
    const std::string chi2 = std::isfinite(row.chi2)
                                 ? fmt::format(", chi2 {:.3g} (limit {:.3g})", row.chi2, row.chi2_limit)
                                 : "",
                      regional = std::isfinite(row.regional_chi2)
                                     ? fmt::format(", of regions {:.3g} ({:.3g})", row.regional_chi2,
                                                   row.regional_limit)
                                     : "";
    const std::string why = told_reason(c, row);
    out.push_back(fmt::format("{} {}: {}{}{}{}", row.quantity, row.region, told_state(row.state), chi2,
                              regional, why.empty() ? "" : ": " + why));
  }
  for (const std::string& line : {compare::sentence(c.causes), compare::pattern_sentence(c.causes.pattern),
                                  compare::gain_sentence(c.causes)})
    if (!line.empty()) out.push_back(line);
  for (const auto& fit : c.fits)
    if (fit.simulated && fit.simulated->usable && fit.simulated->numbers.contains("rms_all_mm"))
      out.push_back(
          fmt::format("{}: simulated rms {:.6f} mm on {} points, {:.6f} mm on all {:.0f} within the gate",
                      fit.object, fit.simulated->numbers.at("rms_mm"), fit.simulated->n,
                      fit.simulated->numbers.at("rms_all_mm"), fit.simulated->numbers.at("n_gated")));
  for (const auto& fit : c.fits)
    for (const auto& [key, value] : fit.difference)
      out.push_back(fmt::format("{}: {} simulated - real = {:.6f}", fit.object, key, value));
  for (const auto& limit : c.limits)
    out.push_back(fmt::format("limit {} = {:g}: {:.6g} {}", limit.name, limit.limit, limit.value,
                              limit.pass ? "pass" : "FAIL"));
  return out;
}

std::string convergence_fault(const measure::Measurement& measurement) {
  // Fewer points than this is "too few", which is a warning and no failure (docs/formats/results.md, "Fits").
  constexpr std::size_t kEnoughPoints = 20;
  for (const measure::ObjectFit& fit : measurement.fits)
    if (!fit.usable && fit.n >= kEnoughPoints)
      return fmt::format("the fit of \"{}\" did not converge: {}", fit.object, fit.warning);
  return "";
}

}  // namespace fringetwin::cosim
