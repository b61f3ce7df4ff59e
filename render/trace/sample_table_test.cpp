// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit | origin                                                    |
// |-----------|------|-----------------------------------------------------------|
// | 1e-13     | 1    | exactness of quadrature rules, double rounding            |
// | 1e-6      | 1    | disk rule against the Bessel integral, its design target  |
// | 1e-6      | 1    | float tables                                              |
#include "render/trace/sample_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "render/base/quadrature.hpp"
#include "render/base/sampling.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render::sample_table_test {
namespace {

TEST(SampleTable, GaussRuleIntegratesPolynomialsOverThePixel) {
  const auto table = gauss_samples(9, 0.5, {}, 0.0);
  ASSERT_EQ(table.size(), 9u + 3u);
  double weight = 0, x4 = 0, x2y2 = 0, odd = 0;
  for (const gpu::vec4& s : table) {
    weight += s.z;
    x4 += s.z * std::pow(s.x, 4);
    x2y2 += s.z * s.x * s.x * s.y * s.y;
    odd += s.z * s.x * s.y * s.y;
  }
  // Over a square of half side h = 0.25: <x^4> = h^4/5, <x^2 y^2> = h^4/9.
  EXPECT_NEAR(weight, 1.0, 1e-6);
  EXPECT_NEAR(x4, std::pow(0.25, 4) / 5.0, 1e-6);
  EXPECT_NEAR(x2y2, std::pow(0.25, 4) / 9.0, 1e-6);
  EXPECT_NEAR(odd, 0.0, 1e-8);
}

// The samples' shares of the pixel contain their samples and fill it without gap or overlap.
TEST(SampleTable, SharesTileThePixel) {
  for (int n = 1; n <= 16; ++n) {
    const auto table = gauss_samples(n * n, 0.8, {}, 0.0);
    ASSERT_EQ(table.size(), static_cast<std::size_t>(n * n + n));
    float end = -0.4F;
    for (int i = 0; i < n; ++i) {
      const gpu::vec4& sample = table[static_cast<std::size_t>(i * n + i)];
      const gpu::vec4& share = table[static_cast<std::size_t>(n * n + i)];
      EXPECT_EQ(sample.w, static_cast<float>(i + MOST_COLUMNS * i));
      EXPECT_LE(share.x, 0.0F);
      EXPECT_GE(share.y, 0.0F);
      EXPECT_NEAR(sample.x + share.x, end, 1e-6);
      EXPECT_NEAR(0.8 * 0.8 * sample.z, std::pow(share.y - share.x, 2), 1e-6);
      end = sample.x + share.y;
    }
    EXPECT_NEAR(end, 0.4F, 1e-6);
  }
}

TEST(SampleTable, DiskRuleMoments) {
  const auto rule = disk_rule(3, 8);
  double w = 0, r2 = 0, r4 = 0, x2 = 0, x = 0;
  for (const DiskPoint& p : rule) {
    const double q = p.x * p.x + p.y * p.y;
    w += p.weight;
    x += p.weight * p.x;
    x2 += p.weight * p.x * p.x;
    r2 += p.weight * q;
    r4 += p.weight * q * q;
  }
  EXPECT_NEAR(w, 1.0, 1e-13);
  EXPECT_NEAR(x, 0.0, 1e-13);
  EXPECT_NEAR(x2, 0.25, 1e-13);
  EXPECT_NEAR(r2, 0.5, 1e-13);
  EXPECT_NEAR(r4, 1.0 / 3.0, 1e-13);
}

// Mean of cos(s x) over the unit disk is 2 J1(s)/s.
TEST(SampleTable, DiskRuleAveragesFringesOfItsSwing) {
  for (const double swing : {0.1, 0.7, 1.0, 2.5, 5.0, 9.0, 14.0, 20.0, 29.0}) {
    double cosine = 0.0, sine = 0.0;
    for (const DiskPoint& p : disk_rule_for_swing(swing)) {
      cosine += p.weight * std::cos(swing * p.x);
      sine += p.weight * std::sin(swing * (0.6 * p.x + 0.8 * p.y));
    }
    EXPECT_NEAR(cosine, 2.0 * std::cyl_bessel_j(1, swing) / swing, 1e-6) << swing;
    EXPECT_NEAR(sine, 0.0, 1e-6) << swing;
  }
}

// 2^k Sobol points: one in each of 2^k equal intervals of every dimension, and one in each
// elementary 2^a x 2^b rectangle of the first two.
TEST(SampleTable, SobolIsANet) {
  const std::uint32_t n = 64;
  const auto points = sobol_points(n);
  std::set<std::uint32_t> intervals[4];
  for (const gpu::uvec4& p : points) {
    intervals[0].insert(p.x >> 26);
    intervals[1].insert(p.y >> 26);
    intervals[2].insert(p.z >> 26);
    intervals[3].insert(p.w >> 26);
  }
  for (const auto& s : intervals) EXPECT_EQ(s.size(), n);
  for (std::uint32_t a = 1; a < 6; ++a) {
    std::set<std::pair<std::uint32_t, std::uint32_t>> cells;
    for (const gpu::uvec4& p : points) cells.emplace(p.x >> (32 - a), p.y >> (26 + a));
    EXPECT_EQ(cells.size(), n);
  }
}

TEST(SampleTable, MultiJitterFactors) {
  for (std::uint32_t n = 1; n < 300; ++n) {
    const Factors f = multi_jitter_factors(n);
    EXPECT_GE(f.columns * f.rows, n);
    EXPECT_LT((f.rows - 1) * f.columns, n);
  }
  EXPECT_EQ(multi_jitter_factors(1024).columns, 32u);
  EXPECT_EQ(multi_jitter_factors(12).columns, 3u);
}

// The paper's projector and finest pitch.
Twin rig(double focal_px = 1701.22) {
  Twin twin;
  const Lens lens("LENSMODEL_PINHOLE", {focal_px, focal_px, 640, 400}, {1280, 800}, "test");
  twin.projector = Projector{.lens = lens, .T_proj_world = {}, .response = {}};
  DirectionFringes fringes;
  fringes.pitches_px = {15, 14, 13};
  twin.fringes.directions = {fringes};
  return twin;
}

RenderOptions options(std::optional<int> samples, std::optional<Sampler> sampler, double target = 1e-4) {
  RenderOptions o;
  o.samples = samples;
  o.sampler = sampler;
  o.phase_error_rad = target;
  return o;
}

TEST(ChooseSampling, CheapestForTheTarget) {
  const Sampling chosen = choose_sampling(rig(), options({}, {}, 2e-4));
  EXPECT_EQ(chosen.sampler, Sampler::adaptive);
  EXPECT_EQ(chosen.phase_error_rad, 2e-4);
  const auto gauss = [](double target) {
    return choose_sampling(rig(), options({}, Sampler::gauss, target)).samples;
  };
  EXPECT_EQ(gauss(1e-4), 4);
  EXPECT_EQ(gauss(4e-5), 9);
  EXPECT_EQ(gauss(1e-5), 9);
  EXPECT_EQ(gauss(2e-6), 16);
  EXPECT_EQ(choose_sampling(rig(), options({}, Sampler::sobol, 1e-4)).samples, 256);
}

TEST(ChooseSampling, DoubleWhereSinglePrecisionRoundsTooMuch) {
  EXPECT_FALSE(choose_sampling(rig(), options({}, {}, 1e-4)).precise);
  EXPECT_TRUE(choose_sampling(rig(), options({}, {}, 4e-5)).precise);
  EXPECT_TRUE(choose_sampling(rig(4 * 1701.22), options({}, {}, 1e-4)).precise);
  EXPECT_FALSE(choose_sampling(rig(0.25 * 1701.22), options({}, {}, 4e-5)).precise);
}

// The rounding is a share of the focal length; of a wide fringe it is less of a period.
TEST(ChooseSampling, FinerFringesAskForDoublePrecisionEarlier) {
  const auto with_pitch = [](double pitch_px) {
    Twin twin = rig();
    twin.fringes.directions[0].pitches_px = {pitch_px};
    return twin;
  };
  EXPECT_NEAR(single_precision_error_rad(with_pitch(6.5)), 2.0 * single_precision_error_rad(rig()), 1e-12);
  EXPECT_TRUE(choose_sampling(with_pitch(6.5), options({}, {}, 9e-5)).precise);
  EXPECT_FALSE(choose_sampling(with_pitch(26.0), options({}, {}, 4e-5)).precise);
}

/// Returns by how much the rule of n points a side errs in the contrast of a fringe that turns by this across
/// the pixel.
double contrast_error(int n, double swing_rad) {
  const GaussRule& rule = gauss_rule(n);
  double mean = 0.0;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i)
    mean += 0.5 * rule.weights[i] * std::cos(0.5 * swing_rad * rule.nodes[i]);
  return std::abs(mean - std::sin(0.5 * swing_rad) / (0.5 * swing_rad));
}

