// SPDX-License-Identifier: Apache-2.0
// Progress of work of unequal steps. No tolerances: texts are exact.
#include "compare/result/milestones.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace fringetwin::compare::milestones_test {
namespace {

std::string shown(const std::function<void(Milestones&)>& work) {
  ::testing::internal::CaptureStderr();
  {
    Milestones milestones("causes", 10);
    work(milestones);
  }
  return ::testing::internal::GetCapturedStderr();
}

TEST(Milestones, GoOnAndNeverBack) {
  EXPECT_EQ(shown([](Milestones& m) {
              m.reach(3);
              m.reach(2);
              m.reach(3);
              m.step();
              m.finish();
              m.finish();
            }),
            "fringetwin: causes 30 %\nfringetwin: causes 40 %\nfringetwin: causes 100 %\n");
  EXPECT_EQ(shown([](Milestones&) {}), "") << "work that is not begun is not shown";
}

}  // namespace
}  // namespace fringetwin::compare::milestones_test
