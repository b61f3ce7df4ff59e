// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/capture_killed.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "capture/record/journal.hpp"
#include "capture/record/verify_set.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing {

namespace fs = std::filesystem;

RunResult die_at(int n, const fs::path& folder, const std::vector<std::string>& args) {
  const fs::path tests = fs::path(std::getenv("FRINGETWIN_BINARY")).parent_path() / "tests";
  return run_fringetwin(
      args, {"LD_PRELOAD=" + (tests / "libfaults.so").string(), "FAULT_BELOW=" + folder.string(),
             "FAULT_CALLS=rename,remove,sync", "FAULT_ERROR=kill", "FAULT_AT=" + std::to_string(n)});
}

int kill_between_changes(int every) {
  const fs::path dir = scratch_folder("capture_die");
  write_file(
      dir / "twin.toml",
      small_twin({{"pitches_px = [13, 14, 15]\nsteps = 4", "pitches_px = [15]\nsteps = 3\nunwrap = \"none\""},
                  {"[measure]\ntriangulate = \"projector\"\n[[measure.fit]]\nobject = \"ball\"\n", ""}}));
  const fs::path set = dir / "set";
  const auto args = [&](const std::vector<std::string>& more, const char* how) {
    std::vector<std::string> all = {"-q",
                                    "capture",
                                    (dir / "twin.toml").string(),
                                    "--camera",
                                    "twin:" + (dir / "twin.toml").string(),
                                    "--out",
                                    set.string(),
                                    how};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  int moments = 0;
  for (const auto& [plan, begin] :
       {std::pair<std::vector<std::string>, const char*>{{"--dark", "2", "--repeats", "2"}, "--resume"},
        {{"--exposure-ms", "5,10"}, "--resume"},
        {{}, "--overwrite"}}) {
    for (int n = 1;; n += every) {
      if (std::string(begin) == "--resume") fs::remove_all(set);  // else what the plan before left
      const int exit_code = die_at(n, set, args(plan, begin)).exit_code;
      // The first change is the new journal's name: an older set is as it was.
      if (std::string(begin) == "--overwrite" && n == 1) continue;
      const capture::SetCheck broken_off = capture::verify_set(set);
      EXPECT_EQ(broken_off.passed(),
                fs::exists(set / "capture.toml") && !fs::exists(set / capture::kJournalName))
          << n;
      if (exit_code == 0 || ::testing::Test::HasFailure()) break;
      ++moments;
      const RunResult resumed = run_fringetwin(args(plan, "--resume"));
      EXPECT_EQ(resumed.exit_code, 0) << n << " " << resumed.err;
      const capture::SetCheck check = capture::verify_set(set);
      EXPECT_TRUE(check.passed()) << n << ::testing::PrintToString(check.findings);
      if (std::string(begin) == "--overwrite") write_file(set / "left" / "0017.png", "of an older set");
    }
  }
  std::printf("killed at %d moments\n", moments);
  return moments;
}

}  // namespace fringetwin::testing
