// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/cause_search.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <string_view>
#include <utility>

#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kWorthATry = 0.25;  ///< of what the best linear step takes away, and of the excess
constexpr double kOtherGain = 2.0;   ///< times the gain: no longer one
constexpr double kAsMuch = 0.8;      ///< of what the best one takes away beside a field: worth a fit
constexpr double kPairShare = 0.5;   ///< of the excess that the linear step of two must take away
/// What a linear step leaves of the excess is its model's fault up to so many times what that of a cause
/// leaves which then explains all; kAlikeShare of the excess does not tell rivals apart, kAlikeChi2 neither.
constexpr double kAsCurved = 10.0, kAlikeShare = 0.02, kAlikeChi2 = 50.0;
constexpr std::size_t kMostAlone = 6, kMostFirst = 3, kMostPairs = 3;
constexpr std::size_t kMostWithContrast = 2;  ///< pairs with another contrast of all fringes, beside these
constexpr std::size_t kEvery = 4;             ///< pixel, where pairs are only chosen

/// Parts of the work of a search, in percent: what has ended when each of them begins.
constexpr std::size_t kColumnsDone = 40, kAloneDone = 70, kPairsDone = 90;

constexpr PixelField kFields[] = {
    {FreePerPixel::offset, "offset",
     "an offset per pixel (room light, scattering, a lamp beside, pixels of unequal black level)"},
    {FreePerPixel::factor, "texture",
     "a factor per pixel (texture, gloss, a projector that lights unevenly, pixels of unequal gain)"},
    {FreePerPixel::factor_and_offset, "texture and offset",
     "a factor and an offset per pixel (uneven surface and room light, or pixels that are not alike)"}};

/// What takes contrast from the fringes by a known way: of one pitch as another contrast of all does.
constexpr std::string_view kTakeContrast[] = {"blur", "halo", "camera_psf", "subsurface"};

/// Keeps the first n, and `besides` wherever it is: another contrast of all fringes looks like much that
/// takes contrast, and takes nobody's place.
void keep_first(std::vector<std::size_t>& list, std::size_t n, std::size_t besides) {
  std::erase_if(list,
                [&, kept = std::size_t{0}](std::size_t k) mutable { return k != besides && ++kept > n; });
}

}  // namespace

CauseSearch::CauseSearch(Sensitivity& sensitivity, const Twin& twin, const std::vector<FitRow>& fits,
                         const std::vector<int>& steps)
    : sensitivity_(sensitivity), twin_(twin), fits_(fits) {
  const bool sees_code = sensitivity.holds_code(twin);
  for (const ParameterGroup& group : parameter_groups()) {
    if (!group.is_searched || (group.name == "halo" && !sees_code)) continue;
    CauseGroup g{group.name, {}};
    for (Parameter& p : parameters_of(twin, group.name, steps)) {
      g.at.push_back(parameters_.size());
      parameters_.push_back(std::move(p));
    }
    if (!g.at.empty()) groups_.push_back(std::move(g));
  }
  start_ = start_values(parameters_);
  base_ = sensitivity.predicted(twin, parameters_, start_);
  sensitivity.settle_lights(base_);
}

