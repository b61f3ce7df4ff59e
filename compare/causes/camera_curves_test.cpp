// SPDX-License-Identifier: Apache-2.0
// Knees and smooth bends of two cameras, planted into gray values with noise that the double-precision
// reference's light makes, are found by the fit that `--refine camera_knee` and `camera_response` and the
// search for causes make.
//
// | check            | tolerance | origin                                                            |
// |------------------|-----------|-------------------------------------------------------------------|
// | planted value    | 3 sigma   | required; six numbers, normal: one seed in 62                     |
// | sigma of a place | 1 DN      | 0.3 DN of noise, 46,080 values, a bend of 5 % and more: 0.3 DN    |
// | sigma of a slope | 2e-3      | the same over 100 DN: 0.3/100/sqrt(5000)                          |
// | chi2             | 1.02      | 46,080 values: sqrt(2/n) = 0.0066                                 |
// | curve as fitted  | 0.1 DN    | 3 sigma at the ends of the levels of 1,920 pixels, polynomials of four |
// | table of a curve | 0.04 DN   | second derivative 2*0.08 + 10*0.04 + 50*0.02 over 0.9 R, steps of R/40:
// R 1.7/1600/8 |
#include "compare/parameters/camera_curves.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "compare/causes/group_fit.hpp"
#include "compare/causes/own_levels.hpp"
#include "compare/parameters/parameters.hpp"
#include "tests/support/compare/planted_samples.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare::camera_curves_test {
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

