// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "compare/causes/cause_regions.hpp"
#include "compare/causes/gauss_newton.hpp"
#include "compare/verdict/explained.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kWorthAdding = 0.02;  ///< share a further cause must explain to be listed in the order
constexpr std::size_t kMostInOrder = 4;
constexpr double kClear = 0.97;          ///< a linear step that explains so much has no rivals
constexpr double kRivalShare = 0.25;     ///< of the excess that a linear step must take away to be iterated
constexpr double kPairShare = 0.5;       ///< of the excess that the linear step of two groups must take away
constexpr std::size_t kRivals = 3;       ///< candidates that are iterated
constexpr double kClearlyBetter = 25.0;  ///< of chi2, beyond what noise gives the parameters
constexpr int kIterations = 6;

struct Group {
  std::string name;
  std::vector<std::size_t> at;  ///< of its parameters among all
};

/// Groups fitted to convergence, with a gain and black level per camera that go with them.
struct CauseFit {
  std::string groups;  ///< "blur, pose"
  std::vector<CauseParameter> parameters = {};
  std::vector<CauseGain> gain = {};
  double chi2 = kNaN;   ///< per value
  double total = kNaN;  ///< chi2 of all values and the number of what was fitted besides the sensors
  bool settled = false;
  std::vector<CauseRegion> regions = {};

  /// Returns whether single values and regions show no more than noise.
  bool passes(std::uint64_t n) const {
    return chi2 <= 1.0 + allowed_for(static_cast<double>(n)) && regions[0].n > 0 &&
           std::ranges::all_of(regions, &CauseRegion::passes);
  }
};

/// Returns whether a group changes the images as the gain does, here more and there less: then how much of it
/// is gain, nobody can tell.
bool scales_the_gain(const std::string& group) {
  return group == "texture" || group == "albedo" || group == "vignetting";
}

/// Returns by how much more than by its own number of parameters a group must lower chi2 to be named: nearly
/// as many again, or 5 standard deviations of chi2 where they are many.
double worth_naming(double parameters) {
  return kClearlyBetter + std::min(parameters, 5.0 * std::sqrt(2.0 * parameters));
}

double worth_naming(const CauseRow& row) { return worth_naming(static_cast<double>(row.parameters.size())); }

class CauseSearch {
 public:
  CauseSearch(Sensitivity& sensitivity, const Twin& twin) : sensitivity_(sensitivity), twin_(twin) {
    for (const ParameterGroup& group : parameter_groups()) {
      Group g{group.name, {}};
      for (Parameter& p : parameters_of(twin, group.name)) {
        g.at.push_back(parameters_.size());
        parameters_.push_back(std::move(p));
      }
      if (!g.at.empty()) groups_.push_back(std::move(g));
    }
    start_ = start_values(parameters_);
    equations_ = sensitivity.equations(twin, parameters_, start_);
    for (std::size_t c = 0; c < sensitivity.samples().size(); ++c)
      for (const std::size_t at : {equations_.gain_at(c), equations_.black_at(c)}) sensors_.push_back(at);
  }

  Causes run() {
    Causes out;
    before_ = solve({}).chi2;
    out.n = equations_.n;
    const auto n = static_cast<double>(out.n);
    out.chi2 = before_ / n;
    excess_ = before_ - n;
    as_it_is_ = converge({}).regions;
    values_fail_ = !(out.chi2 <= 1.0 + allowed_for(n));
    if (!values_fail_ && std::ranges::all_of(as_it_is_, &CauseRegion::passes)) return out;
    for (std::size_t g = 0; g < groups_.size(); ++g) out.rows.push_back(make_row(g, solve({g})));
    std::vector<std::size_t> named = best_alone(out.rows);
    if (named.empty()) named = best_pair(out.rows);
    if (named.empty() && !sensitivity_.has_free_factors()) named = texture(out.rows);
    if (named.empty())
      list_in_order(out);
    else
      list_named(named, out);
    std::ranges::stable_sort(out.rows, [](const CauseRow& a, const CauseRow& b) {
      const int x = a.order > 0 ? a.order : 99, y = b.order > 0 ? b.order : 99;
      return x != y ? x < y : a.removed > b.removed;
    });
    return out;
  }

