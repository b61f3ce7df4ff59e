// SPDX-License-Identifier: Apache-2.0
#include "render/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "render/philox.hpp"
#include "twin/errors.hpp"

namespace fringetwin::render {
namespace {

// Image numbers of the two reference images, far from any sequence index.
constexpr std::uint32_t white_image = 0xFFFFFFFEu, black_image = 0xFFFFFFFFu;

/// In (0, 1): the share of normal deviates that are larger than this one in magnitude, or more.
double radius_share(const PhiloxCounter& w) {
  const std::uint64_t bits = (std::uint64_t{w[0]} << 32) | w[1];
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

/// One standard normal deviate from the words of a counter (Box-Muller, 53-bit radius).
double standard_normal(const PhiloxCounter& w) {
  const double u = radius_share(w);
  const double angle = 2.0 * std::numbers::pi * static_cast<double>(w[2]) * 0x1p-32;
  return std::sqrt(-2.0 * std::log(u)) * std::cos(angle);
}

/// Most pixels of most images are dark, and the noise of most dark pixels is less than the rounding: their
/// deviates, |n| <= sqrt(-2 ln u), need not be worked out where u says so.
double share_lost_in_rounding(double dark_dn, double sigma_dn, double max_dn) {
  const double level = std::floor(dark_dn + 0.5);
  double room = HUGE_VAL;
  if (level > 0.0) room = dark_dn - (level - 0.5);
  if (level < max_dn) room = std::min(room, level + 0.5 - dark_dn);
  constexpr double rounding = 1.0 + 1e-9;  // of the deviate's own arithmetic
  return std::exp(-0.5 * std::pow(room / (rounding * sigma_dn), 2));
}

}  // namespace

ImageF expose(const ImageF& irradiance, const Sensor& sensor, std::uint64_t seed, std::uint32_t camera,
              std::uint32_t image) {
  FT_CHECK(sensor.bit_depth >= 1 && sensor.bit_depth <= 16, "sensor bit depth");
  const double read_variance = std::pow(sensor.read_noise_dn.value_or(0.0), 2);
  const double shot_per_signal = sensor.electrons_per_dn ? 1.0 / *sensor.electrons_per_dn : 0.0;
  const bool noisy = sensor.has_noise();
  const double max_dn = sensor.max_dn();
  const PhiloxKey key{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)};
  ImageF gray(irradiance.width, irradiance.height);
  const auto n = static_cast<std::int64_t>(irradiance.size());
  // Truncation after adding a half: std::round() would be a call of the library for every pixel. NaN stays.
  const auto stored = [max_dn](double dn) {
    const double inside = dn > 0.0 ? std::min(dn, max_dn) : 0.0;
    const auto rounded = static_cast<float>(static_cast<std::int32_t>(inside + 0.5));
    return dn == dn ? rounded : std::numeric_limits<float>::quiet_NaN();
  };
  if (!noisy) {
#pragma omp parallel for schedule(static)
    for (std::int64_t i = 0; i < n; ++i) {
      const auto pixel = static_cast<std::size_t>(i);
      gray.data[pixel] =
          stored(sensor.gain_dn * static_cast<double>(irradiance.data[pixel]) + sensor.black_level_dn);
    }
    return gray;
  }
  const float dark = stored(sensor.black_level_dn);
  const double dark_sigma = std::sqrt(read_variance);
  const double lost = share_lost_in_rounding(sensor.black_level_dn, dark_sigma, max_dn);
#pragma omp parallel for schedule(static)
  for (std::int64_t i = 0; i < n; ++i) {
    const auto pixel = static_cast<std::size_t>(i);
    if (irradiance.data[pixel] == 0.0F && dark_sigma == 0.0) {
      gray.data[pixel] = dark;
      continue;
    }
    const double signal = sensor.gain_dn * static_cast<double>(irradiance.data[pixel]);
    const double variance = std::max(0.0, signal) * shot_per_signal + read_variance;
    const PhiloxCounter counter{static_cast<std::uint32_t>(pixel),
                                static_cast<std::uint32_t>(std::uint64_t{pixel} >> 32), image, camera};
    const PhiloxCounter words = philox4x32(counter, key);
    if (irradiance.data[pixel] == 0.0F && radius_share(words) > lost) {
      gray.data[pixel] = dark;
      continue;
    }
    gray.data[pixel] = stored(signal + sensor.black_level_dn + std::sqrt(variance) * standard_normal(words));
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
