// SPDX-License-Identifier: Apache-2.0
// tolerance: none, sharing is decided, not measured. That shared light is the same light: point_runner_test.
#include "study/run/trace_share.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::trace_share_test {
namespace {

using study::PlannedPoint;
using study::Settings;
using study::StudyPoint;

std::filesystem::path twin_file(const std::string& toml) {
  const auto file = scratch_folder("trace_share") / "twin.toml";
  write_file(file, toml);
  return file;
}

std::vector<std::size_t> groups(const std::string& toml, const std::vector<StudyPoint>& points) {
  std::vector<std::size_t> all;
  for (const PlannedPoint& p : study::plan_traces(twin_file(toml), points)) all.push_back(p.group);
  return all;
}

bool share(const std::string& toml, const Settings& a, const Settings& b) {
  const auto g = groups(toml, {{0, a, 1}, {1, b, 2}});
  return g[0] == g[1];
}

TEST(TraceShare, SensorStepsAndMeasurementLeaveTheLightAlone) {
  for (const auto& [key, value] : Settings{{"camera.left.sensor.bit_depth", "12"},
                                           {"camera[0].sensor.gain_dn", "300.0"},
                                           {"camera.left.sensor.electrons_per_dn", "40"},
                                           {"camera.left.sensor", "{ bit_depth = 10 }"},
                                           {"camera.left.sensor.prnu", "\"factors.exr\""},
                                           {"camera.left.sensor.dsnu", "\"offsets.exr\""},
                                           {"fringes.steps", "8"},
                                           {"fringes.amplitude", "0.3"},
                                           {"camera.left.psf_px", "0.7"},
                                           {"measure.min_modulation_dn", "2"},
                                           {"name", "\"other\""}})
    EXPECT_TRUE(share(small_twin(), {}, {{key, value}})) << key << " = " << value;
}

TEST(TraceShare, LightOfImagesLeavesTheTraceAlone) {
  const auto factors = [](double third) {
    return fmt::format("[1, 1, {}, 1, 1, 1, 1, 1, 1, 1, 1, 1]", third);
  };
  EXPECT_TRUE(share(small_twin(), {}, {{"projector.light_factors", factors(1.02)}}));
  EXPECT_TRUE(share(small_twin(), {}, {{"camera.left.exposure_factors", factors(0.97)}}));
  const std::string flickers =
      small_twin({{"intensity = 40", "intensity = 40\nlight_factors = " + factors(1.01)}});
  EXPECT_TRUE(share(flickers, {}, {{"projector.light_factors[2]", "0.99"}}));
}

TEST(TraceShare, EverythingElseSeparates) {
  for (const auto& [key, value] : Settings{{"fringes.pitches_px", "[26, 28, 30]"},
                                           {"fringes.phase_origin_px", "1.0"},
                                           {"projector.blur_px", "1.0"},
                                           {"projector.intensity", "41"},
                                           {"object.ball.radius_mm", "18.5"},
                                           {"camera.left.rt_cam_world", "[0, 0, 0, 0.1, 0, 0]"},
                                           {"render.gray_error", "1e-3"},
                                           {"camera.left.intrinsics[0]", "261"}})
    EXPECT_FALSE(share(small_twin(), {}, {{key, value}})) << key << " = " << value;
}

TEST(TraceShare, StepsSeparateWhereTheTraceHoldsThem) {
  const Settings steps{{"fringes.steps", "8"}}, sensor{{"camera.left.sensor.bit_depth", "12"}};
  const std::string gamma = small_twin({{"intensity = 40", "intensity = 40\nresponse = { gamma = 2.2 }"}});
  EXPECT_FALSE(share(gamma, {}, steps));
  EXPECT_FALSE(share(gamma, {}, {{"fringes.mean", "0.4"}, {"fringes.amplitude", "0.4"}}));
  EXPECT_TRUE(share(gamma, {}, sensor));
  const std::string gray = small_twin({{"pitches_px = [13, 14, 15]", "pitches_px = [20]\nunwrap = \"gray\""},
                                       {"steps = 4\n", "steps = 4\n[fringes.gray]\nbits = 6\n"}});
  EXPECT_FALSE(share(gray, {}, steps));
  EXPECT_TRUE(share(gray, {}, sensor));
}

TEST(TraceShare, RandomSamplesBelongToTheirSeed) {
  EXPECT_EQ(groups(small_twin(), {{0, {}, 1}, {1, {}, 2}}), (std::vector<std::size_t>{0, 0}));
  const std::string random = small_twin({}, "[render]\nsamples = 16\nsampler = \"multi-jittered\"\n");
  EXPECT_EQ(groups(random, {{0, {}, 1}, {1, {}, 2}, {2, {{"camera.left.sensor.bit_depth", "12"}}, 1}}),
            (std::vector<std::size_t>{0, 1, 0}));
}

TEST(TraceShare, LightBetweenSurfacesIsDrawnAnewForEachSeed) {
  const std::string bounces = small_twin({}, "[render]\nbounces = 1\n");
  EXPECT_EQ(groups(bounces, {{0, {}, 1}, {1, {}, 2}, {2, {}, 1}}), (std::vector<std::size_t>{0, 1, 0}));
}

TEST(TraceShare, AnUnreadablePointStandsAlone) {
  const Settings bad{{"camera.left.sensor.bit_depth", "99"}};
  EXPECT_EQ(groups(small_twin(), {{0, {}, 1}, {1, bad, 1}, {2, bad, 2}, {3, {}, 2}}),
            (std::vector<std::size_t>{0, 1, 2, 0}));
}

// 255/20 = 12.75, 4095/400 = 10.2, 1023/60 = 17.1
TEST(TraceShare, TheTraceIsMadeForTheMostDemandingPoints) {
  const std::string depth = "camera.left.sensor.bit_depth", gain = "camera.left.sensor.gain_dn";
  for (const PlannedPoint& p : study::plan_traces(
           twin_file(small_twin()), {{0, {}, 1},
                                     {1, {{depth, "12"}, {gain, "400.0"}}, 1},
                                     {2, {{depth, "10"}, {gain, "60.0"}}, 1},
                                     {3, {{"fringes.mean", "0.6"}, {"fringes.amplitude", "0.4"}}, 1}})) {
    ASSERT_EQ(p.demand.sensors.size(), 1U);
    EXPECT_EQ(p.demand.sensors[0].bit_depth, 12);
    EXPECT_EQ(p.demand.sensors[0].gain_dn, 400.0);
    EXPECT_EQ(p.demand.mean, 0.6);
    EXPECT_EQ(p.demand.amplitude, 0.5);
  }
}

}  // namespace
}  // namespace fringetwin::testing::trace_share_test
