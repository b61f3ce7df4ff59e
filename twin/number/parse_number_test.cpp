// SPDX-License-Identifier: Apache-2.0
#include "twin/number/parse_number.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

namespace fringetwin::parse_number_test {
namespace {

TEST(ParseNumber, TheWholeTextIsTheNumber) {
  EXPECT_EQ(parse_number<int>("-12"), -12);
  EXPECT_EQ(parse_number<unsigned>("12"), 12U);
  EXPECT_EQ(parse_number<std::size_t>("5000000000"), std::size_t{5'000'000'000});
  EXPECT_EQ(parse_number<double>("-1.25e-3"), -1.25e-3);
  EXPECT_EQ(parse_number<double>("7"), 7.0);
  EXPECT_TRUE(std::isnan(parse_number<double>("nan").value()));
  EXPECT_TRUE(std::isinf(parse_number<double>("-inf").value()));
}

TEST(ParseNumber, AnythingElseIsNone) {
  for (const char* text : {"", " ", " 1", "1 ", "+1", "1,5", "1mm", "x", "--1", "0x10"}) {
    EXPECT_EQ(parse_number<int>(text), std::nullopt) << text;
    EXPECT_EQ(parse_number<double>(text), std::nullopt) << text;
  }
  EXPECT_EQ(parse_number<int>("1.5"), std::nullopt);
  EXPECT_EQ(parse_number<unsigned>("-1"), std::nullopt);
}

TEST(ParseNumber, BeyondTheRangeIsNone) {
  EXPECT_EQ(parse_number<int>("3000000000"), std::nullopt);
  EXPECT_EQ(parse_number<double>("1e999"), std::nullopt);
}

}  // namespace
}  // namespace fringetwin::parse_number_test
