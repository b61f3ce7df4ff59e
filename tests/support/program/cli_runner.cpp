// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/cli_runner.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "twin/twin.hpp"

namespace fringetwin::test {

namespace {

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr)
    throw std::runtime_error(std::string(name) + " is not set; run the tests through ctest");
  return value;
}

class ScratchRoot {
 public:
  ScratchRoot() {
    std::string pattern = (std::filesystem::temp_directory_path() / "fringetwin-e2e-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no scratch folder");
    root_ = pattern;
  }
  ~ScratchRoot() {
    std::error_code ignored;
    std::filesystem::remove_all(root_, ignored);
  }
  ScratchRoot(const ScratchRoot&) = delete;
  ScratchRoot& operator=(const ScratchRoot&) = delete;
  const std::filesystem::path& root() const { return root_; }

 private:
  std::filesystem::path root_;
};

const std::filesystem::path& scratch_root() {
  static const ScratchRoot root;
  return root.root();
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
  std::string command = "env";
  for (const auto& entry : environment) command += " " + quoted(entry);
  command += " timeout 600 " + quoted(variable("FRINGETWIN_BINARY"));
  for (const auto& arg : args) command += " " + quoted(arg);
  command += " >" + quoted(base.string() + ".out") + " 2>" + quoted(base.string() + ".err") + " </dev/null";
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

std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

bool have_device() {
  static const bool have = run_fringetwin({"render", "--device", "list"}).exit_code == 0;
  return have;
}

bool have_captures(const std::string& set) { return std::filesystem::is_directory(captures_root() / set); }

}  // namespace fringetwin::test
