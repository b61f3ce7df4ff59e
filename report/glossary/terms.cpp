// SPDX-License-Identifier: Apache-2.0
#include "report/glossary/terms.hpp"

#include <algorithm>
#include <iterator>

namespace fringetwin::report {
namespace {

/// Greek letters stand where their names do. The formulas are in docs/METRICS.md.
constexpr Term kTerms[] = {
    {"beyond Huber", "share of the values so far off that they count less in the fit"},
    {"budget too wide",
     "what was expected is so much larger than what was observed that agreement would prove little"},
    {"χ² of values",
     "mean square of the differences over their expected variance: 1 where the twin explains them"},
    {"χ² of regions",
     "the same of means over regions, where noise averages out: it sees errors smaller than a pixel's noise"},
    {"covered", "share of the pixels that either side measured which both measured"},
    {"explained",
     "the differences are no larger than noise, rendering, calibration and refined places, which are known, "
     "make "
     "them"},
    {"explains alone", "share of what is not explained that this cause takes away by itself"},
    {"gain", "gray values per unit of simulated irradiance: the photoelectric gain coefficient"},
    {"not compared",
     "most of it, or a standard error of it, is missing on a side, so that nothing is said of it"},
    {"not explained",
     "the differences are larger than noise, rendering, calibration and refined places, which are known, "
     "make "
     "them"},
    {"P99 of |d|", "99 of 100 differences are smaller than this, whatever their sign"},
    {"R²", "share of the variance of the real gray values that the simulated ones predict"},
    {"rms", "root of the mean square"},
    {"σ", "standard deviation or standard uncertainty: about two of three values lie within it"},
    {"σ inflation", "by how much more the standard uncertainty is than noise alone would make it"},
    {"z", "difference over its standard uncertainty: beyond 3 it is hardly chance"},
};

}  // namespace

std::span<const Term> glossary() { return kTerms; }

std::string_view meaning_of(std::string_view word) {
  const auto* term = std::ranges::find(kTerms, word, &Term::word);
  return term == std::end(kTerms) ? std::string_view{} : term->meaning;
}

}  // namespace fringetwin::report
