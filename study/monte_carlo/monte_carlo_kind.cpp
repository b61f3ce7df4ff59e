// SPDX-License-Identifier: Apache-2.0
// Runs a study of kind "monte-carlo": trials with inputs drawn from their distributions, until the numbers'
// uncertainties are known well enough.
#include <fmt/format.h>

#include <algorithm>

#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/uncertain/uncertain_file.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

/// Returns "radius 19.0031, sigma 0.0054, 95 %: 18.9919 ... 19.0131; total effects: depth 0.82, noise 0.20"
std::string number_line(const std::string& name, const MonteCarloNumber& n, const MonteCarloResult& result,
                        double coverage) {
  const SampleSummary& s = n.summary;
  std::string out = fmt::format("{} {:.8g}, sigma {:.3g}, {:g} %: {:.8g} ... {:.8g}", name, s.mean, s.sigma,
                                100.0 * coverage, s.symmetric.low, s.symmetric.high);
  for (std::size_t f = 0; f < n.sensitivity.total.size(); ++f)
    out += fmt::format("{} {} {:.2f}", f == 0 ? "; total effects:" : ",", result.factors[f],
                       n.sensitivity.total[f].value);
  return out + (n.convergence.reached ? "\n" : " (not converged)\n");
}

/// Returns a number to two digits, as it is told: 1900 of 1873.
std::size_t rounded_up(std::size_t n) {
  std::size_t unit = 1;
  while (n / unit >= 100) unit *= 10;
  return (n + unit - 1) / unit * unit;
}

/// Says what comes next: those trials of a block that are not kept from before or, after the last block, the
/// points of the Sobol indices. `needed`: trials in all, as far as that can be told.
std::string trials_text(const std::vector<StudyPoint>& batch, const MonteCarloPlan& plan,
                        std::optional<std::size_t> needed) {
  const std::int64_t first = batch.front().id, last = batch.back().id;
  if (first >= kFirstRowId) return points_text(batch.size()) + " for the shares of the inputs";
  return fmt::format("trials {} ... {} of at most {}{}", first + 1, last + 1, plan.most_trials,
                     needed ? fmt::format("; about {} will be needed", rounded_up(*needed)) : "");
}

/// Returns how far the trials are before these; the points of the Sobol indices are counted by themselves.
Outlook outlook_of(const std::vector<StudyPoint>& batch, const MonteCarloPlan& plan,
                   std::optional<std::size_t> needed) {
  if (batch.front().id >= kFirstRowId) return {};
  return {static_cast<std::size_t>(batch.front().id),
          std::min(needed.value_or(plan.most_trials), plan.most_trials)};
}

/// Warns where the rule could not be met however well the numbers are known: it asks for more blocks than
/// there will be.
void warn_of_too_few_trials(const MonteCarloPlan& plan) {
  const std::size_t block = plan.rule.trials_per_block(), blocks = plan.rule.least_blocks,
                    most_block = plan.most_trials / blocks;
  if (block <= most_block) return;
  warn(fmt::format(
      "this study cannot converge: that takes {} blocks (least_blocks) of {} trials (block_trials), and "
      "most_trials is {}; give most_trials = {} or more{}",
      blocks, block, plan.most_trials, blocks * block,
      most_block < 2 ? "" : fmt::format(", or block_trials = {} or less", most_block)));
}

class MonteCarloKind final : public Kind {
 public:
  MonteCarloKind(const StudyHead& head, const MonteCarloPlan& plan) : head_(head), plan_(plan) {}

  /// Returns the twin itself, and the first trial without its calibration.
  PointSequence plan() override {
    const UncertainInputs& inputs = plan_.inputs;
    const StudyPoint first = point_of(inputs, 0, draw_inputs(inputs, plan_.seed, DrawStream::trials, 0));
    plan_.inputs = complete_inputs(plan_, head_.twin);
    return {StudyPoint{}, first};
  }
  PointTask task() const override { return {head_.twin, head_.records, true, plan_.inputs.calibration > 0}; }