Causes CauseSearch::run() {
  Causes out;
  judge_twin(out);
  if (!values_fail_ && std::ranges::all_of(regions_before_, &CauseRegion::passes)) return out;
  const auto pose = std::ranges::find(groups_, "pose", &CauseGroup::name);
  columns_ = sensitivity_.columns_of_all_groups(
      twin_, parameters_, start_, pose == groups_.end() ? std::vector<std::size_t>{} : pose->at,
      [&](std::size_t done) { progress_.reach(done * kColumnsDone / (parameters_.size() + 1)); });
  weigh_by_the_nearest();
  judge_twin(out);
  progress_.reach(kColumnsDone);
  equations_ = sensitivity_.equations_at(base_, columns_, FreePerPixel::nothing);
  for (std::size_t g = 0; g < groups_.size(); ++g) out.rows.push_back(make_row(g, solve(equations_, {g})));
  try_alone(out.rows);
  progress_.reach(kAloneDone);
  std::vector<std::size_t> named = alike();
  if (named.empty()) try_pairs(out.rows);
  progress_.reach(kPairsDone);
  if (named.empty()) named = alike();
  if (named.empty() && !sensitivity_.has_free_factors()) try_fields(out.rows);
  if (named.empty()) named = alike();
  if (all_is_free(named) && !sensitivity_.has_free_factors()) {
    try_fields_with_groups();
    named = alike();
  }
  if (named.empty())
    list_in_order(out);
  else
    list_named(named, out);
  progress_.finish();
  return out;
}

void CauseSearch::judge_twin(Causes& out) {
  sensitivity_.choose_scale(base_, FreePerPixel::nothing);
  const CauseFit as_it_is = fit_cause(sensitivity_, twin_, {}, FreePerPixel::nothing, {.predicted = base_});
  out.n = n_ = as_it_is.n;
  out.chi2 = as_it_is.chi2;
  own_ = as_it_is.tried.fitted;
  before_ = as_it_is.tried.chi2 - own_;
  excess_ = before_ - static_cast<double>(out.n);
  regions_before_ = as_it_is.regions;
  out.chi2_limit = sensitivity_.chi2_limit(static_cast<double>(out.n));
  values_fail_ = !(out.chi2 <= out.chi2_limit);
}

void CauseSearch::weigh_by_the_nearest() {
  const NormalEquations e = sensitivity_.equations_at(base_, columns_, FreePerPixel::nothing, kEvery);
  double most = worth_naming(1.0);
  const std::size_t contrast = group_at("fringe_contrast");
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (const double removed = removed_by(e, {g}, kEvery); g != contrast && removed > most)
      most = removed, nearest_ = g;
  // what takes contrast by a known way comes first where it takes away nearly as much
  if (contrast < groups_.size() && kAsMuch * removed_by(e, {contrast}, kEvery) > most) nearest_ = contrast;
  if (!nearest_) return;
  begin_.emplace(fit({*nearest_}, nullptr, nullptr, true));
  // all fits begin at its gain, but where that is none: an albedo that light from surface to surface drives
  // to nothing has one of a million
  const std::vector<GridSamples> before = sensitivity_.samples();
  sensitivity_.take_sensors(begin_->sensors.samples());
  if (is_switch(*nearest_)) {
    Twin turned = twin_;
    const Parameter& p = parameters_[groups_[*nearest_].at[0]];
    p.change(turned, p.start > 0.5 ? -1.0 : 1.0);
    sensitivity_.add_scatter_of(turned);
  }
  sensitivity_.weigh_at(begin_->predicted);
  const auto is_no_gain = [&](std::size_t c) {
    const double ratio = begin_->sensors.samples()[c].gain_dn / before[c].gain_dn;
    return !(ratio > 1.0 / kOtherGain && ratio < kOtherGain);
  };
  for (std::size_t c = 0; c < before.size(); ++c)
    if (is_no_gain(c)) return sensitivity_.take_sensors(before);
}

Step CauseSearch::solve(const NormalEquations& e, const std::vector<std::size_t>& groups) const {
  std::vector<std::size_t> unknowns;
  for (std::size_t c = 0; c < sensitivity_.samples().size(); ++c) {
    for (const std::size_t at : {e.gain_at(c), e.black_at(c)}) unknowns.push_back(at);
    std::ranges::copy(sensitivity_.lights_at(c, e.n_parameters), std::back_inserter(unknowns));
  }
  for (const std::size_t g : groups)
    unknowns.insert(unknowns.end(), groups_[g].at.begin(), groups_[g].at.end());
  return solve_step(e, unknowns);
}