// A pixel of a camera with a quarter of the projector's focal length sees four of the projector's pixels.
TEST(ChooseSampling, TheRuleThatStandsInIsTheSmallestThatKeepsTheContrast) {
  const Twin twin = rig();
  const Sampling adaptive = choose_sampling(twin, options({}, {}, 1e-4));
  ASSERT_EQ(adaptive.sampler, Sampler::adaptive);
  for (const auto& [camera_focal_px, points] : {std::pair{1701.22 / 4.0, 3}, {4.0 * 1701.22, 2}}) {
    const Lens lens("LENSMODEL_PINHOLE", {camera_focal_px, camera_focal_px, 640, 400}, {1280, 800}, "test");
    const Camera camera{"left", lens, Pose{}, Sensor{}, std::nullopt};
    const double swing_rad = 2.0 * std::numbers::pi / 13.0 * 1701.22 / camera_focal_px;
    EXPECT_LT(contrast_error(points, swing_rad), adaptive.gray_error);
    if (points > 2) {
      EXPECT_GT(contrast_error(points - 1, swing_rad), adaptive.gray_error);
    }
    EXPECT_EQ(without_adaptation(adaptive, twin, camera).samples, points * points);
  }
}

// Levels 0, 1, 0, 1 are a square wave of half the period: harmonics 2, 6, 10, ... of 4 A / pi over 1, 3, 5.
// A wave of one period of the same height has at most half of that in harmonic 2. The blurs leave of the
// second harmonic what counts as much as the first.
TEST(ChooseSampling, TheRuleThatStandsInHoldsHarmonicsOfAnyWaveform) {
  Twin twin = rig();
  twin.fringes.waveform = {Waveform::Kind::levels, {0.0, 1.0, 0.0, 1.0}};
  const Sampling adaptive = choose_sampling(twin, options({}, {}, 1e-4));
  std::set<int> chosen;
  for (const double blur_px : {2.0, 2.3}) {
    twin.projector->blur_px = blur_px;
    const auto error = [&](int points, double swing_rad) {
      double sum = 0.0;
      for (const int m : {1, 3, 5, 7}) {
        const double turn_rad = std::numbers::pi * 2 * m * blur_px / 13.0,
                     size = 4.0 * twin.fringes.amplitude / std::numbers::pi / m *
                            std::exp(-2.0 * turn_rad * turn_rad);
        sum += size * contrast_error(points, 2 * m * swing_rad);
      }
      return sum;
    };
    for (double camera_focal_px = 300.0; camera_focal_px < 6000.0; camera_focal_px *= 1.02) {
      const Lens lens("LENSMODEL_PINHOLE", {camera_focal_px, camera_focal_px, 640, 400}, {1280, 800}, "test");
      const Camera camera{"left", lens, Pose{}, Sensor{}, std::nullopt};
      const double swing_rad = 2.0 * std::numbers::pi / 13.0 * 1701.22 / camera_focal_px;
      const int points =
          static_cast<int>(std::lround(std::sqrt(without_adaptation(adaptive, twin, camera).samples)));
      chosen.insert(points);
      if (points == 6) continue;  // the most that are taken
      EXPECT_LT(error(points, swing_rad), adaptive.gray_error) << camera_focal_px << ' ' << blur_px;
      EXPECT_LT(contrast_error(points, swing_rad), adaptive.gray_error) << camera_focal_px;
    }
  }
  EXPECT_TRUE(chosen.contains(2) && chosen.contains(3) && chosen.contains(4));
}

