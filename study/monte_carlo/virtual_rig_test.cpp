// SPDX-License-Identifier: Apache-2.0
// The chain under Monte Carlo: rigs drawn from the calibration's covariance record a sphere, the nominal twin
// measures it. Against linear propagation, and where that fails. The noise is one and the same in all trials,
// so that differences of the chain are derivatives of what the trials vary.
// | check                              | tolerance | origin                                                |
// |------------------------------------|-----------|-------------------------------------------------------|
// | sigma of centre and radius, linear | 10 %      | 1/sqrt(2 x 300) = 4 % of chance, fixed seed           |
// | mean of a square                   | 30 %      | sqrt(2/200) = 10 % of chance, three times             |
// | sigma of a square                  | 30 %      | sqrt(14/4/200) = 13 % of chance, two times, fixed seed |
#include <gtest/gtest.h>

#include <cmath>

#include "measure/measurement.hpp"
#include "render/sensor/sensor.hpp"
#include "study/monte_carlo/monte_carlo_study.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::study::virtual_rig_test {
namespace {

using Numbers = std::map<std::string, double>;

/// What the drawn rig records, measured with the nominal twin.
Numbers measured(const VirtualRig& rig, const StudyPoint& point) {
  const Twin drawn = rig.drawn(point.settings);
  const render::RenderedCamera rendered =
      testing::shared_renderer()->render(drawn, 0, render::choose_sampling(drawn), 0);
  const auto m = measure::measure(rig.nominal(), {render::expose(rendered, drawn.cameras[0], 0, point.seed)});
  if (m.fits.empty() || !m.fits[0].usable) return {};
  const Eigen::Vector3d& center = m.fits[0].vectors.at("center_mm");
  return {
      {"radius", m.fits[0].numbers.at("radius_mm")}, {"x", center[0]}, {"y", center[1]}, {"z", center[2]}};
}

/// One camera, one projector, a ball; the calibration of these parameters.
VirtualRig virtual_rig(const std::string& folder_name, const std::string& noise,
                       const std::string& covariance) {
  const auto folder = testing::scratch_folder(folder_name);
  testing::write_file(folder / "twin.toml",
                      testing::small_twin({{"gain_dn = 20", "gain_dn = 20\n" + noise}},
                                          "[uncertainty]\ncalibration = \"calibration.json\"\n"
                                          "[render]\nsamples = 4\nsampler = \"gauss\"\n"));
  testing::write_file(
      folder / "calibration.json",
      R"({"schema": "fringetwin-calibration/1", "devices": [{"name": "left"}], "covariance": )" + covariance +
          "}");
  return VirtualRig(folder / "twin.toml", true);
}

MonteCarloResult trials(const VirtualRig& rig, const UncertainInputs& inputs, std::size_t n) {
  MonteCarloPlan plan;
  plan.inputs = inputs;
  plan.rule.block_trials = n;
  plan.most_trials = n;
  return run_monte_carlo(plan, [&](const std::vector<StudyPoint>& points) {
    std::vector<PointOutcome> out;
    for (const StudyPoint& point : points) {
      out.emplace_back();
      out.back().id = point.id;
      out.back().numbers = measured(rig, point);
    }
    return out;
  });
}

/// One input off by so many deviates, keys first.
Numbers at(const VirtualRig& rig, const UncertainInputs& inputs, std::size_t input, double deviate) {
  InputDraw draw;
  draw.deviates.assign(inputs.keys.size(), 0.0);
  draw.calibration.assign(inputs.calibration, 0.0);
  (input < inputs.keys.size() ? draw.deviates[input] : draw.calibration[input - inputs.keys.size()]) =
      deviate;
  return measured(rig, point_of(inputs, 0, draw));
}

TEST(VirtualRigMonteCarlo, AgreesWithLinearPropagationWhereThatHolds) {
  REQUIRE_RENDERER();
  const VirtualRig rig = virtual_rig("virtual_rig_linear", "electrons_per_dn = 40\nread_noise_dn = 2", R"(
      {"parameters": ["projector.r2", "projector.t1", "left.fx"],
       "matrix": [[4e-10, -1e-7, 0], [-1e-7, 1e-4, 0.0005], [0, 0.0005, 0.01]]})");
  UncertainInputs inputs;
  inputs.keys.push_back({"depth", {"object.ball.center_mm[2]"}, {270.0}, Distribution::uniform, 0.02});
  inputs.keys.push_back({"side", {"object.ball.center_mm[1]"}, {0.0}, Distribution::normal, 0.01});
  inputs.calibration = rig.calibration_directions();
  inputs.noise = false;
  const auto result = trials(rig, inputs, 300);
  EXPECT_EQ(result.failed, 0u);

  Numbers variance;
  for (std::size_t input = 0; input < inputs.keys.size() + inputs.calibration; ++input) {
    const double sigma = input == 0 ? 1.0 / std::sqrt(3.0) : 1.0;  // of the deviate; the first is uniform
    const Numbers up = at(rig, inputs, input, sigma), down = at(rig, inputs, input, -sigma);
    for (const auto& [name, value] : up) variance[name] += std::pow(0.5 * (value - down.at(name)), 2);
  }
  ASSERT_EQ(variance.size(), 4u);
  for (const auto& [name, v] : variance) {
    EXPECT_EQ(result.numbers.at(name).summary.n, 300u);
    EXPECT_NEAR(result.numbers.at(name).summary.sigma, std::sqrt(v), 0.10 * std::sqrt(v)) << name;
    RecordProperty(name + "_ratio", std::to_string(result.numbers.at(name).summary.sigma / std::sqrt(v)));
  }
}

// The ball, the camera and the projector lie in the plane y = 0: a roll of the projector shows everything but
// y the same whichever way it goes, so that the derivative is zero and the effect a square.
TEST(VirtualRigMonteCarlo, IsRightWhereLinearPropagationIsNot) {
  REQUIRE_RENDERER();
  const VirtualRig rig = virtual_rig("virtual_rig_square", "", R"(
      {"parameters": ["projector.r3"], "matrix": [[4e-4]]})");
  UncertainInputs inputs;
  inputs.calibration = rig.calibration_directions();
  inputs.noise = false;
  const auto result = trials(rig, inputs, 200);
  EXPECT_EQ(result.failed, 0u);
  const Numbers middle = at(rig, inputs, 0, 0.0), up = at(rig, inputs, 0, 1.0),
                down = at(rig, inputs, 0, -1.0);
  for (const std::string name : {"radius", "z"}) {
    const SampleSummary& s = result.numbers.at(name).summary;
    const double slope = 0.5 * (up.at(name) - down.at(name)),
                 square = 0.5 * (up.at(name) + down.at(name)) - middle.at(name);
    EXPECT_LT(std::abs(slope), 0.1 * s.sigma) << name << ": linear propagation sees nothing";
    EXPECT_NEAR((s.mean - middle.at(name)) / square, 1.0, 0.30) << name;
    EXPECT_NEAR(s.sigma / std::abs(square), std::sqrt(2.0), 0.30 * std::sqrt(2.0)) << name;
  }
}

}  // namespace
}  // namespace fringetwin::study::virtual_rig_test
