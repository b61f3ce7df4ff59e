// SPDX-License-Identifier: Apache-2.0
#include "cosim/other_noise.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fringetwin::cosim::other_noise_test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

Twin one_camera(std::optional<double> read_noise_dn) {
  Twin twin;
  const Lens lens("LENSMODEL_PINHOLE", {900, 905, 31.5, 23.5}, {64, 48}, "test");
  twin.cameras = {{"left", lens, Pose{}, Sensor{}, std::nullopt}};
  twin.cameras[0].sensor.read_noise_dn = read_noise_dn;
  return twin;
}

TEST(OtherNoise, OnlyImagesThatThisProgramRenderedHaveASeed) {
  EXPECT_EQ(seed_of_rendered({{"device", "fringetwin renderer on llvmpipe"}, {"seed", "7"}}), 7U);
  EXPECT_EQ(seed_of_rendered({{"device", "fringetwin renderer on x"}, {"seed", "18446744073709551615"}}),
            18446744073709551615U);
  EXPECT_EQ(seed_of_rendered({{"device", "a camera"}, {"seed", "7"}}), std::nullopt);
  EXPECT_EQ(seed_of_rendered({{"seed", "7"}}), std::nullopt);
  EXPECT_EQ(seed_of_rendered({{"device", "fringetwin renderer on x"}}), std::nullopt);
  for (const char* text : {"", "-1", "7.5", "seven", "18446744073709551616"})
    EXPECT_EQ(seed_of_rendered({{"device", "fringetwin renderer on x"}, {"seed", text}}), std::nullopt)
        << text;
}

TEST(OtherNoise, TheDefaultSeedGivesWayAndSaysSo) {
  const ChosenSeed chosen = choose_seed(one_camera(0.5), std::nullopt, 0);
  EXPECT_EQ(chosen.seed, 1U);
  EXPECT_THAT(chosen.note, HasSubstr("rendered with seed 0: the simulated ones have seed 1"));
  EXPECT_THAT(chosen.warning, IsEmpty());
}

TEST(OtherNoise, ASeedThatWasAskedForStaysWithAWarning) {
  const ChosenSeed chosen = choose_seed(one_camera(0.5), 7, 7);
  EXPECT_EQ(chosen.seed, 7U);
  EXPECT_THAT(chosen.warning, HasSubstr("--seed 8"));
  EXPECT_THAT(chosen.note, IsEmpty());
}

TEST(OtherNoise, NothingChangesWithoutNoiseOrWithAnotherSeedOrARealCamera) {
  for (const auto& [noise_dn, of_real] :
       {std::pair<std::optional<double>, std::optional<std::uint64_t>>{std::nullopt, 0},
        {0.0, 0},
        {0.5, 3},
        {0.5, std::nullopt}}) {
    const ChosenSeed chosen = choose_seed(one_camera(noise_dn), std::nullopt, of_real);
    EXPECT_EQ(chosen.seed, 0U);
    EXPECT_THAT(chosen.note + chosen.warning, IsEmpty());
  }
}

TEST(OtherNoise, TwoRenderedSetsOfOneSeedAreWarnedOf) {
  EXPECT_THAT(same_noise_warning(one_camera(0.5), 4, 4), HasSubstr("render one of them with --seed 5"));
  EXPECT_THAT(same_noise_warning(one_camera(0.5), 4, 5), IsEmpty());
  EXPECT_THAT(same_noise_warning(one_camera(0.5), std::nullopt, std::nullopt), IsEmpty());
  EXPECT_THAT(same_noise_warning(one_camera(std::nullopt), 4, 4), IsEmpty());
}

}  // namespace
}  // namespace fringetwin::cosim::other_noise_test
