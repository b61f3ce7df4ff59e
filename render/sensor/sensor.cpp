// SPDX-License-Identifier: Apache-2.0
#include "render/sensor/sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include "render/base/normal_deviates.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

// Image numbers of the two reference images, far from any sequence index.
constexpr std::uint32_t kWhiteImage = 0xFFFFFFFEu, kBlackImage = 0xFFFFFFFFu;

/// Returns the gray value stored for a signal. It is rounded by truncation after adding a half: std::round()
/// would be a call of the library for every pixel. NaN stays.
float stored(double dn, double max_dn) {
  const double inside = dn > 0.0 ? std::min(dn, max_dn) : 0.0;
  const auto rounded = static_cast<float>(static_cast<std::int32_t>(inside + 0.5));
  return dn == dn ? rounded : std::numeric_limits<float>::quiet_NaN();
}

/// The signal of a sensor whose gray values are straight over the light.
struct StraightLine {
  explicit StraightLine(const Sensor&) {}
  double signal_dn(double light_dn) const { return light_dn; }
  double shot_variance(double light_dn, double per_light) const {
    return std::max(0.0, light_dn) * per_light;
  }
};

/// The signal of a sensor with a response: shot noise is the light's, and goes through the curve as it does.
struct Curve {
  const CameraResponse& response;
  explicit Curve(const Sensor& sensor) : response(sensor.response) {}
  double signal_dn(double light_dn) const { return response(light_dn); }
  double shot_variance(double light_dn, double per_light) const {
    const double slope = response.slope(light_dn);
    return slope * slope * std::max(0.0, light_dn) * per_light;
  }
};

/// Gain and black level of a sensor whose pixels are all alike.
struct LikePixels {
  static constexpr bool kAllAlike = true;
  double gain, black;
  explicit LikePixels(const Sensor& sensor) : gain(sensor.gain_dn), black(sensor.black_level_dn) {}
  double gain_dn(std::size_t) const { return gain; }
  double black_level_dn(std::size_t) const { return black; }
};

/// Gain and black level of a sensor whose pixels have a factor, an offset or both of their own.
struct OwnPixels {
  static constexpr bool kAllAlike = false;
  const Sensor& sensor;
  explicit OwnPixels(const Sensor& of) : sensor(of) {}
  double gain_dn(std::size_t pixel) const {
    return sensor.prnu.values ? sensor.gain_dn * static_cast<double>(sensor.prnu.values->data[pixel])
                              : sensor.gain_dn;
  }
  double black_level_dn(std::size_t pixel) const {
    return sensor.dsnu.values ? sensor.black_level_dn + static_cast<double>(sensor.dsnu.values->data[pixel])
                              : sensor.black_level_dn;
  }
};

/// The formula of sensor.hpp with a sensor's numbers.
template <class Response, class Pixels>
struct Formula {
  double shot_per_light, read_variance, max_dn;
  Response response;
  Pixels pixels;

  explicit Formula(const Sensor& sensor)
      : shot_per_light(sensor.electrons_per_dn ? 1.0 / *sensor.electrons_per_dn : 0.0),
        read_variance(std::pow(sensor.read_noise_dn.value_or(0.0), 2)),
        max_dn(sensor.max_dn()),
        response(sensor),
        pixels(sensor) {}

  double light_dn(float irradiance, std::size_t pixel) const {
    return pixels.gain_dn(pixel) * static_cast<double>(irradiance);
  }
  double signal_dn(double light) const { return response.signal_dn(light); }
  double black_level_dn(std::size_t pixel) const { return pixels.black_level_dn(pixel); }
  float noiseless(float irradiance, std::size_t pixel) const {
    return stored(signal_dn(light_dn(irradiance, pixel)) + black_level_dn(pixel), max_dn);
  }
  double sigma_dn(double light) const {
    return std::sqrt(response.shot_variance(light, shot_per_light) + read_variance);
  }
};

using Block = std::array<double, kMostDeviates>;

