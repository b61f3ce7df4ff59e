// SPDX-License-Identifier: Apache-2.0
// Makes images of a scene whose projector coordinate is known at every pixel, formed from
// pattern_value() in double precision. Independent of the decoder.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "measure/decode/decode.hpp"

namespace fringetwin::testing {

struct FringeScene {
  ImageD column_px, row_px;                  ///< truth; row_px may be empty
  double black_dn = 10.0, white_dn = 210.0;  ///< gray value of pattern value 0 and 1
  ImageF albedo;                             ///< factor of (white - black); empty = 1
  double noise_dn = 0.0;                     ///< Gaussian, every image
  bool quantised = true;                     ///< 8 bit; else float "radiance"
  /// Gray bits are averaged over +-footprint/2 projector px, as a real pixel does.
  double footprint_px = 1.0;
  unsigned seed = 1;
  std::vector<double> light;  ///< of each image, over a steady lamp's; empty = 1
};

inline double bit_average(const Fringes& fringes, const PatternSpec& spec, double x_px, double footprint_px) {
  constexpr int kSamples = 8;
  double sum = 0.0;
  for (int i = 0; i < kSamples; ++i)
    sum += pattern_value(fringes, spec, x_px + footprint_px * ((i + 0.5) / kSamples - 0.5));
  return sum / kSamples;
}

inline CameraImages project(const Fringes& fringes, const FringeScene& scene) {
  std::mt19937 random(scene.seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  CameraImages out;
  out.camera = "synthetic";
  out.radiance = !scene.quantised;
  const int w = scene.column_px.width, h = scene.column_px.height;
  const auto expose = [&](const std::function<double(std::size_t)>& value) {
    const double light = scene.light.empty() ? 1.0 : scene.light.at(out.images.size());
    ImageF image(w, h);
    for (std::size_t i = 0; i < image.size(); ++i) {
      const double albedo = scene.albedo.empty() ? 1.0 : static_cast<double>(scene.albedo.data[i]);
      double dn = scene.black_dn + light * albedo * (scene.white_dn - scene.black_dn) * value(i);
      if (scene.noise_dn > 0.0) dn += scene.noise_dn * normal(random);
      if (scene.quantised) dn = std::clamp(std::round(dn), 0.0, 255.0);
      image.data[i] = static_cast<float>(dn);
    }
    return image;
  };
  for (const PatternSpec& spec : expand_sequence(fringes)) {
    const Axis axis = fringes.directions[static_cast<std::size_t>(spec.direction)].axis;
    const ImageD& truth = axis == Axis::x ? scene.column_px : scene.row_px;
    out.images.push_back(expose([&](std::size_t i) {
      return spec.is_gray() ? bit_average(fringes, spec, truth.data[i], scene.footprint_px)
                            : pattern_value(fringes, spec, truth.data[i]);
    }));
  }
  if (needs_white_black(fringes)) {
    out.white = expose([](std::size_t) { return 1.0; });
    out.black = expose([](std::size_t) { return 0.0; });
  }
  return out;
}

/// Coordinates rising along camera x from first to last, tilted a little along camera y.
inline ImageD ramp(int w, int h, double first_px, double last_px, double tilt_px = 0.0) {
  ImageD out(w, h);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const double f = w > 1 ? static_cast<double>(x) / (w - 1) : 0.0;
      const double g = h > 1 ? static_cast<double>(y) / (h - 1) : 0.0;
      out(x, y) = std::clamp(first_px + f * (last_px - first_px) + g * tilt_px, first_px, last_px);
    }
  return out;
}

inline Fringes one_direction(Unwrap unwrap, int steps, std::vector<double> pitches_px,
                             std::vector<double> origins_px) {
  Fringes f;
  f.unwrap = unwrap;
  f.steps = steps;
  f.directions.resize(1);
  f.directions[0].pitches_px = std::move(pitches_px);
  f.directions[0].phase_origin_px = std::move(origins_px);
  return f;
}

inline Fringes gray_fringes(int steps, double pitch, double origin, GrayCode code) {
  Fringes f = one_direction(Unwrap::gray, steps, {pitch}, {origin});
  f.directions[0].gray = code;
  return f;
}

inline measure::DecodeOptions projector_of_width(double width_px) {
  measure::DecodeOptions o;
  o.projector_width_px = width_px;
  return o;
}

/// 400 x 200 px, coordinates 2...1277 of a 1280 px projector, amplitude 40...90 DN.
inline FringeScene noisy_scene(double noise_dn) {
  FringeScene scene;
  scene.noise_dn = noise_dn;
  scene.column_px = ramp(400, 200, 2.0, 1277.0, 40.0);
  scene.albedo = ImageF(400, 200);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 400; ++x) scene.albedo(x, y) = 0.4f + 0.5f * static_cast<float>(y) / 199.0f;
  return scene;
}

struct DecodeErrors {
  std::size_t n_valid = 0, n_wrong = 0;  ///< wrong: more than a quarter of the finest period off
  double rms_px = 0.0, worst_px = 0.0;   ///< of those that are not wrong
};

inline DecodeErrors decode_errors(const measure::DirectionDecode& decoded, const ImageD& truth_px) {
  const double period = decoded.pitches_px[static_cast<std::size_t>(decoded.finest)];
  DecodeErrors e;
  double sum = 0.0;
  for (std::size_t i = 0; i < truth_px.size(); ++i) {
    if (!std::isfinite(decoded.coordinate_px.data[i])) continue;
    ++e.n_valid;
    const double error = decoded.coordinate_px.data[i] - truth_px.data[i];
    if (std::fabs(error) > 0.25 * period) {
      ++e.n_wrong;
      continue;
    }
    sum += error * error;
    e.worst_px = std::max(e.worst_px, std::fabs(error));
  }
  if (e.n_valid > e.n_wrong) e.rms_px = std::sqrt(sum / static_cast<double>(e.n_valid - e.n_wrong));
  return e;
}

}  // namespace fringetwin::testing
