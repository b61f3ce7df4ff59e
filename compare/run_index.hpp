// SPDX-License-Identifier: Apache-2.0
// Writes the page that lists the runs below a folder.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "compare/run_summary.hpp"

namespace fringetwin::compare {

/// Returns the page: a row for each run, with a link to its page relative to where they were looked for.
/// `argv`, `version`: of the command that makes it.
std::string run_index_html(const std::filesystem::path& dir, const std::vector<RunSummary>& runs,
                           const std::vector<std::string>& argv, const std::string& version);

/// Returns whether a file is such a page, so that it may be written anew.
bool is_run_index(const std::filesystem::path& file);

}  // namespace fringetwin::compare
