// SPDX-License-Identifier: Apache-2.0
#include "compare/comparison.hpp"

#include <algorithm>

#include "compare/fit_rows.hpp"
#include "compare/gain_fit.hpp"
#include "compare/gray_budget.hpp"
#include "compare/gray_rows.hpp"
#include "compare/limits.hpp"
#include "compare/phase_rows.hpp"

namespace fringetwin::compare {
namespace {

void compare_gray(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options,
                  Comparison& out) {
  const std::vector<GrayPair> pairs = pair_gray(twin, real, simulated, options, out.warnings);
  for (std::size_t c = 0; c < pairs.size(); ++c) {
    const GainFit fit = fit_gain(pairs[c], out.warnings);
    out.gain.push_back(fit.row);
    if (!fit.row.usable) continue;
    for (GrayRow& row : gray_rows(twin, pairs[c], fit)) out.gray.push_back(std::move(row));
    const measure::CameraDecode* real_decode = real.measurement ? &real.measurement->cameras.at(c) : nullptr;
    const measure::CameraDecode* simulated_decode =
        simulated.measurement ? &simulated.measurement->cameras.at(c) : nullptr;
    if (auto budget = gray_budget(pairs[c], fit, real_decode, simulated_decode, options))
      out.gray_budget.push_back(*budget);
  }
}

}  // namespace

Comparison compare(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options) {
  Comparison out;
  for (const Side* side : {&real, &simulated})
    if (side->measurement)
      for (const std::string& warning : side->measurement->warnings)
        out.warnings.push_back((side == &real ? "real: " : "simulated: ") + warning);
  out.fits = fit_rows(twin, real, simulated, out.warnings);
  compare_gray(twin, real, simulated, options, out);
  if (real.measurement && simulated.measurement)
    out.phase = phase_rows(twin, *real.measurement, *simulated.measurement);
  out.limits = check_limits(twin.limits, out, twin.file.string());
  for (const LimitRow& row : out.limits)
    if (row.value != row.value)
      out.warnings.push_back("limit " + row.name + " cannot be checked: this comparison has no such number");
  out.pass = std::all_of(out.limits.begin(), out.limits.end(), [](const LimitRow& row) { return row.pass; });
  return out;
}

}  // namespace fringetwin::compare
