// SPDX-License-Identifier: Apache-2.0
#include "render/base/sobol.hpp"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <vector>

namespace fringetwin::testing::sobol_test {
namespace {
using namespace fringetwin::render;

// SciPy 1.10 (scipy.stats.qmc.Sobol, scramble=False, bits=32), whose points come in the order of Gray's code.
TEST(Sobol, AgreesWithSciPy) {
  struct Row {
    int dimension;
    std::uint32_t at_5, at_100, at_777;
  };
  for (const Row& row : std::vector<Row>{{1, 3758096384U, 1107296256U, 4022337536U},
                                         {7, 1610612736U, 2046820352U, 3275751424U},
                                         {20, 2684354560U, 3254779904U, 1019215872U},
                                         {39, 1610612736U, 570425344U, 1539309568U}}) {
    const auto v = sobol_directions(row.dimension);
    EXPECT_EQ(sobol_coordinate(v, 5 ^ 2), row.at_5) << row.dimension;
    EXPECT_EQ(sobol_coordinate(v, 100 ^ 50), row.at_100) << row.dimension;
    EXPECT_EQ(sobol_coordinate(v, 777 ^ 388), row.at_777) << row.dimension;
  }
}

// Points 2^0 ... 2^15 of a dimension are its direction numbers: one wrong number of the table changes their
// weighted sum. From SciPy, as above.
TEST(Sobol, EveryDimensionHasTheDirectionNumbersOfSciPy) {
  constexpr std::array<std::uint64_t, kSobolDimensions> scipy{
      8588754944,   438322987008, 334603878400, 342336864256, 319831277568, 334969307136, 285380050944,
      289311424512, 292074946560, 275256049664, 254168924160, 242814681088, 309610545152, 328000471040,
      281004605440, 272947871744, 254403805184, 242008588288, 349203988480, 274044157952, 261558763520,
      279026991104, 244111507456, 293023383552, 267187519488, 252412035072, 237618724864, 198006669312,
      306662735872, 297908174848, 295178731520, 225103446016, 314647642112, 256395051008, 295203897344,
      337032642560, 293386715136, 389776539648, 328309276672, 255966183424};
  for (int d = 0; d < kSobolDimensions; ++d) {
    const auto v = sobol_directions(d);
    std::uint64_t sum = 0;
    for (std::uint64_t bit = 0; bit < 16; ++bit) sum += (bit + 1) * sobol_coordinate(v, 1U << bit);
    EXPECT_EQ(sum, scipy[static_cast<std::size_t>(d)]) << "dimension " << d;
  }
}

// Each dimension alone: one of 2^k points in each of 2^k equal intervals. A wrong or even number of the table
// breaks this.
TEST(Sobol, EveryDimensionIsStratified) {
  for (int d = 0; d < kSobolDimensions; ++d) {
    const auto v = sobol_directions(d);
    for (const std::uint32_t k : {3U, 6U, 10U}) {
      std::set<std::uint32_t> intervals;
      for (std::uint32_t i = 0; i < 1U << k; ++i) intervals.insert(sobol_coordinate(v, i) >> (32 - k));
      EXPECT_EQ(intervals.size(), 1U << k) << "dimension " << d;
    }
  }
}

}  // namespace
}  // namespace fringetwin::testing::sobol_test