 private:
  /// Solves for these groups with gain and black level of every camera.
  Step solve(const std::vector<std::size_t>& groups) const {
    std::vector<std::size_t> unknowns = sensors_;
    for (const std::size_t g : groups)
      unknowns.insert(unknowns.end(), groups_[g].at.begin(), groups_[g].at.end());
    return solve_step(equations_, unknowns);
  }
  /// Returns by how much the fit would lower noise alone.
  double freedom(const Step& step) const {
    return static_cast<double>(step.n_determined) - static_cast<double>(sensors_.size());
  }
  bool is_switch(std::size_t g) const { return parameters_[groups_[g].at[0]].is_switch; }

  /// Returns the share of what fails that is taken away: of the excess of single values, or else of that of
  /// the kinds of regions that fail. NaN where only regions fail and what is left in them is not known.
  double share(double removed, const std::vector<CauseRegion>& after) const {
    if (values_fail_) return std::min(1.0, removed / excess_);
    double excess = 0.0, left = 0.0;
    for (std::size_t k = 0; k < after.size(); ++k)
      if (const CauseRegion& was = as_it_is_[k]; !was.passes()) {
        excess += static_cast<double>(was.n) * (was.chi2 - 1.0);
        left += static_cast<double>(was.n) * (after[k].chi2 - 1.0);
      }
    return excess > 0.0 ? std::min(1.0, 1.0 - left / excess) : kNaN;
  }

  /// Fits the groups that take away most to convergence, and returns the best of those that explain the
  /// difference.
  std::vector<std::size_t> best_alone(std::vector<CauseRow>& rows) {
    std::vector<std::size_t> rivals;
    for (std::size_t g = 0; g < rows.size(); ++g)
      if (rows[g].removed >= worth_naming(rows[g]) &&
          (!values_fail_ || rows[g].removed >= kRivalShare * excess_))
        rivals.push_back(g);
    std::ranges::sort(rivals, [&](auto a, auto b) { return rows[a].removed > rows[b].removed; });
    rivals.resize(std::min(rivals.size(), kRivals));
    std::vector<std::size_t> best;
    for (const std::size_t g : rivals) {
      const bool is_clear = best.empty() && values_fail_ && rows[g].removed >= kClear * excess_;
      take(converge({g}), rows[g]);
      if (!rows[g].passes || rows[g].removed < worth_naming(rows[g])) continue;
      if (is_clear) return {g};
      if (best.empty() || rows[g].removed > rows[best[0]].removed) best = {g};
    }
    return best;
  }

  /// Writes what a fit of its group alone found into the row.
  void take(const CauseFit& fit, CauseRow& row) {
    row.chi2_after = fit.chi2;
    row.passes = fit.passes(equations_.n);
    row.regions_after = fit.regions;
    row.removed = before_ - fit.total;
    row.alone = share(row.removed, fit.regions);
    take_values(fit, row);
    fits_.emplace(row.group, fit);
  }
  static void take_values(const CauseFit& fit, CauseRow& row) {
    for (const CauseParameter& fitted : fit.parameters)
      for (CauseParameter& p : row.parameters)
        if (p.name == fitted.name && fitted.sigma > 0.0) p = fitted;
  }

