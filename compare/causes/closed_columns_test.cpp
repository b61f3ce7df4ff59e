// SPDX-License-Identifier: Apache-2.0
// Effects without rendering, on made-up light: E of every pixel and image is a formula, and so is what an
// error makes of it, in double precision.
//
// | check                           | tolerance | origin                                                |
// |---------------------------------|-----------|-------------------------------------------------------|
// | values                          | 5e-6 E    | single precision, 6e-8 a rounding, sums of up to 12   |
// | blur                            | 3e-4 of 2 | narrow kernel cos w - 1 for -w^2/2: s w^4/24, 2.9e-4  |
#include "compare/parameters/closed_columns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "compare/causes/sensitivity.hpp"
#include "compare/parameters/parameters.hpp"

namespace fringetwin::compare::closed_columns_test {
namespace {

constexpr int kWidth = 64, kHeight = 48, kSteps = 4;
constexpr double kGain = 20.0, kBlack = 15.0, kRangeDn = 255.0 - kBlack, kPi = std::numbers::pi;
constexpr double kPitches[] = {13.0, 14.0, 15.0};

Twin two_cameras() {
  Twin twin;
  const Lens lens("LENSMODEL_PINHOLE", {900, 905, 31.5, 23.5}, {kWidth, kHeight}, "test");
  twin.cameras.push_back({"left", lens, Pose{}, Sensor{}, std::nullopt});
  twin.cameras.push_back({"right", lens, Pose{}, Sensor{}, std::nullopt});
  for (Camera& camera : twin.cameras) camera.sensor.black_level_dn = kBlack;
  const Lens projector("LENSMODEL_PINHOLE", {900, 905, 640, 360}, {1280, 720}, "test");
  twin.projector = Projector{.lens = projector, .T_proj_world = Pose{}, .response = {}};
  twin.fringes.directions = {{Axis::x, {13, 14, 15}, {0, 0, 0}, {}}};
  twin.fringes.steps = kSteps;
  return twin;
}

/// Light at a pixel of the camera that the projector's pixel (u, v) lights, its fringes `shift_px` further.
double light(double x, double y, int image, double shift_px = 0.0) {
  const double u = 300.0 + 2.1 * x + 0.3 * y, pitch = kPitches[image / kSteps];
  const double psi = 2.0 * kPi * (image % kSteps) / kSteps;
  return (3.0 + 0.02 * x) * (1.0 + 0.8 * std::cos(2.0 * kPi * (u - shift_px) / pitch + psi));
}
Eigen::Vector2d projector_px(double x, double y) { return {300.0 + 2.1 * x + 0.3 * y, 100.0 + 5.0 * y}; }

/// Every third pixel of the second camera, images in another order than projected and one of them missing.
GridSamples samples() {
  GridSamples s;
  s.camera = 1;
  s.grid = {3, 1, 1, 21, 16};
  s.images = {3, 0, 1, 2, 4, 6, 7, 8, 9, 10, 5};
  s.gain_dn = kGain;
  for (std::size_t i = 0; i < 21 * 16; i += 5) s.cell.push_back(i);
  s.real_dn.resize(s.cell.size() * s.images.size());
  s.projector_px.resize(s.cell.size());
  return s;
}

struct Place {
  double x, y;
};
Place place(const GridSamples& s, std::size_t pixel) {
  return {1.0 + 3.0 * static_cast<double>(s.cell[pixel] % 21),
          1.0 + 3.0 * static_cast<double>(s.cell[pixel] / 21)};
}

using Truth = std::function<double(double x, double y, int image, double value)>;

/// Holds the effect from the parameter's start to `value` and on to another against the truth.
void expect_effect(const std::string& group, const std::string& name, double value, const Truth& truth) {
  constexpr double tolerance = 5e-6;
  SCOPED_TRACE(name);
  const Twin twin = two_cameras();
  GridSamples s = samples();
  std::vector<float> before;
  for (std::size_t p = 0; p < s.n_pixels(); ++p) {
    const auto [x, y] = place(s, p);
    s.projector_px[p] = projector_px(x, y).cast<float>();
    for (const int image : s.images) before.push_back(static_cast<float>(light(x, y, image)));
  }
  const bool is_exact = group == "light" || group == "exposure" || group == "projector_field" ||
                        group == "camera_knee",
             is_kept = is_exact || group == "image_shift";  // by a key of twin.toml
  for (const Parameter& parameter : parameters_of(twin, group)) {
    if (parameter.name != name) continue;
    ASSERT_TRUE(parameter.effect);
    EXPECT_EQ(parameter.instead.empty(), is_kept || group == "camera_response");  // `--refine` has its own
    EXPECT_EQ(parameter.is_closed, is_exact);  // harmonics of the fringes move along with them
    EXPECT_EQ(static_cast<bool>(parameter.change), is_kept);
    std::vector<float> after = before;
    parameter.effect({twin, twin, s, before, parameter.start, value}, after);
    const std::vector<float> between = after;
    std::vector<float> back = after;
    parameter.effect({twin, twin, s, between, value, parameter.start}, back);
    for (std::size_t p = 0, i = 0; p < s.n_pixels(); ++p)
      for (std::size_t k = 0; k < s.images.size(); ++k, ++i) {
        const auto [x, y] = place(s, p);
        const double e = static_cast<double>(before[i]);
        ASSERT_NEAR(static_cast<double>(after[i]), truth(x, y, s.images[k], value), tolerance * (e + 1.0))
            << x << ' ' << y << ' ' << s.images[k];
        // of those two the way back begins at what they changed: the other images of the pitch, r
        if (group != "image_shift" && group != "camera_response") {
          ASSERT_NEAR(static_cast<double>(back[i]), e, tolerance * (e + 1.0));
        }
      }
    return;
  }
  FAIL() << "no such parameter";
}

TEST(ClosedColumns, LightOfOneImageIsRelativeToTheMean) {
  const auto truth = [](double x, double y, int image, double value) {
    return light(x, y, image) * std::exp(image == 6 ? value : image == 0 ? -value : 0.0);
  };
  expect_effect("light", "image_6.light", 0.03, truth);
  EXPECT_EQ(parameters_of(two_cameras(), "light").size(), 11u);
}

TEST(ClosedColumns, ExposureOfOneImageIsOfOneCamera) {
  const auto truth = [](double x, double y, int image, double value) {
    return light(x, y, image) * std::exp(image == 6 ? value : image == 0 ? -value : 0.0);
  };
  expect_effect("exposure", "right.image_6.exposure", 0.03, truth);
  const std::vector<Parameter> all = parameters_of(two_cameras(), "exposure");
  EXPECT_EQ(all.size(), 22u);
  EXPECT_EQ(all.front().camera, 0u);
  EXPECT_EQ(all.back().camera, 1u);
}

// The lamp's light alone grows: the room's, which has factors of its own and the lens's vignetting, stays.
// The exposure is of both.
TEST(ClosedColumns, LightOfOneImageLeavesTheRoomsLight) {
  constexpr double kAmbient = 1.5, kVignetting = -0.3;
  const std::string name = "image_6.light";
  Twin twin = two_cameras();
  for (int image = 0; image < 12; ++image) {
    twin.projector->ambient_factors.push_back(1.0 + 0.3 * std::sin(0.4 * image));
    twin.cameras[1].exposure_factors.push_back(1.0 + 0.05 * std::sin(2.0 + image));
  }
  twin.projector->ambient = kAmbient;
  twin.cameras[1].vignetting = {.kind = Vignetting::Kind::polynomial, .a = {kVignetting, 0.0, 0.0}};
  const auto light_of = [&](double x, double y, int image, double factor) {
    // r is 1 in the corners of the 64 x 48 px, 40 px from the middle
    const double r2 = (std::pow(x - 31.5, 2) + std::pow(y - 23.5, 2)) / (40.0 * 40.0);
    const double room = kAmbient * (1.0 + kVignetting * r2) * (1.0 + 0.3 * std::sin(0.4 * image));
    return (1.0 + 0.05 * std::sin(2.0 + image)) * (factor * light(x, y, image) + room);
  };
  const GridSamples s = samples();
  std::vector<float> before;
  for (std::size_t p = 0; p < s.n_pixels(); ++p)
    for (const int image : s.images)
      before.push_back(static_cast<float>(light_of(place(s, p).x, place(s, p).y, image, 1.0)));
  std::vector<float> after = before;
  const std::vector<Parameter> all = parameters_of(twin, "light");
  const auto parameter = std::ranges::find(all, name, &Parameter::name);
  ASSERT_NE(parameter, all.end());
  parameter->effect({twin, twin, s, before, 0.0, 0.03}, after);
  for (std::size_t p = 0, i = 0; p < s.n_pixels(); ++p)
    for (const int image : s.images) {
      const double factor = std::exp(image == 6   ? 0.03
                                     : image == 0 ? -0.03
                                                  : 0.0),
                   truth = light_of(place(s, p).x, place(s, p).y, image, factor);
      ASSERT_NEAR(static_cast<double>(after[i++]), truth, 5e-6 * (truth + 1.0)) << image;
    }
}

TEST(ClosedColumns, RoomLightIsAPolynomialOverTheImage) {
  const std::pair<std::string, std::pair<int, int>> terms[] = {
      {"x", {1, 0}}, {"y", {0, 1}}, {"xx", {2, 0}}, {"xy", {1, 1}}, {"yy", {0, 2}}};
  for (const auto& [name, powers] : terms)
    expect_effect("room_light", "right.room_light." + name, 7.0,
                  [powers = powers](double x, double y, int image, double value) {
                    const double u = (x - 32.0) / 32.0, v = (y - 24.0) / 32.0;
                    return light(x, y, image) +
                           value / kGain * std::pow(u, powers.first) * std::pow(v, powers.second);
                  });
}

TEST(ClosedColumns, ACamerasResponseIsOfItsSignal) {
  const auto after = [](const std::function<double(double)>& curve) {
    return [curve](double x, double y, int image, double) {
      return curve(kGain * light(x, y, image) / kRangeDn) * kRangeDn / kGain;
    };
  };
  const auto chebyshev = [](int order, double r) {
    const double z = 2.0 * std::min(r / 0.75, 1.2) - 1.0;
    return z > 1.0 ? std::cosh(order * std::acosh(z)) : std::cos(order * std::acos(z));
  };
  expect_effect("camera_response", "right.response.gamma", 0.9,
                after([](double r) { return std::pow(r, 0.9); }));
  expect_effect("camera_response", "right.response.square", -0.1,
                after([](double r) { return r - 0.1 * r * r; }));
  expect_effect("camera_response", "right.response.cubic", 0.01,
                after([&](double r) { return r + 0.01 * chebyshev(3, r); }));
  expect_effect("camera_response", "right.response.quartic", 0.01,
                after([&](double r) { return r + 0.01 * chebyshev(4, r); }));
}

TEST(ClosedColumns, AKneeIsOfItsSignal) {
  const double at_dn = 0.4 * kRangeDn;  // where the search begins
  expect_effect("camera_knee", "right.response.slope", 0.7, [=](double x, double y, int image, double slope) {
    const double dn = kGain * light(x, y, image);
    return (dn > at_dn ? at_dn + slope * (dn - at_dn) : dn) / kGain;
  });
}

// Place and slope one after the other, as a prediction has them, of a camera without a response and of one
// with a knee, whose gray values are straightened by that.
TEST(ClosedColumns, AKneeGoesFromThatOfTheTwinToAnother) {
  constexpr double kAtDn = 60.0, kSlope = 0.8;
  for (const bool has_knee : {false, true}) {
    Twin twin = two_cameras();
    if (has_knee) twin.cameras[1].sensor.response = knee_response(80.0, 0.6);
    std::vector<Parameter> knee = parameters_of(twin, "camera_knee");
    std::erase_if(knee, [](const Parameter& p) { return p.camera != 1u; });
    ASSERT_EQ(knee.size(), 2u);
    EXPECT_EQ(knee[0].name, "right.response.slope");
    EXPECT_EQ(knee[0].start, has_knee ? 0.6 : 1.0);
    EXPECT_EQ(knee[1].name, "right.response.knee_dn");
    if (has_knee) {
      EXPECT_EQ(knee[1].start, 80.0);
    }
    const Eigen::Vector2d values(kSlope, kAtDn);
    const Twin fitted = with_values(twin, knee, values);
    const CameraResponse& response = fitted.cameras[1].sensor.response;
    ASSERT_EQ(response.corners.size(), 1u);
    EXPECT_DOUBLE_EQ(response.corners[0].in_dn, kAtDn);
    EXPECT_DOUBLE_EQ(response.last_slope, kSlope);
    const GridSamples s = samples();
    std::vector<float> before;
    for (std::size_t p = 0; p < s.n_pixels(); ++p)
      for (const int image : s.images)
        before.push_back(static_cast<float>(light(place(s, p).x, place(s, p).y, image)));
    std::vector<float> after = before;
    for (Eigen::Index k = 0; k < 2; ++k) {
      const Parameter& p = knee[static_cast<std::size_t>(k)];
      p.effect({twin, fitted, s, before, p.start, values[k]}, after);
    }
    for (std::size_t i = 0; i < before.size(); ++i) {
      const double dn = kGain * static_cast<double>(before[i]),
                   seen = dn > kAtDn ? kAtDn + kSlope * (dn - kAtDn) : dn,
                   straightened = has_knee && seen > 80.0 ? 80.0 + (seen - 80.0) / 0.6 : seen;
      ASSERT_NEAR(static_cast<double>(after[i]), straightened / kGain, 5e-6 * (straightened / kGain + 1.0));
    }
  }
  Twin table = two_cameras();
  table.cameras[1].sensor.response = {{{40.0, 40.0}, {90.0, 80.0}}, 0.5};
  EXPECT_EQ(parameters_of(table, "camera_knee").size(), 2u) << "of the other camera";
}

TEST(ClosedColumns, TheProjectorsFieldFollowsItsOwnImage) {
  const auto after = [](const std::function<double(double, double)>& field) {
    return [field](double x, double y, int image, double value) {
      const Eigen::Vector2d p = projector_px(x, y);
      return light(x, y, image) *
             std::exp(value * field((p.x() + 0.5) / 640.0 - 1.0, (p.y() + 0.5) / 360.0 - 1.0));
    };
  };
  expect_effect("projector_field", "projector.light_field.1_0", 0.2,
                after([](double a, double) { return a; }));
  expect_effect("projector_field", "projector.light_field.0_2", -0.2,
                after([](double, double b) { return 1.5 * b * b - 0.5; }));
  expect_effect("projector_field", "projector.light_field.3_1", 0.3,
                after([](double a, double b) { return (2.5 * a * a * a - 1.5 * a) * b; }));
  EXPECT_EQ(parameters_of(two_cameras(), "projector_field").size(), 14u);
}

TEST(ClosedColumns, AnImageShiftsByTensOfDegreesToo) {
  for (const int image : {0, 3, 6, 9})  // of the pitch of image 9 one step is missing
    expect_effect("image_shift", "image_" + std::to_string(image) + ".shift_px", 1.3,
                  [image](double x, double y, int at, double value) {
                    return light(x, y, at, at == image ? value : 0.0);
                  });
}

/// Eight steps of one pitch under steady light of the room, each with a light, an exposure, a place and a
/// first harmonic of its own.
class OneOfEightImages : public ::testing::Test {
 protected:
  OneOfEightImages() {
    twin_.fringes.steps = 8;
    twin_.fringes.directions[0] = {.axis = Axis::x, .pitches_px = {13}, .phase_origin_px = {0}};
    twin_.fringes.unwrap = Unwrap::none;
    twin_.projector->ambient = 1.5;
    s_.images = {0, 1, 2, 3, 4, 5, 6, 7};
    s_.real_dn.resize(s_.cell.size() * s_.images.size());
    for (int image = 0; image < 8; ++image) {
      twin_.cameras[1].exposure_factors.push_back(1.0 + 0.05 * std::sin(2.0 + image));
      twin_.projector->light_factors.push_back(1.0 + 0.04 * std::cos(image));
      twin_.projector->image_shifts_px.push_back(0.2 * std::sin(1.0 + image));
      twin_.fringes.image_harmonics.push_back(
          {{0.06 + 0.03 * std::cos(3.0 * image), 0.05 * std::sin(image)}});
    }
    twin_.fringes.image_harmonics[2].clear();
  }

