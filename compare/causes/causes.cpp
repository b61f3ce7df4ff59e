// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/causes/gauss_newton.hpp"

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
      return finish(std::move(out));
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
    return finish(std::move(out));
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

  static Causes finish(Causes out) {
    std::stable_sort(out.rows.begin(), out.rows.end(), [](const CauseRow& a, const CauseRow& b) {
      const int x = a.order > 0 ? a.order : 99, y = b.order > 0 ? b.order : 99;
      return x != y ? x < y : a.alone > b.alone;
    });
    if (!out.rows.empty() && out.rows[0].order == 1 && out.rows[0].alone >= kWorthNaming)
      out.named = out.rows[0].group;
    return out;
  }

  /// Helps where errors are too large for one linear step: the best candidates are fitted to convergence, and
  /// the best of them is returned if it then explains half or more. Nothing where one step is clear or
  /// explains little.
  std::optional<std::size_t> iterate_rivals(double sensors_alone, std::vector<CauseRow>& rows) {
    std::vector<std::size_t> rivals;
    for (std::size_t g = 0; g < rows.size(); ++g)
      if (rows[g].alone >= kRivalShare && !parameters_[groups_[g].at[0]].is_switch) rivals.push_back(g);
    std::sort(rivals.begin(), rivals.end(), [&](auto a, auto b) { return rows[a].alone > rows[b].alone; });
    const auto less = [](const CauseRow& a, const CauseRow& b) { return a.alone < b.alone; };
    if (rivals.empty() || std::max_element(rows.begin(), rows.end(), less)->alone >= kClear)
      return std::nullopt;
    rivals.resize(std::min(rivals.size(), kRivals));
    for (const std::size_t g : rivals) {
      std::vector<Parameter> own;
      for (const std::size_t at : groups_[g].at) own.push_back(parameters_[at]);
      Sensitivity own_sensors = sensitivity_;  // each begins with the same gain and black level
      GaussNewton fit(own_sensors, twin_, std::move(own), false);
      for (int i = 0; i < kIterations && fit.step(true) == GaussNewton::Outcome::moved; ++i) {
      }
      const double share = (sensors_alone - fit.chi2() * static_cast<double>(equations_.n) -
                            static_cast<double>(fit.parameters().size())) /
                           excess_;
      if (share <= rows[g].alone) continue;
      rows[g].alone = share;
      const Step last = solve_step(fit.equations(), fit.unknowns());
      const double inflation = std::sqrt(std::max(1.0, fit.chi2()));
      for (std::size_t k = 0; k < fit.parameters().size(); ++k) {
        const Parameter& p = fit.parameters()[k];
        rows[g].parameters[k].estimate = p.shown(fit.values()[k]);
        rows[g].parameters[k].sigma = p.shown_sigma(fit.values()[k], inflation * last.sigma[k]);
      }
    }
    const auto best = *std::max_element(rivals.begin(), rivals.end(),
                                        [&](auto a, auto b) { return rows[a].alone < rows[b].alone; });
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
        if (std::find(taken.begin(), taken.end(), g) != taken.end()) continue;
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

}  // namespace fringetwin::compare
