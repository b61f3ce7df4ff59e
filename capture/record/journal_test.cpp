// SPDX-License-Identifier: Apache-2.0
#include "capture/record/journal.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/twin/child_process.hpp"
#include "tests/support/twin/expect_user_error.hpp"

namespace fringetwin::testing::journal_test {
namespace {

using namespace capture;

class JournalFile : public ::testing::Test {
 protected:
  const std::string head_ = R"({"schema": "fringetwin-capture-journal/1", "identity": {"a": "b"}})"
                            "\n";
  ScratchFolder folder_;
};

TEST_F(JournalFile, WhatIsDamagedIsNamedWithItsLine) {
  const std::string deep = R"({"schema": "fringetwin-capture-journal/1", "identity": {"a": "b"}, "more": )" +
                           std::string(100, '[') + std::string(100, ']') + "}\n";
  for (const std::string& head :
       {std::string("[]\n"), std::string("3\n"), std::string("{\"identity\": 3}\n"),
        std::string("{\"identity\": {\"a\": 3}}\n"), std::string("{\n"), std::string("1e999\n"), deep}) {
    folder_.write(kJournalName, head);
    expect_user_error(ExitCode::input, "capture.journal:1: is damaged",
                      [&] { Journal::identity(folder_.path()); });
    expect_user_error(ExitCode::input, "capture.journal:1: is damaged", [&] {
      Journal::resume(folder_.path(), {{"a", "b"}});
    });
  }
  for (const char* line :
       {"{}\n", "[1]\n", "{\"step\": \"one\"}\n", "{\"step\": 1e999}\n", "{\"step\": 3.5e38}\n"}) {
    folder_.write(kJournalName, head_ + line);
    expect_user_error(ExitCode::input, "capture.journal:2: is damaged", [&] {
      Journal::resume(folder_.path(), {{"a", "b"}});
    });
  }
}

TEST_F(JournalFile, APipeIsRefusedWithoutWaiting) {
  EXPECT_TRUE(Journal::identity(folder_.path()).empty());
  ASSERT_EQ(::mkfifo((folder_.path() / kJournalName).c_str(), 0600), 0);
  expect_user_error(ExitCode::input, "is a pipe or a device", [&] { Journal::identity(folder_.path()); });
  expect_user_error(ExitCode::input, "is a pipe or a device", [&] {
    Journal::resume(folder_.path(), {{"a", "b"}});
  });
}

}  // namespace
}  // namespace fringetwin::testing::journal_test
