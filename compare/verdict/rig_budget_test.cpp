// SPDX-License-Identifier: Apache-2.0
// A rig that is not quite what its calibration says: within the stated covariance it is explained, far beyond
// it is not. One camera, one projector, a sphere; the projector's r2 is uncertain by 2e-5 rad (0.034 px).
//
// | check                        | tolerance | origin                                                      |
// |------------------------------|-----------|-------------------------------------------------------------|
// | phase of the whole image     | 3 %       | (1 + tan^2) over the sphere's place in the projector's image |
// | centre and radius of the fit | 5 %       | noise weights of irradiance are others than of gray values  |
#include "compare/verdict/rig_budget.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "compare/comparison.hpp"
#include "compare/refine/refined_budget.hpp"
#include "compare/verdict/calibration_covariance.hpp"
#include "measure/measurement.hpp"
#include "render/sensor/sensor.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare::rig_budget_test {
namespace {

using testing::shared_renderer;

constexpr double kSigmaRad = 2e-5;

class CalibrationInBudget : public ::testing::Test {
 protected:
  void SetUp() override {
    REQUIRE_RENDERER();
    folder_ = testing::scratch_folder("calibration_in_budget");
    testing::write_file(
        folder_ / "twin.toml",
        testing::small_twin({{"gain_dn = 20", "gain_dn = 20\nelectrons_per_dn = 40\nread_noise_dn = 0.5"}}));
    testing::write_file(folder_ / "calibration.json",
                        R"({"schema": "fringetwin-calibration/1", "devices": [{"name": "left"}],
                         "covariance": {"parameters": ["projector.r2"], "matrix": [[4e-10]]}})");
    twin_ = load_twin(folder_ / "twin.toml");
    stated_ = twin_;
    stated_.calibration_uncertainty = folder_ / "calibration.json";
  }

  /// The projector turned by so many sigmas about its r2.
  Twin off_by(double sigmas) const {
    Twin twin = twin_;
    RotTrans rt = rt_from_pose(twin.projector->T_proj_world);
    rt[1] += sigmas * kSigmaRad;
    twin.projector->T_proj_world = pose_from_rt(rt);
    return twin;
  }

  /// What `rig` records, measured with the twin.
  Side side(const Twin& rig, std::uint64_t seed) const {
    const render::RenderedCamera rendered =
        shared_renderer()->render(rig, 0, render::choose_sampling(rig), 0);
    Side out;
    out.images.push_back(render::expose(rendered, rig.cameras[0], 0, seed));
    out.irradiance.push_back(render::as_radiance(rendered));
    out.measurement = measure::measure(twin_, out.images);
    return out;
  }

  Comparison compare_with(const Twin& twin, double sigmas,
                          const std::vector<Twin>& one_error_away = {}) const {
    CompareOptions options;
    options.renderer = shared_renderer();
    options.one_error_away = one_error_away;
    return compare(twin, side(off_by(sigmas), 1), side(twin_, 2), options);
  }

  /// The last line of each budget, without that of the coverage.
  static std::vector<std::string> last_lines(const Comparison& c) {
    std::vector<std::string> out;
    for (const ExplainedRow& row : c.explained)
      if (row.quantity != "coverage") out.push_back(row.lines.back().name);
    return out;
  }

  static std::string text(const Comparison& c) {
    std::string out;
    for (const ExplainedRow& r : c.explained) {
      out += r.quantity + " " + r.region + ": chi2 " + std::to_string(r.chi2) +
             " <= " + std::to_string(r.chi2_limit) + ", regional " + std::to_string(r.regional_chi2) +
             " <= " + std::to_string(r.regional_limit) + "\n";
      for (const BudgetLine& line : r.lines)
        out += "  " + line.name + " " + std::to_string(std::sqrt(line.variance)) + "\n";
    }
    return out;
  }

  void expect_all(const Comparison& c, bool explained) const {
    EXPECT_EQ(c.explained.size(), 4u) << text(c);  // gray, phase, geometry, coverage
    for (const ExplainedRow& row : c.explained)
      if (row.quantity != "coverage") {
        EXPECT_EQ(row.explained(), explained) << row.quantity << "\n" << text(c);
      }
  }

  std::filesystem::path folder_;
  Twin twin_, stated_;
};

TEST_F(CalibrationInBudget, TheRightRigIsExplainedWithAndWithout) {
  expect_all(compare_with(twin_, 0.0), true);
  expect_all(compare_with(stated_, 0.0), true);
}

TEST_F(CalibrationInBudget, TwoSigmasAreExplainedByItOnly) {
  const Comparison without = compare_with(twin_, 2.0), with = compare_with(stated_, 2.0);
  expect_all(without, false);
  expect_all(with, true);
  for (const ExplainedRow& row : without.explained)
    for (const BudgetLine& line : row.lines) EXPECT_NE(line.name, "calibration covariance");
  EXPECT_THAT(last_lines(with), ::testing::Each("calibration covariance"));
  EXPECT_EQ(with.fits[0].z, without.fits[0].z);  // the fits' own errors
}

TEST_F(CalibrationInBudget, TwentySigmasAreNot) { expect_all(compare_with(stated_, 20.0), false); }

