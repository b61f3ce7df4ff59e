// SPDX-License-Identifier: Apache-2.0
// Images moved by a known part of a pixel.
//
// | check       | tolerance       | origin                                                           |
// |-------------|-----------------|------------------------------------------------------------------|
// | mean shift  | 3 printed sigma | one draw of noise                                                |
// |   besides   | 0.2 %           | third order of a 14 px fringe 0.03 %, a draw of noise in the gain |
// | every block | 5 printed sigma | the worst of 30 blocks                                           |
#include "compare/phase/shift_field.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::shift_field_test {
namespace {

/// Four steps of one or two directions over a soft spot of light, moved by `shift` on the real side.
struct Moved {
  double dx = 0.0, dy = 0.0;
  bool rows = false;  ///< horizontal fringes, too
  double noise_dn = 1.5, albedo_sigma = 0.0;
  int width = 192, height = 160;
};

class Scene {
 public:
  explicit Scene(const Moved& m)
      : m_(m),
        camera_{"left", Lens("LENSMODEL_PINHOLE", {400.0, 400.0, 96.0, 80.0}, {m.width, m.height}, "test"),
                Pose{}, Sensor{}, std::nullopt} {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    real_.bit_depth = 8;
    irradiance_.radiance = true;
    ImageF albedo(m.width, m.height);
    for (float& a : albedo.data) a = static_cast<float>(1.0 + m.albedo_sigma * normal(random));
    for (int image = 0; image < (m.rows ? 8 : 4); ++image) {
      ImageF real(m.width, m.height), e(m.width, m.height);
      for (int y = 0; y < m.height; ++y)
        for (int x = 0; x < m.width; ++x) {
          e(x, y) = static_cast<float>(light(image, x, y));
          const double dn =
              kGain * static_cast<double>(albedo(x, y)) * light(image, x - m.dx, y - m.dy) + kBlack;
          real(x, y) = static_cast<float>(std::round(dn + m.noise_dn * normal(random)));
        }
      real_.images.push_back(std::move(real));
      irradiance_.images.push_back(std::move(e));
    }
  }

  GrayPair pair() const {
    GrayPair p;
    p.camera = &camera_;
    p.real = &real_;
    p.irradiance = &irradiance_;
    p.mask = ImageU8(m_.width, m_.height, 1);
    for (int i = 0; i < static_cast<int>(real_.images.size()); ++i) {
      p.images.push_back(i);
      p.gain_images.push_back(i);
    }
    return p;
  }
  ShiftRow run() const {
    const GrayPair p = pair();
    std::vector<std::string> warnings;
    const GainFit fit = fit_gain(p, warnings);
    EXPECT_TRUE(fit.row.usable);
    return shift_field(p, fit, {m_.noise_dn * m_.noise_dn + 1.0 / 12.0, 0.0, 1.0 / 12.0});
  }

