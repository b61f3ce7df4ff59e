// SPDX-License-Identifier: Apache-2.0
#include "twin/captures/numbered_name.hpp"

#include <gtest/gtest.h>

namespace fringetwin::testing::numbered_name_test {
namespace {

TEST(NumberedName, ThereAndBack) {
  for (const char* text : {"left/%04d.png", "%d", "img%d.png", "L%02d_%"}) {
    const auto name = parse_numbered_name(text);
    if (std::string(text) == "L%02d_%") {
      EXPECT_FALSE(name);
      continue;
    }
    ASSERT_TRUE(name) << text;
    for (const int number : {0, 7, 10, 99999}) EXPECT_EQ(name->number_of((*name)(number)), number) << text;
  }
  EXPECT_EQ((*parse_numbered_name("left/%04d.png"))(12), "left/0012.png");
}

TEST(NumberedName, OtherNamesHaveNoNumber) {
  const auto name = parse_numbered_name("img%02d.png");
  ASSERT_TRUE(name);
  for (const char* other : {"img1.png", "img001.png", "img-1.png", "img.png", "imgxx.png", "img01.pngx",
                            "img+1.png", "img 1.png", "img99999999999999.png"})
    EXPECT_FALSE(name->number_of(other)) << other;
}

TEST(NumberedName, WhatIsNoPattern) {
  for (const char* text : {"", "left.png", "%4d.png", "%x.png", "%", "%04", "%d_%d.png", "%0021d.png",
                           "%099d", "left/%04d/../0000.png", "%04d/..", "%d/x/../../0.png"})
    EXPECT_FALSE(parse_numbered_name(text)) << text;
}

}  // namespace
}  // namespace fringetwin::testing::numbered_name_test
