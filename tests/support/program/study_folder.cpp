// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/study_folder.hpp"

#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing {

namespace fs = std::filesystem;

fs::path study_folder(const std::string& name, const std::string& study) {
  const fs::path dir = scratch_folder(name);
  write_file(dir / "twin.toml", small_twin());
  write_file(dir / "STUDY.toml", study);
  return dir;
}

std::vector<std::string> study_arguments(const fs::path& dir, const std::string& out,
                                         const std::vector<std::string>& more) {
  std::vector<std::string> args{"study", (dir / "STUDY.toml").string(), "--out", (dir / out).string()};
  args.insert(args.end(), more.begin(), more.end());
  return args;
}

RunResult run_study(const fs::path& dir, const std::string& out, const std::vector<std::string>& more) {
  return run_fringetwin(study_arguments(dir, out, more));
}

}  // namespace fringetwin::testing