double CauseSearch::removed_by(const NormalEquations& e, const std::vector<std::size_t>& groups,
                               std::size_t every) const {
  const Step without = solve(e, {}), with = solve(e, groups);
  return without.chi2 - with.chi2 -
         static_cast<double>(every) * static_cast<double>(with.n_determined - without.n_determined);
}

std::size_t CauseSearch::group_at(const char* name) const {
  return static_cast<std::size_t>(std::ranges::find(groups_, name, &CauseGroup::name) - groups_.begin());
}

bool CauseSearch::is_switch(std::size_t g) const { return parameters_[groups_[g].at[0]].is_switch; }

Sensitivity::Values CauseSearch::switched(std::size_t g) const {
  const std::size_t at = groups_[g].at[0];
  const float step = parameters_[at].start > 0.5 ? -1.0F : 1.0F;
  Sensitivity::Values out = base_;
  for (std::size_t c = 0; c < out.size(); ++c)
    for (std::size_t i = 0; i < out[c].size(); ++i) out[c][i] += step * columns_.each[at][c][i];
  return out;
}

bool CauseSearch::is_one_spread(std::size_t g, std::size_t other) const {
  const std::string &a = groups_[g].name, &b = groups_[other].name;
  return (a == "halo" && b == "blur") || (a == "blur" && b == "halo");
}

bool CauseSearch::moves_objects(std::size_t g) const {
  return groups_[g].name == "pose" || groups_[g].name == "size";
}

double CauseSearch::share(double removed, const std::vector<CauseRegion>& after) const {
  if (values_fail_) return std::min(1.0, removed / excess_);
  double excess = 0.0, left = 0.0;
  for (std::size_t k = 0; k < after.size(); ++k)
    if (const CauseRegion& was = regions_before_[k]; !was.passes()) {
      excess += static_cast<double>(was.n) * (was.chi2 - 1.0);
      // of none: what every pixel has of its own takes all of them
      if (after[k].n > 0) left += static_cast<double>(was.n) * (after[k].chi2 - 1.0);
    }
  return excess > 0.0 ? std::min(1.0, 1.0 - left / excess) : kNaN;
}

std::vector<std::size_t> CauseSearch::alike() const {
  std::vector<std::size_t> named = explaining();
  const std::vector<std::size_t> all = named;
  std::erase_if(named, [&](std::size_t k) {
    return std::ranges::any_of(
        all, [&](std::size_t known) { return stands_for_contrast(tried_[known], tried_[k]); });
  });
  return named;
}

bool CauseSearch::stands_for_contrast(const TriedExplanation& known, const TriedExplanation& contrast) const {
  if (known.field != contrast.field || known.groups.size() != contrast.groups.size()) return false;
  std::vector<std::size_t> rest = known.groups;  // without what both have
  bool has_contrast = false;
  for (const std::size_t g : contrast.groups)
    if (groups_[g].name == "fringe_contrast")
      has_contrast = true;
    else
      std::erase(rest, g);
  return has_contrast && rest.size() == 1 &&
         std::ranges::find(kTakeContrast, groups_[rest[0]].name) != std::end(kTakeContrast);
}

std::vector<std::size_t> CauseSearch::explaining() const {
  std::vector<TriedCause> all;
  double least = sensitivity_.chi2_limit(static_cast<double>(n_));
  for (const TriedExplanation& t : tried_) {
    all.push_back(t.fit.tried);
    if (t.fit.tried.passes) least = std::min(least, t.fit.chi2);
  }
  return explaining_alike(all, before_, least);
}

