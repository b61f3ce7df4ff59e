// SPDX-License-Identifier: Apache-2.0
// The response of a real camera from its exposure series.
//
// | check                       | tolerance      | origin |
// |-----------------------------|----------------|-----------------------------------------------------------|
// | held-out exposures          | 0.3 DN rms     | what is asked of the fit; a quintic in the exposure | | |
// | leaves 0.55 (README of the set)                           | | knee                        | 110 ... 130
// DN | README of the set: near 120 DN, 63 -> 51 DN/ms            |
#include <gtest/gtest.h>

#include <fstream>

#include "calib/photometry/response_fit.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::calib::response_real_test {
namespace {

TEST(ResponseReal, Bsc2ExposureSeries) {
  const auto folder = captures_root() / "bsc2-exposure-series";
  std::ifstream list(folder / "exposures.csv");
  if (!list) GTEST_SKIP() << "real captures absent (FRINGETWIN_CAPTURES)";
  std::string line;
  std::getline(list, line);
  std::vector<ExposedBlocks> images;
  while (std::getline(list, line)) {
    const auto comma = line.find(',');
    if (comma == std::string::npos) continue;
    images.push_back(exposed_blocks({read_gray(folder / line.substr(0, comma)).image},
                                    std::stod(line.substr(comma + 1)), 255.0));
  }
  ASSERT_EQ(images.size(), 64u);
  const auto fit = fit_response(std::move(images), 0.0, "left");
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->held_out_rms_dn, 0.3);
  EXPECT_TRUE(fit->has_knee);
  EXPECT_GT(fit->knee_dn.value, 110.0);
  EXPECT_LT(fit->knee_dn.value, 130.0);
}

}  // namespace
}  // namespace fringetwin::calib::response_real_test
