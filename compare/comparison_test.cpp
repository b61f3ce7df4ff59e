// SPDX-License-Identifier: Apache-2.0
// The whole comparison on made sides whose images are decoded as a user's are.
#include "compare/comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "compare/phase/phase_budget.hpp"
#include "measure/measurement.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::comparison_test {
namespace {

using testing::SidesTruth;
using testing::SyntheticSides;

constexpr double kElectronsPerDn = 4.0;

/// Returns sides of much shot noise, one real image of which is 5 % too bright.
SyntheticSides flickering_sides() {
  SidesTruth t = testing::deep_truth();
  t.electrons_per_dn = kElectronsPerDn;
  SyntheticSides sides = testing::make_sides(t);
  for (float& v : sides.real.images[0].images[3].as_floats())
    v = static_cast<float>(t.black_level_dn + 1.05 * (static_cast<double>(v) - t.black_level_dn));
  Sensor& sensor = sides.twin.cameras[0].sensor;
  sensor.black_level_dn = t.black_level_dn;
  sensor.read_noise_dn = t.noise_dn;
  sensor.electrons_per_dn = kElectronsPerDn;
  for (Side* side : {&sides.real, &sides.simulated})
    side->measurement->cameras[0] =
        measure::decode(side->images[0], sides.twin.fringes,
                        measure::decode_options(sides.twin, sides.twin.cameras[0], side->images[0]));
  return sides;
}

/// Returns what factors told with these options predict.
double predicted_with(const SyntheticSides& sides, const measure::LightOptions& options) {
  const auto light = measure::estimate_light(sides.real.images[0], sides.twin.fringes, options);
  EXPECT_TRUE(light);
  const measure::DirectionDecode& real = sides.real.measurement->cameras[0].directions[0];
  return light ? predicted_brightness_rad2(sides.twin, 0, real, {}, *light) : kNaN;
}

// A bright pixel of this sensor has ten times the variance of a dark one: the factors are other ones, a
// little, where that is left out.
TEST(Comparison, LightIsToldWithTheNoiseOfTheCamera) {
  const SyntheticSides sides = flickering_sides();
  const Comparison comparison = compare(sides.twin, sides.real, sides.simulated, {});
  ASSERT_EQ(comparison.phase_budget.size(), 1u);
  const double predicted_rad2 = comparison.phase_budget[0].light_rad2;
  const double black_dn = sides.twin.cameras[0].sensor.black_level_dn,
               read_dn = *sides.twin.cameras[0].sensor.read_noise_dn, per_dn = 1.0 / kElectronsPerDn,
               least_dn = sides.twin.measure.min_modulation_dn;
  EXPECT_DOUBLE_EQ(
      predicted_rad2,
      predicted_with(sides, {.black_level_dn = black_dn,
                             .min_amplitude = least_dn,
                             .variance_offset_dn2 = read_dn * read_dn - per_dn * black_dn + 1.0 / 12.0,
                             .variance_per_dn = per_dn}));
  const double without = predicted_with(sides, {.black_level_dn = black_dn, .min_amplitude = least_dn});
  EXPECT_GT(std::abs(predicted_rad2 / without - 1.0), 1e-6) << "else the noise tells nothing here";
  std::printf("light_rad2 %.6g with the camera's noise, %.6g without\n", predicted_rad2, without);
}

}  // namespace
}  // namespace fringetwin::compare::comparison_test