/// Gives every pixel a factor of 0.6 to 1.4 and an offset of up to 12 DN, before the camera's curve.
Error textured(const Error& curve) {
  return [=](double e, std::size_t camera, int image, int x, int y) {
    const double factor = 1.0 + 0.4 * std::sin(0.9 * x + 0.3 * y + static_cast<double>(camera)),
                 offset_dn = 6.0 + 6.0 * std::sin(0.5 * x - 0.8 * y);
    return curve(factor * e + offset_dn / kGain, camera, image, x, y);
  };
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

// A factor and an offset of every pixel: a level is what the pixel has of its own, not what the twin says.
TEST(CameraKnee, IsFoundAtTheLevelsOfPixelsOfTheirOwn) {
  const Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  const Images light = traced_by_reference(twin);
  const Knee left{level_dn(light, 0, 0.4), 0.85}, right{level_dn(light, 1, 0.3), 0.6};
  const std::vector<CameraImages> frames = frames_of(light);
  Sensitivity sensitivity(testing::needed_renderer(),
                          samples_of(light, textured(through(left, right)), frames));
  sensitivity.free_in_all(FreePerPixel::factor_and_offset);
  GroupFit fit(sensitivity, twin, parameters_of(twin, "camera_knee"), {.hold_gain = true, .exact = true});
  expect_knees(fit, left, right);
}

/// Gray values that saturate: straight up to a twentieth of the range, then less and less steep, by an
/// exponential that no polynomial is.
struct Saturating {
  double range_dn, length;
  double operator()(double dn) const {
    const double over = std::max(0.0, dn / range_dn - 0.05);
    return std::min(dn, 0.05 * range_dn) + range_dn * length * (1.0 - std::exp(-over / length));
  }
};

double range_dn(const Twin& twin) {
  const Sensor& sensor = twin.cameras[0].sensor;
  return sensor.max_dn() - sensor.black_level_dn;
}

/// Fits the bends of both cameras and holds the curves against those planted, over the levels of the images.
void expect_bends(GroupFit& fit, const Images& light, const Saturating (&planted)[2], double most_factor) {
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_LT(fit.chi2(), 1.02);
  for (std::size_t c = 0; c < 2; ++c) {
    const CameraResponse fitted = fit.twin().cameras[c].sensor.response;
    for (const double part : {0.05, 0.3, 0.6, 0.95}) {
      const double dn = most_factor * level_dn(light, c, part);
      EXPECT_NEAR(fitted(dn), planted[c](dn), 0.1) << c << ' ' << dn;
    }
  }
}

TEST(CameraBend, IsRefinedBack) {
  const Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  const Images light = traced_by_reference(twin);
  const Saturating planted[] = {{range_dn(twin), 8.0}, {range_dn(twin), 3.0}};
  const std::vector<CameraImages> frames = frames_of(light);
  std::vector<GridSamples> samples = samples_of(
      light, [&](double e, std::size_t c, int, int, int) { return planted[c](kGain * e) / kGain; }, frames);
  for (GridSamples& s : samples) s.reference_gain_dn = 0.95 * kGain;
  Sensitivity sensitivity(testing::needed_renderer(), std::move(samples));
  GroupFit fit(sensitivity, twin, refinable_parameters_of(twin, "camera_response"), {.exact = true});
  expect_bends(fit, light, planted, 1.0);
  for (const GridSamples& s : sensitivity.samples()) EXPECT_NEAR(s.gain_dn, kGain, 0.03);
}

TEST(CameraBend, IsFoundAtTheLevelsOfPixelsOfTheirOwn) {
  const Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  const Images light = traced_by_reference(twin);
  const Saturating planted[] = {{range_dn(twin), 8.0}, {range_dn(twin), 3.0}};
  const std::vector<CameraImages> frames = frames_of(light);
  Sensitivity sensitivity(testing::needed_renderer(),
                          samples_of(light, textured([&](double e, std::size_t c, int, int, int) {
                                       return planted[c](kGain * e) / kGain;
                                     }),
                                     frames));
  sensitivity.free_in_all(FreePerPixel::factor_and_offset);
  GroupFit fit(sensitivity, twin, refinable_parameters_of(twin, "camera_response"),
               {.hold_gain = true, .exact = true});
  expect_bends(fit, light, planted, 1.0);
}

// Levels of a pixel by plain numbers: 5 images, of which one has other exposure and one other light.
TEST(OwnLevels, AreThoseOfThePixelsNumbers) {
  const std::vector<float> e{1.0F, 2.0F, 4.0F, 3.0F, 5.0F};
  const std::vector<double> exposure{1.0, 1.1, 1.0, 1.0, 1.0};
  struct Own {
    FreePerPixel free;
    double factor, offset;
  };
  for (const Own& own : {Own{FreePerPixel::factor_and_offset, 0.6, 0.4}, Own{FreePerPixel::factor, 1.7, 0.0},
                         Own{FreePerPixel::offset, 1.0, 0.4}, Own{FreePerPixel::nothing, 1.0, 0.0}}) {
    GridSamples s;
    s.gain_dn = 20.0, s.black_level_dn = 7.0;
    s.cell = {0}, s.images = {0, 1, 2, 3, 4};
    s.light = {1.0, 1.0, 1.0, 1.3, 1.0};
    std::vector<double> level;
    for (std::size_t k = 0; k < e.size(); ++k) {
      level.push_back(s.light[k] * (own.factor * static_cast<double>(e[k]) + own.offset * exposure[k]));
      s.real_dn.push_back(static_cast<float>(20.0 * level[k] + 7.0));
      s.weight.push_back(1.0F);
    }
    s.real_dn[4] = 255.0F, s.weight[4] = 0.0F;  // not used
    const OwnLevels levels(s, e, real_light(s), own.free, exposure);
    std::vector<float> values = e;
    levels.to_levels(values);
    for (std::size_t k = 0; k < e.size(); ++k) EXPECT_NEAR(values[k], level[k], 1e-5) << k;
    levels.to_irradiance(values);
    for (std::size_t k = 0; k < e.size(); ++k) EXPECT_NEAR(values[k], e[k], 1e-5) << k;
  }
}

// A pixel that sees nothing of the light has no factor to bend by: its level is its offset's.
TEST(OwnLevels, OfAPixelThatSeesNoFringes) {
  GridSamples s;
  s.cell = {0}, s.images = {0, 1, 2};
  s.real_dn = {5.0F, 5.02F, 4.99F}, s.weight = {1.0F, 1.0F, 1.0F};
  std::vector<float> values{1.0F, 2.0F, 3.0F};
  const OwnLevels levels(s, values, real_light(s), FreePerPixel::factor_and_offset, {});
  levels.to_levels(values);
  EXPECT_NEAR(values[1], 5.0, 0.02);
}

// What a value does to light is what the twin's response does that it makes, on top of one that there is.
TEST(CameraBend, DoesAsTheTableOfTheTwin) {
  constexpr double kCurveGain = 17.0;
  for (const bool has_knee : {false, true}) {
    Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
    if (has_knee) twin.cameras[1].sensor.response = knee_response(110.0, 0.6);
    const CameraResponse given = twin.cameras[1].sensor.response;
    std::vector<Parameter> bends = refinable_parameters_of(twin, "camera_response");
    std::erase_if(bends, [](const Parameter& p) { return p.camera != 1u; });
    ASSERT_EQ(bends.size(), 3u);
    const Eigen::Vector3d values(-0.08, 0.04, -0.02);
    const Twin fitted = with_values(twin, bends, values);
    const CameraResponse& response = fitted.cameras[1].sensor.response;
    GridSamples s;
    s.gain_dn = s.reference_gain_dn = kCurveGain;
    std::vector<float> light;
    for (double dn = 0.0; dn < range_dn(twin); dn += 0.7)
      light.push_back(static_cast<float>(dn / kCurveGain));
    std::vector<float> bent = light;
    for (Eigen::Index k = 0; k < 3; ++k)
      bends[static_cast<std::size_t>(k)].effect({twin, fitted, s, bent, 0.0, values[k]}, bent);
    std::vector<float> back = bent;
    for (Eigen::Index k = 3; k-- > 0;)
      bends[static_cast<std::size_t>(k)].effect({twin, fitted, s, back, values[k], 0.0}, back);
    for (std::size_t i = 0; i < light.size(); ++i) {
      const double dn = kCurveGain * static_cast<double>(light[i]);
      ASSERT_NEAR(given(kCurveGain * static_cast<double>(bent[i])), response(dn), 0.04) << dn;
      ASSERT_NEAR(back[i], light[i], 1e-5) << dn;
    }
  }
}

TEST(CameraBend, ACurveThatFallsIsRefused) {
  const Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  const std::vector<Parameter> bends = refinable_parameters_of(twin, "camera_response");
  EXPECT_THROW(with_values(twin, {bends[1]}, Eigen::VectorXd::Constant(1, -0.5)), UserError);
}

}  // namespace
}  // namespace fringetwin::compare::camera_curves_test
