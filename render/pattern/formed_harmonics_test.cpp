// SPDX-License-Identifier: Apache-2.0
// Harmonics from the fundamental against sums over points of the pixels (numbers of their own: no renderer).
// | tolerance | unit           | origin                                                          |
// |-----------|----------------|------------------------------------------------------------------|
// | the limit | irradiance     | what find_unformed() was asked for                               |
// | 3e-6      | of the light   | single precision: a contrast off by 2e-7, times k^2/2 = 18       |
// | 1e-4      | full scale     | required of the renderer                                         |
#include "render/pattern/formed_harmonics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <random>

#include "render/pattern/response_series.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::render::formed_harmonics_test {
namespace {

constexpr int kSide = 5, kOrders = 5, kPoints = 64;

/// Orders 2 to 6 of one pitch.
Twin twin_with_harmonics() {
  Twin twin = testing::only_camera(testing::paper_rig(), 0);
  twin.fringes.steps = 4;
  twin.fringes.directions[0] = {Axis::x, {13.0}, {0.0}, {}};
  twin.fringes.directions[0].harmonics = {
      {{0.004, -0.011}, {-0.003, 0.008}, {0.001, 0.005}, {0.002, -0.003}, {-0.001, 0.002}}};
  return twin;
}

HarmonicsPlan plan_of(const Twin& twin) {
  return plan_harmonics(twin, twin.cameras[0], choose_series(twin), 1e-4, 640.0, 360.0);
}

/// A surface with a crease: its phase (rad) and light at a place, pixels from the middle of the image.
struct Surface {
  double phase, gx, gy, xx, xy, yy;      // to second order
  double turn, across, at;               // more of the gradient beyond a line
  double light, light_x, light_y, step;  // and of the light

  double beyond(double x, double y) const { return std::cos(across) * x + std::sin(across) * y - at; }
  double phase_at(double x, double y) const {
    return phase + gx * x + gy * y + 0.5 * xx * x * x + xy * x * y + 0.5 * yy * y * y +
           turn * std::max(0.0, beyond(x, y));
  }
  double light_at(double x, double y) const {
    return light * (1.0 + light_x * x + light_y * y + (beyond(x, y) > 0.0 ? step : 0.0));
  }
};

/// Returns the mean of light times exp(i k phase) over a pixel.
std::complex<double> mean_of(const Surface& s, int k, int x, int y) {
  std::complex<double> sum = 0.0;
  for (int j = 0; j < kPoints; ++j)
    for (int i = 0; i < kPoints; ++i) {
      const double u = x + (i + 0.5) / kPoints - 0.5, v = y + (j + 0.5) / kPoints - 0.5;
      sum += s.light_at(u, v) * std::polar(1.0, k * s.phase_at(u, v));
    }
  return sum / static_cast<double>(kPoints * kPoints);
}

Transport transport_of(const Surface& s, const SeriesTable& series) {
  Transport t;
  t.series = series;
  t.mean = ImageF(kSide, kSide, 0.0F);
  t.cosine = t.sine = {{t.mean}};
  t.harmonics = {{{}}};
  t.own_harmonics = {{{}}};
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const std::complex<double> z = mean_of(s, 1, x - kSide / 2, y - kSide / 2);
      t.mean(x, y) = static_cast<float>(mean_of(s, 0, x - kSide / 2, y - kSide / 2).real());
      t.cosine[0][0](x, y) = static_cast<float>(z.real());
      t.sine[0][0](x, y) = static_cast<float>(z.imag());
    }
  return t;
}

constexpr std::uint32_t kMiddle = kSide * (kSide / 2) + kSide / 2;

/// Returns the error of all harmonics of the middle pixel together, as the renderer would form them.
double error_of_middle(const Surface& s, const Transport& t) {
  std::vector<float> values(2 * kOrders * kSide * kSide);
  std::vector<FormedPair> pairs;
  for (int k = 0; k < kOrders; ++k)
    pairs.push_back({&values[2 * k * kSide * kSide], &values[(2 * k + 1) * kSide * kSide]});
  form_harmonics(t, 0, 0, 13.0, 0.0, 0, kSide * kSide, pairs);
  double error = 0.0;
  for (int k = 2; k < kOrders + 2; ++k) {
    const std::complex<double> formed(pairs[k - 2].cosine[kMiddle], pairs[k - 2].sine[kMiddle]);
    error += t.series[0][0].size(k) * std::abs(formed - mean_of(s, k, 0, 0));
  }
  return error;
}

bool is_found(const Transport& t, const HarmonicsPlan& plan, double irradiance,
              const std::vector<PixelState>& states = {}) {
  std::vector<FormedError> large;
  find_unformed(t, plan, states, 0, 0, {irradiance, 1e9, 1.0}, &large);
  return std::ranges::find(large, kMiddle, &FormedError::place) != large.end();
}