CauseFit CauseSearch::fit(const std::vector<std::size_t>& groups, const PixelField* field,
                          const CauseFit* first, bool only_values) const {
  std::vector<Parameter> own;
  CauseStart start{.predicted = base_, .columns = {columns_.rough, {}}};
  for (const std::size_t g : groups)
    for (const std::size_t at : groups_[g].at) {
      own.push_back(parameters_[at]);
      start.columns.each.push_back(columns_.each[at]);
      start.columns.steps.push_back(columns_.steps[at]);
    }
  if (first) {
    start.values = start_values(own);
    FT_CHECK(first->values.size() <= start.values.size(), "the first groups are among these");
    start.values.head(first->values.size()) = first->values;
    start.predicted = first->predicted;
    if (first->columns.each.size() == own.size()) {
      start.columns = first->columns;
      start.columns_at = first->columns_at;
    }
  }
  Eigen::VectorXd lit = with_light_in_halo(own, start_values(own));
  const Eigen::Index n_first = first ? first->values.size() : 0;
  if (lit.tail(lit.size() - n_first) != start_values(own).tail(lit.size() - n_first)) {
    if (first) lit.head(n_first) = first->values;
    start = {.values = lit, .predicted = sensitivity_.predicted(twin_, own, lit)};
  }
  if (std::ranges::any_of(groups, [this](std::size_t g) { return is_switch(g); }))
    start = {.predicted = groups.size() == 1 ? switched(groups[0]) : Sensitivity::Values{}};
  start.only_values = only_values;
  return fit_cause(sensitivity_, twin_, own, field ? field->free : FreePerPixel::nothing, std::move(start));
}

const CauseFit& CauseSearch::try_fit(const std::vector<std::size_t>& groups, const PixelField* field,
                                     const CauseFit* first) {
  CauseFit fitted = fit(groups, field, first);
  fitted.tried.fitted -= own_;
  fitted.tried.chi2 -= own_;
  if (!field && std::ranges::all_of(groups, [this](std::size_t g) { return moves_objects(g); }))
    hold_against_fits(fits_, twin_, fitted);
  return tried_.emplace_back(TriedExplanation{groups, field, std::move(fitted)}).fit;
}

void CauseSearch::try_alone(std::vector<CauseRow>& rows) {
  std::vector<std::size_t> groups;
  double most = values_fail_ ? excess_ : 0.0;
  std::vector<double> promised;
  for (const CauseRow& row : rows) {
    most = std::max(most, row.removed);
    promised.push_back(row.removed);
  }
  promise_of_the_curved(promised);
  for (std::size_t g = 0; g < rows.size(); ++g)
    if (promised[g] >= std::max(kWorthATry * most, worth_naming(1.0))) groups.push_back(g);
  std::ranges::stable_sort(groups, [&](auto a, auto b) { return promised[a] > promised[b]; });
  keep_first(groups, kMostAlone, group_at("fringe_contrast"));
  double least = 0.0;  // that a rival's linear step must take away
  try_where_fits_are(rows, groups, least);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const std::size_t g = groups[k];
    progress_.reach(kColumnsDone + k * (kAloneDone - kColumnsDone) / groups.size());
    if (promised[g] < least) break;
    fit_alone(g, g == nearest_ && !is_switch(g) ? &*begin_ : nullptr, rows[g], least);
  }
  try_place_and_size(rows);
}

void CauseSearch::promise_of_the_curved(std::vector<double>& removed_by_group) const {
  for (const auto& [curved, other] :
       {std::pair{"camera_knee", "camera_response"}, std::pair{"subsurface", "blur"}})
    if (const std::size_t g = group_at(curved), as = group_at(other);
        g < groups_.size() && as < groups_.size())
      removed_by_group[g] = std::max(removed_by_group[g], removed_by_group[as]);
}

void CauseSearch::fit_alone(std::size_t g, const CauseFit* first, CauseRow& row, double& least) {
  const double linear = row.removed;
  take(try_fit({g}, nullptr, first), row);
  if (row.passes)
    least = std::max(least, row.removed - std::max({kAsCurved * (row.removed - linear), kAlikeShare * excess_,
                                                    kAlikeChi2}));
}

