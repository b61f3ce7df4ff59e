// SPDX-License-Identifier: Apache-2.0
// Photon-transfer noise must predict the phase noise of real captures.
//
// | check                            | tolerance | origin                                                |
// |----------------------------------|-----------|-------------------------------------------------------|
// | measured phase noise, slsdk      | 10 %      | README of the set: 0.038, 0.036 rad, second differences |
// | measured / predicted phase noise | 10 %      | left out of the sensor: texture, flicker, harmonics   |
// | measured / predicted gray noise  | 3 %       | the line is fitted to these values, 3 % in bins       |
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "calib/photometry/photometry.hpp"
#include "compare/gray/noise_check.hpp"
#include "measure/measurement.hpp"
#include "tests/support/twin/real_set.hpp"

namespace fringetwin::compare::noise_real_test {
namespace {

using testing::load_real_set;
using testing::RealSet;

NoiseRow row_of(const RealSet& set, std::size_t camera, const Sensor& sensor) {
  Camera c = set.twin.cameras[camera];
  c.sensor = sensor;
  const measure::CameraDecode decode = measure::decode(
      set.images[camera], set.twin.fringes, measure::decode_options(set.twin, c, set.images[camera]));
  const auto rows = noise_rows(c, set.twin.fringes, set.images[camera], decode, {});
  EXPECT_EQ(rows.size(), 1u);
  if (rows.empty()) return {};
  const NoiseRow& r = rows[0];
  std::cout << c.name << ": gray " << r.gray_measured_dn << " / " << r.gray_predicted_dn << " DN, ratio "
            << r.gray_ratio << " +- " << r.gray_ratio_sigma << ", n " << r.n << "; phase "
            << r.phase_measured_rad << " / " << r.phase_predicted_rad << " rad, ratio " << r.phase_ratio
            << " +- " << r.phase_ratio_sigma << ", n " << r.n_phase << "\n";
  return r;
}

TEST(NoiseReal, SlsdkPhotonTransferPredictsThePhaseNoise) {
  const auto set = load_real_set("slsdk-stereo-statue");
  if (!set) GTEST_SKIP() << "real captures absent (FRINGETWIN_CAPTURES)";
  std::vector<calib::CameraFrames> frames(2);
  for (std::size_t c = 0; c < 2; ++c) frames[c].captures.push_back(set->images[c]);
  const calib::Photometry photometry = calib::analyse_photometry(set->twin, frames);
  const double readme_rad[] = {0.038, 0.036};
  for (std::size_t c = 0; c < 2; ++c) {
    const NoiseRow r = row_of(*set, c, photometry.cameras[c].sensor);
    EXPECT_TRUE(r.sensor_known);
    EXPECT_NEAR(r.gray_ratio, 1.0, 0.03);
    EXPECT_NEAR(r.phase_measured_rad, readme_rad[c], 0.1 * readme_rad[c]);
    EXPECT_NEAR(r.phase_ratio, 1.0, 0.1);
  }
}

TEST(NoiseReal, SlmasterSensorOfTheTwin) {
  const auto set = load_real_set("slmaster-mono-relief");
  if (!set) GTEST_SKIP() << "real captures absent (FRINGETWIN_CAPTURES)";
  const NoiseRow r = row_of(*set, 0, set->twin.cameras[0].sensor);
  EXPECT_NEAR(r.gray_ratio, 1.0,
              0.02);  // three of the sensor values' own standard errors (1.3 % of a variance)
  EXPECT_NEAR(r.phase_ratio, 1.0, 0.1);
  EXPECT_NEAR(r.phase_measured_rad, 0.0188, 0.1 * 0.0188);  // README of the set
}

}  // namespace
}  // namespace fringetwin::compare::noise_real_test
