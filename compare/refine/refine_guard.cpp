// SPDX-License-Identifier: Apache-2.0
#include "compare/refine/refine_guard.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "compare/geometry/fit_rows.hpp"
#include "compare/verdict/coverage.hpp"
#include "compare/verdict/explained.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kSameChi2 = 1e-6;    ///< solving again from the minimum moves it by 1e-7
constexpr double kSameBudget = 1.02;  ///< another modulation allows the same difference that much less

/// Collects sentences on what got worse.
class Complaints {
 public:
  /// Adds one where a mean of n squares rises by more than it may by chance.
  void rise(const std::string& what, double from, double to, double sigmas, std::uint64_t n) {
    const double relative = n > 0 ? sigmas * std::sqrt(2.0 / static_cast<double>(n)) : 0.0;
    if (to > from + std::max(1.0, from) * std::max(kSameChi2, relative))
      add("{} would rise from {:.5g} to {:.5g}", what, from, to);
  }
  template <class... Values>
  void add(fmt::format_string<Values...> sentence, Values&&... values) {
    sentences_.push_back(fmt::format(sentence, std::forward<Values>(values)...));
  }
  std::string joined() const { return fmt::format("{}", fmt::join(sentences_, "; ")); }

 private:
  std::vector<std::string> sentences_;
};

/// Returns the row of the same quantity and region; null where there is none.
const ExplainedRow* row_like(const std::vector<ExplainedRow>& rows, const ExplainedRow& row) {
  const auto like = std::ranges::find_if(rows, [&row](const ExplainedRow& other) {
    return other.quantity == row.quantity && other.region == row.region;
  });
  return like != rows.end() ? &*like : nullptr;
}

/// Returns whether a row that was compared is no longer: a phase may have no row then.
bool is_lost(const ExplainedRow& then, const ExplainedRow* now) {
  return then.state != kNotCompared &&
         (now != nullptr ? now->state == kNotCompared : then.quantity == "phase");
}

/// Where pixels have numbers of their own nothing may have been left of a kind before.
void compare_light(const CauseRegion& then, const CauseRegion& now, bool fits_light, Complaints& worse) {
  if (then.n == 0) return;
  const std::string what = fmt::format("chi2 of the {} in regions", now.kind);
  if (then.passes() && !now.passes())
    worse.add("{} would rise from {:.3g} to {:.3g}, limit {:.3g}", what, then.chi2, now.chi2, now.limit);
  else if (!now.passes() && fits_light)
    worse.rise(what, then.chi2, now.chi2, 2.0, then.n);
}

void compare_fits(const ExplainedRow& then, const ExplainedRow& now, Complaints& worse) {
  const double z_then = std::sqrt(then.chi2), z_now = std::sqrt(now.chi2);
  if (now.state == kNotExplained && z_now > z_then + 1.0)
    worse.add("the largest |z| of {} would rise from {:.3g} to {:.3g}", now.region, z_then, z_now);
}

/// Compares rows of phase or coverage.
void compare_places(const ExplainedRow& then, const ExplainedRow& now, Complaints& worse) {
  if (then.state == kExplained && now.state != kExplained && now.state != kTooWide)
    worse.add("the {} of {} would not be explained any more", now.quantity, now.region);
  if (now.quantity != "phase" || then.state == kExplained) return;
  const std::string what = fmt::format("chi2 of the phase of {}", now.region);
  if (now.chi2 > now.chi2_limit) worse.rise(what, kSameBudget * then.chi2, now.chi2, 2.0, then.n);
  if (now.regional_chi2 > now.regional_limit)
    worse.rise(what + " in regions", kSameBudget * then.regional_chi2, now.regional_chi2, 2.0,
               then.n_regions);
}

/// Returns the sum of the squares that are left of the light in regions.
double light_left(const Standing& s) {
  double sum = 0.0;
  for (const CauseRegion& r : s.light)
    if (r.n > 0) sum += static_cast<double>(r.n) * r.chi2;
  return sum;
}

}  // namespace

