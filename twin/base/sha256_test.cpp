// SPDX-License-Identifier: Apache-2.0
// Truth: FIPS 180-4 test vectors.
#include "twin/base/sha256.hpp"

#include <gtest/gtest.h>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::sha256_test {
namespace {

using testing::ScratchFolder;

constexpr const char* kAbc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
constexpr const char* kNothing = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
constexpr const char* kMillionA = "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0";

TEST(Sha256, MatchesTheStandard) {
  EXPECT_EQ(sha256_of_text("abc"), kAbc);
  EXPECT_EQ(sha256_of_text(""), kNothing);
  EXPECT_EQ(sha256_of_text("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_of_text(std::string(1'000'000, 'a')), kMillionA);
}

TEST(Sha256, OfAFileAsOfItsBytes) {
  const ScratchFolder folder;
  EXPECT_EQ(sha256_of_file(folder.write("abc", "abc")), kAbc);
  EXPECT_EQ(sha256_of_file(folder.write("empty", "")), kNothing);
  EXPECT_EQ(sha256_of_file(folder.write("a", std::string(1'000'000, 'a'))), kMillionA);
}

TEST(Sha256, PartsMakeTheSameAsTheWhole) {
  Sha256 digest;
  for (const char* part : {"a", "", "bc"}) digest.add(std::as_bytes(std::span(std::string_view(part))));
  EXPECT_EQ(digest.hex(), kAbc);
}

TEST(Sha256, WhatCannotBeReadIsNamed) {
  for (const char* file : {"/nowhere/image.png", "/", "/dev/zero"}) {
    try {
      sha256_of_file(file, "put it back");
      FAIL();
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::input);
      EXPECT_EQ(error.what(), std::string(file) + ": the file cannot be read; put it back");
    }
  }
}

}  // namespace
}  // namespace fringetwin::testing::sha256_test
