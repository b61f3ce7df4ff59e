// SPDX-License-Identifier: Apache-2.0
#include "cosim/compared_steps.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "twin/base/errors.hpp"

namespace fringetwin::cosim {

std::vector<int> compared_steps(const Twin& twin, const std::string& which, const std::vector<int>& allowed) {
  if (which != "even" && which != "odd")
    throw UserError(ExitCode::usage, "--steps " + which, "is not known", "use even or odd");
  std::vector<int> steps;
  for (int n = which == "odd" ? 1 : 0; n < twin.fringes.steps; n += 2)
    if (allowed.empty() || std::ranges::find(allowed, n) != allowed.end()) steps.push_back(n);
  if (steps.size() < 3)
    throw UserError(ExitCode::usage, "--steps " + which,
                    fmt::format("leaves {} phase steps to compare, and a phase needs 3", steps.size()),
                    allowed.empty() ? "compare all of them"
                                    : "a measured object is built from the others: give it steps = \"all\"");
  return steps;
}

}  // namespace fringetwin::cosim
