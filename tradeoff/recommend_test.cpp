// SPDX-License-Identifier: Apache-2.0
// No tolerances: what is left off, and sums of small integers.
#include "tradeoff/recommend.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "tests/support/paper_rig.hpp"
#include "tradeoff/effects.hpp"

namespace fringetwin::tradeoff::recommend_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
const double nan = std::nan("");
constexpr double inf = std::numeric_limits<double>::infinity();

TEST(Recommendation, DearestFirst) {
  const Tolerance t{10, 10, 10};
  EXPECT_THAT(leave_off({{{1, 1, 1}, 1.0}, {{1, 1, 1}, 5.0}, {{1, 1, 1}, 2.0}}, t), ElementsAre(1, 2, 0));
}

TEST(Recommendation, ChangesAddUpInEveryQuantity) {
  const Tolerance t{10, 1, 1};
  // 6 + 5 rad is too much, though each is not; the third fits beside the first
  EXPECT_THAT(leave_off({{{6, 0, 0}, 3.0}, {{5, 0, 0}, 2.0}, {{4, 0, 0}, 1.0}}, t), ElementsAre(0, 2));
  EXPECT_THAT(leave_off({{{0, 2, 0}, 9.0}}, t), IsEmpty());
  EXPECT_THAT(leave_off({{{0, 0, 2}, 9.0}}, t), IsEmpty());
}

TEST(Recommendation, EqualCostSmallestChangeFirst) {
  EXPECT_THAT(leave_off({{{6, 0, 0}, 1.0}, {{5, 0, 0}, 1.0}}, {10, 1, 1}), ElementsAre(1));
}

TEST(Recommendation, UnknownIsNotJudgedAndLostIsTooMuch) {
  const Tolerance t{1, 1, 1};
  EXPECT_THAT(leave_off({{{nan, 0.5, nan}, 1.0}}, t), ElementsAre(0));
  EXPECT_THAT(leave_off({{{inf, 0.5, nan}, 1.0}}, t), IsEmpty());
  const Change sum = Change{nan, 1, nan} + Change{nan, 2, 3};
  EXPECT_TRUE(std::isnan(sum.phase_rad));
  EXPECT_EQ(sum.gray_dn, 3);
  EXPECT_EQ(sum.fit_mm, 3);
}

TEST(Recommendation, ToleranceZeroKeepsWhatChangesAnything) {
  EXPECT_THAT(leave_off({{{0, 0, 0}, 1.0}, {{1e-12, 0, 0}, 9.0}}, {0, 0, 0}), ElementsAre(0));
}

/// A twin with every effect on.
Twin everything() {
  Twin twin = testing::with_object(testing::paper_rig(), "ball", testing::ideal_sphere());
  twin.objects.push_back({"wall", testing::frontal_plane(), {}});
  twin.objects[0].material.specular = 0.2;
  for (Camera& c : twin.cameras) {
    c.optics = Optics{8.0, 10.0, 270.0};
    c.sensor.electrons_per_dn = 40.0;
    c.sensor.read_noise_dn = 0.5;
    c.sensor.black_level_dn = 3.0;
    c.psf_px = 0.4;
    c.vignetting.kind = Vignetting::Kind::cos4;
  }
  Projector& p = *twin.projector;
  p.ambient = 0.1;
  p.inverse_square = true;
  p.reference_distance_mm = 270.0;
  p.blur_px = 1.0;
  p.response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  p.optics = Optics{2.0, 15.0, 270.0};
  p.pixel_structure = true;
  p.quantise_bits = 8;
  twin.render.bounces = 1;
  std::get<PlaneShape>(twin.objects[1].shape).albedo_map = std::make_shared<ImageF>(2, 2, 0.5F);
  return twin;
}

TEST(Effects, EachSwitchActsOnItsOwnEffectOnly) {
  const Twin full = everything();
  std::set<std::string> names;
  for (const Effect& effect : effects()) {
    EXPECT_TRUE(names.insert(effect.name).second) << effect.name << " is there twice";
    EXPECT_FALSE(effect.switch_on.empty() || effect.without.empty()) << effect.name;
    if (!effect.is_on(full)) continue;
    Twin without = full;
    effect.switch_off(without);
    for (const Effect& other : effects())
      EXPECT_EQ(other.is_on(without), other.is_on(full) && other.name != effect.name)
          << "switching off " << effect.name << " changed " << other.name;
  }
}

// All effects are on in that twin and off in the plainest one.
TEST(Effects, OnAndOff) {
  for (const Effect& effect : effects()) EXPECT_TRUE(effect.is_on(everything())) << effect.name;
  Twin plain = testing::with_object(testing::paper_rig(), "ball", testing::ideal_sphere());
  std::vector<std::string> on;
  for (const Effect& effect : effects())
    if (effect.is_on(plain)) on.push_back(effect.name);
  EXPECT_THAT(on, ElementsAre("pixel area", "sensor rounding"));
}

// A finer converter of the same range: black, full scale and noise in DN of the first stay where they were.
TEST(Effects, WithoutRoundingTheSensorKeepsItsRange) {
  Twin twin = everything();
  const Sensor before = twin.cameras[0].sensor;
  for (const Effect& effect : effects())
    if (effect.name == "sensor rounding") effect.switch_off(twin);
  const Sensor& after = twin.cameras[0].sensor;
  const double scale = after.gain_dn / before.gain_dn;
  EXPECT_EQ(after.bit_depth, 16);
  EXPECT_EQ(scale, 256.0);
  EXPECT_EQ(after.black_level_dn / scale, before.black_level_dn);
  EXPECT_EQ(*after.read_noise_dn / scale, *before.read_noise_dn);
  // variance gain E / electrons_per_dn, in DN of the first
  EXPECT_EQ(after.gain_dn / *after.electrons_per_dn / (scale * scale),
            before.gain_dn / *before.electrons_per_dn);
}

}  // namespace
}  // namespace fringetwin::tradeoff::recommend_test
