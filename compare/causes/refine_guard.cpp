// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/refine_guard.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "compare/geometry/fit_rows.hpp"
#include "compare/verdict/coverage.hpp"
#include "compare/verdict/explained.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kSameChi2 = 1e-6;  ///< solving again from the minimum moves it by 1e-7

/// Returns how far a mean of n squares may rise by chance; of none: not at all.
double by_chance(double chi2, double sigmas, std::uint64_t n) {
  const double relative = n > 0 ? sigmas * std::sqrt(2.0 / static_cast<double>(n)) : 0.0;
  return std::max(1.0, chi2) * std::max(kSameChi2, relative);
}

}  // namespace

std::vector<ExplainedRow> measured_rows(const Twin& twin, const Side& real, const Side& simulated) {
  std::vector<std::string> warnings;  // those of the comparison come with it
  std::vector<ExplainedRow> rows = explain_geometry(fit_rows(twin, real, simulated, warnings));
  for (ExplainedRow& row : explain_coverage(twin, coverage_rows(twin, real, simulated)))
    rows.push_back(std::move(row));
  return rows;
}

std::string what_got_worse(const Standing& before, const Standing& after) {
  std::vector<std::string> worse;
  const auto check = [&](const std::string& what, double from, double to, double sigmas, std::uint64_t n) {
    if (to > from + by_chance(from, sigmas, n))
      worse.push_back(fmt::format("{} would rise from {:.5g} to {:.5g}", what, from, to));
  };
  check("chi2", before.chi2, after.chi2, 1.0, before.n);
  check("chi2 of the fringes' places", before.chi2_of_place, after.chi2_of_place, 1.0, before.n);
  // below 1 before it: the noise has the scatter of bounces, which a twin without them does not make
  check("chi2 of the fringes' shift in regions",
        before.scatters ? std::max(1.0, before.shift.chi2) : before.shift.chi2, after.shift.chi2, 2.0,
        before.shift.n);
  for (std::size_t k = 0; k < std::min(before.light.size(), after.light.size()); ++k) {
    const CauseRegion &then = before.light[k], &now = after.light[k];
    const std::string what = fmt::format("chi2 of the {} in regions", now.kind);
    if (then.passes() && !now.passes())
      worse.push_back(fmt::format("{} would rise from {:.3g} to {:.3g}, limit {:.3g}", what, then.chi2,
                                  now.chi2, now.limit));
    else if (!now.passes() && before.fits_light)
      check(what, then.chi2, now.chi2, 2.0, then.n);
  }
  for (const ExplainedRow& then : before.rows)
    for (const ExplainedRow& now : after.rows) {
      if (then.quantity != now.quantity || then.region != now.region) continue;
      const bool geometry = now.quantity == "geometry";
      if (geometry && now.state == kNotExplained && std::sqrt(now.chi2) > std::sqrt(then.chi2) + 1.0)
        worse.push_back(fmt::format("the largest |z| of {} would rise from {:.3g} to {:.3g}", now.region,
                                    std::sqrt(then.chi2), std::sqrt(now.chi2)));
      if (geometry && now.state == kNotCompared && then.state != kNotCompared)
        worse.push_back(fmt::format("{} could not be compared any more", now.region));
      if (!geometry && then.state == kExplained && now.state != kExplained && now.state != kTooWide)
        worse.push_back(
            fmt::format("the {} of {} would not be explained any more", now.quantity, now.region));
    }
  for (const ExplainedRow& now : after.rows)  // an object that no camera sees has a row only then
    if (now.quantity == "coverage" && now.state == kNotCompared &&
        std::ranges::none_of(before.rows, [&](const ExplainedRow& then) {
          return then.quantity == now.quantity && then.region == now.region;
        }))
      worse.push_back(fmt::format("{} would not be seen any more", now.region));
  return fmt::format("{}", fmt::join(worse, "; "));
}

std::string warning_of_what_is_left(const Refinement& refinement, const std::vector<ExplainedRow>& rows) {
  std::vector<std::string> apart;
  for (const ExplainedRow& row : rows)
    if (row.quantity == "geometry" && row.state == kNotExplained)
      apart.push_back(fmt::format("{} by {:.3g} standard errors", row.region, std::sqrt(row.chi2)));
  if (apart.empty()) return "";
  return fmt::format(
      "--refine {}: the fits of both sides still differ ({}), so something else is wrong besides: the values "
      "are not to be trusted",
      fmt::join(refinement.asked, ","), fmt::join(apart, ", "));
}

void take_back(Refined& refined, const Twin& before, const std::string& why) {
  Refinement& report = refined.report;
  report.notes.push_back(why + ": the twin stays as it is");
  report.warnings.push_back(fmt::format("--refine {} is taken back: {}", fmt::join(report.asked, ","), why));
  report.taken_back = true;
  refined.twin = before;
  report.chi2_after = report.chi2_before;
  report.covariance.setConstant(kNaN);
  report.texture.clear();
  for (RefinedRow& row : report.rows) row.after = row.before, row.sigma = kNaN;
}

}  // namespace fringetwin::compare