 private:
  static constexpr double kGain = 17.0, kBlack = 5.0;
  double light(int image, double x, double y) const {
    const double u = (x - 0.5 * m_.width) / m_.width, v = (y - 0.5 * m_.height) / m_.height;
    const double step = 0.5 * std::numbers::pi * (image % 4), turn = 2.0 * std::numbers::pi / 14.0;
    const double phase = image < 4 ? turn * (x + 1e-3 * x * y) : turn * (y + 0.05 * x);
    return 9.0 * (1.0 - 1.2 * (u * u + v * v)) * (0.5 + 0.45 * std::cos(phase + step));
  }
  Moved m_;
  Camera camera_;
  CameraImages real_, irradiance_;
};

void expect_shift(const ShiftComponent& c, double truth_px) {
  EXPECT_GE(c.n_blocks, 20u);
  EXPECT_NEAR(c.mean_px, truth_px, 3.0 * c.mean_sigma_px + 0.002 * std::abs(truth_px));
  EXPECT_GT(c.mean_sigma_px, 0.0);
  EXPECT_LT(c.mean_sigma_px, 0.001);  // 1.5 DN against slopes of 20 DN per px on 100,000 values: 0.0003
}

TEST(ShiftField, FringesOfBothDirectionsTellBothComponents) {
  const ShiftRow row = Scene({.dx = 0.1, .dy = -0.07, .rows = true}).run();
  expect_shift(row.dx, 0.1);
  expect_shift(row.dy, -0.07);
  EXPECT_GT(row.chi2_before, 1.2);
  EXPECT_NEAR(row.chi2_after, 1.0, 0.05);
  EXPECT_EQ(row.dx_px.width, 6);
  EXPECT_EQ(row.dx_px.height, 5);
}

TEST(ShiftField, VerticalFringesTellNoDy) {
  const ShiftRow row = Scene({.dx = 0.1}).run();
  expect_shift(row.dx, 0.1);
  EXPECT_EQ(row.dy.n_blocks, 0u);
  EXPECT_TRUE(std::isnan(row.dy.mean_px));
  for (const float v : row.dy_px.data) EXPECT_TRUE(std::isnan(v));
}

TEST(ShiftField, NoShiftIsNone) {
  const ShiftRow row = Scene({.rows = true}).run();
  expect_shift(row.dx, 0.0);
  expect_shift(row.dy, 0.0);
  EXPECT_NEAR(row.chi2_before, 1.0, 0.05);
  EXPECT_LT(row.dx.largest_px, 0.02);
}

TEST(ShiftField, AlbedoMakesNoShift) {
  const ShiftRow row = Scene({.dx = -0.1, .rows = true, .albedo_sigma = 0.1}).run();
  EXPECT_NEAR(row.dx.mean_px, -0.1, 3.0 * row.dx.mean_sigma_px + 0.0002);
  EXPECT_NEAR(row.dy.mean_px, 0.0, 3.0 * row.dy.mean_sigma_px + 0.0002);
  EXPECT_LT(row.dx.mean_sigma_px, 0.002);
}

TEST(ShiftField, DarkImagesTellNothing) {
  Scene scene({.dx = 0.1});
  GrayPair pair = scene.pair();
  std::vector<std::string> warnings;
  const GainFit fit = fit_gain(pair, warnings);
  std::fill(pair.mask.data.begin(), pair.mask.data.end(), static_cast<unsigned char>(0));
  const ShiftRow row = shift_field(pair, fit, {2.0, 0.0, 0.1});
  EXPECT_EQ(row.dx.n_blocks + row.dy.n_blocks, 0u);
  EXPECT_TRUE(std::isnan(row.dx.mean_px));
  EXPECT_TRUE(std::isnan(row.chi2_after));
}

// Without a gray budget: read noise, rounding, and shot noise of what lies above the black level.
TEST(ShiftField, TheSensorsNoiseIsTheSumOfItsVariances) {
  Camera camera{"left", Lens("LENSMODEL_PINHOLE", {400.0, 400.0, 96.0, 80.0}, {192, 160}, "test"), Pose{},
                Sensor{}, std::nullopt};
  camera.sensor.read_noise_dn = 3.0;
  camera.sensor.black_level_dn = 16.0;
  camera.sensor.electrons_per_dn = 8.0;
  CameraImages real;
  GrayPair pair;
  pair.camera = &camera;
  pair.real = &real;
  const NoiseLine line = noise_line(pair, GainFit{}, std::nullopt);
  EXPECT_DOUBLE_EQ(line.variance_dn2(16.0), 9.0 + 1.0 / 12.0);
  EXPECT_DOUBLE_EQ(line.variance_dn2(96.0), 9.0 + 1.0 / 12.0 + 80.0 / 8.0);
  EXPECT_DOUBLE_EQ(line.variance_dn2(10.0), 9.0 + 1.0 / 12.0) << "below black there is no less";
}

TEST(ShiftField, OfAComparisonIsZeroWhereTheTwinIsRight) {
  const testing::SyntheticSides scene = testing::make_sides({});
  const Comparison c = compare(scene.twin, scene.real, scene.simulated, {});
  ASSERT_EQ(c.shift.size(), 1u);
  EXPECT_GT(c.shift[0].dx.n_blocks, 15u);
  EXPECT_NEAR(c.shift[0].dx.mean_px, 0.0, 4.0 * c.shift[0].dx.mean_sigma_px);
  EXPECT_EQ(c.shift[0].dy.n_blocks, 0u);
  EXPECT_NEAR(c.shift[0].chi2_after, 1.0, 0.05);
}

}  // namespace
}  // namespace fringetwin::compare::shift_field_test