std::optional<CauseFit> CauseSearch::begin_where_fits_are(const std::vector<std::size_t>& groups) const {
  std::vector<Parameter> own;
  for (const std::size_t g : groups)
    for (const std::size_t at : groups_[g].at) own.push_back(parameters_[at]);
  const std::optional<Eigen::VectorXd> values = values_of_fits(fits_, twin_, own);
  if (!values) return std::nullopt;
  CauseFit begin{.sensors = sensitivity_, .fitted = {}};
  begin.values = *values;
  begin.predicted = sensitivity_.predicted(twin_, own, *values);
  return begin;
}

void CauseSearch::try_where_fits_are(std::vector<CauseRow>& rows, std::vector<std::size_t>& not_yet,
                                     double& least) {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (!moves_objects(g)) continue;
    const std::optional<CauseFit> begin = begin_where_fits_are({g});
    if (!begin) continue;
    fit_alone(g, &*begin, rows[g], least);
    std::erase(not_yet, g);
  }
}

void CauseSearch::try_place_and_size(const std::vector<CauseRow>& rows) {
  const std::vector<std::size_t> both{group_at("pose"), group_at("size")};
  for (const std::size_t g : both)
    if (g == groups_.size() || rows[g].passes) return;
  const std::optional<CauseFit> begin = begin_where_fits_are(both);
  if (!begin) return;
  try_fit(both, nullptr, &*begin);
  settle_pair(tried_.back(), rows);
}

void CauseSearch::settle_pair(TriedExplanation& pair, const std::vector<CauseRow>& rows) const {
  for (const std::size_t k : {0u, 1u}) {
    const double alone = before_ - rows[pair.groups[1 - k]].removed;
    if (alone - pair.fit.tried.chi2 < worth_naming(static_cast<double>(groups_[pair.groups[k]].at.size())))
      pair.fit.tried.passes = false;
  }
  if (rows[pair.groups[1]].removed > rows[pair.groups[0]].removed) std::swap(pair.groups[0], pair.groups[1]);
}

