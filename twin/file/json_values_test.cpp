// SPDX-License-Identifier: Apache-2.0
#include "twin/file/json_values.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace fringetwin::testing::json_values_test {
namespace {

using Json = nlohmann::json;

TEST(JsonValues, WholeNumbersOfTheTypesEndsAreRead) {
  for (const int number : {std::numeric_limits<int>::min(), -1, 0, std::numeric_limits<int>::max()})
    EXPECT_EQ(whole_number<int>(Json::parse(std::to_string(number))), number);
  constexpr auto kMost = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(whole_number<std::uint64_t>(Json::parse(std::to_string(kMost))), kMost);
}

TEST(JsonValues, ANumberBeyondItsTypeOrWithAFractionIsRefused) {
  for (const char* text :
       {"2147483648", "-2147483649", "18446744073709551616", "3.5e38", "1e2", "2.0", "-0.5"})
    EXPECT_THROW(whole_number<int>(Json::parse(text)), std::out_of_range) << text;
  EXPECT_THROW(whole_number<std::uint32_t>(Json::parse("-1")), std::out_of_range);
  EXPECT_THROW(whole_number<std::uint64_t>(Json::parse("1e19")), std::out_of_range);
}

TEST(JsonValues, WhatIsNoNumberIsRefused) {
  for (const char* text : {"\"1\"", "null", "[1]", "{}", "true"})
    EXPECT_THROW(whole_number<int>(Json::parse(text)), Json::exception) << text;
}

TEST(JsonValues, ATextIsParsedWithinItsBounds) {
  EXPECT_EQ(parse_json<Json>("[1, 2]").size(), 2u);
  EXPECT_THROW(parse_json<Json>("[1, 2"), Json::exception);
  EXPECT_THROW(parse_json<Json>(std::string(100, '[') + std::string(100, ']')), std::out_of_range);
}

}  // namespace
}  // namespace fringetwin::testing::json_values_test
