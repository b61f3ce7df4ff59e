// SPDX-License-Identifier: Apache-2.0
// Gray code, two directions, other steps and origins against the reference.
// | tolerance | unit           | origin                                                               |
// |-----------|----------------|----------------------------------------------------------------------|
// | 5e-5      | full scale rms | as for the shapes; also Gray code where no edge crosses the pixel    |
// | 5e-3      | of the light   | share of a code word in a pixel: half of it the truth's own grid     |
// | 2e-4      | full scale rms | that over all pixels, of which one in fifty has an edge              |
// | 5e-4      | full scale rms | the same with several edges in every pixel                           |
// | 1e-6      | full scale rms | two renderings of the same points: single precision alone            |
// | 1e-5      | full scale rms | blur wider than the pixel: the truth is exact, fp32 and erf leave 3e-6 |
// | 4e-5      | rad rms        | as for the shapes                                                    |
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <iostream>
#include <string>

#include "render/base/quadrature.hpp"
#include "render/pattern/waveform.hpp"
#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::patterns_test {
namespace {

Twin window() { return with_object(left_window({0, 0, 300}, 160, 120), "plane", tilted_plane()); }

Twin gray_code_twin(GrayCode::Threshold threshold, bool lsb_first) {
  Twin twin = window();
  twin.fringes.unwrap = Unwrap::gray;
  twin.fringes.steps = 4;
  DirectionFringes d;
  d.axis = Axis::x;
  d.pitches_px = {20.0};
  d.phase_origin_px = {-0.5};
  GrayCode gray;
  gray.bits = 6;
  gray.lsb_first = lsb_first;
  gray.complementary = true;
  gray.offset_periods = 0.25;
  gray.threshold = threshold;
  d.gray = gray;
  twin.fringes.directions = {d};
  return twin;
}

/// Irradiance of the Gray images over one pixel in double: 8 Gauss points across the code, 256 midpoints
/// along it, so that a sharp edge is placed to 1/512 px. Entry 0 is the light of a white image.
std::vector<double> fine_truth(const render::Reference& reference, const std::vector<PatternSpec>& specs,
                               const std::vector<render::EffectivePattern>& patterns, Axis axis, int x,
                               int y) {
  constexpr int midpoints = 256;
  const render::GaussRule& rule = render::gauss_rule(8);
  std::vector<double> sums(specs.size() + 1, 0.0);
  for (std::size_t j = 0; j < rule.nodes.size(); ++j)
    for (int i = 0; i < midpoints; ++i) {
      const double along = (i + 0.5) / midpoints - 0.5, across = 0.5 * rule.nodes[j];
      const auto s = axis == Axis::x ? reference.sample(0, {x + along, y + across})
                                     : reference.sample(0, {x + across, y + along});
      if (!s.lit) continue;
      const double w = s.weight * 0.5 * rule.weights[j] / midpoints;
      const double coordinate = axis == Axis::x ? s.projector_px.x() : s.projector_px.y();
      sums[0] += w;
      for (std::size_t k = 0; k < specs.size(); ++k) sums[k + 1] += w * patterns[k](coordinate);
    }
  return sums;
}

/// Gray images over whole pixels: those inside one code word to rounding, those with an edge to the share
/// of it that each word covers.
void expect_code(const Twin& twin, const std::string& what, int stride, double rms_limit) {
  const auto rendered = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  const render::Reference reference(twin);
  const auto sequence = expand_sequence(twin.fringes);
  std::vector<PatternSpec> specs;
  std::vector<render::EffectivePattern> patterns;
  std::vector<std::size_t> images;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (sequence[i].is_gray()) {
      specs.push_back(sequence[i]);
      patterns.emplace_back(twin, sequence[i]);
      images.push_back(i);
    }
  const Lens& lens = twin.cameras[0].lens;
  std::vector<std::pair<int, int>> pixels;
  for (int y = 1; y < lens.height() - 1; y += stride)
    for (int x = 1; x < lens.width() - 1; x += stride)
      if (reference.is_whole(0, x, y)) pixels.emplace_back(x, y);
  const double full_scale = twin.cameras[0].sensor.max_dn() / twin.cameras[0].sensor.gain_dn;
  double uniform_sum = 0.0, sum = 0.0, worst = 0.0;
  int uniform = 0, bright = 0, mixed = 0, n = 0;
#pragma omp parallel for schedule(dynamic) reduction(+ : uniform_sum, sum, uniform, bright, mixed, n) \
    reduction(max : worst)
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const auto [x, y] = pixels[p];
    const auto truth = fine_truth(reference, specs, patterns, twin.fringes.directions[0].axis, x, y);
    for (std::size_t k = 0; k < specs.size(); ++k) {
      const double share = truth[k + 1] / truth[0];
      const double error = rendered.irradiance[images[k]](x, y) - truth[k + 1];
      sum += std::pow(error / full_scale, 2);
      ++n;
      if (share > 1e-9 && share < 1 - 1e-9) {
        ++mixed;
        worst = std::max(worst, std::abs(error) / truth[0]);
      } else {
        ++uniform;
        bright += share > 0.5;
        uniform_sum += std::pow(error / full_scale, 2);
      }
    }
  }
  std::cout << what << ": " << uniform << " uniform values, rms "
            << std::sqrt(uniform_sum / std::max(1, uniform)) << ", " << mixed << " mixed, worst share "
            << worst << ", all rms " << std::sqrt(sum / n) << "\n";
  EXPECT_GT(n, 1000) << what;
  EXPECT_GT(mixed, 15) << what;
  EXPECT_LE(worst, 5e-3) << what;
  EXPECT_LE(std::sqrt(uniform_sum / std::max(1, uniform)), 5e-5) << what;
  EXPECT_LE(std::sqrt(sum / n), rms_limit) << what;
  if (uniform == 0) return;
  EXPECT_GT(bright, uniform / 5) << what;
  EXPECT_LT(bright, uniform - uniform / 5) << what;
}

