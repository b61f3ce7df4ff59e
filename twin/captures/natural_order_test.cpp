// SPDX-License-Identifier: Apache-2.0
#include "twin/captures/natural_order.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/twin/random_values.hpp"

namespace fringetwin::testing::natural_order_test {
namespace {
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(NaturalOrder, NumbersAsNumbers) {
  std::vector<std::string> names = {"img10.png", "img2.png",  "img1.png", "img002.png",  "b/img1.png",
                                    "img.png",   "img1a.png", "img1",     "img10_2.png", "img10_10.png"};
  std::sort(names.begin(), names.end(), natural_less);
  EXPECT_THAT(names, ElementsAre("b/img1.png", "img.png", "img1", "img1.png", "img1a.png", "img002.png",
                                 "img2.png", "img10.png", "img10_2.png", "img10_10.png"));
  EXPECT_TRUE(natural_less("99999999999999999998", "99999999999999999999"));
  EXPECT_TRUE(natural_less("a9", "a00000000000000000000010"));
}

std::string any_name() {
  return *rc::gen::resize(8, rc::gen::container<std::string>(rc::gen::element('0', '1', '9', 'a', '.')));
}

RC_GTEST_PROP(NaturalOrder, IsAStrictOrder, ()) {
  const std::string a = any_name(), b = any_name(), c = any_name();
  RC_ASSERT(!natural_less(a, a));
  RC_ASSERT(a == b || natural_less(a, b) != natural_less(b, a));
  if (natural_less(a, b) && natural_less(b, c)) RC_ASSERT(natural_less(a, c));
}

RC_GTEST_PROP(NaturalOrder, SortsNumberedFiles, ()) {
  const int a = *rc::gen::inRange(0, 100000), b = *rc::gen::inRange(0, 100000);
  const auto name = [](int number) { return "L_" + std::to_string(number) + ".bmp"; };
  RC_ASSERT(natural_less(name(a), name(b)) == (a < b));
}

TEST(NumberList, RangesAndNumbers) {
  EXPECT_THAT(parse_number_list("0-3,7,5"), ElementsAre(0, 1, 2, 3, 7, 5));
  EXPECT_THAT(parse_number_list("3-1"), ElementsAre(3, 2, 1));
  EXPECT_THAT(parse_number_list("4"), ElementsAre(4));
  EXPECT_THAT(parse_number_list("2-2,2"), ElementsAre(2, 2));
  for (const char* bad :
       {"", ",", "1,", ",1", "1,,2", "a", "1-", "-1", "1-2-3", "1 2", "0-99999999", "1--2", "1,-2"})
    EXPECT_THAT(parse_number_list(bad), IsEmpty()) << bad;
}

}  // namespace
}  // namespace fringetwin::testing::natural_order_test
