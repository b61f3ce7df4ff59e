// SPDX-License-Identifier: Apache-2.0
// Finds the runs below a folder, and sums up each from what it left: its result.json, and the head of its
// page.
#pragma once
#include <chrono>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace fringetwin::compare {

/// One run; texts are as they stand in its files, and may be anything.
struct RunSummary {
  std::filesystem::path folder;  ///< relative to where it was looked for; "." for that folder itself
  std::string page;              ///< name of its page, which this program wrote; empty: it has none
  std::chrono::system_clock::time_point written;
  std::string twin, command, verdict, answer;
  double held_out_ratio = std::numeric_limits<double>::quiet_NaN();  ///< of the worst camera
  double phase_rms_rad = std::numeric_limits<double>::quiet_NaN();   ///< of the worst camera and direction
  std::vector<std::pair<double, double>> gains_dn;                   ///< of each camera, with its sigma
  std::string fault;  ///< why result.json does not count; empty where all is well
};

/// Returns the runs in all folders at and below `dir` that hold a result.json, a study or a page of this
/// program, by their paths; a folder that several commands wrote their pages into has one for each. Links to
/// folders and hidden folders are not followed. A result.json that cannot be read is no failure: the run says
/// so. Throws Cancelled.
std::vector<RunSummary> runs_below(const std::filesystem::path& dir);

}  // namespace fringetwin::compare
