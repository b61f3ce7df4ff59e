// SPDX-License-Identifier: Apache-2.0
// The exposure chosen against the closed form: a pixel of gain g is clipped from (full scale - 1/2 - black)/g
// on.
#include "capture/adjust/exposure_choice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/capture/even_rig.hpp"
#include "tests/support/twin/child_process.hpp"
#include "tests/support/twin/random_values.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::exposure_choice_test {
namespace {

using namespace fringetwin::capture;
using testing::EvenCamera;
using testing::EvenCameraOptions;
using testing::EvenRig;
using ::testing::HasSubstr;
using testing::uniform;

/// The exposure at which more than `share` of the pixels clip.
double closed_form_ms(const EvenCamera& camera, const EvenCameraOptions& o, double share) {
  const auto first =
      static_cast<std::size_t>(share * o.width * o.height);  // gains fall with the pixel's number
  return ((1 << o.bits) - 1.5 - o.black_dn) / (camera.gain(first) * (1.0 + o.ambient));
}

TEST(ExposureChoice, IsTheLongestThatDoesNotSaturate) {
  for (const int bits : {8, 12}) {
    EvenRig rig;
    rig.add("left", {.width = 100, .height = 50, .bits = bits, .dn_per_ms = bits == 8 ? 15.0 : 240.0});
    rig.add("right", {.width = 100, .height = 50, .bits = bits, .exposure_ms = 90.0, .dn_per_ms = 60.0});
    const auto choices = choose_exposures(rig.cameras, rig.display);
    for (std::size_t c = 0; c < 2; ++c) {
      const double best_ms = closed_form_ms(rig.camera(c), rig.camera(c).options(), 0.001);
      EXPECT_LE(choices[c].exposure_ms, best_ms);
      EXPECT_GE(choices[c].exposure_ms, 0.98 * best_ms - 0.01);  // to 1 %, and the level to one of 255
      EXPECT_LE(choices[c].saturated_share, 0.001);
      EXPECT_EQ(choices[c].limit, ExposureChoice::Limit::light);
      EXPECT_LE(choices[c].tries, 12);
      EXPECT_EQ(rig.camera(c).exposure_ms(), choices[c].exposure_ms);
    }
  }
}

// Four frames after each change still have the exposure before, as many as are left out.
TEST(ExposureChoice, ACameraThatAppliesExposuresLate) {
  EvenRig rig;
  rig.add("left",
          {.width = 100, .height = 50, .exposure_ms = 90.0, .dn_per_ms = 15.0, .exposure_late_frames = 4});
  const ExposureChoice choice = choose_exposures(rig.cameras, rig.display)[0];
  const double best_ms = closed_form_ms(rig.camera(0), rig.camera(0).options(), 0.001);
  EXPECT_LE(choice.exposure_ms, best_ms);
  EXPECT_GE(choice.exposure_ms, 0.98 * best_ms - 0.01);  // as above
  EXPECT_EQ(choice.limit, ExposureChoice::Limit::light);
}

// Every other frame gets half as much light again: whether it is the first or the last of those looked at, it
// is the one that saturates.
TEST(ExposureChoice, TheWorstFrameCounts) {
  EvenRig rig;
  for (const int flash_at : {0, 1})
    rig.add(flash_at == 0 ? "even" : "odd",
            {.width = 100, .height = 50, .dn_per_ms = 15.0, .flash_at = flash_at, .flash = 1.5});
  const auto choices = choose_exposures(rig.cameras, rig.display);
  for (std::size_t c = 0; c < 2; ++c) {
    const double best_ms = closed_form_ms(rig.camera(c), rig.camera(c).options(), 0.001) / 1.5;
    EXPECT_LE(choices[c].exposure_ms, best_ms) << choices[c].camera;
    EXPECT_GE(choices[c].exposure_ms, 0.98 * best_ms - 0.01) << choices[c].camera;  // as above
    EXPECT_LE(choices[c].saturated_share, 0.001);
  }
}

RC_GTEST_PROP(ExposureChoiceProperty, AnyStartAnyLightAnyShare, ()) {
  EvenRig rig;
  EvenCameraOptions o;
  o.width = 50;
  o.height = 40;
  o.bits = *rc::gen::element(8, 12);
  o.black_dn = *uniform(0.0, 20.0);
  o.ambient = *uniform(0.0, 0.3);
  o.exposure_ms = *uniform(0.1, 100.0);
  const double best_ms = std::pow(10.0, *uniform(-0.7, 1.9));  // 0.2 ... 80 ms
  const double share = *rc::gen::element(0.0, 0.001, 0.05);
  o.dn_per_ms = 1.0;
  {
    EvenRig unit;
    unit.add("left", o);
    o.dn_per_ms = closed_form_ms(unit.camera(0), o, share) / best_ms;
  }
  rig.add("left", o);
  const ExposureChoice choice = choose_exposures(rig.cameras, rig.display, {.saturated_share = share})[0];
  RC_ASSERT(choice.limit == ExposureChoice::Limit::light);
  RC_ASSERT(choice.saturated_share <= share);
  RC_ASSERT(choice.exposure_ms <= best_ms + 0.011);  // and a step, one of range {0.1, 100, 0.01}
  RC_ASSERT(choice.exposure_ms >= 0.98 * best_ms - 0.021);
  RC_ASSERT(choice.tries <= 20);
}

TEST(ExposureChoice, NoiseCostsLittle) {
  EvenRig rig;
  rig.add("left", {.width = 100, .height = 50, .bits = 12, .dn_per_ms = 240.0, .noise_dn = 40.0});
  const ExposureChoice choice = choose_exposures(rig.cameras, rig.display)[0];
  const double best_ms = closed_form_ms(rig.camera(0), rig.camera(0).options(), 0.001);
  EXPECT_LE(choice.saturated_share, 0.001);
  EXPECT_LT(choice.exposure_ms, best_ms);
  EXPECT_GT(choice.exposure_ms, 0.94 * best_ms);  // 40 of 4095 DN: 3 sigma of it are 3 %
}

TEST(ExposureChoice, MultiplesOfTheProjectorsFrame) {
  EvenRig rig;
  rig.add("left", {.dn_per_ms = 6.0, .range = {0.1, 100.0, 0.001}});
  const double best_ms = closed_form_ms(rig.camera(0), rig.camera(0).options(), 0.001);  // 41.6 ms
  const ExposureChoice choice = choose_exposures(rig.cameras, rig.display, {.unit_ms = 8.333})[0];
  EXPECT_NEAR(choice.exposure_ms, std::floor(best_ms / 8.333) * 8.333, 0.001);
}

TEST(ExposureChoice, LimitsAreSaid) {
  {
    EvenRig rig;
    rig.add("left", {.dn_per_ms = 50000.0});
    const ExposureChoice choice = choose_exposures(rig.cameras, rig.display)[0];
    EXPECT_EQ(choice.limit, ExposureChoice::Limit::least);
    EXPECT_NEAR(choice.exposure_ms, 0.1, 1e-9);
    EXPECT_EQ(choice.saturated_share, 1.0);
    EXPECT_THAT(choice.text(), HasSubstr("100 % saturated"));
    EXPECT_THAT(choice.text(), HasSubstr("close the aperture"));
  }
  {
    EvenRig rig;
    rig.add("left", {.dn_per_ms = 0.1});
    const ExposureChoice choice = choose_exposures(rig.cameras, rig.display)[0];
    EXPECT_EQ(choice.limit, ExposureChoice::Limit::greatest);
    EXPECT_NEAR(choice.exposure_ms, 100.0, 1e-9);
    EXPECT_TRUE(choice.too_dark());
    EXPECT_THAT(choice.text(), HasSubstr("too dark at the greatest exposure"));
  }
  {
    EvenRig rig;
    rig.add("left", {.dn_per_ms = 4.0});
    const ExposureChoice choice = choose_exposures(rig.cameras, rig.display, {.max_ms = 33.0})[0];
    EXPECT_EQ(choice.limit, ExposureChoice::Limit::greatest);
    EXPECT_NEAR(choice.exposure_ms, 33.0, 1e-9);
    EXPECT_FALSE(choice.too_dark());
  }
}

}  // namespace
}  // namespace fringetwin::testing::exposure_choice_test
