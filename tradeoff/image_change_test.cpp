// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit    | origin                                |
// |-----------|---------|---------------------------------------|
// | 1e-12     | rad, DN | closed forms, double rounding         |
#include "tradeoff/image_change.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/paper_rig.hpp"

namespace fringetwin::tradeoff::image_change_test {
namespace {

constexpr double pi = std::numbers::pi;

/// Values of one pixel: mean + amplitude cos(phase + 2 pi n/N) at every pitch.
std::vector<double> steps(const Fringes& fringes, double mean, double amplitude, double phase) {
  std::vector<double> out;
  for (const PatternSpec& p : expand_sequence(fringes))
    out.push_back(mean + amplitude * std::cos(phase + 2.0 * pi * p.step / fringes.steps));
  return out;
}

TEST(ImageChange, PhaseAndGrayOfAShift) {
  const Fringes fringes = testing::paper_rig().fringes;
  ChangeSum sum(fringes, 5.0);
  const double shift = 0.01;
  // across the wrap, too
  sum.add({{0, 0, false, 1.0}, {1, 0, false, 1.0}},
          {steps(fringes, 100, 50, pi - 0.003), steps(fringes, 100, 50, 0.4)},
          {steps(fringes, 100, 50, pi - 0.003 + shift), steps(fringes, 100, 50, 0.4 - shift)});
  const ImageChange c = sum.result();
  EXPECT_NEAR(c.phase_rms_rad, shift, 1e-12);
  EXPECT_NEAR(c.phase_interior_rms_rad, shift, 1e-12);
  // difference of two cosines: amplitude 2 * 50 sin(shift / 2), rms over the steps / sqrt 2
  EXPECT_NEAR(c.gray_rms_dn, 100.0 * std::sin(shift / 2) / std::sqrt(2.0), 1e-12);
  EXPECT_TRUE(std::isnan(c.gray_edge_rms_dn));
  EXPECT_EQ(c.n_phase, 2u);
}

TEST(ImageChange, WeightsAndEdges) {
  const Fringes fringes = testing::paper_rig().fringes;
  ChangeSum sum(fringes, 5.0);
  sum.add({{0, 0, false, 3.0}, {1, 0, true, 1.0}}, {steps(fringes, 100, 50, 0), steps(fringes, 100, 50, 0)},
          {steps(fringes, 101, 50, 0), steps(fringes, 105, 50, 0)});
  const ImageChange c = sum.result();
  EXPECT_NEAR(c.gray_interior_rms_dn, 1.0, 1e-12);
  EXPECT_NEAR(c.gray_edge_rms_dn, 5.0, 1e-12);
  EXPECT_NEAR(c.gray_rms_dn, std::sqrt((3.0 + 25.0) / 4.0), 1e-12);
  EXPECT_NEAR(c.phase_rms_rad, 0.0, 1e-12);
}

// A pixel that stands for three others counts three times in the phase, too: sqrt((3 0.01^2 + 0.02^2)/4).
TEST(ImageChange, PhasesAreWeightedAsGrayValuesAre) {
  const Fringes fringes = testing::paper_rig().fringes;
  for (const bool second_is_edge : {false, true}) {
    ChangeSum sum(fringes, 5.0);
    sum.add({{0, 0, false, 3.0}, {1, 0, second_is_edge, 1.0}},
            {steps(fringes, 100, 50, 0.3), steps(fringes, 100, 50, 0.3)},
            {steps(fringes, 100, 50, 0.31), steps(fringes, 100, 50, 0.32)});
    EXPECT_NEAR(sum.result().phase_rms_rad, std::sqrt(7e-4 / 4.0), 1e-12);
    EXPECT_NEAR(sum.result().phase_interior_rms_rad, second_is_edge ? 0.01 : std::sqrt(7e-4 / 4.0), 1e-12);
  }
}

TEST(ImageChange, PixelsAreTakenAsGrayValues) {
  std::vector<ImageF> images(2, ImageF(3, 2));
  images[0](2, 1) = 4.0F;
  images[1](2, 1) = 8.0F;
  const PixelValues values = take_pixels(images, {{2, 1, false, 1.0}, {1, 0, true, 1.0}}, 20.0, 3.0);
  EXPECT_EQ(values, (PixelValues{{83.0, 163.0}, {3.0, 3.0}}));
}

TEST(ImageChange, DarkPixelsHaveNoPhase) {
  const Fringes fringes = testing::paper_rig().fringes;
  const std::vector<double> dark = steps(fringes, 100, 4, 0), lit = steps(fringes, 100, 50, 1);
  for (const bool dark_first : {true, false}) {
    ChangeSum sum(fringes, 5.0);
    sum.add({{0, 0, false, 1.0}}, {dark_first ? dark : lit}, {dark_first ? lit : dark});
    EXPECT_EQ(sum.result().n_phase, 0u);
    EXPECT_TRUE(std::isnan(sum.result().phase_rms_rad));
    EXPECT_EQ(sum.result().n_gray, 1u);
  }
}

// Only the finest pitch counts: 13 px comes first in the paper's sequence.
TEST(ImageChange, FinestPitchOnly) {
  const Fringes fringes = testing::paper_rig().fringes;
  std::vector<double> a = steps(fringes, 100, 50, 0), b = a;
  for (std::size_t i = 4; i < b.size(); ++i) b[i] += 7.0 * static_cast<double>(i % 3);
  ChangeSum sum(fringes, 5.0);
  sum.add({{0, 0, false, 1.0}}, {a}, {b});
  EXPECT_NEAR(sum.result().phase_rms_rad, 0.0, 1e-12);
  EXPECT_GT(sum.result().gray_rms_dn, 1.0);
}

}  // namespace
}  // namespace fringetwin::tradeoff::image_change_test
