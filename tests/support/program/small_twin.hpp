// SPDX-License-Identifier: Apache-2.0
// A small rig that renders in a moment, and what a refusal looks like.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "tests/support/program/cli_runner.hpp"

namespace fringetwin::testing {

/// A rig (160 x 120 px, one camera, one projector) that sees a sphere; `extra` goes at the end, `replace`
/// swaps text.
std::string small_twin(const std::vector<std::pair<std::string, std::string>>& replace = {},
                       const std::string& extra = "");

/// Writes DIR/twin.toml and renders it into DIR/out.
RunResult render_twin(const std::string& toml, const std::filesystem::path& dir);

/// The exit code, "fringetwin: error: " on stderr, and each part of the sentence.
void expect_refused(const RunResult& run, int exit_code, const std::vector<std::string>& parts);

}  // namespace fringetwin::testing
