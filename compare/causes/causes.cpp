// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "compare/causes/cause_fit.hpp"
#include "compare/causes/parameters.hpp"
#include "compare/result/milestones.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kWorthAdding = 0.02;  ///< share a further cause must explain to be listed in the order
constexpr std::size_t kMostInOrder = 4;
constexpr double kWorthATry = 0.25;  ///< of what the best linear step takes away, and of the excess
constexpr double kOtherGain = 2.0;   ///< times the gain: no longer one
constexpr double kAsMuch = 0.8;      ///< of what the best one takes away beside a field: worth a fit
constexpr double kPairShare = 0.5;   ///< of the excess that the linear step of two must take away
/// What a linear step leaves of the excess is its model's fault up to so many times what that of a cause
/// leaves which then explains all; kAlikeShare of the excess does not tell rivals apart, kAlikeChi2 neither.
constexpr double kAsCurved = 10.0, kAlikeShare = 0.02, kAlikeChi2 = 50.0;
constexpr std::size_t kMostAlone = 6, kMostFirst = 3, kMostPairs = 3;
constexpr std::size_t kEvery = 4;  ///< pixel, where pairs are only chosen

/// Parts of the work of a search, in percent: what has ended when each of them begins.
constexpr std::size_t kColumnsDone = 40, kAloneDone = 70, kPairsDone = 90, kAll = 100;

struct Group {
  std::string name;
  std::vector<std::size_t> at;  ///< of its parameters among all
};

/// What every pixel may have of its own, as causes.
struct PixelField {
  FreePerPixel free;
  const char *name, *cause;
};
constexpr PixelField kFields[] = {
    {FreePerPixel::offset, "offset",
     "an offset per pixel (room light, scattering, a lamp beside, pixels of unequal black level)"},
    {FreePerPixel::factor, "texture",
     "a factor per pixel (texture, gloss, a projector that lights unevenly, pixels of unequal gain)"},
    {FreePerPixel::factor_and_offset, "texture and offset",
     "a factor and an offset per pixel (uneven surface and room light, or pixels that are not alike)"}};

/// One explanation that was tried: groups, and a field of what every pixel has of its own.
struct Tried {
  std::vector<std::size_t> groups;
  const PixelField* field = nullptr;
  CauseFit fit;
};

class CauseSearch {
 public:
  CauseSearch(Sensitivity& sensitivity, const Twin& twin, const std::vector<FitRow>& fits,
              const std::vector<int>& steps)
      : sensitivity_(sensitivity), twin_(twin), fits_(fits) {
    for (const ParameterGroup& group : parameter_groups()) {
      if (!group.is_searched) continue;
      Group g{group.name, {}};
      for (Parameter& p : parameters_of(twin, group.name, steps)) {
        g.at.push_back(parameters_.size());
        parameters_.push_back(std::move(p));
      }
      if (!g.at.empty()) groups_.push_back(std::move(g));
    }
    start_ = start_values(parameters_);
    base_ = sensitivity.predicted(twin, parameters_, start_);
  }

