// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/gray_pair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kLeastMarginDn = 2.0;  // from a clip
constexpr double kMostMargin = 0.25;    // of the range: noise that asks for more is no sensor's
constexpr double kLowestPixels = 1e-3;  // hot and dead ones: they do not bound the range of all others

/// Returns whether the Gray-code images have the exposure of the phase steps: one gain cannot fit two
/// exposures.
bool same_exposure(const CameraImages& images) {
  return !images.gray_code_exposure || std::abs(*images.gray_code_exposure - 1.0) < 1e-9;
}

/// Fills the pair's lists of images: those that are compared, and those on which the gain is fitted.
void choose_images(GrayPair& pair, const Twin& twin, const CompareOptions& options,
                   std::vector<std::string>& warnings) {
  const bool gray_compares = same_exposure(*pair.real) && same_exposure(*pair.irradiance);
  bool left_out = false;
  for (int i = 0; i < static_cast<int>(pair.patterns.size()); ++i) {
    const PatternSpec& pattern = pair.patterns[i];
    if (std::ranges::find(options.leave_out_images, i) != options.leave_out_images.end()) continue;
    if (pattern.is_image()) {
      pair.images.push_back(i);
      continue;
    }
    if (pattern.is_gray()) {
      if (gray_compares)
        pair.images.push_back(i);
      else
        left_out = true;
      continue;
    }
    const auto& use = options.use_steps;
    if (!use.empty() && std::ranges::find(use, pattern.step) == use.end()) continue;
    pair.images.push_back(i);
    pair.gain_images.push_back(i);
  }
  if (twin.fringes.steps == 0) pair.gain_images = pair.images;  // Gray code only
  if (left_out)
    warnings.push_back(
        fmt::format("{}: the Gray-code images have another exposure than the phase steps and are left out of "
                    "gain and gray",
                    pair.camera->name));
}

/// Throws UserError(input) unless there is one image of the camera's size for each image of the sequence.
void check_images(const CameraImages& images, const GrayPair& pair, const char* side) {
  const std::string where = std::string(side) + " images of camera \"" + pair.camera->name + "\"";
  if (images.images.size() != pair.patterns.size())
    throw UserError(
        ExitCode::input, where,
        fmt::format("{} images, but the fringe sequence has {}", images.images.size(), pair.patterns.size()),
        "give both sides the images of one sequence");
  for (const GrayImage& image : images.images)
    if (!image.same_size(pair.mask))
      throw UserError(ExitCode::input, where,
                      fmt::format("an image has {}x{} pixels, the camera {}x{}", image.width, image.height,
                                  pair.width(), pair.height()),
                      "use captures of this rig");
}

/// What a camera whose pixels are all alike, and whose response is straight, would have said of the light.
class Straightening {
 public:
  explicit Straightening(const Sensor& sensor)
      : sensor_(sensor), factors_(sensor.prnu.values.get()), offsets_(sensor.dsnu.values.get()) {}

  double operator()(double dn, std::size_t pixel) const {
    const double offset_dn = offsets_ ? static_cast<double>(offsets_->data[pixel]) : 0.0,
                 factor = factors_ ? static_cast<double>(factors_->data[pixel]) : 1.0;
    return sensor_.black_level_dn +
           sensor_.response.inverse(dn - sensor_.black_level_dn - offset_dn) / factor;
  }

  /// Returns the straightened value that most pixels reach with a gray value of `dn`.
  double reached_by_most(double dn) const {
    if (!sensor_.has_maps()) return (*this)(dn, 0);
    std::vector<double> reached(factors_ ? factors_->size() : offsets_->size());
    for (std::size_t i = 0; i < reached.size(); ++i) reached[i] = (*this)(dn, i);
    const auto lowest = static_cast<std::ptrdiff_t>(kLowestPixels * static_cast<double>(reached.size()));
    std::nth_element(reached.begin(), reached.begin() + lowest, reached.end());
    return reached[static_cast<std::size_t>(lowest)];
  }

 private:
  const Sensor& sensor_;
  const ImageF *factors_, *offsets_;
};

/// Puts straightened images in the place of those that were taken; irradiance is straight.
void straighten(GrayPair& pair) {
  const Sensor& sensor = pair.camera->sensor;
  if (!pair.real->radiance) {
    pair.straight_real = straightened(*pair.real, sensor);
    pair.real = pair.straight_real.get();
  }
  if (pair.simulated && !pair.simulated->radiance) {
    pair.straight_simulated = straightened(*pair.simulated, sensor);
    pair.simulated = pair.straight_simulated.get();
  }
}

}  // namespace