template <class SensorFormula>
float exact_value(const SensorFormula& formula, float irradiance, std::size_t pixel, double deviate) {
  const double light = formula.light_dn(irradiance, pixel);
  return stored(formula.signal_dn(light) + formula.black_level_dn(pixel) + formula.sigma_dn(light) * deviate,
                formula.max_dn);
}

/// Computes gray values from near deviates, NaN where another one is possible with the exact deviate.
/// Rounding is monotone: a value is sure where both ends of the deviate's error are stored alike.
template <class SensorFormula>
void near_values(const SensorFormula& formula, std::size_t first, std::span<const float> irradiance,
                 const Block& deviates, float* gray) {
  constexpr double kArithmetic = 1e-14;  // of the formula's own rounding, a few units of 1.1e-16 of each term
  for (std::size_t i = 0; i < irradiance.size(); ++i) {
    const double light = formula.light_dn(irradiance[i], first + i), sigma = formula.sigma_dn(light),
                 signal = formula.signal_dn(light), black_dn = formula.black_level_dn(first + i);
    const double dn = signal + black_dn + sigma * deviates[i];
    const double error = kDeviateError * sigma + kArithmetic * (std::abs(signal) + std::abs(black_dn));
    const float low = stored(dn - error, formula.max_dn), high = stored(dn + error, formula.max_dn);
    gray[i] = low == high ? low : std::numeric_limits<float>::quiet_NaN();
  }
}

/// Exposes up to kMostDeviates pixels from pixel `first` on.
template <class SensorFormula>
void expose_block(const SensorFormula& formula, const DeviateSource& source, std::size_t first,
                  std::span<const float> irradiance, float* gray) {
  Block deviates;
  near_deviates(source, first, &deviates);
  near_values(formula, first, irradiance, deviates, gray);
  for (std::size_t i = 0; i < irradiance.size(); ++i)
    if (std::isnan(gray[i]))
      gray[i] = exact_value(formula, irradiance[i], first + i, exact_deviate(source, first + i));
}

/// Exposes pixels without light, from pixel `first` on, of a sensor without read noise.
template <class Response, class Pixels>
void expose_dark(const Formula<Response, Pixels>& formula, std::size_t first, std::span<float> gray) {
  if constexpr (Pixels::kAllAlike) {
    std::ranges::fill(gray, formula.noiseless(0.0F, first));
  } else {
    for (std::size_t i = 0; i < gray.size(); ++i) gray[i] = formula.noiseless(0.0F, first + i);
  }
}

bool dark(std::span<const float> irradiance) {
  return std::ranges::all_of(irradiance, [](float e) { return e == 0.0F; });
}

// Returns n values of an image from `first` on; `room` holds them where the image keeps none.
std::span<const float> part_of(const ImageF& image, std::size_t first, std::size_t n, std::vector<float>&) {
  return {image.data.data() + first, n};
}
std::span<const float> part_of(const GrayImage& image, std::size_t first, std::size_t n,
                               std::vector<float>& room) {
  return image.values(first, n, room);
}

template <class Response, class Pixels, class Irradiance>
ImageF expose_by(const Irradiance& irradiance, const Sensor& sensor, std::uint64_t seed, std::uint32_t camera,
                 std::uint32_t image) {
  ImageF gray(irradiance.width, irradiance.height);
  const auto n = static_cast<std::int64_t>(irradiance.size());
  const Formula<Response, Pixels> formula(sensor);
  if (!sensor.has_noise()) {
#pragma omp parallel for schedule(static)
    for (std::int64_t i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      gray.data[at] = formula.noiseless(irradiance[at], at);
    }
    return gray;
  }
  const DeviateSource source{
      {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}, image, camera};
  constexpr auto kBlock = static_cast<std::int64_t>(kMostDeviates);
#pragma omp parallel
  {
    std::vector<float> room;
#pragma omp for schedule(static)
    for (std::int64_t first = 0; first < n; first += kBlock) {
      const auto at = static_cast<std::size_t>(first);
      const std::span<const float> lit =
          part_of(irradiance, at, static_cast<std::size_t>(std::min(kBlock, n - first)), room);
      // Most blocks of most images are dark: without light there is no shot noise.
      if (formula.read_variance == 0.0 && dark(lit))
        expose_dark(formula, at, {gray.data.data() + at, lit.size()});
      else
        expose_block(formula, source, at, lit, gray.data.data() + at);
    }
  }
  return gray;
}

