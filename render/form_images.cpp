// SPDX-License-Identifier: Apache-2.0
// Irradiance images from a transport: E = ambient + a_0 mean + sum_k a_k (C_k cos k d - S_k sin k d).
#include <cmath>
#include <numbers>

#include "render/renderer.hpp"
#include "twin/errors.hpp"

namespace fringetwin::render {

std::vector<ImageF> form_images(const Twin& twin, const Transport& transport) {
  const auto sequence = expand_sequence(twin.fringes);
  const auto n_pixels = static_cast<std::ptrdiff_t>(transport.mean.size());
  std::vector<ImageF> images(sequence.size());
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const PatternSpec& spec = sequence[i];
    ImageF image(transport.mean.width, transport.mean.height);
    float* out = image.data.data();
    const float* ambient = transport.ambient.data.data();
    if (i < transport.direct.size() && !transport.direct[i].empty()) {
      const float* direct = transport.direct[i].data.data();
#pragma omp parallel for
      for (std::ptrdiff_t k = 0; k < n_pixels; ++k) out[k] = ambient[k] + direct[k];
    } else {
      FT_CHECK(!spec.is_gray() && !transport.cosine.empty(), "transport without the image's sums");
      const auto d = static_cast<std::size_t>(spec.direction), p = static_cast<std::size_t>(spec.pitch);
      const double delta = 2.0 * std::numbers::pi * spec.step / twin.fringes.steps;
      const std::vector<double>& a = transport.series[d][p].a;
      const auto level = static_cast<float>(a[0]);
      const auto c = static_cast<float>(a[1] * std::cos(delta));
      const auto s = static_cast<float>(a[1] * std::sin(delta));
      const float* mean = transport.mean.data.data();
      const float* cosine = transport.cosine[d][p].data.data();
      const float* sine = transport.sine[d][p].data.data();
#pragma omp parallel for
      for (std::ptrdiff_t k = 0; k < n_pixels; ++k)
        out[k] = ambient[k] + level * mean[k] + c * cosine[k] - s * sine[k];
      for (std::size_t h = 2; h < a.size(); ++h) {
        const auto c_h = static_cast<float>(a[h] * std::cos(static_cast<double>(h) * delta));
        const auto s_h = static_cast<float>(a[h] * std::sin(static_cast<double>(h) * delta));
        const Transport::Pair& pair = transport.harmonics[d][p][h - 2];
        const float *cosine_h = pair.cosine.data.data(), *sine_h = pair.sine.data.data();
#pragma omp parallel for
        for (std::ptrdiff_t k = 0; k < n_pixels; ++k) out[k] += c_h * cosine_h[k] - s_h * sine_h[k];
      }
    }
    images[i] = std::move(image);
  }
  return images;
}

}  // namespace fringetwin::render
