// SPDX-License-Identifier: Apache-2.0
#include "twin/base/parallel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

namespace fringetwin::parallel_test {
namespace {

TEST(Parallel, EveryJobRunsOnce) {
  std::vector<int> runs(1000);
  for_each_parallel(1000, [&](int i) { ++runs[i]; });
  EXPECT_THAT(runs, ::testing::Each(1));
}

TEST(Parallel, TheLowestFaultIsToldAndWhatLiesBehindItIsLeftOut) {
  try {
    for_each_parallel(1'000'000, [&](int i) {
      if (i >= 10) throw std::runtime_error(std::to_string(i));
    });
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_STREQ(e.what(), "10");
  }
  std::atomic<int> run = 0;
  EXPECT_THROW(for_each_parallel(1'000'000,
                                 [&](int i) {
                                   ++run;
                                   if (i == 3) throw std::runtime_error("3");
                                 }),
               std::runtime_error);
  EXPECT_LT(run, 1'000'000);
}

}  // namespace
}  // namespace fringetwin::parallel_test
