// SPDX-License-Identifier: Apache-2.0
// The last line and the badge say the worst there is, never "pass" beside something that is not explained.
#include "compare/verdict/overall.hpp"

#include <gtest/gtest.h>

namespace fringetwin::compare::overall_test {
namespace {

Comparison with(const std::vector<std::pair<std::string, std::string>>& states) {
  Comparison c;
  for (const auto& [quantity, state] : states) {
    ExplainedRow& row = c.explained.emplace_back();
    row.quantity = quantity;
    row.state = state;
  }
  return c;
}

TEST(Overall, TheWorstStateWithAllThatAreInIt) {
  Comparison c = with({{"gray", kTooWide},
                       {"phase", kNotExplained},
                       {"coverage", kNotExplained},
                       {"geometry", kNotCompared}});
  EXPECT_EQ(overall_verdict(c).text, "coverage, phase: not explained; no limits set");
  EXPECT_EQ(overall_verdict(c).badge, "none");
  c = with({{"gray", kTooWide}, {"phase", kExplained}});
  EXPECT_EQ(overall_verdict(c).text, "gray: budget too wide; no limits set");
}

TEST(Overall, MetLimitsAreNoPassBesideSomethingNotExplained) {
  Comparison c = with({{"gray", kExplained}, {"phase", kNotCompared}});
  c.limits = {{"center_mm", 0.0, 1.0, true}};
  EXPECT_EQ(overall_verdict(c).text, "phase: not compared; limits met");
  EXPECT_EQ(overall_verdict(c).badge, "none");
  c = with({{"gray", kExplained}, {"phase", kExplained}});
  c.limits = {{"center_mm", 0.0, 1.0, true}};
  EXPECT_EQ(overall_verdict(c).text, "explained; limits met");
  EXPECT_EQ(overall_verdict(c).badge, "pass");
  c.pass = false;
  EXPECT_EQ(overall_verdict(c).text, "explained; limits not met");
  EXPECT_EQ(overall_verdict(c).badge, "fail");
}

TEST(Overall, WithNothingToExplainTheLimitsAlone) {
  Comparison c;
  EXPECT_EQ(overall_verdict(c).text, "no limits set");
  c.limits = {{"center_mm", 0.0, 1.0, true}};
  EXPECT_EQ(overall_verdict(c).text, "limits met");
  EXPECT_EQ(overall_verdict(c).badge, "pass");
}

}  // namespace
}  // namespace fringetwin::compare::overall_test