void CauseSearch::try_pairs(const std::vector<CauseRow>& rows) {
  std::vector<std::size_t> firsts;  // fits of single groups
  for (std::size_t k = 0; k < tried_.size(); ++k)
    if (tried_[k].groups.size() == 1 && !tried_[k].field) firsts.push_back(k);
  std::ranges::stable_sort(
      firsts, [&](auto a, auto b) { return tried_[a].fit.tried.chi2 < tried_[b].fit.tried.chi2; });
  const std::size_t contrast = group_at("fringe_contrast");
  const auto of_contrast =
      std::ranges::find_if(firsts, [&](std::size_t k) { return tried_[k].groups[0] == contrast; });
  keep_first(firsts, kMostFirst, of_contrast == firsts.end() ? tried_.size() : *of_contrast);
  struct Pair {
    std::size_t first, second;
    double left;
  };
  std::vector<Pair> pairs;
  for (const std::size_t k : firsts) {
    const CauseFit& fit = tried_[k].fit;
    if (fit.fitted.empty()) continue;  // a switch
    const std::size_t g = tried_[k].groups[0];
    Sensitivity there = fit.sensors;
    const NormalEquations e = there.equations_at(fit.predicted, columns_, FreePerPixel::nothing, kEvery);
    const double alone = removed_by(e, {g}, kEvery);
    std::vector<double> beside(groups_.size(), 0.0);  // what each takes away more; no switches
    for (std::size_t other = 0; other < groups_.size(); ++other)
      if (other != g && !is_switch(other)) beside[other] = removed_by(e, {g, other}, kEvery) - alone;
    promise_of_the_curved(beside);
    beside[g] = 0.0;
    for (std::size_t other = 0; other < groups_.size(); ++other) {
      const double more = beside[other], left = fit.tried.chi2 - more;
      if (is_one_spread(g, other) || (more >= worth_naming(static_cast<double>(groups_[other].at.size())) &&
                                      (!values_fail_ || before_ - left >= kPairShare * excess_)))
        pairs.push_back({k, other, left});
    }
  }
  // those of one spread first: a linear step from one of the two says nothing of both
  const auto is_spread = [this](const Pair& p) { return is_one_spread(tried_[p.first].groups[0], p.second); };
  std::ranges::stable_sort(pairs, {}, [&](const Pair& p) { return std::pair(!is_spread(p), p.left); });
  const auto numbers = [this](const Pair& p) {
    return groups_[tried_[p.first].groups[0]].at.size() + groups_[p.second].at.size();
  };
  const Pair* passed = nullptr;  // one that a linear step does not tell apart, of fewer numbers, is its rival
  const auto is_rival = [&](const Pair& p) {
    return passed && numbers(p) < numbers(*passed) && p.left <= passed->left + kAlikeShare * excess_;
  };
  std::size_t n_tried = 0, n_with_contrast = 0;
  for (const Pair& pair : pairs) {
    const auto& [first, second, left] = pair;
    std::vector<std::size_t> both{tried_[first].groups[0], second};
    const auto is_same = [&](const TriedExplanation& t) {
      return t.groups.size() == 2 && std::ranges::is_permutation(t.groups, both);
    };
    const bool has_contrast = std::ranges::find(both, contrast) != both.end();
    if (std::ranges::any_of(tried_, is_same) ||
        (has_contrast ? n_with_contrast >= kMostWithContrast
                      : n_tried >= (is_rival(pair) ? 2 * kMostPairs : kMostPairs)))
      continue;
    progress_.reach(kAloneDone + n_tried * (kPairsDone - kAloneDone) / (2 * kMostPairs));
    ++(has_contrast ? n_with_contrast : n_tried);
    const CauseFit begin = tried_[first].fit;  // tried_ grows
    try_fit(both, nullptr, is_one_spread(both[0], both[1]) ? nullptr : &begin);
    settle_pair(tried_.back(), rows);
    if (tried_.back().fit.tried.passes) passed = &pair;
  }
}

bool CauseSearch::all_is_free(const std::vector<std::size_t>& named) const {
  return std::ranges::all_of(named, [this](std::size_t k) {
    return tried_[k].field && tried_[k].field->free == FreePerPixel::factor_and_offset;
  });
}

void CauseSearch::try_fields(std::vector<CauseRow>& rows) {
  for (const PixelField& field : kFields) {
    CauseRow row;
    row.group = field.name;
    row.cause = field.cause;
    take(try_fit({}, &field), row);
    rows.push_back(std::move(row));
  }
}

void CauseSearch::try_fields_with_groups() {
  for (const FreePerPixel free : {FreePerPixel::offset, FreePerPixel::factor}) {
    const NormalEquations e = sensitivity_.equations_at(base_, columns_, free, kEvery);
    std::vector<std::pair<double, std::size_t>> all;
    for (std::size_t g = 0; g < groups_.size(); ++g)
      if (const double removed = removed_by(e, {g}, kEvery); !is_switch(g) && removed > worth_naming(1.0))
        all.emplace_back(removed, g);
    std::ranges::sort(all, std::greater());
    all.resize(std::min(all.size(), kMostFirst));
    for (const auto& [removed, g] : all)
      if (removed >= kAsMuch * all[0].first) try_fit({g}, field_of(free));
  }
}

const PixelField* CauseSearch::field_of(FreePerPixel free) {
  for (const PixelField& field : kFields)
    if (field.free == free) return &field;
  return nullptr;
}

Causes find_causes(Sensitivity& sensitivity, const Twin& twin, const std::vector<FitRow>& fits,
                   const std::vector<int>& steps) {
  const Twin searched = sensitivity.holds_code(twin) ? with_empty_halo(twin) : twin;
  sensitivity.choose_points(searched);
  return CauseSearch(sensitivity, searched, fits, steps).run();
}

}  // namespace fringetwin::compare