TEST(ChooseSampling, TheUsersChoiceStands) {
  EXPECT_EQ(choose_sampling(rig(), options(9, Sampler::gauss)).samples, 9);
  const Sampling paper = choose_sampling(rig(), options(1024, {}));
  EXPECT_EQ(paper.samples, 1024);
  EXPECT_EQ(paper.sampler, Sampler::multi_jittered);
  EXPECT_EQ(choose_sampling(rig(), options(100, {})).sampler, Sampler::gauss);
  EXPECT_EQ(choose_sampling(rig(), options(7, {})).sampler, Sampler::multi_jittered);
}

void expect_usage_error(const RenderOptions& o) {
  try {
    choose_sampling(rig(), o);
    ADD_FAILURE() << "accepted";
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
  }
}

TEST(ChooseSampling, BadValuesAreRefused) {
  expect_usage_error(options(0, {}));
  expect_usage_error(options(-4, Sampler::sobol));
  expect_usage_error(options(65537, Sampler::sobol));
  expect_usage_error(options(8, Sampler::gauss));
  expect_usage_error(options(289, Sampler::gauss));
  expect_usage_error(options({}, {}, 0.0));
  expect_usage_error(options({}, {}, std::nan("")));
  RenderOptions fill;
  fill.pixel_fill = -1.0;
  expect_usage_error(fill);
}

}  // namespace
}  // namespace fringetwin::render::sample_table_test