TEST(FormedHarmonics, ErrIsFoundWhereItIsTooMuch) {
  const Twin twin = twin_with_harmonics();
  const SeriesTable series = choose_series(twin);
  const HarmonicsPlan plan = plan_of(twin);
  ASSERT_TRUE(plan.formed());
  std::mt19937 random(7);
  const auto draw = [&](double most) { return std::uniform_real_distribution<double>(-most, most)(random); };
  int n_formed = 0, n_found = 0;
  for (int i = 0; i < 300; ++i) {
    const double bent = i % 3 == 0 ? 0.1 : 0.01;
    const double creased = i % 2 == 0 ? 1.0 : 0.0;  // else within one surface
    const std::vector<PixelState> states(i % 2 == 0 ? 0 : kSide * kSide, PixelState::plain);
    const Surface s{draw(kTwoPi), draw(0.7),           draw(0.3),          draw(bent), draw(bent),
                    draw(bent),   draw(0.1 * creased), draw(kTwoPi),       draw(0.6),  1.0,
                    draw(0.05),   draw(0.05),          draw(0.2 * creased)};
    const Transport t = transport_of(s, series);
    const double error = error_of_middle(s, t);
    const bool found = is_found(t, plan, 5e-5, states);
    (found ? n_found : n_formed) += 1;
    if (!found) {
      EXPECT_LE(error, 5e-5 + 3e-6) << i;
    }
    if (error > 6e-6) {
      EXPECT_TRUE(is_found(t, plan, error - 3e-6, states)) << i << ": no bound of " << error;
    }
  }
  EXPECT_GT(n_formed, 50);
  EXPECT_GT(n_found, 50);
}

// A fringe of 13 px seen pixel by pixel, a little bent and shaded: nothing has to be traced.
TEST(FormedHarmonics, ServeSmoothSurfaces) {
  const Twin twin = twin_with_harmonics();
  for (const double gradient : {0.1, 0.48, 0.7}) {
    const Surface s{0.4, gradient, 0.02, 2e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0, 1.0, 0.01, 0.02, 0.0};
    const Transport t = transport_of(s, choose_series(twin));
    EXPECT_LE(error_of_middle(s, t), 3e-5) << gradient;
    EXPECT_FALSE(is_found(t, plan_of(twin), 1e-4)) << gradient;
  }
}

TEST(FormedHarmonics, EdgesAreFound) {
  const Twin twin = twin_with_harmonics();
  const Surface s{0.4, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
  Transport t = transport_of(s, choose_series(twin));
  EXPECT_FALSE(is_found(t, plan_of(twin), 1e-4));
  std::swap(t.cosine[0][0].data[kMiddle], t.sine[0][0].data[kMiddle]);  // of another depth
  EXPECT_TRUE(is_found(t, plan_of(twin), 1e-4));
}

TEST(FormedHarmonics, SumsOfTheirOwnTakeTheirPlace) {
  const Twin twin = twin_with_harmonics();
  const Surface s{0.4, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
  Transport t = transport_of(s, choose_series(twin));
  const HarmonicsPlan plan = plan_of(twin);
  ASSERT_EQ(plan.own.size(), 1u);
  for (const std::uint32_t place : {9u, 3u})
    keep_harmonics(plan.own[0], place, &t,
                   [&](std::size_t c) { return static_cast<float>(100 * place + c); });
  sort_harmonics(&t);
  std::vector<float> values(2 * kOrders * 8);
  std::vector<FormedPair> pairs;
  for (int k = 0; k < kOrders; ++k) pairs.push_back({&values[16 * k], &values[16 * k + 8]});
  form_harmonics(t, 0, 0, 13.0, 0.0, 2, 8, pairs);
  EXPECT_EQ(pairs[0].cosine[1], 304.0F);  // channels: mean, hits, the fundamental's two, order 2
  EXPECT_EQ(pairs[0].sine[1], 305.0F);
  EXPECT_EQ(pairs[4].sine[7], 913.0F);
  EXPECT_NEAR(pairs[0].cosine[0], mean_of(s, 2, 0, -2).real(), 1e-5);  // the third pixel of the first row
}

// Where the orders turn too fast for a pixel, or the light comes another way, they are summed up.
TEST(FormedHarmonics, StandBackWhereTheyDoNotApply) {
  Twin twin = twin_with_harmonics();
  EXPECT_TRUE(plan_of(twin).formed());
  twin.fringes.directions[0].pitches_px = {4.0};
  EXPECT_FALSE(plan_of(twin).formed());
  for (const auto& change : std::vector<std::function<void(Twin&)>>{
           [](Twin& t) { t.fringes.directions[0].harmonics.clear(); },
           [](Twin& t) {
             t.projector->optics = Optics{2.0, 16.0, 240.0};
           },
           [](Twin& t) {
             t.cameras[0].optics = Optics{2.0, 16.0, 240.0};
           },
           [](Twin& t) {
             t.projector->blur_field_px2 = {0.1, 0.0, 0.1, 0.0, 0.0};
           },
           [](Twin& t) {
             t.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
           },
           [](Twin& t) { t.render.bounces = 1; }}) {
    twin = twin_with_harmonics();
    change(twin);
    EXPECT_FALSE(plan_of(twin).formed());
  }
}

}  // namespace
}  // namespace fringetwin::render::formed_harmonics_test