TEST_F(CalibrationInBudget, StandardErrorsOfRefinedPlacesAreCountedWhereSomethingFails) {
  const std::vector<Twin> away = {off_by(1.0)};
  const Comparison right = compare_with(twin_, 0.0, away), two = compare_with(twin_, 2.0, away);
  expect_all(right, true);
  EXPECT_THAT(last_lines(right), ::testing::Not(::testing::Contains(kRefinedLine)));  // nothing failed
  expect_all(two, true);
  EXPECT_THAT(last_lines(two), ::testing::Each(kRefinedLine));
  expect_all(compare_with(twin_, 20.0, away), false);
}

TEST_F(CalibrationInBudget, AndRefinedPlacesTogether) {
  // r2 of the calibration and of the refinement, each 2e-5 rad: sigma is the root of two times as much
  const Comparison both = compare_with(stated_, 5.0, {off_by(1.0)});
  EXPECT_THAT(last_lines(both), ::testing::Each("calibration covariance"));
  const auto variance = [](const Comparison& c) { return c.explained.front().lines.back().variance; };
  EXPECT_NEAR(variance(both) / variance(compare_with(stated_, 5.0)), 2.0, 1e-6);
}

// What pixels have of their own is told after the places: the changed rigs have it, too.
TEST_F(CalibrationInBudget, ATextureIsNoChangeOfTheRig) {
  Twin textured = twin_;
  auto texture = std::make_shared<PixelTexture>();
  texture->factor = ImageF(twin_.cameras[0].lens.width(), twin_.cameras[0].lens.height(), 0.5F);
  textured.cameras[0].texture = texture;
  CompareOptions options;
  options.renderer = shared_renderer();
  options.one_error_away = {twin_};  // no change at all
  options.refinement.emplace();
  options.refinement->texture.emplace_back();
  ExplainedRow fails;
  fails.quantity = "geometry", fails.state = kNotExplained, fails.chi2 = 20.0, fails.chi2_limit = 13.0;
  const auto budget = refined_budget(textured, side(twin_, 2), options, {fails});
  ASSERT_TRUE(budget);
  EXPECT_EQ(*std::ranges::max_element(budget->irradiance.at(0).data), 0.0F);
  fails.quantity = "gray";  // single values do not show what a few numbers are off by
  EXPECT_FALSE(refined_budget(textured, side(twin_, 2), options, {fails}));
}

TEST_F(CalibrationInBudget, IsTheFiniteDifferenceOfOneParameter) {
  const auto covariance = read_calibration_covariance(stated_);
  const RigBudget budget =
      rig_budget(twin_, one_sigma_away(twin_, covariance), kCalibrationLine,
                 {.renderer = *shared_renderer(), .sampling = render::choose_sampling(twin_), .nominal = {}});
  EXPECT_EQ(budget.n_directions, 1);
  constexpr double kSteps = 5.0;
  const auto measured = [&](double sigmas) {
    const Twin rig = off_by(sigmas);
    CameraImages images =
        render::as_radiance(shared_renderer()->render(rig, 0, render::choose_sampling(rig), 0));
    images.radiance = false;  // gray values without rounding
    for (GrayImage& image : images.images)
      for (float& value : image.as_floats()) value *= 20.0F;
    return measure::measure(twin_, {images});
  };
  const auto plus = measured(kSteps), minus = measured(-kSteps);
  const double radius =
      (plus.fits[0].numbers.at("radius_mm") - minus.fits[0].numbers.at("radius_mm")) / (2 * kSteps);
  const Eigen::Vector3d center =
      (plus.fits[0].vectors.at("center_mm") - minus.fits[0].vectors.at("center_mm")) / (2 * kSteps);
  const RigBudget::Fit& fit = budget.fits.at("ball");
  EXPECT_NEAR(std::sqrt(fit.numbers.at("radius_mm")), std::abs(radius), 0.1 * std::abs(radius));
  EXPECT_NEAR(std::sqrt(fit.vectors.at("center_mm").z()), std::abs(center.z()), 0.02 * std::abs(center.z()));
  // pixel (80, 60) sees the sphere where it always did, lit by another column
  const ImageF& phase = budget.phase_rad2[0][0];
  const Eigen::Vector3d ray = twin_.cameras[0].lens.unproject({80.0, 60.0}).value();
  const Eigen::Vector3d middle(0, 0, 270);
  const double b = ray.dot(middle);
  const Eigen::Vector3d p = (b - std::sqrt(b * b - middle.squaredNorm() + 19.0 * 19.0)) * ray;
  const auto column = [&](double sigmas) {
    const Projector projector = off_by(sigmas).projector.value();
    return projector.lens.project(projector.T_proj_world * p).value().x();
  };
  const double expected = kTwoPi / 13.0 * std::abs(column(kSteps) - column(-kSteps)) / (2 * kSteps);
  EXPECT_NEAR(std::sqrt(static_cast<double>(phase(80, 60))), expected, 0.01 * expected);
  EXPECT_EQ(phase(2, 2), 0.0F);
}

}  // namespace
}  // namespace fringetwin::compare::rig_budget_test
