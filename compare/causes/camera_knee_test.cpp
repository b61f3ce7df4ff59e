// SPDX-License-Identifier: Apache-2.0
// Knees of two cameras, planted into gray values with noise that the double-precision reference's light
// makes, are found by the fit that `--refine camera_knee` and the search for causes make.
//
// | check            | tolerance | origin                                                            |
// |------------------|-----------|-------------------------------------------------------------------|
// | planted value    | 3 sigma   | required; six numbers, normal: one seed in 62                     |
// | sigma of a place | 1 DN      | 0.3 DN of noise, 46,080 values, a bend of 5 % and more: 0.3 DN    |
// | sigma of a slope | 2e-3      | the same over 100 DN: 0.3/100/sqrt(5000)                          |
// | chi2             | 1.02      | 46,080 values: sqrt(2/n) = 0.0066                                 |
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "compare/causes/camera_curves.hpp"
#include "compare/causes/group_fit.hpp"
#include "compare/causes/parameters.hpp"
#include "tests/support/compare/planted_samples.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::camera_knee_test {
namespace {

using namespace planted_samples;

struct Knee {
  double at_dn, slope;
  double operator()(double dn) const { return dn > at_dn ? at_dn + slope * (dn - at_dn) : dn; }
};

/// Returns this light as cameras with these knees see it.
Error through(const Knee& left, const Knee& right) {
  return [=](double e, std::size_t camera, int, int, int) {
    return (camera == 0 ? left : right)(kGain * e) / kGain;
  };
}

/// Returns gray values of this light through these knees. The gain that curves are told at is 5 % off, as one
/// is that a straight line through bent gray values gave.
std::vector<GridSamples> bent(const Images& light, const Knee& left, const Knee& right,
                              const std::vector<CameraImages>& frames) {
  std::vector<GridSamples> samples = samples_of(light, through(left, right), frames);
  for (GridSamples& s : samples) s.reference_gain_dn = 0.95 * kGain;
  return samples;
}

GroupFit::Known known_of(const GroupFit& fit, const std::string& name) {
  for (std::size_t k = 0; k < fit.parameters().size(); ++k)
    if (fit.parameters()[k].name == name) return fit.known()[k];
  ADD_FAILURE() << "no parameter " << name;
  return {};
}

void expect_knee(const GroupFit& fit, const std::string& camera, const Knee& planted) {
  SCOPED_TRACE(camera);
  const GroupFit::Known place = known_of(fit, camera + ".response.knee_dn"),
                        slope = known_of(fit, camera + ".response.slope");
  EXPECT_TRUE(place.told);
  EXPECT_NEAR(place.value, planted.at_dn, 3.0 * place.sigma);
  EXPECT_LT(place.sigma, 1.0);
  EXPECT_TRUE(slope.told);
  EXPECT_NEAR(slope.value, planted.slope, 3.0 * slope.sigma);
  EXPECT_LT(slope.sigma, 2e-3);
}

/// Fits until it rests, and holds the knees of both cameras against those that were planted.
void expect_knees(GroupFit& fit, const Knee& left, const Knee& right) {
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_LT(fit.chi2(), 1.02);
  expect_knee(fit, "left", left);
  expect_knee(fit, "right", right);
}

/// Returns what lies between a part of the window's gray values and the others; the light of the reference.
double level_dn(const Images& light, std::size_t camera, double part) {
  std::vector<float> all;
  for (const ImageF& image : light[camera]) all.insert(all.end(), image.data.begin(), image.data.end());
  std::ranges::sort(all);
  return kGain * static_cast<double>(all[static_cast<std::size_t>(part * static_cast<double>(all.size()))]);
}

TEST(CameraKnee, KneesAreRefinedBack) {
  const Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  const Images light = traced_by_reference(twin);
  const Knee left{level_dn(light, 0, 0.7), 0.9}, right{level_dn(light, 1, 0.4), 0.55};
  const std::vector<CameraImages> frames = frames_of(light);
  Sensitivity sensitivity(testing::needed_renderer(), bent(light, left, right, frames));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "camera_knee"), {.exact = true});
  expect_knees(fit, left, right);
  const CameraResponse response = fit.twin().cameras[1].sensor.response;
  ASSERT_EQ(response.corners.size(), 1u);
  EXPECT_DOUBLE_EQ(response.corners[0].in_dn, known_of(fit, "right.response.knee_dn").value);
  // gain and black level are those of the line below the knee
  for (const GridSamples& s : sensitivity.samples()) {
    EXPECT_NEAR(s.gain_dn, kGain, 0.02);
    EXPECT_NEAR(s.black_level_dn, kBlack, 0.2);
  }
}

