// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/cli_runner.hpp"

#include <fmt/format.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "report/text.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing {

namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr)
    throw std::runtime_error(std::string(name) + " is not set; run the tests through ctest");
  return value;
}

const std::filesystem::path& scratch_root() {
  static const ScratchFolder root;
  return root.path();
}

}  // namespace

std::filesystem::path scratch_folder(const std::string& name) {
  const auto folder = scratch_root() / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

RunResult run_fringetwin(const std::vector<std::string>& args, const std::vector<std::string>& environment) {
  static int count = 0;
  const auto base = scratch_root() / ("run-" + std::to_string(++count));
  std::vector<std::string> words{"env"};
  words.insert(words.end(), environment.begin(), environment.end());
  words.insert(words.end(), {"timeout", "600", variable("FRINGETWIN_BINARY")});
  words.insert(words.end(), args.begin(), args.end());
  const std::string command = fmt::format("{} >{} 2>{} </dev/null", report::shell_command(words),
                                          report::shell_command({base.string() + ".out"}),
                                          report::shell_command({base.string() + ".err"}));
  const int status = std::system(command.c_str());
  RunResult result;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = read_file(base.string() + ".out");
  result.err = read_file(base.string() + ".err");
  return result;
}

std::filesystem::path dataset_twin(const std::string& name) {
  return std::filesystem::path(variable("FRINGETWIN_SOURCE")) / "datasets" / name / "twin.toml";
}

nlohmann::json read_json(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot open " + file.string());
  return nlohmann::json::parse(in);
}

void write_file(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

bool have_device() {
  static const bool have = run_fringetwin({"render", "--device", "list"}).exit_code == 0;
  return have;
}

bool have_captures(const std::string& set) { return std::filesystem::is_directory(captures_root() / set); }

}  // namespace fringetwin::testing
