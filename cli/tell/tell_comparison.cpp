// SPDX-License-Identifier: Apache-2.0
#include "cli/tell/tell_comparison.hpp"

#include <fmt/format.h>

#include "compare/page/answer.hpp"
#include "compare/verdict/overall.hpp"
#include "cosim/summary.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cli {

int convergence_exit_code(const measure::Measurement& measurement, int otherwise) {
  const std::string fault = cosim::convergence_fault(measurement);
  if (fault.empty()) return otherwise;
  warn(fault);
  return static_cast<int>(ExitCode::no_convergence);
}

int tell_comparison(const std::filesystem::path& dir, const cosim::Run& run,
                    const compare::Comparison& comparison, const std::vector<std::string>& argv) {
  for (const std::string& warning : comparison.warnings) warn(warning);
  for (const std::string& line : cosim::summary_lines(comparison)) say(line);
  if (const std::string answer = compare::answer_sentence(comparison); !answer.empty()) say(answer + ".");
  say(fmt::format("verdict: {}; report: {}", compare::overall_verdict(comparison).text,
                  (dir / "report.html").string()));
  const compare::NextStep next = compare::next_step(comparison, run.twin, argv);
  if (!next.text.empty())
    say("next: " + next.text + (next.argv.empty() ? "" : ": " + report::shell_command(next.argv)));
  const int verdict = static_cast<int>(comparison.pass ? ExitCode::ok : ExitCode::limits_not_met);
  for (const compare::Side* side : {&run.real, &run.simulated}) {
    if (!side->measurement) continue;
    const int code = convergence_exit_code(*side->measurement, verdict);
    if (code != verdict) return code;
  }
  if (comparison.refinement && !comparison.refinement->converged)
    return static_cast<int>(ExitCode::no_convergence);
  return verdict;
}

}  // namespace fringetwin::cli