  /// Returns two groups that explain the difference together and not alone, the one that takes away more
  /// first.
  std::vector<std::size_t> best_pair(std::vector<CauseRow>& rows) {
    for (const std::size_t first : {next_after({}, 0.0), most_removed(rows)}) {
      if (first == groups_.size()) continue;
      std::vector<std::size_t> pair{first, next_after({first}, worth_naming(0.0))};
      if (pair[1] == groups_.size()) continue;
      if (rows[pair[1]].removed > rows[pair[0]].removed) std::swap(pair[0], pair[1]);
      if (fits_.contains(name_of(pair))) continue;
      const Step linear = solve(pair);
      if (values_fail_ && before_ - linear.chi2 - freedom(linear) < kPairShare * excess_) continue;
      const CauseFit& fit = fits_.emplace(name_of(pair), converge(pair)).first->second;
      const double removed = before_ - fit.total,
                   besides = worth_naming(static_cast<double>(groups_[pair[1]].at.size()));
      if (fit.passes(equations_.n) && removed - rows[pair[0]].removed >= besides) return pair;
    }
    return {};
  }
  static std::size_t most_removed(const std::vector<CauseRow>& rows) {
    const auto less = [](const CauseRow& a, const CauseRow& b) { return a.removed < b.removed; };
    return static_cast<std::size_t>(std::ranges::max_element(rows, less) - rows.begin());
  }

  /// Gives every pixel a brightness of its own. It explains whatever is common to all images of a pixel, also
  /// what a group of few numbers would: so it is tried last.
  std::vector<std::size_t> texture(std::vector<CauseRow>& rows) {
    CauseRow row;
    row.group = "texture";
    row.cause = "reflectivity that varies over a surface (texture), one factor per pixel";
    take(converge({}, true), row);
    const CauseFit& fit = fits_.at(row.group);
    const double factors = fit.total - fit.chi2 * static_cast<double>(n_textured_);
    rows.push_back(std::move(row));
    if (!rows.back().passes || rows.back().removed < worth_naming(factors)) return {};
    return {rows.size() - 1};
  }

  /// Puts the named ones first, with the values and the sensors that go with them.
  void list_named(const std::vector<std::size_t>& named, Causes& out) const {
    const bool is_texture = named[0] >= groups_.size();
    const CauseFit& fit = fits_.at(is_texture ? out.rows[named[0]].group : name_of(named));
    double before = 0.0;
    for (std::size_t k = 0; k < named.size(); ++k) {
      CauseRow& row = out.rows[named[k]];
      take_values(fit, row);
      row.order = static_cast<int>(k) + 1;
      const double together = k + 1 < named.size() ? row.alone : share(before_ - fit.total, fit.regions);
      row.in_order = together - before;
      before = together;
    }
    out.rest = 1.0 - before;
    out.named = out.rows[named[0]].group;
    out.chi2_after = fit.chi2;
    for (const std::size_t g : named)
      if (scales_the_gain(out.rows[g].group) || sensitivity_.has_free_factors())
        out.why =
            "what changes the images as the gain does (reflectivity, vignetting) cannot be told from it";
      else if (is_switch(g))
        out.why = "it is either on or off: set it in the twin and compare again";
    if (out.why.empty() && !fit.settled) out.why = "the fit did not come to rest";
    if (!out.why.empty()) return;
    out.gain = fit.gain;
    out.with = fit.groups;
    const CauseParameter& first = fit.parameters[0];
    if (fit.parameters.size() == 1 && first.sigma > 0.0)
      out.with += " " + report::with_sigma(first.estimate, first.sigma) + (first.unit.empty() ? "" : " ") +
                  first.unit;
  }

  /// Lists the groups by what linear steps take away one after the other, where nothing is named.
  void list_in_order(Causes& out) const {
    double before = before_;
    std::vector<std::size_t> taken;
    for (const std::size_t g : choose_order()) {
      taken.push_back(g);
      const Step step = solve(taken);
      out.rows[g].order = static_cast<int>(taken.size());
      out.rows[g].in_order = share(before - step.chi2, {});
      before = step.chi2;
    }
    if (!taken.empty() && values_fail_) out.rest = (before - static_cast<double>(out.n)) / excess_;
  }

  std::string name_of(const std::vector<std::size_t>& groups) const {
    std::string all;
    for (const std::size_t g : groups) all += (all.empty() ? "" : ", ") + groups_[g].name;
    return all;
  }

