// SPDX-License-Identifier: Apache-2.0
// Runs the built program as a user would and reads what it wrote.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tests/support/twin/child_process.hpp"

namespace fringetwin::testing {

struct RunResult {
  int exit_code = -1;
  std::string out, err;
};

/// `fringetwin ARGS...`; `environment` entries are "NAME=value" and override. 10 minutes at most.
RunResult run_fringetwin(const std::vector<std::string>& args,
                         const std::vector<std::string>& environment = {});

/// A fresh empty folder, removed at exit.
std::filesystem::path scratch_folder(const std::string& name);

/// <source>/datasets/NAME/twin.toml
std::filesystem::path dataset_twin(const std::string& name);

nlohmann::json read_json(const std::filesystem::path& file);
void write_file(const std::filesystem::path& file, const std::string& text);

/// True when a Vulkan device is there; without one the test FAILS in CI and skips elsewhere.
bool have_device();
/// True when the real captures are there.
bool have_captures(const std::string& set);

}  // namespace fringetwin::testing

#define FT_NEED_DEVICE()                                                                \
  if (!::fringetwin::testing::have_device()) {                                          \
    ASSERT_EQ(std::getenv("CI"), nullptr) << "no Vulkan device in CI";                  \
    ASSERT_EQ(std::getenv("FRINGETWIN_REQUIRE_DEVICE"), nullptr) << "no Vulkan device"; \
    GTEST_SKIP() << "SKIPPED: no Vulkan device";                                        \
  }
#define FT_NEED_CAPTURES(set)                                                                 \
  if (!::fringetwin::testing::have_captures(set)) {                                           \
    GTEST_SKIP() << "SKIPPED: real captures " << (set) << " not found (FRINGETWIN_CAPTURES)"; \
  }