  /// Returns the light with more contrast in image 5, whose fringes lie further.
  double light_of(double x, double y, int image, double contrast, double shift_px) const {
    const auto i = static_cast<std::size_t>(image);
    if (image != 5) contrast = shift_px = 0.0;
    const Harmonics& own = twin_.fringes.image_harmonics[i];
    const double psi = 2.0 * kPi * image / 8.0,
                 at = (300.0 + 2.1 * x + 0.3 * y - twin_.projector->image_shifts_px[i] - shift_px) / 13.0,
                 theta = 2.0 * kPi * at + psi,
                 wave = (0.5 + contrast + (own.empty() ? 0.0 : own[0].cosine)) * std::cos(theta) +
                        (own.empty() ? 0.0 : own[0].sine) * std::sin(theta);
    return twin_.cameras[1].exposure_factors[i] *
           (twin_.projector->light_factors[i] * (6.0 + 0.02 * x) * (0.5 + wave) + twin_.projector->ambient);
  }

  void expect_effect_of(const std::string& group, const std::string& name, double contrast, double shift_px) {
    const std::vector<Parameter> all = parameters_of(twin_, group);
    const auto parameter = std::ranges::find(all, name, &Parameter::name);
    ASSERT_NE(parameter, all.end());
    std::vector<float> before;
    for (std::size_t p = 0; p < s_.n_pixels(); ++p)
      for (const int image : s_.images)
        before.push_back(static_cast<float>(light_of(place(s_, p).x, place(s_, p).y, image, 0.0, 0.0)));
    std::vector<float> after = before;
    parameter->effect({twin_, twin_, s_, before, 0.0, contrast + shift_px}, after);
    for (std::size_t p = 0, i = 0; p < s_.n_pixels(); ++p)
      for (const int image : s_.images) {
        const double truth = light_of(place(s_, p).x, place(s_, p).y, image, contrast, shift_px);
        ASSERT_NEAR(static_cast<double>(after[i++]), truth, 5e-6 * (truth + 1.0)) << image;
      }
  }