std::shared_ptr<const CameraImages> straightened(const CameraImages& images, const Sensor& sensor) {
  const Straightening straight(sensor);
  const double saturation_dn = images.saturation_dn();
  // Compared with straightened values, which are floats: the bound is rounded as they are.
  const auto bound = static_cast<float>(straight.reached_by_most(saturation_dn));
  auto out = std::make_shared<CameraImages>(images);
  for (GrayImage& image : out->images) {
    std::vector<float>& values = image.as_floats();
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto dn = static_cast<double>(values[i]);
      const auto value = static_cast<float>(straight(dn, i));
      values[i] = dn >= saturation_dn ? std::max(value, bound) : dn <= 0.0 ? std::min(value, 0.0F) : value;
    }
  }
  out->clip = Clip{static_cast<double>(bound), images.clip ? images.clip->n : 0};
  return out;
}

std::vector<int> GrayPair::gain_and_code_images() const {
  std::vector<int> out;
  std::ranges::copy_if(images, std::back_inserter(out),
                       [this](int image) { return !patterns[static_cast<std::size_t>(image)].is_image(); });
  return out;
}

std::vector<int> GrayPair::code_images() const {
  std::vector<int> out;
  std::ranges::copy_if(images, std::back_inserter(out), [this](int image) {
    return patterns[static_cast<std::size_t>(image)].is_gray() &&
           std::ranges::find(gain_images, image) == gain_images.end();
  });
  return out;
}

ImageU8 valid_in_both(const Camera& camera, std::size_t index, const Side& real, const Side& simulated) {
  ImageU8 mask(camera.lens.width(), camera.lens.height(), 1);
  for (const measure::CameraDecode* decode : {decode_of(real, index), decode_of(simulated, index)}) {
    if (!decode) continue;
    FT_CHECK(decode->flags.same_size(mask), "decode and camera have one image size");
    for (std::size_t i = 0; i < mask.size(); ++i)
      if (decode->flags.data[i] != measure::kValid) mask.data[i] = 0;
  }
  return mask;
}

std::vector<std::size_t> set_pixels(const ImageU8& mask, std::size_t most) {
  std::vector<std::size_t> all, some;
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (mask.data[i] != 0) all.push_back(i);
  const std::size_t stride = all.size() / most + 1;
  for (std::size_t k = 0; k < all.size(); k += stride) some.push_back(all[k]);
  return some;
}

const ImageF* wrapped_phase(const measure::CameraDecode& decode, const PatternSpec& pattern) {
  const auto d = static_cast<std::size_t>(pattern.direction), k = static_cast<std::size_t>(pattern.pitch);
  if (d >= decode.directions.size() || k >= decode.directions[d].wrapped_rad.size()) return nullptr;
  const ImageF& image = decode.directions[d].wrapped_rad[k];
  return image.empty() ? nullptr : &image;
}

std::vector<GrayPair> pair_gray(const Twin& twin, const Side& real, const Side& simulated,
                                const CompareOptions& options, std::vector<std::string>& warnings) {
  std::vector<GrayPair> pairs;
  const bool has_irradiance = !simulated.irradiance.empty();
  if (real.images.empty() || (simulated.images.empty() && !has_irradiance)) return pairs;
  FT_CHECK(real.images.size() == twin.cameras.size(), "one set of real images per camera");
  const std::vector<PatternSpec> patterns = expand_sequence(twin.fringes);
  for (std::size_t c = 0; c < twin.cameras.size(); ++c) {
    GrayPair pair;
    pair.camera = &twin.cameras[c];
    pair.real = &real.images[c];
    if (!simulated.images.empty()) pair.simulated = &simulated.images.at(c);
    if (!pair.camera->sensor.straight()) straighten(pair);
    pair.irradiance = has_irradiance ? &simulated.irradiance.at(c) : pair.simulated;
    const Sensor& sensor = pair.camera->sensor;
    if (!pair.irradiance->radiance) {
      pair.from_dn = true;
      pair.e_scale = 1.0 / sensor.gain_dn;
      pair.e_offset = -sensor.black_level_dn / sensor.gain_dn;
    }
    pair.patterns = patterns;
    pair.mask = valid_in_both(*pair.camera, c, real, simulated);
    check_images(*pair.real, pair, "real");
    check_images(*pair.irradiance, pair, "simulated");
    if (pair.simulated) check_images(*pair.simulated, pair, "simulated");
    choose_images(pair, twin, options, warnings);
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

UsableRange usable_range(const GrayPair& pair, double gain_dn, double black_level_dn,
                         const ClipMargins& margins) {
  const double infinity = std::numeric_limits<double>::infinity();
  UsableRange u{.saturation_dn = pair.real->saturation_dn(),
                .sim_low = pair.from_dn ? 0.0 : -infinity,
                .sim_high = pair.from_dn ? pair.irradiance->saturation_dn() : infinity,
                .gain_dn = gain_dn,
                .black_level_dn = black_level_dn};
  const auto margin_dn = [&](double asked_dn) {
    return std::clamp(asked_dn, kLeastMarginDn, std::max(kLeastMarginDn, kMostMargin * u.saturation_dn));
  };
  u.low_dn = pair.real->radiance ? -infinity : margin_dn(margins.low_dn);
  u.high_dn = pair.real->radiance ? infinity : u.saturation_dn - margin_dn(margins.high_dn);
  return u;
}

}  // namespace fringetwin::compare