// Light that differs from image to image goes through the knee: what it changes in bent gray values is not
// what it changes in the light.
TEST(CameraKnee, BesidesLightThatFlickers) {
  const Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  Twin truth = twin;
  for (int k = 0; k < 12; ++k) truth.projector->light_factors.push_back(1.0 + 0.05 * std::sin(2.0 + 5.0 * k));
  const Images light = traced_by_reference(truth);
  const Knee left{level_dn(light, 0, 0.6), 0.6}, right{level_dn(light, 1, 0.6), 0.7};
  const std::vector<CameraImages> frames = frames_of(light);
  Sensitivity sensitivity(testing::needed_renderer(), bent(light, left, right, frames));
  std::vector<Parameter> parameters = parameters_of(twin, "camera_knee");
  for (Parameter& p : parameters_of(twin, "light")) parameters.push_back(std::move(p));
  GroupFit fit(sensitivity, twin, parameters, {.exact = true});
  expect_knees(fit, left, right);
  double mean = 0.0;
  for (const double factor : truth.projector->light_factors) mean += std::log(factor) / 12.0;
  for (int k = 1; k < 12; ++k) {
    const GroupFit::Known known = known_of(fit, "image_" + std::to_string(k) + ".light");
    EXPECT_NEAR(known.value, std::log(truth.projector->light_factors[static_cast<std::size_t>(k)]) - mean,
                3.5 * known.sigma)
        << k;
  }
}

// Gray values are straightened by the knee that the twin has, which is another than the camera's.
TEST(CameraKnee, GoesOnFromTheKneeOfTheTwin) {
  Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  const Images light = traced_by_reference(twin);
  const Knee left{level_dn(light, 0, 0.6), 0.8}, right{level_dn(light, 1, 0.5), 0.55};
  const Knee believed[] = {{left.at_dn - 20.0, 0.65}, {right.at_dn + 25.0, 0.7}};
  for (std::size_t c = 0; c < 2; ++c)
    twin.cameras[c].sensor.response = knee_response(believed[c].at_dn, believed[c].slope);
  const std::vector<CameraImages> frames = frames_of(light);
  std::vector<GridSamples> samples = samples_of(
      light,
      [&](double e, std::size_t c, int, int, int) {
        const double dn = (c == 0 ? left : right)(kGain * e), over = dn - believed[c].at_dn;
        return (over > 0.0 ? believed[c].at_dn + over / believed[c].slope : dn) / kGain;
      },
      frames);
  for (GridSamples& s : samples) s.gain_dn = s.reference_gain_dn = 1.04 * kGain;
  Sensitivity sensitivity(testing::needed_renderer(), std::move(samples));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "camera_knee"), {.exact = true});
  expect_knees(fit, left, right);
}

// A straight camera has no knee: the slope is 1.
TEST(CameraKnee, AStraightCameraHasNone) {
  const Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  const Images light = traced_by_reference(twin);
  const std::vector<CameraImages> frames = frames_of(light);
  Sensitivity sensitivity(testing::needed_renderer(), samples_of(light, same, frames));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "camera_knee"), {.exact = true});
  fit.run();
  EXPECT_LT(fit.chi2(), 1.02);
  for (const char* camera : {"left", "right"}) {
    const GroupFit::Known slope = known_of(fit, std::string(camera) + ".response.slope");
    EXPECT_NEAR(slope.value, 1.0, 4.0 * slope.sigma) << camera;
  }
}

}  // namespace
}  // namespace fringetwin::compare::camera_knee_test
