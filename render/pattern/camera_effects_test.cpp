// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit       | origin                                                             |
// |-----------|------------|--------------------------------------------------------------------|
// | 1e-12     |            | sums of a few dozen doubles                                         |
// | 1.5e-4    | relative   | aliasing of a sampled Gaussian of 0.75 px at 0.1 cycles/px: 1.1e-4    |
// | 1e-12     | relative   | contrast of the discrete Gaussian, its own closed form              |
// | 3e-7      | relative   | float images                                                        |
#include "render/pattern/camera_effects.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace fringetwin::render::camera_effects_test {
namespace {

constexpr double pi = std::numbers::pi;

double contrast(const std::vector<double>& kernel, double cycles_per_px) {
  double sum = kernel[0];
  for (std::size_t n = 1; n < kernel.size(); ++n)
    sum += 2.0 * kernel[n] * std::cos(2.0 * pi * cycles_per_px * static_cast<double>(n));
  return sum;
}

Camera camera(int width, int height) {
  return {.name = "c",
          .lens = Lens("LENSMODEL_PINHOLE", {200.0, 200.0, 0.5 * (width - 1), 0.5 * (height - 1)},
                       {width, height}, "c"),
          .T_cam_world = {},
          .sensor = {},
          .optics = {}};
}

ImageF noise(int width, int height) {
  ImageF image(width, height);
  unsigned state = 7;
  for (float& v : image.data) {
    state = state * 1664525U + 1013904223U;
    v = static_cast<float>(state >> 8) / 16777216.0F;
  }
  return image;
}

TEST(PsfKernel, HasUnitSumAndTheVarianceAskedFor) {
  for (const double sigma : {0.1, 0.3, 0.5, 0.74, 0.76, 1.0, 2.5, 7.0}) {
    const auto k = psf_kernel(sigma);
    double sum = k[0], variance = 0.0;
    for (std::size_t n = 1; n < k.size(); ++n) {
      sum += 2.0 * k[n];
      variance += 2.0 * k[n] * static_cast<double>(n * n);
    }
    EXPECT_NEAR(sum, 1.0, 1e-12) << sigma;
    EXPECT_NEAR(variance, sigma * sigma, sigma * sigma * (sigma < 1.0 ? 1.2e-3 : 2e-6)) << sigma;
  }
}

TEST(PsfKernel, ContrastOfAFringe) {
  for (const double f : {0.01, 0.05, 0.1}) {
    for (const double sigma : {0.75, 1.0, 2.0, 3.3})
      EXPECT_NEAR(contrast(psf_kernel(sigma), f) / std::exp(-2.0 * std::pow(pi * sigma * f, 2)), 1.0, 1.5e-4)
          << sigma << " " << f;
    for (const double sigma : {0.2, 0.5, 0.74}) {
      const double c = contrast(psf_kernel(sigma), f);
      EXPECT_NEAR(c, std::exp(-sigma * sigma * (1.0 - std::cos(2.0 * pi * f))), 1e-9) << sigma << " " << f;
      if (f <= 0.05) {
        EXPECT_NEAR(c / std::exp(-2.0 * std::pow(pi * sigma * f, 2)), 1.0, 3e-4);
      }
    }
  }
}

// The two-dimensional sum with its scaled border, without the separation.
TEST(Convolution, EqualsTheSumOverTheWholePlane) {
  const ImageF image = noise(23, 17);
  const auto k = psf_kernel(1.3);
  const ImageF out = convolve_separable(image, k);
  const auto weight = [&](int d) {
    return std::abs(d) < static_cast<int>(k.size()) ? k[static_cast<std::size_t>(std::abs(d))] : 0.0;
  };
  for (int y = 0; y < 17; ++y)
    for (int x = 0; x < 23; ++x) {
      double sum = 0.0, weights = 0.0;
      for (int j = 0; j < 17; ++j)
        for (int i = 0; i < 23; ++i) {
          const double w = weight(i - x) * weight(j - y);
          sum += w * image(i, j);
          weights += w;
        }
      EXPECT_NEAR(out(x, y), sum / weights, 3e-7);
    }
  const ImageF flat = convolve_separable(ImageF(9, 8, 2.5F), k);
  for (const float v : flat.data) EXPECT_FLOAT_EQ(v, 2.5F);  // the border gets no darker
}

TEST(VignettingMap, Cos4AndPolynomial) {
  Camera c = camera(161, 121);
  c.vignetting.kind = Vignetting::Kind::cos4;
  const ImageF cos4 = vignetting_map(c);
  EXPECT_FLOAT_EQ(cos4(80, 60), 1.0F);
  EXPECT_NEAR(cos4(0, 0), std::pow(200.0, 4) / std::pow(200.0 * 200.0 + 80.0 * 80.0 + 60.0 * 60.0, 2), 1e-7);
  c.vignetting = {Vignetting::Kind::polynomial, {-0.3, 0.1, -0.05}};
  const ImageF p = vignetting_map(c);
  const double s = (40.0 * 40.0 + 10.0 * 10.0) / (80.5 * 80.5 + 60.5 * 60.5);
  EXPECT_NEAR(p(120, 50), 1.0 - 0.3 * s + 0.1 * s * s - 0.05 * s * s * s, 1e-7);
  c.vignetting = {Vignetting::Kind::polynomial, {}, {0.02, -0.01}};
  const double corner = 0.5 * std::hypot(161, 121);
  EXPECT_NEAR(vignetting_map(c)(120, 50), 1.0 + (0.02 * 40.0 + 0.01 * 10.0) / corner, 1e-7);
}

TEST(CameraEffects, OffChangesNoBitAndOnActsOnEveryImage) {
  Camera c = camera(40, 30);
  RenderedCamera rendered;
  rendered.irradiance = {noise(40, 30), noise(40, 30)};
  rendered.white = noise(40, 30);
  const RenderedCamera before = rendered;
  apply_camera_effects(c, &rendered);
  EXPECT_EQ(rendered.irradiance[1].data, before.irradiance[1].data);
  EXPECT_EQ(rendered.white->data, before.white->data);
  c.vignetting.kind = Vignetting::Kind::cos4;
  c.psf_px = 0.9;
  apply_camera_effects(c, &rendered);
  const ImageF map = vignetting_map(c);
  ImageF expected = before.irradiance[0];
  for (std::size_t i = 0; i < expected.size(); ++i) expected.data[i] *= map.data[i];
  expected = convolve_separable(expected, psf_kernel(0.9));
  for (const ImageF* image : {&rendered.irradiance[0], &rendered.irradiance[1], &*rendered.white})
    EXPECT_EQ(image->data, expected.data);
  EXPECT_FALSE(rendered.black.has_value());
}

}  // namespace
}  // namespace fringetwin::render::camera_effects_test