  void check(const StudyStore& store) const override {
    if (!store.rows(static_cast<std::int64_t>(plan_.most_trials), kFirstRowId - 1).empty())
      throw UserError(
          ExitCode::usage, head_.file.string(),
          fmt::format("most_trials is {}, and the study has more trials already", plan_.most_trials),
          "give at least as many as before, or another --out");
  }

  void run(KeptPoints& kept) override {
    say(fmt::format("study \"{}\": blocks of {} trials, at most {}", head_.name,
                    plan_.rule.trials_per_block(), plan_.most_trials));
    warn_of_too_few_trials(plan_);
    std::optional<std::size_t> needed;
    bool is_warned = false;
    result_ = run_monte_carlo(
        plan_,
        [&](const std::vector<StudyPoint>& batch) {
          return kept.run(
              batch, outlook_of(batch, plan_, needed),
              [&](const std::vector<StudyPoint>& missing) { say(trials_text(missing, plan_, needed)); });
        },
        [&](const MonteCarloResult& so_far) {
          needed = so_far.converged ? std::nullopt : trials_foreseen(so_far);
          if (is_warned || needed.value_or(0) <= plan_.most_trials) return;
          is_warned = true;
          warn(fmt::format(
              "about {} trials will be needed, and most_trials is {}: raise it (the study goes on "
              "with the trials that it has), or ask for fewer digits",
              rounded_up(*needed), plan_.most_trials));
        });
  }

  std::string tell_stopped(const std::vector<StoredPoint>& rows) const override {
    const MonteCarloResult so_far = monte_carlo_so_far(plan_, rows);
    const std::optional<std::size_t> needed = trials_foreseen(so_far);
    std::string out = fmt::format(
        "study \"{}\" so far: {} of at most {} trials, {} failed{}\n", head_.name, so_far.trials,
        plan_.most_trials, so_far.failed,
        !needed || so_far.converged ? "" : fmt::format("; about {} will be needed", rounded_up(*needed)));
    for (const auto& [name, number] : so_far.numbers)
      out += number_line(name, number, so_far, plan_.rule.coverage);
    return out;
  }

  bool has_page_so_far() const override { return true; }
  std::optional<StudyReport> report_so_far(const StudyRecord& study) const override {
    const MonteCarloResult so_far = monte_carlo_so_far(plan_, study.rows);
    if (so_far.numbers.empty()) return std::nullopt;
    MonteCarloPlan trials_alone = plan_;
    trials_alone.sensitivity_rows = 0;  // they come last
    return monte_carlo_report(study, trials_alone, so_far);
  }

  std::string write() const override { return monte_carlo_json(plan_, result_); }
  StudyReport report(const StudyRecord& study) const override {
    return monte_carlo_report(study, plan_, result_);
  }

  std::string tell(const StudyRecord&, const EngineSummary& summary) const override {
    std::string out = fmt::format("study \"{}\": {} trials, {} failed, {} in this run\n", head_.name,
                                  result_.trials, result_.failed, points_text(summary.finished));
    for (const auto& [name, number] : result_.numbers)
      out += number_line(name, number, result_, plan_.rule.coverage);
    return out;
  }
  ExitCode verdict() const override {
    if (result_.converged) return ExitCode::ok;
    warn(
        fmt::format("not converged after {} trials: raise most_trials and run it again (it goes on from "
                    "there), or ask for fewer digits",
                    result_.trials));
    return ExitCode::no_convergence;
  }

 private:
  const StudyHead& head_;
  MonteCarloPlan plan_;
  MonteCarloResult result_;
};

}  // namespace

std::unique_ptr<Kind> make_kind(const StudyHead& head, const MonteCarloPlan& plan) {
  return std::make_unique<MonteCarloKind>(head, plan);
}

}  // namespace fringetwin::study
