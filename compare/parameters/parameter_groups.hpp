// SPDX-License-Identifier: Apache-2.0
// The groups of parameters that a twin can be wrong about, with what a report and `--refine` say of them.
#pragma once
#include <string>
#include <vector>

namespace fringetwin::compare {

/// Parameters that are fitted together and named together.
struct ParameterGroup {
  std::string name;     ///< what `--refine` calls it
  std::string meaning;  ///< of its parameters
  std::string cause;    ///< how a report names it when the twin is wrong about it
  /// What to do about it where `--refine` does not fit it, because no key of twin.toml holds it.
  std::string instead = {};
  std::string besides = {};  ///< what else helps than `--refine`
  bool is_searched = true;   ///< as a cause; else only `--refine` fits it
  std::string absent = {};   ///< what to do where a twin has none of its parameters
};
/// Returns the groups in which the causes are looked for. Gain and black level of each camera come besides.
const std::vector<ParameterGroup>& parameter_groups();
const ParameterGroup& parameter_group(const std::string& name);

}  // namespace fringetwin::compare
