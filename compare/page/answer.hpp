// SPDX-License-Identifier: Apache-2.0
// Answers in one sentence whether twin and rig agree, and says what to do next with the command to type
// (docs/READING_THE_REPORT.md).
#pragma once
#include <string>
#include <vector>

#include "compare/result/rows.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Returns "Twin and rig agree in phase and geometry; gray differs by 4.7 DN rms, 2.3 times what noise and
/// budget allow; most likely cause: the projector's response"; empty where nothing was judged.
std::string answer_sentence(const Comparison& comparison);

struct NextStep {
  std::string text;               ///< a sentence without its full stop; empty: nothing to say
  std::vector<std::string> argv;  ///< the command; may be empty
};

/// Returns what helps most, by the worst state of any quantity. `argv`: the command of this run; a cosim is
/// repeated with its options, into a folder of its own.
NextStep next_step(const Comparison& comparison, const Twin& twin, const std::vector<std::string>& argv);

}  // namespace fringetwin::compare