  Causes run() {
    Causes out;
    judge_twin(out);
    if (!values_fail_ && std::ranges::all_of(regions_before_, &CauseRegion::passes)) return out;
    const auto pose = std::ranges::find(groups_, "pose", &Group::name);
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

 private:
  /// Fits gain and black level alone.
  void judge_twin(Causes& out) {
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

  /// Fits the group whose linear step takes away most, and takes the noise of all values at what it predicts:
  /// at the levels of a twin that is wrong, noise is wrong by a fifth. The same weights for all groups, or
  /// those would be better that predict more noise.
  void weigh_by_the_nearest() {
    const NormalEquations e = sensitivity_.equations_at(base_, columns_, FreePerPixel::nothing, kEvery);
    double most = worth_naming(1.0);
    for (std::size_t g = 0; g < groups_.size(); ++g)
      if (const double removed = removed_by(e, {g}, kEvery); removed > most) most = removed, nearest_ = g;
    if (!nearest_) return;
    begin_.emplace(fit({*nearest_}, nullptr, nullptr, true));
    // all fits begin at its gain, but where that is none: an albedo that light from surface to surface drives
    // to nothing has one of a million
    const std::vector<GridSamples> before = sensitivity_.samples();
    take_sensors(begin_->sensors.samples());
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
      if (is_no_gain(c)) return take_sensors(before);
  }

  void take_sensors(const std::vector<GridSamples>& from) {
    for (std::size_t c = 0; c < from.size(); ++c)
      sensitivity_.set_sensor(c, from[c].gain_dn, from[c].black_level_dn);
  }

  /// Solves for these groups with gain and black level of every camera.
  Step solve(const NormalEquations& e, const std::vector<std::size_t>& groups) const {
    std::vector<std::size_t> unknowns;
    for (std::size_t c = 0; c < sensitivity_.samples().size(); ++c)
      for (const std::size_t at : {e.gain_at(c), e.black_at(c)}) unknowns.push_back(at);
    for (const std::size_t g : groups)
      unknowns.insert(unknowns.end(), groups_[g].at.begin(), groups_[g].at.end());
    return solve_step(e, unknowns);
  }
  /// Returns by how much a linear step in these groups lowers chi2, less what it would lower noise. `every`:
  /// of the equations.
  double removed_by(const NormalEquations& e, const std::vector<std::size_t>& groups,
                    std::size_t every = 1) const {
    const Step without = solve(e, {}), with = solve(e, groups);
    return without.chi2 - with.chi2 -
           static_cast<double>(every) * static_cast<double>(with.n_determined - without.n_determined);
  }
  bool is_switch(std::size_t g) const { return parameters_[groups_[g].at[0]].is_switch; }
  bool moves_objects(std::size_t g) const { return groups_[g].name == "pose" || groups_[g].name == "size"; }

  /// Returns the share of what fails that is taken away: of the excess of single values, or else of that of
  /// the kinds of regions that fail. NaN where only regions fail and what is left in them is not known.
  double share(double removed, const std::vector<CauseRegion>& after) const {
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

  /// Returns those that explain the difference and cannot be told apart.
  std::vector<std::size_t> alike() const {
    std::vector<TriedCause> all;
    double least = sensitivity_.chi2_limit(static_cast<double>(n_));
    for (const Tried& t : tried_) {
      all.push_back(t.fit.tried);
      if (t.fit.tried.passes) least = std::min(least, t.fit.chi2);
    }
    return explaining_alike(all, before_, least);
  }

  /// Fits groups to convergence, in a field or without; `first`: begins where this fit ended.
  CauseFit fit(const std::vector<std::size_t>& groups, const PixelField* field, const CauseFit* first,
               bool only_values = false) const {
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
      start.values.head(first->values.size()) = first->values;
      start.predicted = first->predicted;
      if (first->columns.each.size() == own.size()) {
        start.columns = first->columns;
        start.columns_at = first->columns_at;
      }
    }
    if (std::ranges::any_of(groups, [this](std::size_t g) { return is_switch(g); })) start = {};
    start.only_values = only_values;
    return fit_cause(sensitivity_, twin_, own, field ? field->free : FreePerPixel::nothing, std::move(start));
  }
  const CauseFit& try_fit(const std::vector<std::size_t>& groups, const PixelField* field = nullptr,
                          const CauseFit* first = nullptr) {
    CauseFit fitted = fit(groups, field, first);
    fitted.tried.fitted -= own_;
    fitted.tried.chi2 -= own_;
    if (!field && std::ranges::all_of(groups, [this](std::size_t g) { return moves_objects(g); }))
      hold_against_fits(fits_, twin_, fitted);
    return tried_.emplace_back(Tried{groups, field, std::move(fitted)}).fit;
  }

  /// Fits the groups to convergence whose linear steps take away most; once one passes, only its rivals.
  void try_alone(std::vector<CauseRow>& rows) {
    std::vector<std::size_t> groups;
    double most = values_fail_ ? excess_ : 0.0;
    for (const CauseRow& row : rows) most = std::max(most, row.removed);
    std::vector<double> promised;
    for (const CauseRow& row : rows) promised.push_back(row.removed);
    promise_of_a_knee(promised);
    for (std::size_t g = 0; g < rows.size(); ++g)
      if (promised[g] >= std::max(kWorthATry * most, worth_naming(1.0))) groups.push_back(g);
    std::ranges::stable_sort(groups, [&](auto a, auto b) { return promised[a] > promised[b]; });
    groups.resize(std::min(groups.size(), kMostAlone));
    double least = 0.0;  // that a rival's linear step must take away
    try_where_fits_are(rows, groups, least);
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const std::size_t g = groups[k];
      progress_.reach(kColumnsDone + k * (kAloneDone - kColumnsDone) / groups.size());
      if (promised[g] < least) break;
      fit_alone(g, g == nearest_ && !is_switch(g) ? &*begin_ : nullptr, rows[g], least);
    }
  }
  /// A knee's linear step knows nothing of its place: it may take away as much as smooth curves do.
  void promise_of_a_knee(std::vector<double>& removed_by_group) const {
    const auto at = [this](const char* name) {
      return static_cast<std::size_t>(std::ranges::find(groups_, name, &Group::name) - groups_.begin());
    };
    const std::size_t knee = at("camera_knee"), curves = at("camera_response");
    if (knee < groups_.size() && curves < groups_.size())
      removed_by_group[knee] = std::max(removed_by_group[knee], removed_by_group[curves]);
  }
  /// `first`: as in try_fit(). Raises `least` where the group passes.
  void fit_alone(std::size_t g, const CauseFit* first, CauseRow& row, double& least) {
    const double linear = row.removed;
    take(try_fit({g}, nullptr, first), row);
    if (row.passes)
      least = std::max(least, row.removed - std::max({kAsCurved * (row.removed - linear),
                                                      kAlikeShare * excess_, kAlikeChi2}));
  }

  /// Fits the groups to convergence from where the objects' fits put them: too far for a linear step.
  void try_where_fits_are(std::vector<CauseRow>& rows, std::vector<std::size_t>& not_yet, double& least) {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (!moves_objects(g)) continue;
      std::vector<Parameter> own;
      for (const std::size_t at : groups_[g].at) own.push_back(parameters_[at]);
      const std::optional<Eigen::VectorXd> values = values_of_fits(fits_, twin_, own);
      if (!values) continue;
      CauseFit begin{.sensors = sensitivity_, .fitted = {}};
      begin.values = *values;
      begin.predicted = sensitivity_.predicted(twin_, own, *values);
      fit_alone(g, &begin, rows[g], least);
      std::erase(not_yet, g);
    }
  }

