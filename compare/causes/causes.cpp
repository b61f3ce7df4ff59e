// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "compare/causes/gauss_newton.hpp"
#include "compare/verdict/explained.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kWorthNaming = 0.5;   ///< share of the excess a cause must explain to be named
constexpr double kWorthAdding = 0.02;  ///< share a further cause must explain besides
constexpr std::size_t kMostInOrder = 4;
constexpr double kClear = 0.97;       ///< a linear step that explains so much needs no iteration
constexpr std::size_t kRivals = 3;    ///< candidates that are iterated
constexpr double kRivalShare = 0.25;  ///< of the excess that a candidate's linear step must take away
constexpr int kIterations = 6;

struct Group {
  std::string name;
  std::vector<std::size_t> at;  ///< of its parameters among all
};

/// Groups fitted to convergence, with a gain and black level per camera that go with them.
struct CauseFit {
  Sensitivity sensors;
  Twin twin;
  std::string groups;  ///< "blur, pose"
  std::vector<CauseParameter> parameters;
  std::vector<CauseGain> gain;
  double chi2 = kNaN;
  bool settled = false;
};

/// Returns whether a group changes the images as the gain does, here more and there less: then how much of it
/// is gain, nobody can tell.
bool scales_the_gain(const std::string& group) {
  return group == "texture" || group == "albedo" || group == "vignetting";
}

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
    equations_ =
        sensitivity.equations(twin, parameters_, start_, false, Sensitivity::Derivative::quick, &textured_);
    for (std::size_t c = 0; c < sensitivity.samples().size(); ++c)
      for (const std::size_t at : {equations_.gain_at(c), equations_.black_at(c)}) sensors_.push_back(at);
  }

  Causes run() {
    Causes out;
    const double sensors_alone = solve({}).chi2;
    out.n = equations_.n;
    out.chi2 = sensors_alone / static_cast<double>(out.n);
    excess_ = sensors_alone - static_cast<double>(out.n);
    if (!(excess_ > 0.0)) return out;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const Step alone = solve({g});
      CauseRow row = make_row(g, alone);
      row.alone = (sensors_alone - alone.chi2 - freedom(alone)) / excess_;
      out.rows.push_back(std::move(row));
    }
    if (const auto best = iterate_rivals(sensors_alone, out.rows)) {
      // what is left was measured, not extrapolated: no linear step follows
      out.rows[*best].order = 1;
      out.rows[*best].in_order = out.rows[*best].alone;
      out.rest = 1.0 - out.rows[*best].alone;
      return finish(std::move(out), {*best});
    }
    if (!sensitivity_.has_free_factors()) add_texture(sensors_alone, out);
    double before = solve({}).chi2;
    const std::vector<std::size_t> order = choose_order(before);
    const int taken_before = out.textured ? 1 : 0;
    std::vector<std::size_t> taken;
    for (const std::size_t g : order) {
      taken.push_back(g);
      const Step step = solve(taken);
      out.rows[g].order = taken_before + static_cast<int>(taken.size());
      out.rows[g].in_order = (before - step.chi2) / excess_;
      before = step.chi2;
    }
    if (!taken.empty() || out.textured) {
      const Step all = solve(taken);
      for (const std::size_t g : taken) out.rows[g].parameters = make_row(g, all).parameters;
      out.rest = (all.chi2 - static_cast<double>(system().n)) / excess_;
    }
    return finish(std::move(out), taken);
  }

 private:
  /// Returns the equations that the groups are solved in.
  const NormalEquations& system() const { return after_texture_ ? textured_ : equations_; }

  /// Solves for these groups with gain and black level of every camera.
  Step solve(const std::vector<std::size_t>& groups) const {
    std::vector<std::size_t> unknowns = sensors_;
    for (const std::size_t g : groups)
      unknowns.insert(unknowns.end(), groups_[g].at.begin(), groups_[g].at.end());
    return solve_step(system(), unknowns);
  }
  /// A brightness of its own for every pixel explains whatever is common to all images of a pixel, also what
  /// a group of few numbers would: so it is named only where none of those explains half. The others are then
  /// judged on what it leaves.
  void add_texture(double sensors_alone, Causes& out) {
    CauseRow row;
    row.group = "texture";
    row.cause = "reflectivity that varies over a surface (texture), one factor per pixel";
    const double removed = static_cast<double>(equations_.n - textured_.n);
    after_texture_ = true;
    row.alone = (sensors_alone - solve({}).chi2 - removed) / excess_;
    double best = 0.0;
    for (const CauseRow& other : out.rows) best = std::max(best, other.alone);
    after_texture_ = best < kWorthNaming && row.alone >= kWorthAdding;
    out.textured = after_texture_;
    if (out.textured) {
      row.order = 1;
      row.in_order = row.alone;
    }
    out.rows.push_back(std::move(row));
  }

  /// Returns by how much the fit would lower noise alone.
  double freedom(const Step& step) const {
    return static_cast<double>(step.n_determined) - static_cast<double>(sensors_.size());
  }

  Causes finish(Causes out, const std::vector<std::size_t>& taken) const {
    std::ranges::stable_sort(out.rows, [](const CauseRow& a, const CauseRow& b) {
      const int x = a.order > 0 ? a.order : 99, y = b.order > 0 ? b.order : 99;
      return x != y ? x < y : a.alone > b.alone;
    });
    if (!out.rows.empty() && out.rows[0].order == 1 && out.rows[0].alone >= kWorthNaming)
      out.named = out.rows[0].group;
    if (!out.named.empty()) offer_gain(taken, out);
    return out;
  }

  /// Offers the gain and black level that go with the named cause, or else with all that were taken, where
  /// these explain the gray values; one linear step is not enough for that.
  void offer_gain(std::vector<std::size_t> taken, Causes& out) const {
    if (scales_the_gain(out.named) || sensitivity_.has_free_factors()) {
      out.why = "what changes the images as the gain does (reflectivity, vignetting) cannot be told from it";
      return;
    }
    const auto is_switch = [this](std::size_t g) { return parameters_[groups_[g].at[0]].is_switch; };
    if (is_switch(taken[0])) {
      out.why = "it is either on or off: set it in the twin and compare again";
      return;
    }
    std::erase_if(taken, [&](std::size_t g) { return scales_the_gain(groups_[g].name) || is_switch(g); });
    const auto known = fits_.find(taken[0]);
    if (offer(known != fits_.end() ? known->second : converge({taken[0]}), out) || taken.size() == 1) return;
    offer(converge(taken), out);
  }

  /// Returns whether the fit explains single values and regions, and offers what it says if so.
  static bool offer(const CauseFit& fit, Causes& out) {
    const Sensitivity::Regions regions = fit.sensors.regions(fit.twin);
    const double limit = 1.0 + allowed_for(static_cast<double>(out.n)),
                 regional_limit = 1.0 + allowed_for(static_cast<double>(regions.n));
    out.chi2_after = fit.chi2;
    out.why = "";
    if (regions.n == 0)
      out.why = "no region has enough pixels to judge what is left";
    else if (!(fit.chi2 <= limit && regions.chi2 <= regional_limit))
      out.why = fmt::format(
          "what is left is not explained (chi2 {:.3g}, limit {:.3g}; of regions {:.3g}, limit {:.3g})",
          fit.chi2, limit, regions.chi2, regional_limit);
    else if (!fit.settled)
      out.why = "the fit did not come to rest";
    if (!out.why.empty()) return false;
    out.gain = fit.gain;
    for (const CauseParameter& fitted : fit.parameters)
      for (CauseRow& row : out.rows)
        for (CauseParameter& p : row.parameters)
          if (p.name == fitted.name && fitted.sigma > 0.0) p = fitted;  // the gain goes with this value
    const CauseParameter& first = fit.parameters[0];
    out.with = fit.groups;
    if (fit.parameters.size() == 1 && first.sigma > 0.0)
      out.with += " " + report::with_sigma(first.estimate, first.sigma) + (first.unit.empty() ? "" : " ") +
                  first.unit;
    return true;
  }

  /// Fits groups to convergence, each time from the twin's values.
  CauseFit converge(const std::vector<std::size_t>& groups) const {
    CauseFit out{sensitivity_, twin_, "", {}, {}};  // begins with the same gain and black level
    std::vector<Parameter> own;
    for (const std::size_t g : groups) {
      out.groups += (out.groups.empty() ? "" : ", ") + groups_[g].name;
      for (const std::size_t at : groups_[g].at) own.push_back(parameters_[at]);
    }
    GaussNewton fit(out.sensors, twin_, std::move(own), false);
    GaussNewton::Outcome outcome = GaussNewton::Outcome::moved;
    for (int i = 0; i < kIterations && outcome == GaussNewton::Outcome::moved; ++i) outcome = fit.step(true);
    out.settled = outcome == GaussNewton::Outcome::settled;
    out.twin = fit.twin();
    out.chi2 = fit.chi2();
    const NormalEquations& e = fit.equations();
    const Step last = solve_step(e, fit.unknowns());
    const double inflation = std::sqrt(std::max(1.0, out.chi2));
    for (std::size_t k = 0; k < fit.parameters().size(); ++k) {
      const Parameter& p = fit.parameters()[k];
      out.parameters.push_back({p.name, p.unit, p.shown(p.start), p.shown(fit.values()[k]),
                                p.shown_sigma(fit.values()[k], inflation * last.sigma[k])});
    }
    for (std::size_t c = 0; c < out.sensors.samples().size(); ++c) {
      const GridSamples& s = out.sensors.samples()[c];
      out.gain.push_back({twin_.cameras[s.camera].name, s.gain_dn, inflation * last.sigma[e.gain_at(c)],
                          s.black_level_dn, inflation * last.sigma[e.black_at(c)]});
    }
    return out;
  }

  /// Helps where errors are too large for one linear step: the best candidates are fitted to convergence, and
  /// the best of them is returned if it then explains half or more. Nothing where one step is clear or
  /// explains little.
  std::optional<std::size_t> iterate_rivals(double sensors_alone, std::vector<CauseRow>& rows) {
    std::vector<std::size_t> rivals;
    for (std::size_t g = 0; g < rows.size(); ++g)
      if (rows[g].alone >= kRivalShare && !parameters_[groups_[g].at[0]].is_switch) rivals.push_back(g);
    std::ranges::sort(rivals, [&](auto a, auto b) { return rows[a].alone > rows[b].alone; });
    const auto less = [](const CauseRow& a, const CauseRow& b) { return a.alone < b.alone; };
    if (rivals.empty() || std::ranges::max_element(rows, less)->alone >= kClear) return std::nullopt;
    rivals.resize(std::min(rivals.size(), kRivals));
    for (const std::size_t g : rivals) {
      const CauseFit& fit = fits_.emplace(g, converge({g})).first->second;
      const double share = (sensors_alone - fit.chi2 * static_cast<double>(equations_.n) -
                            static_cast<double>(fit.parameters.size())) /
                           excess_;
      if (share <= rows[g].alone) continue;
      rows[g].alone = share;
      rows[g].parameters = fit.parameters;
    }
    const auto best =
        *std::ranges::max_element(rivals, [&](auto a, auto b) { return rows[a].alone < rows[b].alone; });
    for (std::size_t g = 0; g < rows.size(); ++g)
      if (g != best && rows[g].alone > rows[best].alone) return std::nullopt;  // a switch explains more
    if (rows[best].alone < kWorthNaming) return std::nullopt;
    return best;
  }

  /// Takes the group that takes away most, then the one that takes most of what is left ...
  std::vector<std::size_t> choose_order(double before) const {
    std::vector<std::size_t> taken;
    while (taken.size() < std::min(kMostInOrder, groups_.size())) {
      std::size_t best = groups_.size();
      double least = before - kWorthAdding * excess_;
      for (std::size_t g = 0; g < groups_.size(); ++g) {
        if (std::ranges::find(taken, g) != taken.end()) continue;
        std::vector<std::size_t> with = taken;
        with.push_back(g);
        const Step step = solve(with);
        if (const double left = step.chi2 + freedom(step); left < least) {
          least = left;
          best = g;
        }
      }
      if (best == groups_.size()) break;
      taken.push_back(best);
      before = solve(taken).chi2;
    }
    return taken;
  }

  CauseRow make_row(std::size_t g, const Step& step) const {
    CauseRow row;
    row.group = groups_[g].name;
    row.cause = parameter_group(row.group).cause;
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
  NormalEquations equations_, textured_;
  std::map<std::size_t, CauseFit> fits_;  ///< of the rivals, by group
  bool after_texture_ = false;
  double excess_ = 0.0;
};

}  // namespace

Causes find_causes(Sensitivity& sensitivity, const Twin& twin) {
  return CauseSearch(sensitivity, twin).run();
}

std::string sentence(const Causes& causes) {
  if (causes.rows.empty()) return "";
  if (causes.named.empty())
    return fmt::format(
        "none of the causes tested explains half of what the budget does not (most: {}, {:.0f} %)",
        causes.rows[0].cause, 100.0 * causes.rows[0].alone);
  return fmt::format(
      "most likely cause: {}; it explains {:.1f} % of the gray difference beyond the budget. Fit it with "
      "--refine {}",
      causes.rows[0].cause, 100.0 * std::min(causes.rows[0].alone, 1.0), causes.named);
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
