// SPDX-License-Identifier: Apache-2.0
// Knows the names of the pages that the commands write: of a run's folder it finds the page.
#pragma once
#include <array>
#include <filesystem>

namespace fringetwin::compare {

/// What `cosim`, `compare`, `measure` and a finished `study` write.
inline constexpr const char* kRunPage = "report.html";
/// What `study --so-far` writes of one that is not finished.
inline constexpr const char* kUnfinishedStudyPage = "unfinished.html";

/// The page of a command that writes no report.html.
struct OwnPage {
  const char* name;
  const char* command;
};
inline constexpr std::array<OwnPage, 4> kOwnPages = {{{"needs.html", "needs"},
                                                      {"pareto.html", "pareto"},
                                                      {"photometry.html", "photometry"},
                                                      {"calibration.html", "calibrate"}}};

/// Returns the page that lies in a folder; of several the report, then the index of the runs below it. An
/// empty path where there is none.
std::filesystem::path page_in(const std::filesystem::path& folder);

/// Returns whether the folder is that of a study, whose result.json is of a kind of its own.
bool is_study_folder(const std::filesystem::path& folder);

}  // namespace fringetwin::compare