  /// Writes what a fit by itself found into the row.
  void take(const CauseFit& fit, CauseRow& row) const {
    row.chi2_after = fit.chi2;
    row.passes = fit.tried.passes;
    row.regions_after = fit.regions;
    row.fit_z_after = fit.fit_z;
    row.fits_agree = fit.fits_agree;
    row.removed = before_ - fit.tried.chi2;
    row.alone = share(row.removed, fit.regions);
    take_values(fit, row);
  }
  static void take_values(const CauseFit& fit, CauseRow& row) {
    for (const CauseParameter& fitted : fit.told)
      for (CauseParameter& p : row.parameters)
        if (p.name == fitted.name) {
          p = fitted;
          if (!(p.sigma > 0.0)) p.sigma = kNaN;  // held at the twin's value
        }
  }

  /// Fits the groups that take away most together with each that takes most of what they leave; each of the
  /// two must be worth naming besides the other.
  void try_pairs(const std::vector<CauseRow>& rows) {
    std::vector<std::size_t> firsts(tried_.size());
    for (std::size_t k = 0; k < firsts.size(); ++k) firsts[k] = k;
    std::ranges::stable_sort(
        firsts, [&](auto a, auto b) { return tried_[a].fit.tried.chi2 < tried_[b].fit.tried.chi2; });
    firsts.resize(std::min(firsts.size(), kMostFirst));
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
      std::vector<double> removed(groups_.size(), 0.0);
      for (std::size_t other = 0; other < groups_.size(); ++other)
        if (other != g && !is_switch(other))
          removed[other] = removed_by(e, {g, other}, kEvery) - removed_by(e, {g}, kEvery);
      promise_of_a_knee(removed);
      for (std::size_t other = 0; other < groups_.size(); ++other) {
        if (other == g || is_switch(other)) continue;
        const double more = removed[other], left = fit.tried.chi2 - more;
        if (more >= worth_naming(static_cast<double>(groups_[other].at.size())) &&
            (!values_fail_ || before_ - left >= kPairShare * excess_))
          pairs.push_back({k, other, left});
      }
    }
    std::ranges::stable_sort(pairs, [](const Pair& a, const Pair& b) { return a.left < b.left; });
    const auto numbers = [this](const Pair& p) {
      return groups_[tried_[p.first].groups[0]].at.size() + groups_[p.second].at.size();
    };
    const Pair* passed =
        nullptr;  // one that a linear step does not tell apart, of fewer numbers, is its rival
    const auto is_rival = [&](const Pair& p) {
      return passed && numbers(p) < numbers(*passed) && p.left <= passed->left + kAlikeShare * excess_;
    };
    std::size_t n_tried = 0;
    for (const Pair& pair : pairs) {
      const auto& [first, second, left] = pair;
      std::vector<std::size_t> both{tried_[first].groups[0], second};
      const auto is_same = [&](const Tried& t) {
        return t.groups.size() == 2 && std::ranges::is_permutation(t.groups, both);
      };
      if (n_tried >= (is_rival(pair) ? 2 * kMostPairs : kMostPairs) || std::ranges::any_of(tried_, is_same))
        continue;
      progress_.reach(kAloneDone + n_tried * (kPairsDone - kAloneDone) / (2 * kMostPairs));
      ++n_tried;
      const CauseFit begin = tried_[first].fit;  // tried_ grows
      try_fit(both, nullptr, &begin);
      TriedCause& tried = tried_.back().fit.tried;
      for (const std::size_t k : {0u, 1u}) {
        const double alone = before_ - rows[both[1 - k]].removed;
        if (alone - tried.chi2 < worth_naming(static_cast<double>(groups_[both[k]].at.size())))
          tried.passes = false;  // one of them is for nothing
      }
      if (tried.passes) passed = &pair;
      if (rows[both[1]].removed > rows[both[0]].removed)
        std::swap(tried_.back().groups[0], tried_.back().groups[1]);
    }
  }

  /// Returns whether nothing is named but what explains all that is common to a pixel's images: light of two
  /// kinds at once, of which a group of few numbers may tell one.
  bool all_is_free(const std::vector<std::size_t>& named) const {
    return std::ranges::all_of(named, [this](std::size_t k) {
      return tried_[k].field && tried_[k].field->free == FreePerPixel::factor_and_offset;
    });
  }

  /// Gives every pixel an offset, a factor or both of its own.
  void try_fields(std::vector<CauseRow>& rows) {
    for (const PixelField& field : kFields) {
      CauseRow row;
      row.group = field.name;
      row.cause = field.cause;
      take(try_fit({}, &field), row);
      rows.push_back(std::move(row));
    }
  }
  /// The same besides groups that then take away most: a factor with a projector's gamma is like a camera's.
  void try_fields_with_groups() {
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
  static const PixelField* field_of(FreePerPixel free) {
    for (const PixelField& field : kFields)
      if (field.free == free) return &field;
    return nullptr;
  }

  std::string name_of(const Tried& tried) const {
    std::string all = tried.field ? tried.field->name : "";
    for (const std::size_t g : tried.groups) all += (all.empty() ? "" : kCausesTogether) + groups_[g].name;
    return all;
  }

  /// Puts the named ones first, the first of them with its order, values and sensors.
  void list_named(const std::vector<std::size_t>& named, Causes& out) const {
    for (const std::size_t k : named) out.together.push_back(name_of(tried_[k]));
    add_texture_beside(out);
    const Tried& first = tried_[named[0]];
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
    sort(out);
    out.rest = 1.0 - before;
    out.chi2_after = first.fit.chi2;
    offer_gain(first, out);
  }
  /// What scales the light over a single camera's image may as well be on the surfaces.
  void add_texture_beside(Causes& out) const {
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

  void offer_gain(const Tried& first, Causes& out) const {
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
      out.with += " " + report::with_sigma(value.estimate, value.sigma) + (value.unit.empty() ? "" : " ") +
                  value.unit;
  }

  /// Lists the groups by what linear steps take away one after the other, where nothing is named.
  void list_in_order(Causes& out) const {
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
  static void sort(Causes& out) {
    std::ranges::stable_sort(out.rows, [](const CauseRow& a, const CauseRow& b) {
      const int x = a.order > 0 ? a.order : 99, y = b.order > 0 ? b.order : 99;
      return x != y ? x < y : a.removed > b.removed;
    });
  }

  /// Takes the group that takes away most, then the one that takes most of what is left ...
  std::vector<std::size_t> choose_order() const {
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

  CauseRow make_row(std::size_t g, const Step& step) const {
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

  Milestones progress_{"causes", kAll};
  Sensitivity& sensitivity_;
  const Twin& twin_;
  const std::vector<FitRow>& fits_;
  std::vector<Parameter> parameters_;
  std::vector<Group> groups_;
  Eigen::VectorXd start_;
  Sensitivity::Columns columns_;  ///< of all parameters at the twin
  Sensitivity::Values base_;      ///< what the twin predicts
  NormalEquations equations_;     ///< there
  std::vector<CauseRegion> regions_before_;
  std::vector<Tried> tried_;
  std::optional<std::size_t> nearest_;  ///< group whose linear step takes away most
  std::optional<CauseFit> begin_;       ///< its fit, with the noise of the twin's levels
  std::uint64_t n_ = 0;                 ///< values
  double own_ = 0.0;                    ///< numbers that pixels have of their own in all fits
  double before_ = 0.0, excess_ = 0.0;  ///< chi2 with gain and black level alone, and beyond noise
  bool values_fail_ = false;
};

}  // namespace

Causes find_causes(Sensitivity& sensitivity, const Twin& twin, const std::vector<FitRow>& fits,
                   const std::vector<int>& steps) {
  return CauseSearch(sensitivity, twin, fits, steps).run();
}

}  // namespace fringetwin::compare