  /// Fits groups to convergence, each time from the twin's values; a switch is turned. `textured`: with a
  /// brightness of its own for every pixel.
  CauseFit converge(const std::vector<std::size_t>& groups, bool textured = false) {
    CauseFit out{.groups = name_of(groups)};
    Sensitivity sensors = sensitivity_;  // begins with the same gain and black level
    Twin twin = twin_;
    if (textured) sensors.free_factors();
    std::vector<Parameter> own;
    double n_fitted = 0.0;
    for (const std::size_t g : groups)
      for (const std::size_t at : groups_[g].at) {
        n_fitted += 1.0;
        if (!is_switch(g))
          own.push_back(parameters_[at]);
        else
          parameters_[at].change(twin, parameters_[at].start > 0.5 ? -1.0 : 1.0);
      }
    GaussNewton fit(sensors, twin, std::move(own), false);
    GaussNewton::Outcome outcome = GaussNewton::Outcome::moved;
    if (!fit.parameters().empty())
      for (int i = 0; i < kIterations && outcome == GaussNewton::Outcome::moved; ++i)
        outcome = fit.step(true);
    out.settled = fit.parameters().empty() || outcome == GaussNewton::Outcome::settled;
    fit.settle_sensors();
    out.chi2 = fit.chi2();
    const Twin fitted = fit.twin();
    out.regions = cause_regions(sensors, fitted);
    const auto n = static_cast<double>(equations_.n);
    if (textured) {
      n_textured_ = sensors.equations_without_parameters(fitted).n;
      n_fitted = n - static_cast<double>(n_textured_);
    }
    out.total = out.chi2 * (textured ? static_cast<double>(n_textured_) : n) + n_fitted;
    if (!fit.parameters().empty()) tell_values(fit, sensors, out);
    return out;
  }
  void tell_values(const GaussNewton& fit, const Sensitivity& sensors, CauseFit& out) const {
    const NormalEquations& e = fit.equations();
    const Step last = solve_step(e, fit.unknowns());
    const double inflation = std::sqrt(std::max(1.0, out.chi2));
    for (std::size_t k = 0; k < fit.parameters().size(); ++k) {
      const Parameter& p = fit.parameters()[k];
      out.parameters.push_back({p.name, p.unit, p.shown(p.start), p.shown(fit.values()[k]),
                                p.shown_sigma(fit.values()[k], inflation * last.sigma[k])});
    }
    for (std::size_t c = 0; c < sensors.samples().size(); ++c) {
      const GridSamples& s = sensors.samples()[c];
      out.gain.push_back({twin_.cameras[s.camera].name, s.gain_dn, inflation * last.sigma[e.gain_at(c)],
                          s.black_level_dn, inflation * last.sigma[e.black_at(c)]});
    }
  }

  /// Returns the group whose linear step takes away most besides those taken, more than `least` and than its
  /// number of parameters; the number of groups where none does.
  std::size_t next_after(const std::vector<std::size_t>& taken, double least) const {
    std::size_t best = groups_.size();
    double lowest = solve(taken).chi2 - least;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (std::ranges::find(taken, g) != taken.end()) continue;
      std::vector<std::size_t> with = taken;
      with.push_back(g);
      const Step step = solve(with);
      if (const double left = step.chi2 + freedom(step); left < lowest) {
        lowest = left;
        best = g;
      }
    }
    return best;
  }

  /// Takes the group that takes away most, then the one that takes most of what is left ...
  std::vector<std::size_t> choose_order() const {
    std::vector<std::size_t> taken;
    while (taken.size() < kMostInOrder) {
      const std::size_t next = next_after(taken, std::max(kClearlyBetter, kWorthAdding * excess_));
      if (next == groups_.size()) break;
      taken.push_back(next);
    }
    return taken;
  }

  CauseRow make_row(std::size_t g, const Step& step) const {
    CauseRow row;
    row.group = groups_[g].name;
    row.cause = parameter_group(row.group).cause;
    row.removed = before_ - step.chi2 - freedom(step);
    row.alone = share(row.removed, {});
    const double inflation = std::sqrt(std::max(1.0, step.chi2 / static_cast<double>(equations_.n)));
    for (const std::size_t k : groups_[g].at) {
      const Parameter& p = parameters_[k];
      const double value = std::clamp(start_[k] + step.change[k], p.is_switch ? -1e300 : p.smallest,
                                      p.is_switch ? 1e300 : p.largest);
      row.parameters.push_back({p.name, p.unit, p.shown(start_[k]), p.shown(value),
                                p.shown_sigma(value, inflation * step.sigma[k])});
    }
    return row;
  }

  Sensitivity& sensitivity_;
  const Twin& twin_;
  std::vector<Parameter> parameters_;
  std::vector<Group> groups_;
  std::vector<std::size_t> sensors_;
  Eigen::VectorXd start_;
  NormalEquations equations_;
  std::map<std::string, CauseFit> fits_;  ///< by their groups
  std::vector<CauseRegion> as_it_is_;     ///< what the twin leaves in regions
  double before_ = 0.0, excess_ = 0.0;    ///< chi2 with gain and black level alone, and beyond noise
  bool values_fail_ = false;
  std::uint64_t n_textured_ = 0;  ///< values, less one per pixel
};

