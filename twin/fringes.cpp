// SPDX-License-Identifier: Apache-2.0
#include "twin/fringes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "twin/base/errors.hpp"
#include "twin/number/sinc.hpp"

namespace fringetwin {
namespace {

/// floor(words) modulo 2^bits: the code repeats where the projector is wider than 2^bits words.
unsigned wrapped_word(double words, int bits) {
  const double n = std::ldexp(1.0, bits);
  const double k = std::floor(words);
  return static_cast<unsigned>(k - n * std::floor(k / n));
}

void append_with_inverse(std::vector<PatternSpec>& sequence, PatternSpec spec, bool pairs) {
  sequence.push_back(spec);
  if (!pairs) return;
  spec.kind = spec.kind == PatternSpec::Kind::gray_bit ? PatternSpec::Kind::gray_bit_inverse
                                                       : PatternSpec::Kind::complementary_inverse;
  sequence.push_back(spec);
}

void append_gray(std::vector<PatternSpec>& sequence, const GrayCode& gray, int direction) {
  const bool pairs = gray.threshold == GrayCode::Threshold::inverse;
  PatternSpec spec{.kind = PatternSpec::Kind::gray_bit, .direction = direction};
  for (int i = 0; i < gray.bits; ++i) {
    spec.bit = gray.lsb_first ? gray.bits - 1 - i : i;
    append_with_inverse(sequence, spec, pairs);
  }
  if (!gray.complementary) return;
  spec.kind = PatternSpec::Kind::complementary;
  spec.bit = gray.bits;
  append_with_inverse(sequence, spec, pairs);
}

double gray_value(const DirectionFringes& direction, const PatternSpec& pattern, double coordinate_px) {
  FT_CHECK(direction.gray.has_value(), "Gray pattern of a direction without Gray code");
  const GrayCode& gray = *direction.gray;
  const double periods = (coordinate_px - direction.phase_origin_px.front()) / direction.pitches_px.front();
  const double words = periods - gray.offset_periods;
  const int bits = gray.bits + 1;  // of the code of half periods, whose last bit the complementary one is
  const int bright = pattern.is_complementary()
                         ? gray_code_bit(wrapped_word(2.0 * words, bits), bits, bits - 1)
                         : gray_code_bit(wrapped_word(words, gray.bits), gray.bits, pattern.bit);
  return pattern.is_inverse() ? 1.0 - bright : bright;
}

/// Returns "gray bit 1/6 (most significant)": counted from the most significant one whatever the order of the
/// files, and the two ends are told by name, for others count from the other end.
std::string gray_bit_name(const DirectionFringes& direction, int bit) {
  FT_CHECK(direction.gray.has_value(), "a Gray bit of a direction without Gray code");
  const int bits = direction.gray->bits;
  return fmt::format("gray bit {}/{}{}", bit + 1, bits,
                     bit == 0          ? " (most significant)"
                     : bit == bits - 1 ? " (least significant)"
                                       : "");
}

/// Returns the phase of a step at a coordinate, in turns.
double phase_turns(const Fringes& fringes, const PatternSpec& pattern, double coordinate_px) {
  const DirectionFringes& direction = fringes.directions.at(pattern.direction);
  const auto pitch = static_cast<std::size_t>(pattern.pitch);
  const double periods =
      (coordinate_px - direction.phase_origin_px.at(pitch)) / direction.pitches_px.at(pitch);
  return periods + static_cast<double>(pattern.step) / fringes.steps;
}

}  // namespace

double Waveform::operator()(double turns) const {
  if (kind == Kind::sine) return std::cos(2.0 * std::numbers::pi * turns);
  FT_CHECK(!values.empty(), "a waveform has values");
  const std::size_t n = values.size();
  const double at = (turns - std::floor(turns)) * static_cast<double>(n);
  const auto i = std::min(static_cast<std::size_t>(at), n - 1);
  if (kind == Kind::levels) return 2.0 * values[i] - 1.0;
  const double part = at - static_cast<double>(i);
  return 2.0 * ((1.0 - part) * values[i] + part * values[(i + 1) % n]) - 1.0;
}

const Harmonics& DirectionFringes::harmonics_of(std::size_t pitch) const {
  static const Harmonics none;
  return pitch < harmonics.size() ? harmonics[pitch] : none;
}

namespace {
bool has_any(const std::vector<Harmonics>& lists) {
  return std::ranges::any_of(lists, [](const Harmonics& list) {
    return std::ranges::any_of(list, [](const Harmonic& h) { return h != Harmonic{}; });
  });
}
}  // namespace

bool Raster::has_any() const { return fringetwin::has_any({waves}); }

double Raster::turns_taken(int order, double fringe_pitch_px) const {
  return std::round(order * pitch_px / fringe_pitch_px);
}

double Raster::left_by_pixels(double per_px) const { return sinc(std::numbers::pi * per_px * pitch_px); }

bool DirectionFringes::has_own_harmonics() const { return has_any(harmonics); }
bool DirectionFringes::has_harmonics_field() const { return has_any(harmonics_field); }

std::vector<double> DirectionFringes::harmonics_field_sizes() const {
  std::vector<double> sizes;  // no term is beyond -1 ... 1
  for (const Harmonics& more : harmonics_field) {
    sizes.resize(std::max(sizes.size(), more.size()));
    for (std::size_t i = 0; i < more.size(); ++i) sizes[i] += std::hypot(more[i].cosine, more[i].sine);
  }
  return sizes;
}

double DirectionFringes::contrast_of(std::size_t pitch) const {
  return pitch < contrast.size() ? contrast[pitch] : 1.0;
}

bool Fringes::has_contrast() const {
  return std::ranges::any_of(directions, [](const DirectionFringes& d) {
    return std::ranges::any_of(d.contrast, [](double c) { return c != 1.0; });
  });
}

double Fringes::largest_contrast() const {
  double largest = 1.0, more = 0.0;
  for (const DirectionFringes& d : directions)
    for (const double c : d.contrast) largest = std::max(largest, c);
  for (const Harmonics& list : image_harmonics)
    if (!list.empty()) more = std::max(more, std::hypot(list[0].cosine, list[0].sine));
  return largest * (1.0 + more / amplitude);
}

bool Fringes::has_image_harmonics() const { return has_any(image_harmonics); }

bool Fringes::has_raster() const {
  return std::ranges::any_of(directions, [](const DirectionFringes& d) { return d.raster.has_any(); });
}

const Harmonics& Fringes::harmonics_of_image(std::size_t image) const {
  static const Harmonics none;
  return image < image_harmonics.size() ? image_harmonics[image] : none;
}

std::vector<double> Fringes::more_harmonics(const DirectionFringes& direction) const {
  std::vector<double> sizes = direction.harmonics_field_sizes(), of_images;
  for (const Harmonics& list : image_harmonics) {
    of_images.resize(std::max(of_images.size(), list.size()));
    for (std::size_t i = 0; i < list.size(); ++i)
      of_images[i] = std::max(of_images[i], std::hypot(list[i].cosine, list[i].sine));
  }
  if (of_images.size() > sizes.size() + 1) sizes.resize(of_images.size() - 1);
  for (std::size_t i = 1; i < of_images.size(); ++i) sizes[i - 1] += of_images[i];
  return sizes;
}

bool Fringes::has_harmonics() const {
  return has_harmonics_field() || has_image_harmonics() ||
         std::ranges::any_of(directions, &DirectionFringes::has_own_harmonics);
}

bool Fringes::has_harmonics_field() const {
  return std::ranges::any_of(directions, &DirectionFringes::has_harmonics_field);
}

int DirectionFringes::finest() const {
  FT_CHECK(!pitches_px.empty(), "a direction needs a pitch");
  return static_cast<int>(std::ranges::min_element(pitches_px) - pitches_px.begin());
}

double Fringes::finest_pitch_px() const {
  double finest = std::numeric_limits<double>::infinity();
  for (const DirectionFringes& d : directions)
    for (const double pitch : d.pitches_px) finest = std::min(finest, pitch);
  return finest;
}

std::string PatternSpec::label(const Fringes& fringes) const {
  if (is_image()) {
    const std::string name = fringes.images.at(image).file.filename().string();
    return name.empty() ? fmt::format("image {}", image) : "image " + name;
  }
  const DirectionFringes& d = fringes.directions.at(direction);
  const char* axis = axis_name(d.axis);
  switch (kind) {
    case Kind::phase_step:
      return fmt::format("{} pitch {} step {}/{}", axis, d.pitches_px.at(pitch), step + 1, fringes.steps);
    case Kind::gray_bit:
      return fmt::format("{} {}", axis, gray_bit_name(d, bit));
    case Kind::gray_bit_inverse:
      return fmt::format("{} {} inverse", axis, gray_bit_name(d, bit));
    case Kind::complementary:
      return fmt::format("{} complementary bit", axis);
    case Kind::complementary_inverse:
      return fmt::format("{} complementary bit inverse", axis);
    case Kind::image:
      break;
  }
  return axis;
}

std::vector<PatternSpec> expand_sequence(const Fringes& fringes) {
  std::vector<PatternSpec> sequence;
  for (int d = 0; d < static_cast<int>(fringes.directions.size()); ++d) {
    const DirectionFringes& direction = fringes.directions[d];
    for (int pitch = 0; pitch < static_cast<int>(direction.pitches_px.size()); ++pitch) {
      for (int step = 0; step < fringes.steps; ++step)
        sequence.push_back({.direction = d, .pitch = pitch, .step = step});
    }
    if (direction.gray) append_gray(sequence, *direction.gray, d);
  }
  for (int i = 0; i < static_cast<int>(fringes.images.size()); ++i)
    sequence.push_back(
        {.kind = PatternSpec::Kind::image, .direction = -1, .pitch = -1, .step = -1, .image = i});
  return sequence;
}

bool needs_white_black(const Fringes& fringes) {
  return std::ranges::any_of(fringes.directions, [](const DirectionFringes& d) {
    return d.gray && d.gray->threshold == GrayCode::Threshold::white_black;
  });
}

double image_level(const ImageF& levels, double x_px, double y_px) {
  const auto nearest = [](double q, int size) {
    return static_cast<int>(std::clamp(std::floor(q + 0.5), 0.0, static_cast<double>(size - 1)));
  };
  return levels(nearest(x_px, levels.width), nearest(y_px, levels.height));
}

double pattern_value(const Fringes& fringes, const PatternSpec& pattern, double coordinate_px) {
  FT_CHECK(!pattern.is_image(), "an image is no function of one coordinate");
  const DirectionFringes& direction = fringes.directions.at(pattern.direction);
  if (pattern.is_gray()) return gray_value(direction, pattern, coordinate_px);
  return fringes.mean + fringes.amplitude * fringes.waveform(phase_turns(fringes, pattern, coordinate_px));
}

double harmonic_light(const Fringes& fringes, const PatternSpec& pattern, double coordinate_px) {
  if (pattern.kind != PatternSpec::Kind::phase_step) return 0.0;
  const Harmonics& harmonics =
      fringes.directions.at(pattern.direction).harmonics_of(static_cast<std::size_t>(pattern.pitch));
  if (harmonics.empty()) return 0.0;
  const double phase_rad = 2.0 * std::numbers::pi * phase_turns(fringes, pattern, coordinate_px);
  double light = 0.0;
  for (std::size_t i = 0; i < harmonics.size(); ++i) {
    const double angle = static_cast<double>(i + 2) * phase_rad;
    light += harmonics[i].cosine * std::cos(angle) + harmonics[i].sine * std::sin(angle);
  }
  return light;
}

}  // namespace fringetwin
