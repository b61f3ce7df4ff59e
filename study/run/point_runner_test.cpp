// SPDX-License-Identifier: Apache-2.0
// Shared light is the same light, bit for bit: against a run of each point alone, and the images of `render`
// where the trace is as exact as the point's own would be.
//
// | tolerance      | unit                   | origin                                                    |
// | 2 gray_error   | fraction of full scale | where it is more exact: both are within the target (rms)  |
#include "study/run/point_runner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::point_runner_test {
namespace {

using study::PlannedPoint;
using study::PointOutcome;
using study::PointRunner;
using study::StudyPoint;
using study::TraceDemand;
using ::testing::HasSubstr;

const std::string depth = "camera.left.sensor.bit_depth", gain = "camera.left.sensor.gain_dn",
                  electrons = "camera.left.sensor.electrons_per_dn";

std::map<std::string, std::uint64_t> bits(const PointOutcome& o) {
  std::map<std::string, std::uint64_t> all;
  for (const auto& [name, value] : o.numbers) all[name] = std::bit_cast<std::uint64_t>(value);
  return all;
}

double rms_difference(const ImageF& a, const ImageF& b) {
  if (a.size() != b.size()) return HUGE_VAL;
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += std::pow(static_cast<double>(a.data[i]) - static_cast<double>(b.data[i]), 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

struct Shared {
  int traced = 0;     ///< points that were traced
  int identical = 0;  ///< points compared with `render` bit for bit
};
/// The points through one runner, and each through one of its own.
Shared check_sharing(const std::string& toml, const std::vector<StudyPoint>& points) {
  const auto file = scratch_folder("point_runner") / "twin.toml";
  write_file(file, toml);
  render::Renderer renderer;
  PointRunner sharing({file, {}}, renderer);
  Shared out;
  int& traced = out.traced;
  int& identical = out.identical;
  for (const PlannedPoint& planned : study::plan_traces(file, points)) {
    const PointOutcome together = sharing.run(planned);
    EXPECT_FALSE(together.failed) << together.reason;
    EXPECT_FALSE(together.numbers.empty());
    traced += together.traced ? 1 : 0;

    PointRunner one({file, {}}, renderer);
    const PointOutcome alone = one.run(planned);
    EXPECT_TRUE(alone.traced);
    EXPECT_EQ(bits(together), bits(alone)) << "point " << planned.point.id;

    const Twin twin = load_twin(file, planned.point.settings);
    const TraceDemand own = TraceDemand::of(twin);
    const render::Sampling sampling = render::choose_sampling(twin);
    const bool as_exact = sampling.sampler != Sampler::adaptive || planned.demand == own;
    for (std::size_t i = 0; i < twin.cameras.size(); ++i) {
      const auto rendered = renderer.render(twin, i, sampling, planned.point.seed);
      EXPECT_EQ(rendered.irradiance.size(), sharing.rendered()[i].irradiance.size());
      for (std::size_t k = 0; k < rendered.irradiance.size(); ++k) {
        const ImageF &a = rendered.irradiance[k], &b = sharing.rendered()[i].irradiance[k];
        if (as_exact)
          EXPECT_EQ(a.data, b.data) << "point " << planned.point.id << ", image " << k;
        else
          EXPECT_LT(rms_difference(a, b), 2.0 * sampling.gray_error * own.sensors[i].irradiance());
      }
    }
    identical += as_exact ? 1 : 0;
  }
  return out;
}

std::vector<StudyPoint> varied() {
  return {{0, {}, 1},
          {1, {}, 2},
          {2, {{electrons, "40.2"}}, 1},
          {3, {{electrons, "40.2"}}, 2},
          {4, {{depth, "12"}, {gain, "320.0"}}, 1},
          {5, {{"fringes.steps", "8"}}, 1},
          {6, {{"fringes.steps", "3"}, {"fringes.mean", "0.4"}, {"fringes.amplitude", "0.3"}}, 1},
          {7, {{"camera.left.psf_px", "0.8"}}, 1},
          {8, {}, 3}};
}

TEST(PointRunner, SharedPointsAreThoseOfUnsharedRuns) {
  FT_NEED_DEVICE();
  const Shared shared = check_sharing(small_twin(), varied());
  EXPECT_EQ(shared.traced, 1);
  EXPECT_EQ(shared.identical, 7)
      << "all but the deeper sensor's, which has a lower full scale, and the weaker light's";
}

// The points of one plan meet the demand of all of them; a next plan's may be another.
TEST(PointRunner, ATraceForAnotherDemandIsNotTakenOver) {
  FT_NEED_DEVICE();
  const auto file = scratch_folder("point_runner_demand") / "twin.toml";
  write_file(file, small_twin());
  render::Renderer renderer;
  PointRunner runner({file, {}}, renderer), fresh({file, {}}, renderer);
  const auto strict = study::plan_traces(file, {{0, {{depth, "12"}, {gain, "400.0"}}, 1}, {1, {}, 1}}),
             alone = study::plan_traces(file, {{1, {}, 1}});
  runner.run(strict[0]);
  EXPECT_FALSE(runner.run(strict[1]).traced);
  const PointOutcome again = runner.run(alone[0]);
  EXPECT_TRUE(again.traced);
  EXPECT_EQ(bits(again), bits(fresh.run(alone[0])));
}

TEST(PointRunner, SharedWithFixedSamplesAndInDoublePrecision) {
  FT_NEED_DEVICE();
  const Shared fixed = check_sharing(small_twin({}, "[render]\nsamples = 4\n"), varied());
  EXPECT_EQ(fixed.traced, 1);
  EXPECT_EQ(fixed.identical, 9);
  EXPECT_EQ(check_sharing(small_twin({}, "[render]\nphase_error_rad = 1e-6\n"), varied()).traced, 1);
}

TEST(PointRunner, AResponseOrGrayCodeSharesWhatItCan) {
  FT_NEED_DEVICE();
  // points 5 and 6 change the steps: the others around them share what came last
  const std::string gamma = small_twin({{"intensity = 40", "intensity = 40\nresponse = { gamma = 2.2 }"}});
  EXPECT_EQ(check_sharing(gamma, varied()).traced, 4);
  const std::string gray = small_twin({{"pitches_px = [13, 14, 15]", "pitches_px = [20]\nunwrap = \"gray\""},
                                       {"steps = 4\n", "steps = 4\n[fringes.gray]\nbits = 6\n"}});
  EXPECT_EQ(check_sharing(gray, varied()).traced, 4);
}

TEST(PointRunner, FaultsAreOutcomesAndLeaveNothingBehind) {
  FT_NEED_DEVICE();
  const auto file = scratch_folder("point_runner_faults") / "twin.toml";
  write_file(file, small_twin());
  const auto plan = study::plan_traces(file, {{0, {}, 1},
                                              {1, {{depth, "99"}}, 1},
                                              {2, {{"object.ball.center_mm", "[0, 0, 5]"}}, 1},
                                              {3, {{"object.ball.center_mm", "[900, 0, 270]"}}, 1},
                                              {4, {}, 1}});
  render::Renderer renderer;
  PointRunner runner({file, {}}, renderer);
  std::vector<PointOutcome> outcomes;
  for (const PlannedPoint& p : plan) outcomes.push_back(runner.run(p));
  EXPECT_THAT(outcomes[1].reason, HasSubstr("bit_depth"));
  EXPECT_THAT(outcomes[2].reason, HasSubstr("inside the sphere \"ball\""));
  EXPECT_THAT(outcomes[3].reason, HasSubstr("no camera sees any object"));
  for (const int bad : {1, 2, 3}) {
    EXPECT_TRUE(outcomes[static_cast<std::size_t>(bad)].failed);
    EXPECT_TRUE(outcomes[static_cast<std::size_t>(bad)].numbers.empty());
  }
  EXPECT_FALSE(outcomes[0].failed) << outcomes[0].reason;
  EXPECT_EQ(bits(outcomes[0]), bits(outcomes[4]));
}

}  // namespace
}  // namespace fringetwin::testing::point_runner_test