void make_ready_for_timing(const Twin& twin, std::vector<Parameter>& chosen) {
  constexpr int kFewest = 4;
  if (twin.fringes.steps < kFewest)
    throw UserError(
        ExitCode::usage, "--refine",
        fmt::format("timing is told by {} phase steps or more, the twin has {}", kFewest, twin.fringes.steps),
        "leave it out: light and image_shift are told by 3");
  for (Parameter& p : chosen)
    if (p.group == "light") p.is_closed = false;
}

std::vector<ExplainedRow> measured_rows(const Twin& twin, const Side& real, const Side& simulated,
                                        const RigBudget* rig) {
  std::vector<std::string> warnings;  // those of the comparison come with it
  std::vector<ExplainedRow> rows = explain_geometry(fit_rows(twin, real, simulated, warnings), rig);
  for (ExplainedRow& row : explain_coverage(twin, coverage_rows(twin, real, simulated)))
    rows.push_back(std::move(row));
  return rows;
}

void excuse(std::vector<ExplainedRow>& rows, const std::vector<ExplainedRow>& with_budget) {
  for (ExplainedRow& row : rows) {
    const ExplainedRow* like = row_like(with_budget, row);
    if (row.state == kNotExplained && like != nullptr && like->explained()) row = *like;
  }
}

std::string what_got_worse(const Standing& before, const Standing& after) {
  Complaints worse;
  worse.rise("chi2", before.chi2, after.chi2, 1.0, before.n);
  worse.rise("chi2 of the fringes' places", before.chi2_of_place, after.chi2_of_place, 1.0, before.n);
  // below 1 before it: the noise has the scatter of bounces, which a twin without them does not make
  worse.rise("chi2 of the fringes' shift in regions",
             before.scatters ? std::max(1.0, before.shift.chi2) : before.shift.chi2, after.shift.chi2, 2.0,
             before.shift.n);
  for (std::size_t k = 0; k < std::min(before.light.size(), after.light.size()); ++k)
    compare_light(before.light[k], after.light[k], before.fits_light, worse);
  for (const ExplainedRow& then : before.rows) {
    const ExplainedRow* now = row_like(after.rows, then);
    if (is_lost(then, now))
      worse.add("{}{} could not be compared any more",
                then.quantity == "geometry" ? "" : "the " + then.quantity + " of ", then.region);
    else if (now != nullptr && now->quantity == "geometry")
      compare_fits(then, *now, worse);
    else if (now != nullptr)
      compare_places(then, *now, worse);
  }
  for (const ExplainedRow& now : after.rows)  // an object that no camera sees has a row only then
    if (now.quantity == "coverage" && now.state == kNotCompared && row_like(before.rows, now) == nullptr)
      worse.add("{} would not be seen any more", now.region);
  return worse.joined();
}

bool leaves_light_alone(const Standing& s) {
  return s.shift.n > 0 && s.shift.passes() && std::ranges::any_of(s.light, [](const CauseRegion& r) {
           return r.n > 0 && r.chi2 > 1.0 + std::sqrt(2.0 / static_cast<double>(r.n));
         });
}

bool is_better_lit(const Standing& by_fringes, const Standing& lit, std::size_t n_fitted) {
  constexpr double kSigmas = 3.0;
  const auto n = static_cast<double>(n_fitted);  // so much chi2 each takes by chance, with a variance of 2
  return std::ranges::all_of(lit.light, &CauseRegion::passes) &&
         light_left(by_fringes) - light_left(lit) > n + kSigmas * std::sqrt(2.0 * n) &&
         what_got_worse(by_fringes, lit).empty();
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
  refined.one_error_away.clear();
  report.chi2_after = report.chi2_before;
  report.covariance.setConstant(kNaN);
  report.texture.clear();
  for (RefinedRow& row : report.rows) row.after = row.before, row.sigma = kNaN;
}

}  // namespace fringetwin::compare
