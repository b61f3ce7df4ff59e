// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/support/program/capture_killed.hpp"
#include "tests/support/program/cli_runner.hpp"

namespace fringetwin::testing::capture_full_test {
namespace {

TEST(CaptureFull, KilledBetweenAnyTwoChangesItIsWholeOrResumes) {
  FT_NEED_DEVICE();
  EXPECT_GT(kill_between_changes(1), 40);
}

}  // namespace
}  // namespace fringetwin::testing::capture_full_test
