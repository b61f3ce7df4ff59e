// SPDX-License-Identifier: Apache-2.0
// Draws the images of a camera whose sensor, projector and scene are known, from the closed forms and with
// the standard library's distributions: nothing of the renderer. For *_test.cpp only.
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "calib/photometry/photometry.hpp"

namespace fringetwin::testing {

struct TrueSensor {
  double electrons_per_dn = 40.0, read_noise_dn = 0.9, black_dn = 12.0;
  int bits = 8;
  bool poisson = false;  ///< else normal with the same variance: a quarter of the time
};

/// One gray value for an expected signal (DN above black).
inline float expose(double signal_dn, const TrueSensor& s, std::mt19937_64& random) {
  double dn = s.black_dn;
  double variance = s.read_noise_dn * s.read_noise_dn;
  if (s.poisson) {
    std::poisson_distribution<int> electrons(std::max(1e-9, signal_dn * s.electrons_per_dn));
    dn += electrons(random) / s.electrons_per_dn;
  } else {
    dn += signal_dn;
    variance += signal_dn / s.electrons_per_dn;
  }
  thread_local std::normal_distribution<double> normal;
  dn += std::sqrt(variance) * normal(random);
  return static_cast<float>(std::clamp(std::round(dn), 0.0, std::pow(2.0, s.bits) - 1.0));
}

struct TrueFringes {
  double gamma = 1.0, blur_px = 0.0, amplitude_dn = 80.0, brightest = 1.0;
  std::vector<double> pitches_px{64.0, 16.0, 4.0};
  int steps = 6;
  bool edges = false;
  double lean_px = 0.0;  ///< of the stripes, per row
  double flicker = 0.0;
  std::vector<double> lamp = {};  ///< of each image, instead of a flicker at random
};

inline constexpr int kDrawnWidth = 320, kDrawnHeight = 200;
inline constexpr double kPxPerColumn = 0.11;  ///< projector px per camera column

/// Light of the projector at x for step n: series of the response, each order lowered by the blur.
inline double projected_light(const TrueFringes& f, double pitch, int n, double x,
                              const std::vector<double>& orders) {
  const double theta = 2.0 * std::numbers::pi * (x / pitch + static_cast<double>(n) / f.steps);
  double sum = orders[0];
  for (std::size_t h = 1; h < orders.size(); ++h) {
    const double k = 2.0 * std::numbers::pi * static_cast<double>(h) / pitch;
    const double half = 0.5 * k * kPxPerColumn;  // the camera pixel's box
    sum += orders[h] * std::exp(-0.5 * k * k * f.blur_px * f.blur_px) * std::sin(half) / half *
           std::cos(static_cast<double>(h) * theta);
  }
  return sum;
}

/// Fourier series of ((1 + cos)/2)^gamma by a sum over the circle.
inline std::vector<double> response_orders(double gamma) {
  std::vector<double> out(12, 0.0);
  for (int i = 0; i < 4096; ++i) {
    const double t = 2.0 * std::numbers::pi * i / 4096.0;
    const double v = std::pow(0.5 + 0.5 * std::cos(t), gamma);
    for (std::size_t h = 0; h < out.size(); ++h)
      out[h] += (h == 0 ? 1.0 : 2.0) / 4096.0 * v * std::cos(static_cast<double>(h) * t);
  }
  return out;
}

inline Twin photometry_twin(const TrueFringes& f, const TrueSensor& s) {
  Twin twin;
  twin.cameras.push_back(
      {"left",
       Lens("LENSMODEL_PINHOLE", {400, 400, 0.5 * (kDrawnWidth - 1), 0.5 * (kDrawnHeight - 1)},
            {kDrawnWidth, kDrawnHeight}, "test"),
       Pose{}, Sensor{}, std::nullopt});
  twin.cameras[0].sensor.bit_depth = s.bits;
  twin.cameras[0].sensor.black_level_dn = s.black_dn;
  twin.fringes.steps = f.steps;
  twin.fringes.unwrap = Unwrap::none;
  DirectionFringes d;
  d.pitches_px = f.pitches_px;
  d.phase_origin_px.assign(f.pitches_px.size(), 0.0);
  twin.fringes.directions.push_back(d);
  return twin;
}

/// A surface whose brightness varies smoothly, or with edges everywhere.
inline double drawn_albedo(const TrueFringes& f, int x, int y) {
  const double smooth = 0.15 + 0.85 * (0.5 + 0.5 * std::sin(0.015 * x)) * (0.5 + 0.5 * std::cos(0.02 * y));
  if (!f.edges) return smooth;
  return (x / 23 + y / 17) % 2 == 0 ? smooth : 0.35 * smooth;
}

inline CameraImages drawn_fringes(const TrueFringes& f, const TrueSensor& s, std::mt19937_64& random) {
  CameraImages out;
  out.camera = "left";
  out.bit_depth = s.bits;
  const auto orders = response_orders(f.gamma);
  std::normal_distribution<double> flicker(1.0, f.flicker);
  ImageD albedo_map(kDrawnWidth, kDrawnHeight);
  for (int y = 0; y < kDrawnHeight; ++y)
    for (int x = 0; x < kDrawnWidth; ++x) albedo_map(x, y) = drawn_albedo(f, x, y);
  for (const double pitch : f.pitches_px)
    for (int n = 0; n < f.steps; ++n) {
      ImageF image(kDrawnWidth, kDrawnHeight);
      const double lamp = !f.lamp.empty()   ? f.lamp.at(out.images.size())
                          : f.flicker > 0.0 ? flicker(random)
                                            : 1.0;
      std::vector<double> row(kDrawnWidth);
      for (int y = 0; y < kDrawnHeight; ++y) {
        if (y == 0 || f.lean_px > 0.0)
          for (int x = 0; x < kDrawnWidth; ++x)
            row[static_cast<std::size_t>(x)] =
                projected_light(f, pitch, n, kPxPerColumn * x + f.lean_px * y, orders);
        for (int x = 0; x < kDrawnWidth; ++x)
          image(x, y) = expose(
              2.0 * f.amplitude_dn * lamp * albedo_map(x, y) * row[static_cast<std::size_t>(x)], s, random);
      }
      out.images.push_back(std::move(image));
    }
  return out;
}

inline calib::CameraPhotometry photometry_of(const TrueFringes& f, const TrueSensor& s,
                                             std::vector<CameraImages> captures) {
  calib::CameraFrames frames;
  frames.captures = std::move(captures);
  return calib::analyse_photometry(photometry_twin(f, s), {frames}).cameras[0];
}

}  // namespace fringetwin::testing
