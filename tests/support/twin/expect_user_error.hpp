// SPDX-License-Identifier: Apache-2.0
// Runs a call that must throw UserError and fails the test unless it does, with the exit code and words
// given. For *_test.cpp only.
#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "twin/base/errors.hpp"

namespace fringetwin::testing {

template <class Call>
void expect_user_error(ExitCode code, const std::string& words, const Call& call) {
  try {
    call();
    ADD_FAILURE() << "not refused: " << words;
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), code);
    EXPECT_THAT(error.what(), ::testing::HasSubstr(words));
  }
}

}  // namespace fringetwin::testing
