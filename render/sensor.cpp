// SPDX-License-Identifier: Apache-2.0
#include "render/sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "render/normal_deviates.hpp"
#include "twin/errors.hpp"

namespace fringetwin::render {
namespace {

// Image numbers of the two reference images, far from any sequence index.
constexpr std::uint32_t white_image = 0xFFFFFFFEu, black_image = 0xFFFFFFFFu;

/// Gray value stored for a signal. Truncation after adding a half: std::round() would be a call of the
/// library for every pixel. NaN stays.
float stored(double dn, double max_dn) {
  const double inside = dn > 0.0 ? std::min(dn, max_dn) : 0.0;
  const auto rounded = static_cast<float>(static_cast<std::int32_t>(inside + 0.5));
  return dn == dn ? rounded : std::numeric_limits<float>::quiet_NaN();
}

/// A sensor with noise: the formula of sensor.hpp.
struct NoisyPixel {
  double gain_dn, black_level_dn, shot_per_signal, read_variance, max_dn;

  explicit NoisyPixel(const Sensor& sensor)
      : gain_dn(sensor.gain_dn),
        black_level_dn(sensor.black_level_dn),
        shot_per_signal(sensor.electrons_per_dn ? 1.0 / *sensor.electrons_per_dn : 0.0),
        read_variance(std::pow(sensor.read_noise_dn.value_or(0.0), 2)),
        max_dn(sensor.max_dn()) {}

  double signal_dn(float irradiance) const { return gain_dn * static_cast<double>(irradiance); }
  double sigma_dn(double signal) const {
    return std::sqrt(std::max(0.0, signal) * shot_per_signal + read_variance);
  }
};

using Block = std::array<double, kMostDeviates>;

float exact_value(const NoisyPixel& pixel, float irradiance, double deviate) {
  const double signal = pixel.signal_dn(irradiance);
  return stored(signal + pixel.black_level_dn + pixel.sigma_dn(signal) * deviate, pixel.max_dn);
}

/// Gray values from near deviates; whether any of them might be another one with the exact deviate; `unsure`:
/// which. Rounding is monotone: a value is sure where both ends of the deviate's error are stored alike.
bool near_values(const NoisyPixel& pixel, std::span<const float> irradiance, const Block& deviates,
                 float* gray, std::uint8_t* unsure) {
  constexpr double arithmetic = 1e-14;  // of the formula's own rounding, a few units of 1.1e-16 of each term
  int n_unsure = 0;
  for (std::size_t i = 0; i < irradiance.size(); ++i) {
    const double signal = pixel.signal_dn(irradiance[i]), sigma = pixel.sigma_dn(signal);
    const double dn = signal + pixel.black_level_dn + sigma * deviates[i];
    const double error =
        kDeviateError * sigma + arithmetic * (std::abs(signal) + std::abs(pixel.black_level_dn));
    const float low = stored(dn - error, pixel.max_dn), high = stored(dn + error, pixel.max_dn);
    gray[i] = low;
    unsure[i] = low == high ? 0 : 1;
    n_unsure += unsure[i];
  }
  return n_unsure > 0;
}

void expose_block(const NoisyPixel& pixel, const DeviateSource& source, std::uint64_t first,
                  std::span<const float> irradiance, float* gray) {
  Block deviates;
  near_deviates(source, first, &deviates);
  std::array<std::uint8_t, kMostDeviates> unsure;
  if (!near_values(pixel, irradiance, deviates, gray, unsure.data())) return;
  for (std::size_t i = 0; i < irradiance.size(); ++i)
    if (unsure[i]) gray[i] = exact_value(pixel, irradiance[i], exact_deviate(source, first + i));
}

bool dark(std::span<const float> irradiance) {
  return std::all_of(irradiance.begin(), irradiance.end(), [](float e) { return e == 0.0F; });
}

}  // namespace

ImageF expose(const ImageF& irradiance, const Sensor& sensor, std::uint64_t seed, std::uint32_t camera,
              std::uint32_t image) {
  FT_CHECK(sensor.bit_depth >= 1 && sensor.bit_depth <= 16, "sensor bit depth");
  ImageF gray(irradiance.width, irradiance.height);
  const auto n = static_cast<std::int64_t>(irradiance.size());
  if (!sensor.has_noise()) {
    const double max_dn = sensor.max_dn();
#pragma omp parallel for schedule(static)
    for (std::int64_t i = 0; i < n; ++i) {
      const auto pixel = static_cast<std::size_t>(i);
      gray.data[pixel] = stored(
          sensor.gain_dn * static_cast<double>(irradiance.data[pixel]) + sensor.black_level_dn, max_dn);
    }
    return gray;
  }
  const NoisyPixel pixel(sensor);
  const DeviateSource source{
      {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}, image, camera};
  constexpr auto block = static_cast<std::int64_t>(kMostDeviates);
#pragma omp parallel for schedule(static)
  for (std::int64_t first = 0; first < n; first += block) {
    const auto at = static_cast<std::size_t>(first);
    const std::span lit(irradiance.data.data() + at, static_cast<std::size_t>(std::min(block, n - first)));
    // Most blocks of most images are dark: no light, no shot noise.
    if (pixel.read_variance == 0.0 && dark(lit))
      std::fill_n(gray.data.data() + at, lit.size(), stored(sensor.black_level_dn, pixel.max_dn));
    else
      expose_block(pixel, source, at, lit, gray.data.data() + at);
  }
  return gray;
}

CameraImages expose(const RenderedCamera& rendered, const Camera& camera, std::size_t camera_index,
                    std::uint64_t seed) {
  const auto number = static_cast<std::uint32_t>(camera_index);
  CameraImages out;
  out.camera = rendered.camera;
  out.bit_depth = camera.sensor.bit_depth;
  out.images.reserve(rendered.irradiance.size());
  for (std::size_t i = 0; i < rendered.irradiance.size(); ++i)
    out.images.push_back(
        expose(rendered.irradiance[i], camera.sensor, seed, number, static_cast<std::uint32_t>(i)));
  if (rendered.white) out.white = expose(*rendered.white, camera.sensor, seed, number, white_image);
  if (rendered.black) out.black = expose(*rendered.black, camera.sensor, seed, number, black_image);
  return out;
}

CameraImages as_radiance(const RenderedCamera& rendered) {
  CameraImages out;
  out.camera = rendered.camera;
  out.images = rendered.irradiance;
  out.white = rendered.white;
  out.black = rendered.black;
  out.radiance = true;
  return out;
}

}  // namespace fringetwin::render
