// SPDX-License-Identifier: Apache-2.0
// A refusal in tests: its exit code and words. For *_test.cpp only.
#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "twin/base/errors.hpp"

namespace fringetwin::test_tools {

template <class Call>
void expect_refused(ExitCode code, const std::string& words, const Call& call) {
  try {
    call();
    ADD_FAILURE() << "not refused: " << words;
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), code);
    EXPECT_THAT(error.what(), ::testing::HasSubstr(words));
  }
}

}  // namespace fringetwin::test_tools
