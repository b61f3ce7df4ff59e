// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit | origin                                        |
// |-----------|------|-----------------------------------------------|
// | 1e-12     | rel. | a few roundings of double precision           |
#include "twin/camera_response.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/twin/twin_file_fixture.hpp"

namespace fringetwin::testing::camera_response_test {
namespace {

using ::testing::HasSubstr;

TEST(CameraResponse, CurveAndInverseByHand) {
  const CameraResponse f{{{40.0, 40.0}, {90.0, 100.0}, {140.0, 120.0}}, 0.25};
  const struct {
    double in, out, slope;
  } points[] = {{-5, -5, 1},    {0, 0, 1},       {20, 20, 1},      {40, 40, 1.2},   {65, 70, 1.2},
                {90, 100, 0.4}, {115, 110, 0.4}, {140, 120, 0.25}, {180, 130, 0.25}};
  for (const auto& p : points) {
    EXPECT_NEAR(f(p.in), p.out, 1e-12 * 130.0) << p.in;
    EXPECT_NEAR(f.inverse(p.out), p.in, 1e-12 * 180.0) << p.out;
    EXPECT_NEAR(f.slope(p.in), p.slope, 1e-12) << p.in;
  }
  EXPECT_NEAR(f.steepest(), 1.2, 1e-12);
  EXPECT_NEAR(f.scaled(16.0)(65.0 * 16.0), 70.0 * 16.0, 1e-12 * 1120.0);
  EXPECT_TRUE(CameraResponse{}.straight());
  EXPECT_EQ(CameraResponse{}(7.0), 7.0);
}

using CameraResponseFile = TwinFile;

TEST_F(CameraResponseFile, FormsAndRefusals) {
  const auto text = [](const std::string& value) {
    return kHead + kCamera + "[camera.sensor]\nresponse = " + value + "\n" + kFringes;
  };
  EXPECT_TRUE(load(text("\"linear\"")).cameras[0].sensor.response.straight());
  const CameraResponse knee = load(text("{ knee_dn = 120, slope = 0.85 }")).cameras[0].sensor.response;
  EXPECT_NEAR(knee(220.0), 205.0, 1e-12 * 205.0);
  const CameraResponse table =
      load(text("{ table = [[60, 60], [120, 130], [220, 200]] }")).cameras[0].sensor.response;
  EXPECT_NEAR(table(320.0), 270.0, 1e-12 * 270.0);
  const struct {
    const char *value, *says;
  } refused[] = {
      {"2.2", "must be \"linear\", { knee_dn"},
      {"{ knee_dn = 120 }", "slope"},
      {"{ knee_dn = 120, slope = 0 }", "must be > 0"},
      {"{ knee_dn = 120, slope = 0.5, table = [[1, 1], [2, 3]] }", "cannot be combined with knee_dn"},
      {"{ table = [[60, 60]] }", "must have 2 points or more"},
      {"{ table = [[60, 60], [80, 50]] }", "does not rise from [60, 60] to [80, 50]"},
      {"{ table = [[60, 90], [80, 100]] }", "starts with the slope 1.5"},
      {"{ gamma = 2 }", "gamma"},
  };
  for (const auto& r : refused) EXPECT_THAT(error(text(r.value), "response"), HasSubstr(r.says)) << r.value;
}

}  // namespace
}  // namespace fringetwin::testing::camera_response_test