TEST(Patterns, GrayCodeMsbFirst) {
  REQUIRE_RENDERER();
  expect_code(gray_code_twin(GrayCode::Threshold::mean, false), "MSB first", 7, 2e-4);
}

TEST(Patterns, GrayCodeLsbFirstInPairsAlongY) {
  REQUIRE_RENDERER();
  Twin twin = gray_code_twin(GrayCode::Threshold::inverse, true);
  twin.fringes.directions[0].axis = Axis::y;
  expect_code(twin, "LSB first along y", 7, 2e-4);
}

// A projector whose black is not dark: a response of two levels. Every image, black and code, too, is that of
// a dark black in closed form, b W + (1 - b) E, with W the white image's light.
TEST(Patterns, BlackOfTheProjectorThatIsNotDark) {
  REQUIRE_RENDERER();
  constexpr double kBlack = 0.02;
  Twin twin = gray_code_twin(GrayCode::Threshold::white_black, false);
  const render::RenderedCamera dark = shared_renderer()->render(twin, 0, {Sampler::gauss, 16});
  twin.projector->response = {ProjectorResponse::Kind::table, 1.0, {kBlack, 1.0}};
  const render::RenderedCamera lit = shared_renderer()->render(twin, 0, {Sampler::gauss, 16});
  const double full_scale = twin.cameras[0].sensor.max_dn() / twin.cameras[0].sensor.gain_dn;
  const auto expect_mixed = [&](const ImageF& with, const ImageF& without, const std::string& what) {
    double squares = 0.0;
    for (std::size_t i = 0; i < with.size(); ++i) {
      const auto mixed = kBlack * static_cast<double>(dark.white->data[i]) +
                         (1.0 - kBlack) * static_cast<double>(without.data[i]);
      squares += std::pow((static_cast<double>(with.data[i]) - mixed) / full_scale, 2);
    }
    EXPECT_LE(std::sqrt(squares / static_cast<double>(with.size())), 1e-6) << what;
  };
  ASSERT_TRUE(lit.white && lit.black && dark.white && dark.black);
  expect_mixed(*lit.white, *dark.white, "white");
  expect_mixed(*lit.black, *dark.black, "black");
  for (std::size_t k = 0; k < lit.irradiance.size(); ++k)
    expect_mixed(lit.irradiance[k], dark.irradiance[k], std::to_string(k));
}