template <class Pixels, class Irradiance>
ImageF expose_pixels(const Irradiance& irradiance, const Sensor& sensor, std::uint64_t seed,
                     std::uint32_t camera, std::uint32_t image) {
  return sensor.response.straight() ? expose_by<StraightLine, Pixels>(irradiance, sensor, seed, camera, image)
                                    : expose_by<Curve, Pixels>(irradiance, sensor, seed, camera, image);
}

template <class Irradiance>
ImageF expose_image(const Irradiance& irradiance, const Sensor& sensor, std::uint64_t seed,
                    std::uint32_t camera, std::uint32_t image) {
  FT_CHECK(sensor.bit_depth >= 1 && sensor.bit_depth <= 16, "sensor bit depth");
  if (!sensor.has_maps()) return expose_pixels<LikePixels>(irradiance, sensor, seed, camera, image);
  for (const PixelMap* map : {&sensor.prnu, &sensor.dsnu})
    FT_CHECK(!map->values || map->values->same_size(irradiance), "a sensor's map has the size of the image");
  return expose_pixels<OwnPixels>(irradiance, sensor, seed, camera, image);
}

template <class Images>
CameraImages expose_images(const RenderedCamera& rendered, const Images& irradiance, const Camera& camera,
                           std::size_t camera_index, std::uint64_t seed) {
  const auto number = static_cast<std::uint32_t>(camera_index);
  CameraImages out{.camera = rendered.camera, .bit_depth = camera.sensor.bit_depth};
  out.images.reserve(irradiance.size());
  const auto exposed = [&](const auto& light, std::uint32_t image) {
    return GrayImage::packed(expose(light, camera.sensor, seed, number, image));
  };
  for (std::size_t i = 0; i < irradiance.size(); ++i)
    out.images.push_back(exposed(irradiance[i], static_cast<std::uint32_t>(i)));
  if (rendered.white) out.white = exposed(*rendered.white, kWhiteImage);
  if (rendered.black) out.black = exposed(*rendered.black, kBlackImage);
  return out;
}

}  // namespace

ImageF expose(const ImageF& irradiance, const Sensor& sensor, std::uint64_t seed, std::uint32_t camera,
              std::uint32_t image) {
  return expose_image(irradiance, sensor, seed, camera, image);
}

ImageF expose(const GrayImage& irradiance, const Sensor& sensor, std::uint64_t seed, std::uint32_t camera,
              std::uint32_t image) {
  return expose_image(irradiance, sensor, seed, camera, image);
}

CameraImages expose(const RenderedCamera& rendered, const Camera& camera, std::size_t camera_index,
                    std::uint64_t seed) {
  return expose_images(rendered, rendered.irradiance, camera, camera_index, seed);
}

CameraImages expose(const KeptCamera& kept, const Camera& camera, std::size_t camera_index,
                    std::uint64_t seed) {
  return expose_images(kept.rendered, kept.irradiance, camera, camera_index, seed);
}

CameraImages as_radiance(KeptCamera kept) {
  return {.camera = std::move(kept.rendered.camera),
          .images = std::move(kept.irradiance),
          .white = std::move(kept.rendered.white),
          .black = std::move(kept.rendered.black),
          .radiance = true};
}

CameraImages as_radiance(RenderedCamera rendered) {
  CameraImages out{.camera = std::move(rendered.camera),
                   .images = {std::make_move_iterator(rendered.irradiance.begin()),
                              std::make_move_iterator(rendered.irradiance.end())},
                   .white = std::move(rendered.white),
                   .black = std::move(rendered.black),
                   .radiance = true};
  return out;
}

}  // namespace fringetwin::render
