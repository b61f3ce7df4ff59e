// SPDX-License-Identifier: Apache-2.0
// What a search for causes says: the rows of its groups, their order, and the gain beside what is named.
#include <algorithm>
#include <cmath>
#include <set>

#include "compare/causes/cause_search.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kWorthAdding = 0.02;  ///< share a further cause must explain to be listed in the order
constexpr std::size_t kMostInOrder = 4;

}  // namespace

void CauseSearch::take(const CauseFit& fit, CauseRow& row) const {
  row.chi2_after = fit.chi2;
  row.passes = fit.tried.passes;
  row.regions_after = fit.regions;
  row.fit_z_after = fit.fit_z;
  row.fits_agree = fit.fits_agree;
  row.removed = before_ - fit.tried.chi2;
  row.alone = share(row.removed, fit.regions);
  take_values(fit, row);
}

void CauseSearch::take_values(const CauseFit& fit, CauseRow& row) {
  for (const CauseParameter& fitted : fit.told)
    for (CauseParameter& p : row.parameters)
      if (p.name == fitted.name) {
        p = fitted;
        if (!(p.sigma > 0.0)) p.sigma = kNaN;  // held at the twin's value
      }
}

std::string CauseSearch::name_of(const TriedExplanation& tried) const {
  std::string all = tried.field ? tried.field->name : "";
  for (const std::size_t g : tried.groups) all += (all.empty() ? "" : kCausesTogether) + groups_[g].name;
  return all;
}

void CauseSearch::list_named(const std::vector<std::size_t>& named, Causes& out) const {
  for (const std::size_t k : named) out.together.push_back(name_of(tried_[k]));
  add_texture_beside(out);
  const TriedExplanation& first = tried_[named[0]];
  const std::vector<std::string> parts = groups_in(out.together[0]);
  if (out.together.size() == 1 && parts.size() == 1) out.named = parts[0];
  double before = 0.0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    CauseRow& row = *std::ranges::find(out.rows, parts[k], &CauseRow::group);
    take_values(first.fit, row);
    row.order = static_cast<int>(k) + 1;
    const double together =
        k + 1 < parts.size() ? row.alone : share(before_ - first.fit.tried.chi2, first.fit.regions);
    row.in_order = together - before;
    before = together;
  }
  say_what_looks_the_same(named, out);
  sort(out);
  out.rest = 1.0 - before;
  out.chi2_after = first.fit.chi2;
  offer_gain(first, out);
}

void CauseSearch::say_what_looks_the_same(const std::vector<std::size_t>& named, Causes& out) const {
  std::set<std::size_t> groups;
  for (const std::size_t left_out : explaining())
    for (const std::size_t k : named)
      if (stands_for_contrast(tried_[k], tried_[left_out]))
        for (const std::size_t g : tried_[k].groups)
          if (std::ranges::find(tried_[left_out].groups, g) == tried_[left_out].groups.end())
            groups.insert(g);
  for (CauseRow& row : out.rows)
    for (const std::size_t g : groups)
      if (row.group == groups_[g].name) row.cause += " (here another contrast of all fringes looks the same)";
}

void CauseSearch::add_texture_beside(Causes& out) const {
  const bool is_smooth = std::ranges::any_of(
      out.together, [](const std::string& t) { return t == "vignetting" || t == "projector_field"; });
  if (!is_smooth || sensitivity_.samples().size() > 1 || sensitivity_.has_free_factors()) return;
  out.together.emplace_back("texture");
  const PixelField& texture = *field_of(FreePerPixel::factor);
  CauseRow row;
  row.group = texture.name;
  row.cause = texture.cause;
  CauseFit fit = fit_cause(sensitivity_, twin_, {}, texture.free, {.predicted = base_});
  fit.tried.fitted -= own_;
  fit.tried.chi2 -= own_;
  take(fit, row);
  out.rows.push_back(std::move(row));
}

void CauseSearch::offer_gain(const TriedExplanation& first, Causes& out) const {
  const auto scales = [](const std::string& name) {
    return std::ranges::any_of(groups_in(name), scales_the_gain);
  };
  if (std::ranges::any_of(out.together, scales) ||
      sensitivity_.with_own(FreePerPixel::nothing) != FreePerPixel::nothing)
    out.why = "what changes the images as the gain does (reflectivity, vignetting) cannot be told from it";
  if (std::ranges::any_of(first.groups, [this](std::size_t g) { return is_switch(g); }))
    out.why = "it is either on or off: set it in the twin and compare again";
  if (first.field) out.why = "what every pixel has of its own cannot be told from it";
  if (out.why.empty() && !first.fit.converged) out.why = "the fit did not come to rest";
  if (!out.why.empty()) return;
  out.gain = first.fit.gain;
  for (const std::size_t g : first.groups) out.with += (out.with.empty() ? "" : ", ") + groups_[g].name;
  const CauseParameter& value = first.fit.told[0];
  if (first.fit.told.size() == 1 && value.sigma > 0.0)
    out.with +=
        " " + report::with_sigma(value.estimate, value.sigma) + (value.unit.empty() ? "" : " ") + value.unit;
}

void CauseSearch::list_in_order(Causes& out) const {
  double before = before_;
  std::vector<std::size_t> taken;
  for (const std::size_t g : choose_order()) {
    taken.push_back(g);
    const Step step = solve(equations_, taken);
    out.rows[g].order = static_cast<int>(taken.size());
    out.rows[g].in_order = share(before - step.chi2, {});
    before = step.chi2;
  }
  if (!taken.empty() && values_fail_) out.rest = (before - static_cast<double>(out.n)) / excess_;
  sort(out);
}

void CauseSearch::sort(Causes& out) {
  std::ranges::stable_sort(out.rows, [](const CauseRow& a, const CauseRow& b) {
    const int x = a.order > 0 ? a.order : 99, y = b.order > 0 ? b.order : 99;
    return x != y ? x < y : a.removed > b.removed;
  });
}

std::vector<std::size_t> CauseSearch::choose_order() const {
  std::vector<std::size_t> taken;
  while (taken.size() < kMostInOrder) {
    std::size_t best = groups_.size();
    double most = removed_by(equations_, taken) + std::max(worth_naming(1.0), kWorthAdding * excess_);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (std::ranges::find(taken, g) != taken.end()) continue;
      std::vector<std::size_t> with = taken;
      with.push_back(g);
      if (const double removed = removed_by(equations_, with); removed > most) most = removed, best = g;
    }
    if (best == groups_.size()) break;
    taken.push_back(best);
  }
  return taken;
}

CauseRow CauseSearch::make_row(std::size_t g, const Step& step) const {
  CauseRow row;
  row.group = groups_[g].name;
  row.cause = parameter_group(row.group).cause;
  row.removed = removed_by(equations_, {g});
  row.alone = share(row.removed, {});
  const double inflation = std::sqrt(std::max(1.0, step.chi2 / static_cast<double>(n_)));
  for (const std::size_t k : groups_[g].at) {
    const Parameter& p = parameters_[k];
    const double value = std::clamp(start_[k] + step.change[k], p.is_switch ? -1e300 : p.smallest,
                                    p.is_switch ? 1e300 : p.largest);
    row.parameters.push_back({p.name, p.unit, p.shown(start_[k]), p.shown(value),
                              p.shown_sigma(value, inflation * step.sigma[k])});
  }
  return row;
}

}  // namespace fringetwin::compare