// Edges across the pixels' diagonals.
TEST(Patterns, GrayCodeOfATurnedProjector) {
  REQUIRE_RENDERER();
  for (const double turn : {0.35, -0.78}) {
    Twin twin = gray_code_twin(GrayCode::Threshold::mean, false);
    twin.projector->T_proj_world =
        Pose{rotation_from_vector({0, 0, turn}), Eigen::Vector3d::Zero()} * twin.projector->T_proj_world;
    expect_code(twin, "turned projector", 9, 2e-4);
  }
}

TEST(Patterns, GrayCodeOnASphere) {
  REQUIRE_RENDERER();
  Twin twin = gray_code_twin(GrayCode::Threshold::mean, false);
  twin.objects.clear();
  twin = with_object(twin, "sphere", SphereShape{{0, 0, 300}, 12.0});
  expect_code(twin, "sphere", 7, 2e-4);
}

TEST(Patterns, BlurredGrayCode) {
  REQUIRE_RENDERER();
  for (const double blur_px : {1.5, 0.3, 0.05}) {
    Twin twin = gray_code_twin(GrayCode::Threshold::mean, false);
    twin.projector->blur_px = blur_px;
    expect_code(twin, "blur " + std::to_string(blur_px), 9, blur_px > 1.0 ? 1e-5 : 2e-4);
  }
}

// Words of 1.25 px, half words of less than a camera pixel: several edges in every pixel.
TEST(Patterns, GrayCodeNearTheProjectorsResolution) {
  REQUIRE_RENDERER();
  for (const double blur_px : {0.0, 0.05, 0.4, 1.0}) {
    Twin twin = gray_code_twin(GrayCode::Threshold::mean, false);
    DirectionFringes& d = twin.fringes.directions[0];
    d.pitches_px = {1.25};
    d.gray->bits = 10;
    twin.projector->blur_px = blur_px;
    expect_code(twin, "10 bits, blur " + std::to_string(blur_px), 13, 5e-4);
  }
}

TEST(Patterns, WhiteAndBlackReferenceImages) {
  REQUIRE_RENDERER();
  Twin twin = gray_code_twin(GrayCode::Threshold::white_black, false);
  twin.projector->ambient = 0.3;
  const auto rendered = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  ASSERT_TRUE(rendered.white && rendered.black);
  const render::Reference reference(twin);
  for (const auto& p : reference_block(reference, 0, whole_image(twin, 0, 17))) {
    if (!p.interior) continue;
    EXPECT_NEAR((*rendered.white)(p.x, p.y), p.pixel.mean + 0.3, 1e-5);
    EXPECT_NEAR((*rendered.black)(p.x, p.y), 0.3, 1e-6);
  }
}

TEST(Patterns, TwoDirectionsOddStepsAndOrigins) {
  REQUIRE_RENDERER();
  Twin twin = window();
  twin.fringes.steps = 5;
  twin.fringes.mean = 0.45;
  twin.fringes.amplitude = 0.4;
  twin.fringes.directions[0].phase_origin_px = {-0.5, 3.75, 639.5};
  DirectionFringes y;
  y.axis = Axis::y;
  y.pitches_px = {12.5, 90.0, 720.0};
  y.phase_origin_px = {1.25, -7.0, 0.0};
  twin.fringes.directions.push_back(y);
  ASSERT_EQ(expect_agreement(twin, "two directions", 1001).pitches.size(), 6u);
}

// Many pitches: more than one trace holds.
TEST(Patterns, TwelvePitches) {
  REQUIRE_RENDERER();
  Twin twin = window();
  DirectionFringes& d = twin.fringes.directions[0];
  d.pitches_px.clear();
  for (int i = 0; i < 12; ++i) d.pitches_px.push_back(13.0 + 3.5 * i);
  d.phase_origin_px.assign(12, 0.0);
  twin.fringes.steps = 3;
  const Agreement a = agreement(twin, 0, render::choose_sampling(twin), whole_image(twin, 0, 4));
  std::cout << "twelve pitches: " << a.text() << "\n";
  ASSERT_EQ(a.pitches.size(), 12u);
  EXPECT_LE(a.worst_phase_rms_rad(), 4e-5);
}

}  // namespace
}  // namespace fringetwin::testing::patterns_test
