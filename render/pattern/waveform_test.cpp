// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit        | origin                                                          |
// |-----------|-------------|-----------------------------------------------------------------|
// | 1e-14     | full scale  | closed forms, rounding of ~50 additions                          |
// | 1e-12     | full scale  | series against direct convolution, ~1e4 additions                |
// | 2e-7      | full scale  | float32 storage of a waveform                                    |
#include "render/pattern/waveform.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/base/quadrature.hpp"
#include "render/pattern/waveform_tables.hpp"

namespace fringetwin::render::waveform_test {
namespace {

double effective_pattern_value(const Twin& twin, const PatternSpec& pattern, double coordinate_px) {
  return EffectivePattern(twin, pattern)(coordinate_px);
}

constexpr double pi = std::numbers::pi;

Lens pinhole(int width, int height) {
  return Lens("LENSMODEL_PINHOLE", {1700.0, 1700.0, (width - 1) / 2.0, (height - 1) / 2.0}, {width, height},
              "test projector");
}

Twin fringe_twin(ProjectorResponse response, double blur_px) {
  Twin twin;
  twin.projector.emplace(Projector{pinhole(1280, 720), {}, 1.0, false, 0.0, 0.0, {}, 0.0});
  twin.projector->response = std::move(response);
  twin.projector->blur_px = blur_px;
  DirectionFringes d;
  d.axis = Axis::x;
  d.pitches_px = {13.0, 14.0, 15.5};
  d.phase_origin_px = {0.0, 2.25, -1.5};
  twin.fringes.directions = {d};
  return twin;
}

Twin gray_twin(double blur_px, Axis axis = Axis::x) {
  Twin twin = fringe_twin({}, blur_px);
  DirectionFringes& d = twin.fringes.directions[0];
  d.axis = axis;
  d.pitches_px = {40.0};
  d.phase_origin_px = {-0.5};
  d.gray = GrayCode{.bits = 5, .complementary = true, .offset_periods = 0.25};
  twin.fringes.unwrap = Unwrap::gray;
  return twin;
}

ProjectorResponse gamma_response(double gamma) { return {ProjectorResponse::Kind::gamma, gamma, {}}; }
ProjectorResponse table_response() {
  return {ProjectorResponse::Kind::table, 1.0, {0.02, 0.1, 0.35, 0.8, 0.97}};
}

PatternSpec phase_step(int pitch, int step) { return {.pitch = pitch, .step = step}; }

double theta(const Twin& twin, const PatternSpec& p, double x) {
  const DirectionFringes& d = twin.fringes.directions[0];
  return 2.0 * pi * (x - d.phase_origin_px[p.pitch]) / d.pitches_px[p.pitch] +
         2.0 * pi * p.step / twin.fringes.steps;
}

TEST(Quadrature, IntegratesPolynomialsOfDegree2nMinus1) {
  for (int n = 1; n <= 64; ++n) {
    const GaussRule& rule = gauss_rule(n);
    double weights = 0.0, even = 0.0, odd = 0.0;
    for (int i = 0; i < n; ++i) {
      weights += rule.weights[i];
      even += rule.weights[i] * std::pow(rule.nodes[i], 2 * n - 2);
      odd += rule.weights[i] * std::pow(rule.nodes[i], 2 * n - 1);
    }
    EXPECT_NEAR(weights, 2.0, 1e-13) << n;
    EXPECT_NEAR(even, 2.0 / (2 * n - 1), 1e-13) << n;
    EXPECT_NEAR(odd, 0.0, 1e-14) << n;
  }
  EXPECT_NEAR(gauss_rule(2).nodes[1], 1.0 / std::sqrt(3.0), 3e-16);
}

TEST(CosineSeriesTest, LinearIsMeanAndAmplitude) {
  const PhaseSeries s = cosine_series({}, 0.5, 0.4, 3);
  EXPECT_EQ(s.a, (std::vector<double>{0.5, 0.4, 0.0, 0.0}));
}

// (m + a cos t)^2 = m^2 + a^2/2 + 2 m a cos t + a^2/2 cos 2t
TEST(CosineSeriesTest, GammaTwoHasThreeTerms) {
  for (const auto& [m, a] : {std::pair{0.5, 0.5}, {0.45, 0.3}, {0.6, 0.4}}) {
    const PhaseSeries s = cosine_series(gamma_response(2.0), m, a, 8);
    EXPECT_NEAR(s.a[0], m * m + a * a / 2, 1e-14);
    EXPECT_NEAR(s.a[1], 2 * m * a, 1e-14);
    EXPECT_NEAR(s.a[2], a * a / 2, 1e-14);
    for (int k = 3; k <= 8; ++k) EXPECT_NEAR(s.a[k], 0.0, 1e-14) << k;
  }
}

// (1/2 + 1/2 cos t)^g = cos(t/2)^(2g): a_0 = Gamma(2g+1) / (4^g Gamma(g+1)^2), and
// a_(k+1)/a_k = (g - k)/(g + k + 1) (the first ratio doubles, as a_0 is not doubled).
TEST(CosineSeriesTest, FullContrastPowerLawAgainstGammaFunctions) {
  for (double g : {2.2, 1.8, 0.45, 2.6}) {
    const PhaseSeries s = cosine_series(gamma_response(g), 0.5, 0.5, 60);
    double expected = std::tgamma(2 * g + 1) / (std::pow(4.0, g) * std::pow(std::tgamma(g + 1), 2));
    EXPECT_NEAR(s.a[0], expected, 1e-13) << g;
    expected *= 2.0;
    for (int k = 0; k < 60; ++k) {
      expected *= (g - k) / (g + k + 1);
      EXPECT_NEAR(s.a[k + 1], expected, 1e-13) << "gamma " << g << " harmonic " << k + 1;
    }
  }
}

// A two-level table {0, 1} is linear; {1, 0} is 1 - v.
TEST(CosineSeriesTest, TablesIntegratePiecewise) {
  const ProjectorResponse inverse{ProjectorResponse::Kind::table, 1.0, {1.0, 0.0}};
  const PhaseSeries s = cosine_series(inverse, 0.5, 0.4, 5);
  EXPECT_NEAR(s.a[0], 0.5, 1e-15);
  EXPECT_NEAR(s.a[1], -0.4, 1e-15);
  for (int k = 2; k <= 5; ++k) EXPECT_NEAR(s.a[k], 0.0, 1e-15);
  // {0, 0, 1}: max(0, 2v - 1) at m = a = 1/2 is max(0, cos t): the half-wave rectifier
  const ProjectorResponse rectifier{ProjectorResponse::Kind::table, 1.0, {0.0, 0.0, 1.0}};
  const PhaseSeries r = cosine_series(rectifier, 0.5, 0.5, 6);
  EXPECT_NEAR(r.a[0], 1 / pi, 1e-15);
  EXPECT_NEAR(r.a[1], 0.5, 1e-15);
  EXPECT_NEAR(r.a[2], 2 / (3 * pi), 1e-15);
  EXPECT_NEAR(r.a[3], 0.0, 1e-15);
  EXPECT_NEAR(r.a[4], -2 / (15 * pi), 1e-15);
}

TEST(CosineSeriesTest, ClenshawEqualsTheSum) {
  const PhaseSeries s{{0.3, -0.2, 0.5, 0.125}};
  for (double t : {-2.0, 0.0, 0.7, pi, 9.0})
    EXPECT_NEAR(s(t), 0.3 - 0.2 * std::cos(t) + 0.5 * std::cos(2 * t) + 0.125 * std::cos(3 * t), 1e-15);
}

TEST(EffectivePatternTest, WithoutEffectsItIsThePatternItself) {
  for (const Twin& twin : {fringe_twin({}, 0.0), fringe_twin(gamma_response(1.0), 0.0)})
    for (int pitch = 0; pitch < 3; ++pitch)
      for (int step = 0; step < 4; ++step)
        for (double x : {-0.5, 0.0, 3.3, 700.125, 1279.5})
          EXPECT_EQ(effective_pattern_value(twin, phase_step(pitch, step), x),
                    pattern_value(twin.fringes, phase_step(pitch, step), x));
}

TEST(EffectivePatternTest, ResponseActsOnTheValue) {
  const Twin twin = fringe_twin(gamma_response(2.2), 0.0);
  const PatternSpec p = phase_step(1, 3);
  for (double x : {0.0, 3.3, 641.77})
    EXPECT_NEAR(effective_pattern_value(twin, p, x), std::pow(0.5 + 0.5 * std::cos(theta(twin, p, x)), 2.2),
                1e-14);
}

TEST(EffectivePatternTest, BlurOfAPureCosineLowersItsContrastOnly) {
  const double sigma = 1.7;
  const Twin twin = fringe_twin({}, sigma);
  for (int pitch = 0; pitch < 3; ++pitch) {
    const PatternSpec p = phase_step(pitch, 1);
    const double u = pi * sigma / twin.fringes.directions[0].pitches_px[pitch];
    for (double x : {0.0, 3.3, 641.77})
      EXPECT_NEAR(effective_pattern_value(twin, p, x),
                  0.5 + 0.5 * std::exp(-2 * u * u) * std::cos(theta(twin, p, x)), 1e-14);
  }
}

// Squaring first gives harmonics 1 and 2, each with its own attenuation: response, then blur.
TEST(EffectivePatternTest, BlurFollowsTheResponse) {
  const double sigma = 2.0;
  const Twin twin = fringe_twin(gamma_response(2.0), sigma);
  const PatternSpec p = phase_step(0, 2);
  const double g1 = blur_attenuation(1, sigma, 13.0), g2 = blur_attenuation(2, sigma, 13.0);
  EXPECT_NEAR(g2, std::pow(g1, 4), 1e-15);
  for (double x : {0.0, 3.3, 641.77}) {
    const double t = theta(twin, p, x);
    EXPECT_NEAR(effective_pattern_value(twin, p, x),
                0.375 + 0.5 * g1 * std::cos(t) + 0.125 * g2 * std::cos(2 * t), 1e-14);
  }
}

// An independent sum: the trapezoid rule on a Gaussian converges beyond all orders for an analytic
// integrand; at the kinks of a table or of a power law it is only good to h^2.
TEST(EffectivePatternTest, BlurEqualsASumOverTheGaussian) {
  struct Case {
    ProjectorResponse response;
    double sigma, tolerance;
  };
  for (const Case& c : {Case{gamma_response(2.2), 1.0, 1e-9},
                        {gamma_response(3.0), 0.7, 1e-13},
                        {table_response(), 1.3, 1e-7},
                        {gamma_response(2.0), 0.004, 1e-13},
                        {gamma_response(2.2), 0.004, 1e-12}}) {
    const Twin twin = fringe_twin(c.response, c.sigma);
    const PatternSpec p = phase_step(2, 1);
    for (double x : {0.0, 5.9, 641.77}) {
      double sum = 0.0, weights = 0.0;
      for (int i = -40000; i <= 40000; ++i) {
        const double u = 9.0 * i / 40000.0, w = std::exp(-0.5 * u * u);
        sum += w * twin.projector->response(
                       std::clamp(0.5 + 0.5 * std::cos(theta(twin, p, x + c.sigma * u)), 0.0, 1.0));
        weights += w;
      }
      EXPECT_NEAR(effective_pattern_value(twin, p, x), sum / weights, c.tolerance)
          << "sigma " << c.sigma << " x " << x;
    }
  }
}

// The two methods meet at sigma = 4.43 pitch / (512 pi): no step there.
TEST(EffectivePatternTest, SeriesAndConvolutionMeet) {
  const double limit = 4.43 * 13.0 / (512 * pi);
  for (const ProjectorResponse& response : {gamma_response(2.2), table_response()}) {
    const Twin below = fringe_twin(response, limit * (1 - 1e-9)),
               above = fringe_twin(response, limit * (1 + 1e-9));
    for (double x : {0.0, 3.25, 6.5, 6.5001, 9.1})
      EXPECT_NEAR(effective_pattern_value(below, phase_step(0, 0), x),
                  effective_pattern_value(above, phase_step(0, 0), x), 1e-11)
          << x;
  }
}

TEST(EffectivePatternTest, GrayImagesAreSumsOfErfEdges) {
  const double sigma = 1.5;
  const Twin twin = gray_twin(sigma);
  const PatternSpec lsb{.kind = PatternSpec::Kind::gray_bit, .bit = 4};
  // bit 4 of the words 0, 1, 2, 3, 4...: 0 1 1 0 0 1 1 ...: edges at word starts 1, 3, 5...
  const double start = -0.5 + 0.25 * 40.0;
  const auto rise = [&](double x, double edge) {
    return 0.5 * std::erfc((edge - x) / sigma / std::sqrt(2.0));
  };
  for (double x :
       {start + 38.0, start + 40.0, start + 41.3, start + 60.0, start + 118.0, start + 120.0, start + 160.0})
    EXPECT_NEAR(effective_pattern_value(twin, lsb, x),
                rise(x, start + 40) - rise(x, start + 120) + rise(x, start + 200), 1e-14)
        << x;
  const PatternSpec extra{.kind = PatternSpec::Kind::complementary};
  // last bit of the 6-bit code of half words: edges at half words 1, 3, 5...
  for (double x : {start + 19.0, start + 20.0, start + 21.0, start + 59.5, start + 61.0})
    EXPECT_NEAR(effective_pattern_value(twin, extra, x),
                rise(x, start + 20) - rise(x, start + 60) + rise(x, start + 100), 1e-14)
        << x;
}

// The first word shown is 0; before it a code that goes on would have its last one, whose highest bit is 1.
TEST(EffectivePatternTest, BeyondTheImageAHaloSeesTheLastPixelsOfACode) {
  Twin twin = gray_twin(30.0);
  twin.fringes.directions[0].phase_origin_px[0] = -0.5;
  twin.fringes.directions[0].gray->offset_periods = 0.0;
  const PatternSpec msb{.kind = PatternSpec::Kind::gray_bit, .bit = 0};
  EXPECT_NEAR(effective_pattern_value(twin, msb, 0.0), 0.5, 0.01);
  twin.projector->halo = {{.share = 0.1, .sigma_px = 5.0}};
  EXPECT_NEAR(effective_pattern_value(twin, msb, 0.0), 0.0, 1e-15);
  twin.projector->pixel_structure = true;
  EXPECT_NEAR(effective_pattern_value(twin, msb, 0.0), 0.0, 1e-15);
}

TEST(EffectivePatternTest, GrayWithoutBlurIsSharpAndBlurVanishesAwayFromEdges) {
  const Twin sharp = gray_twin(0.0), soft = gray_twin(1.0);
  for (const PatternSpec& p : expand_sequence(sharp.fringes)) {
    if (!p.is_gray()) continue;
    for (double x = 19.5; x < 1270.0; x += 20.0)  // 10 px from every half word's border
      EXPECT_NEAR(effective_pattern_value(soft, p, x), effective_pattern_value(sharp, p, x), 1e-15) << x;
  }
}

TEST(EffectivePatternTest, GrayLevelsPassTheResponse) {
  Twin twin = gray_twin(0.8);
  twin.projector->response = table_response();
  const PatternSpec msb{.kind = PatternSpec::Kind::gray_bit, .bit = 0};
  const double start = -0.5 + 0.25 * 40.0;
  EXPECT_NEAR(effective_pattern_value(twin, msb, start + 200.0), 0.02, 1e-15);
  EXPECT_NEAR(effective_pattern_value(twin, msb, start + 16 * 40.0), 0.5 * (0.02 + 0.97), 1e-14);
  EXPECT_NEAR(effective_pattern_value(twin, msb, start + 900.0), 0.97, 1e-14);
}

TEST(Waveforms, OnePeriodStartsAtThetaZero) {
  const Twin twin = fringe_twin(gamma_response(2.2), 0.9);
  for (int step = 0; step < 4; ++step) {
    const PatternSpec p = phase_step(1, step);
    const auto w = periodic_waveform(twin, p, 256);
    ASSERT_EQ(w.size(), 256u);
    for (int i = 0; i < 256; i += 17)
      EXPECT_NEAR(w[i], effective_pattern_value(twin, p, 2.25 + 14.0 * i / 256), 2e-7);
  }
  EXPECT_NEAR(periodic_waveform(fringe_twin({}, 0.0), phase_step(2, 0), 64)[0], 1.0, 2e-7);
  EXPECT_NEAR(periodic_waveform(fringe_twin({}, 0.0), phase_step(2, 1), 64)[0], 0.5, 2e-7);
  EXPECT_NEAR(periodic_waveform(fringe_twin({}, 0.0), phase_step(2, 1), 64)[16], 0.0,
              2e-7);  // cos falls first
}

TEST(Waveforms, TheAxisIsCoveredWithMargin) {
  for (Axis axis : {Axis::x, Axis::y}) {
    const Twin twin = gray_twin(1.2, axis);
    const PatternSpec p{.kind = PatternSpec::Kind::gray_bit, .bit = 2};
    double first = 0.0;
    const auto w = axis_waveform(twin, p, 8.0, &first);
    const int size = axis == Axis::x ? 1280 : 720;
    EXPECT_LE(first, -0.5);
    EXPECT_GE(first + static_cast<double>(w.size() - 1) / 8.0, size - 0.5);
    for (std::size_t i = 0; i < w.size(); i += 97)
      EXPECT_NEAR(w[i], effective_pattern_value(twin, p, first + static_cast<double>(i) / 8.0), 2e-7);
  }
}

// Coefficients of a period by the midpoint rule, whose error is of second order between the kinks.
TEST(FringeSeriesTest, WaveformsAgainstPlainSums) {
  Fringes fringes;
  fringes.mean = 0.45;
  fringes.amplitude = 0.4;
  const Harmonics added{{0.01, -0.02}, {0.0, 0.03}};
  constexpr int kSamples = 280'000;  // no edge of 5, 7 or 8 parts lies inside an interval
  for (const Waveform& waveform : {Waveform{Waveform::Kind::levels, {0.9, 0.1, 0.3, 1.0, 0.0}},
                                   Waveform{Waveform::Kind::table, {1.0, 0.9, 0.2, 0.1, 0.0, 0.3, 0.7}},
                                   Waveform{Waveform::Kind::sine, {}}})
    for (const ProjectorResponse& response : {ProjectorResponse{}, gamma_response(2.2), table_response()}) {
      fringes.waveform = waveform;
      const PhaseSeries s = fringe_series(response, fringes, added, 12);
      for (const int k : {0, 1, 3, 12}) {
        double a = 0.0, b = 0.0;
        for (int i = 0; i < kSamples; ++i) {
          const double turns = (i + 0.5) / kSamples, t = 2.0 * pi * turns;
          const double light = response(0.45 + 0.4 * waveform(turns)) + 0.01 * std::cos(2 * t) -
                               0.02 * std::sin(2 * t) + 0.03 * std::sin(3 * t);
          a += light * std::cos(k * t);
          b += light * std::sin(k * t);
        }
        EXPECT_NEAR(s.a[static_cast<std::size_t>(k)], (k == 0 ? 1.0 : 2.0) * a / kSamples, 1e-9) << k;
        EXPECT_NEAR(s.sine(static_cast<std::size_t>(k)), 2.0 * b / kSamples, 1e-9) << k;
      }
      EXPECT_NEAR(
          s(1.3),
          [&] {
            double sum = s.a[0];
            for (std::size_t k = 1; k < s.a.size(); ++k) {
              const double angle = 1.3 * static_cast<double>(k);
              sum += s.a[k] * std::cos(angle) + s.sine(k) * std::sin(angle);
            }
            return sum;
          }(),
          1e-14);
    }
}

TEST(FringeSeriesTest, VariationOfAPeriod) {
  Fringes fringes;
  fringes.waveform = {Waveform::Kind::levels, {1.0, 0.0, 0.0, 1.0}};
  EXPECT_NEAR(total_variation({}, fringes), 2.0, 1e-15);
  fringes.waveform = {Waveform::Kind::table, {1.0, 0.25, 0.75, 0.0}};
  EXPECT_NEAR(total_variation({}, fringes), 0.75 + 0.5 + 0.75 + 1.0, 1e-15);
  const ProjectorResponse peak{ProjectorResponse::Kind::table, 1.0, {0.0, 1.0, 0.0}};
  fringes.waveform = {Waveform::Kind::table, {1.0, 0.0}};
  EXPECT_NEAR(total_variation(peak, fringes), 4.0, 1e-15);
}

// Each edge of a binary fringe becomes an error function; from 0.02 px on it is a series, below a
// convolution.
TEST(EffectivePatternTest, BinaryFringesAreErrorFunctions) {
  for (const double blur_px : {0.01, 0.5, 1.0, 3.0}) {
    Twin twin = fringe_twin({}, blur_px);
    twin.fringes.waveform = {Waveform::Kind::levels, {1.0, 0.0, 0.0, 1.0}};
    for (const int step : {0, 3})
      for (double x = 100.0; x < 130.0; x += 0.37) {
        const PatternSpec p = phase_step(1, step);
        const double bright = 2.25 - 14.0 * step / 4.0;  // the middle of a bright half
        double value = 0.0;
        for (int k = 0; k < 20; ++k) {
          const double middle = bright + 14.0 * k, scale = 1.0 / (blur_px * std::numbers::sqrt2);
          value += 0.5 * (std::erf((x - middle + 3.5) * scale) - std::erf((x - middle - 3.5) * scale));
        }
        EXPECT_NEAR(effective_pattern_value(twin, p, x), value, 1e-12) << blur_px << " " << x;
      }
  }
}

}  // namespace
}  // namespace fringetwin::render::waveform_test
