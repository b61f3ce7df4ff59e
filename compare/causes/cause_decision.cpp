// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/cause_decision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/parameters/parameters.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kClearlyBetter = 25.0;  ///< of chi2: 5 standard deviations of one parameter

std::string percent(double share) {
  return std::isfinite(share) ? fmt::format("{:.3g} % of it", 100.0 * share) : "part of it";
}

/// Says what of a fit is not explained: ", which leaves chi2 1.5, limit 1.15; shift of regions 5.66, limit
/// 1.37".
std::string left_by(const CauseRow& row, double limit) {
  std::string text;
  if (row.chi2_after > limit) text = fmt::format("chi2 {:.3g}, limit {:.3g}", row.chi2_after, limit);
  for (const CauseRegion& r : row.regions_after)
    if (!r.passes())
      text += fmt::format("{}{} of regions {:.3g}, limit {:.3g}", text.empty() ? "" : "; ", r.kind, r.chi2,
                          r.limit);
  if (!row.fits_agree)
    text += fmt::format("{}fits of objects {:.3g} standard errors apart", text.empty() ? "" : "; ",
                        row.fit_z_after);
  if (!row.regions_after.empty() &&
      std::ranges::all_of(row.regions_after, [](const CauseRegion& r) { return r.n == 0; }))
    text += (text.empty() ? "" : "; ") + std::string("regions with too few pixels to judge it");
  return text.empty() ? "" : ", which leaves " + text;
}

/// Returns "pose + response" in words: "pose of an object and the projector's response (gamma)".
std::string in_words(const Causes& causes, const std::string& together) {
  std::string text;
  for (const std::string& group : groups_in(together)) {
    const auto row = std::ranges::find(causes.rows, group, &CauseRow::group);
    text += (text.empty() ? "" : " and ") + (row == causes.rows.end() ? group : row->cause);
  }
  return text;
}

/// Returns what to do about a cause: ". Fit it with --refine pose", or what `--refine` cannot do.
std::string advice(const std::string& together, const std::vector<std::string>& refined) {
  std::string all, besides;
  const std::vector<std::string> groups = groups_in(together);
  const auto was_refined = [&](const std::string& name) {
    return std::ranges::find(refined, name) != refined.end();
  };
  if (std::ranges::all_of(groups, was_refined))
    return fmt::format(". {0} fitted just now: to fit {1} again would not help",
                       groups.size() > 1 ? "They were" : "It was", groups.size() > 1 ? "them" : "it");
  for (const std::string& name : groups) {
    const auto group = std::ranges::find(parameter_groups(), name, &ParameterGroup::name);
    if (group != parameter_groups().end() && !group->instead.empty())
      return ". What to do: " + group->instead;
    if (group == parameter_groups().end() && name != "texture") return "";
    all += (all.empty() ? "" : ",") + name;
    if (group != parameter_groups().end() && !group->besides.empty()) besides += "; or " + group->besides;
  }
  return ". Fit " + std::string(groups.size() > 1 ? "them" : "it") + " with --refine " + all + besides;
}

std::string none_sentence(const Causes& causes) {
  const auto less = [](const CauseRow& a, const CauseRow& b) { return a.removed < b.removed; };
  const CauseRow& nearest = *std::ranges::max_element(causes.rows, less);
  return fmt::format("none of the causes tested explains what the budget does not (nearest: {}, {}{})",
                     nearest.cause, percent(nearest.alone), left_by(nearest, causes.chi2_limit));
}

}  // namespace

std::vector<std::string> groups_in(std::string together) {
  std::vector<std::string> groups;
  for (std::size_t end = 0; end != std::string::npos;) {
    end = together.find(kCausesTogether);
    groups.push_back(together.substr(0, end));
    if (end != std::string::npos) together.erase(0, end + std::string_view(kCausesTogether).size());
  }
  return groups;
}

double worth_naming(double parameters) {
  return kClearlyBetter + std::min(parameters, 5.0 * std::sqrt(2.0 * parameters));
}

std::vector<std::size_t> explaining_alike(const std::vector<TriedCause>& tried, double before,
                                          double per_value) {
  std::vector<std::size_t> alike;
  per_value = std::max(1.0, per_value);  // where noise is less than stated, fewer numbers are preferred
  double best = before;
  for (std::size_t k = 0; k < tried.size(); ++k)
    if (tried[k].passes && before - tried[k].deviance(per_value) >= worth_naming(tried[k].fitted)) {
      alike.push_back(k);
      best = std::min(best, tried[k].deviance(per_value));
    }
  std::erase_if(alike, [&](std::size_t k) {
    const double many = tried[k].fitted > 2.0 * kClearlyBetter ? worth_naming(tried[k].fitted) : 0.0;
    return tried[k].deviance(per_value) - best >= per_value * std::max(kClearlyBetter, many);
  });
  std::ranges::stable_sort(alike, [&](auto a, auto b) {
    return tried[a].fitted != tried[b].fitted ? tried[a].fitted < tried[b].fitted
                                              : tried[a].deviance(per_value) < tried[b].deviance(per_value);
  });
  return alike;
}

bool scales_the_gain(const std::string& group) {
  return group.starts_with("texture") || group == "albedo" || group == "vignetting" ||
         group == "projector_field";
}

std::string sentence(const Causes& causes) {
  if (causes.rows.empty()) return "";
  if (causes.together.empty()) return none_sentence(causes);
  if (causes.together.size() > 1) {
    std::string all;
    for (std::size_t k = 0; k < causes.together.size(); ++k)
      all += (k == 0                           ? ""
              : k + 1 < causes.together.size() ? ", "
                                               : " or ") +
             in_words(causes, causes.together[k]);
    return fmt::format(
        "most likely cause: {}: each explains the gray difference beyond the budget, and they cannot be told "
        "apart here, because their images differ by less than the noise",
        all);
  }
  const std::string& only = causes.together[0];
  if (only.find(kCausesTogether) != std::string::npos)
    return fmt::format(
        "most likely causes: {}: together they explain the gray difference beyond the budget{}",
        in_words(causes, only), advice(only, causes.refined));
  const CauseRow& row = *std::ranges::find(causes.rows, only, &CauseRow::group);
  return fmt::format(
      "most likely cause: {}; it explains {} of the gray difference beyond the budget{}", row.cause,
      std::isfinite(row.alone) ? fmt::format("{:.1f} %", 100.0 * row.alone) : "what regions show",
      advice(only, causes.refined));
}

std::string gain_sentence(const Causes& causes) {
  if (!causes.why.empty())
    return fmt::format("no gain or black level is offered with {}: {}", causes.together[0], causes.why);
  std::string line = causes.gain.empty() ? "" : "with " + causes.with;
  for (const CauseGain& g : causes.gain)
    line += fmt::format("; {}: gain {} DN, black level {} DN", g.camera,
                        report::with_sigma(g.gain_dn, g.gain_sigma_dn),
                        report::with_sigma(g.black_level_dn, g.black_level_sigma_dn));
  return line;
}

}  // namespace fringetwin::compare