  Twin twin_ = two_cameras();
  GridSamples s_ = samples();
};

// Of one image whose light and exposure are others than those of the steps that tell its fringe, under steady
// light of the room and on fringes that lie further and are of another contrast; and of no other image. A
// column that counted the contrast of all images with its own was 6 % too long on slmaster.
TEST_F(OneOfEightImages, ContrastIsOfItsOwnLight) {
  expect_effect_of("image_harmonics", "image_5.harmonic.1", -0.02, 0.0);
  const std::vector<Parameter> all = parameters_of(twin_, "image_harmonics");
  ASSERT_EQ(all.size(), 8u * 11u);
  const auto second = std::ranges::find(all, "image_5.harmonic.2.quadrature", &Parameter::name);
  EXPECT_EQ(second->does_as->name, "projector.harmonic.2.quadrature");
  EXPECT_EQ(second->only_image, 5);
}

TEST_F(OneOfEightImages, ShiftsAFringeOfItsOwnContrast) {
  expect_effect_of("image_shift", "image_5.shift_px", 0.0, 1.3);
}

TEST(ClosedColumns, ACamerasBlurTakesContrastAway) {
  // a plane wave: a Gaussian of variance s leaves exp(-s w^2/2) of it
  const double w = 0.6;
  CameraImages frame;
  frame.images.assign(12, ImageF(kWidth, kHeight));
  const auto wave = [=](double x, double y) { return 2.0 * std::cos(w * (0.8 * x + 0.6 * y)); };
  for (GrayImage& image : frame.images)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) image.writable(x, y) = static_cast<float>(5.0 + wave(x, y));
  for (const double variance : {0.1, 0.8, 1.5}) {
    const Twin twin = two_cameras();
    GridSamples s = samples();
    s.frame = &frame;
    std::vector<float> before(s.real_dn.size(), 4.0F), after = before;
    parameters_of(twin, "camera_psf").at(1).effect({twin, twin, s, before, 0.0, variance}, after);
    for (std::size_t p = 0; p < s.n_pixels(); ++p) {
      const auto [x, y] = place(s, p);
      if (x < 10 || y < 10 || x > kWidth - 11 || y > kHeight - 11) continue;
      for (std::size_t k = 0; k < s.images.size(); ++k)
        EXPECT_NEAR(static_cast<double>(after[p * s.images.size() + k]),
                    4.0 - (1.0 - std::exp(-0.5 * variance * w * w)) * wave(x, y), 3e-4 * 2.0);
    }
  }
}

TEST(ClosedColumns, OneCamerasEffectsAreItsOwn) {
  const Twin twin = two_cameras();
  for (const char* group : {"room_light", "camera_response", "camera_knee", "camera_psf"})
    for (const Parameter& p : parameters_of(twin, group)) {
      ASSERT_TRUE(p.camera.has_value()) << p.name;
      EXPECT_TRUE(p.name.starts_with(twin.cameras[*p.camera].name)) << p.name;
    }
}

}  // namespace
}  // namespace fringetwin::compare::closed_columns_test
