// SPDX-License-Identifier: Apache-2.0
// Gray values of a window, on the paper's sphere as a rule, with an error and noise, as samples that
// parameters are fitted to; the truth is rendered, or traced by the double-precision reference.
#pragma once
#include <functional>
#include <iterator>
#include <random>
#include <vector>

#include "compare/causes/sensitivity.hpp"
#include "render/reference/reference.hpp"
#include "tests/support/agreement.hpp"

namespace fringetwin::compare::planted_samples {

inline constexpr int kWidth = 48, kHeight = 40;
inline constexpr double kGain = 20.0, kBlack = 7.0, kNoiseDn = 0.3;

using Images = std::vector<std::vector<ImageF>>;  ///< irradiance per camera and image

inline Images rendered(const Twin& twin) {
  Images out;
  for (std::size_t c = 0; c < twin.cameras.size(); ++c)
    out.push_back(render_grid(testing::needed_renderer(), twin, c, {1, 0, 0, kWidth, kHeight}, 9));
  return out;
}

/// What is done to the irradiance of a pixel of a camera in an image.
using Error = std::function<double(double e, std::size_t camera, int image, int x, int y)>;

/// Returns samples of gray values with the error and noise, and the twin's own images as their frame.
inline std::vector<GridSamples> samples_of(const Images& truth, const Error& error,
                                           const std::vector<CameraImages>& frames,
                                           double noise_dn = kNoiseDn) {
  std::vector<GridSamples> all;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, noise_dn);
  for (std::size_t c = 0; c < truth.size(); ++c) {
    GridSamples s;
    s.camera = c;
    const int width = truth[c][0].width;
    s.grid = {1, 0, 0, width, truth[c][0].height};
    s.gain_dn = kGain;
    s.black_level_dn = kBlack;
    s.frame = &frames[c];
    for (int k = 0; k < static_cast<int>(truth[c].size()); ++k) s.images.push_back(k);
    for (std::size_t i = 0; i < truth[c][0].size(); ++i) {
      s.cell.push_back(i);
      for (const int k : s.images) {
        const double e = error(static_cast<double>(truth[c][static_cast<std::size_t>(k)].data[i]), c, k,
                               static_cast<int>(i) % width, static_cast<int>(i) / width);
        s.real_dn.push_back(static_cast<float>(kGain * e + kBlack + noise(random)));
        s.weight.push_back(static_cast<float>(1.0 / noise_dn));
      }
    }
    all.push_back(std::move(s));
  }
  return all;
}

/// Returns irradiance by the double-precision reference, which knows no Fourier series of a pattern.
inline Images traced_by_reference(const Twin& truth) {
  const render::Reference reference(truth);
  Images images;
  for (std::size_t c = 0; c < truth.cameras.size(); ++c) {
    const int width = truth.cameras[c].lens.width(), height = truth.cameras[c].lens.height();
    images.emplace_back(expand_sequence(truth.fringes).size(), ImageF(width, height, 0.0F));
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < width * height; ++i) {
      const auto pixel = reference.pixel(c, i % width, i / width, {.gauss_n = 4});
      for (std::size_t k = 0; k < images[c].size(); ++k)
        images[c][k].data[static_cast<std::size_t>(i)] = static_cast<float>(pixel.irradiance[k]);
    }
  }
  return images;
}

inline std::vector<CameraImages> frames_of(const Images& images) {
  std::vector<CameraImages> frames;
  for (std::vector<ImageF> camera : images)
    frames.push_back(
        {.images = {std::make_move_iterator(camera.begin()), std::make_move_iterator(camera.end())},
         .radiance = true});
  return frames;
}

/// No error.
inline double same(double e, std::size_t, int, int, int) { return e; }

}  // namespace fringetwin::compare::planted_samples
