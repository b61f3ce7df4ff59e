// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit | origin                                        |
// |-----------|------|-----------------------------------------------|
// | 1e-5      | DN   | single precision of gray values up to 100 DN  |
#include "tradeoff/needs.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/paper_rig.hpp"

namespace fringetwin::tradeoff::needs_test {
namespace {

// 8 bits of 20 DN per unit and a black level of 3 DN against 16 bits of the same range: 2.0203 units are 43.4
// DN, rounded to whole ones in 8 bits and to 1/256 in 16.
TEST(UnitsOfTheTwin, AnotherBitDepthOfTheSameRangeIsScaledBack) {
  Twin units = testing::only_camera(testing::paper_rig(), 0);
  Sensor& sensor = units.cameras[0].sensor;
  sensor = {};
  sensor.bit_depth = 8;
  sensor.gain_dn = 20.0;
  sensor.black_level_dn = 3.0;
  Twin model = units;
  const auto rounding = std::ranges::find(effects(), "sensor rounding", &Effect::name);
  ASSERT_NE(rounding, effects().end());
  rounding->switch_off(model);
  render::RenderedCamera rendered;
  rendered.camera = "left";
  rendered.irradiance = {ImageF(2, 1, 2.0203F)};
  rendered.white = ImageF(2, 1, 4.0F);
  rendered.black = ImageF(2, 1, 0.0F);
  const auto own = expose_in_units_of(units, units, {rendered}, 1);
  EXPECT_EQ(own.at(0).images[0](0, 0), 43.0F);
  const auto finer = expose_in_units_of(units, model, {rendered}, 1);
  EXPECT_EQ(finer.at(0).bit_depth, 8);
  EXPECT_NEAR(static_cast<double>(finer[0].images[0](1, 0)), 43.406, 0.5 / 256.0 + 1e-5);
  EXPECT_NEAR(static_cast<double>((*finer[0].white)(0, 0)), 83.0, 1e-5);
  EXPECT_NEAR(static_cast<double>((*finer[0].black)(0, 0)), 3.0, 1e-5);
}

}  // namespace
}  // namespace fringetwin::tradeoff::needs_test