/// Says what of a fit is not explained: "chi2 1.5, limit 1.15; shift of regions 5.66, limit 1.37".
std::string left_by(const CauseRow& row, double limit) {
  std::string text;
  if (row.chi2_after > limit) text = fmt::format("chi2 {:.3g}, limit {:.3g}", row.chi2_after, limit);
  for (const CauseRegion& r : row.regions_after)
    if (!r.passes())
      text += fmt::format("{}{} of regions {:.3g}, limit {:.3g}", text.empty() ? "" : "; ", r.kind, r.chi2,
                          r.limit);
  if (!row.regions_after.empty() && row.regions_after[0].n == 0)
    text += (text.empty() ? "" : "; ") + std::string("regions with too few pixels to judge it");
  return text.empty() ? "" : ", which leaves " + text;
}

}  // namespace

Causes find_causes(Sensitivity& sensitivity, const Twin& twin) {
  return CauseSearch(sensitivity, twin).run();
}

std::string sentence(const Causes& causes) {
  if (causes.rows.empty()) return "";
  const auto percent = [](double share) {
    return std::isfinite(share) ? fmt::format("{:.3g} % of it", 100.0 * share) : std::string("part of it");
  };
  if (causes.named.empty()) {
    const auto less = [](const CauseRow& a, const CauseRow& b) { return a.removed < b.removed; };
    const CauseRow& nearest = *std::ranges::max_element(causes.rows, less);
    return fmt::format("none of the causes tested explains what the budget does not (nearest: {}, {}{})",
                       nearest.cause, percent(nearest.alone),
                       left_by(nearest, 1.0 + allowed_for(static_cast<double>(causes.n))));
  }
  const CauseRow &first = causes.rows[0],
                 &second = causes.rows[std::min<std::size_t>(1, causes.rows.size() - 1)];
  if (second.order == 2)
    return fmt::format(
        "most likely causes: {} ({}) and {}: together they explain the gray difference beyond the budget. "
        "Fit "
        "them with --refine {},{}",
        first.cause, percent(first.alone), second.cause, first.group, second.group);
  return fmt::format(
      "most likely cause: {}; it explains {} of the gray difference beyond the budget. Fit it with --refine "
      "{}",
      first.cause,
      std::isfinite(first.alone) ? fmt::format("{:.1f} %", 100.0 * first.alone) : "what regions show",
      causes.named);
}

std::string gain_sentence(const Causes& causes) {
  if (!causes.why.empty())
    return fmt::format("no gain or black level is offered with {}: {}", causes.named, causes.why);
  std::string line = causes.gain.empty() ? "" : "with " + causes.with;
  for (const CauseGain& g : causes.gain)
    line += fmt::format("; {}: gain {} DN, black level {} DN", g.camera,
                        report::with_sigma(g.gain_dn, g.gain_sigma_dn),
                        report::with_sigma(g.black_level_dn, g.black_level_sigma_dn));
  return line;
}

}  // namespace fringetwin::compare
