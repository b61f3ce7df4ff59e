// SPDX-License-Identifier: Apache-2.0
// | tolerance     | unit  | origin                                                       |
// |---------------|-------|--------------------------------------------------------------|
// | kDeviateError | sigma | the next terms of the series (normal_deviates.hpp)            |
// | 4.5 sigma     | -     | of a share p of n draws: sqrt(p (1 - p) / n); fixed seed      |
#include "render/base/normal_deviates.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

namespace fringetwin::render::normal_deviates_test {
namespace {

using Deviates = std::array<double, kMostDeviates>;

TEST(NormalDeviates, NearOnesLieBesideTheExact) {
  Deviates near;
  double worst = 0.0;
  for (const std::uint64_t first : {std::uint64_t{0}, std::uint64_t{0xFFFFFE00u}, std::uint64_t{1} << 33})
    for (std::uint32_t image = 0; image < 2000; ++image) {
      const DeviateSource source{{7, 9}, image, 2};
      near_deviates(source, first, &near);
      for (std::size_t i = 0; i < kMostDeviates; ++i)
        worst = std::max(worst, std::abs(near[i] - exact_deviate(source, first + i)));
    }
  EXPECT_LE(worst, kDeviateError);
  EXPECT_GT(worst, 1e-3 * kDeviateError) << "near, not the same";
}

// The least and the largest radius, and both sides of where the series begin anew.
TEST(NormalDeviates, AtTheEndsOfTheirRange) {
  const auto block = std::make_unique<DeviateBlock>();
  std::vector<DeviateWords> words;
  for (const std::uint32_t high : {0u, 1u, 0x7FFFFFFFu, 0x80000000u, 0xB504F333u, 0xB504F334u, 0xFFFFFFFFu})
    for (const std::uint32_t low : {0u, 0x7FFu, 0x800u, 0xF9DE6484u, 0xFFFFFFFFu})
      for (const std::uint32_t turn : {0u, 1u, 0x3FFFFFFFu, 0x40000000u, 0x7FFFFFFFu, 0x80000000u,
                                       0x80000001u, 0xC0000000u, 0xFFFFFFFFu})
        words.push_back({high, low, turn});
  ASSERT_LE(words.size(), kMostDeviates);
  *block = {};
  for (std::size_t i = 0; i < words.size(); ++i) {
    block->high[i] = words[i].high;
    block->low[i] = words[i].low;
    block->turn[i] = words[i].turn;
  }
  Deviates near;
  near_box_muller(*block, &near);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const double exact = exact_box_muller(words[i]);
    ASSERT_TRUE(std::isfinite(exact));
    EXPECT_NEAR(near[i], exact, kDeviateError)
        << words[i].high << ' ' << words[i].low << ' ' << words[i].turn;
  }
  EXPECT_NEAR(near[0], 8.652, 1e-3);  // sqrt(2 ln 2^54), the largest
}

// The share beyond k sigma is erfc(k / sqrt 2).
TEST(NormalDeviates, TheirTailsAreThoseOfANormalDistribution) {
  constexpr double n = 2000.0 * kMostDeviates;
  std::array<int, 5> beyond{};
  Deviates near;
  for (std::uint32_t image = 0; image < 2000; ++image) {
    near_deviates({{1, 2}, image, 0}, 0, &near);
    for (const double d : near)
      for (std::size_t k = 1; k < beyond.size(); ++k)
        beyond[k] += std::abs(d) > static_cast<double>(k) ? 1 : 0;
  }
  for (std::size_t k = 1; k < beyond.size(); ++k) {
    const double p = std::erfc(static_cast<double>(k) / std::sqrt(2.0));
    EXPECT_NEAR(beyond[k] / n, p, 4.5 * std::sqrt(p * (1.0 - p) / n)) << k;
  }
}

}  // namespace
}  // namespace fringetwin::render::normal_deviates_test
