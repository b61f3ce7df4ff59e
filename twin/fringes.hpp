// SPDX-License-Identifier: Apache-2.0
// Describes the projected sequence, phase-shifted fringes and Gray code (docs/CONVENTIONS.md): the order of
// its images and their ideal values.
#pragma once
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/image/image.hpp"

namespace fringetwin {

enum class Axis { x, y };  ///< the projector axis along which a pattern varies
inline const char* axis_name(Axis a) { return a == Axis::x ? "x" : "y"; }

enum class Unwrap { heterodyne, hierarchical, gray, none };

struct GrayCode {
  enum class Threshold { mean, inverse, white_black };
  int bits = 0;
  bool lsb_first = false;
  bool complementary = false;   ///< one more, half-period-shifted bit after the others
  double offset_periods = 0.0;  ///< where the code changes, relative to phase_origin_px
  Threshold threshold = Threshold::mean;
  bool operator==(const GrayCode&) const = default;
};

/// Light that a projected fringe has besides its shown value, of one order k: cosine cos(k t) + sine sin(k t)
/// at the phase t of the fringe, fraction of full scale.
struct Harmonic {
  double cosine = 0.0, sine = 0.0;
  bool operator==(const Harmonic&) const = default;
};
/// The orders 2, 3, ... of one pitch.
using Harmonics = std::vector<Harmonic>;
inline constexpr int kHighestHarmonic = 16;
/// Terms by which harmonics vary over the projector's image: Legendre's P_i(u) P_j(v), (i, j) = (1, 0),
/// (0, 1), (2, 0), (1, 1), (0, 2), u and v from -1 to 1 across the image.
inline constexpr std::size_t kHarmonicsFieldTerms = 5;
inline constexpr double kLargestContrast = 2.0;

/// Waves that single high orders of what the fringes show make with the projector's own pixels, each of which
/// shows one level (docs/PHYSICS.md, "Fringes that are no sinusoids"). Order h at the phase t of a fringe of
/// pitch p, step included, is seen where the light lands at x as the wave of phase h t - 2 pi m (x - c)/r: r
/// the raster's pitch, c the middle of a pixel, m = round(h r/p), which makes it the slowest: of f = h/p -
/// m/r per px. The square of a pixel leaves sin(pi f r)/(pi f r) of it.
struct Raster {
  double pitch_px = 1.0;  ///< of the projector's own pixels, px of the calibrated projector
  int first_order = 2;
  Harmonics waves = {};  ///< of the levels that pixels show, of the orders from the first on
  bool has_any() const;  ///< light at all
  /// Returns m, by how many turns per pixel the wave of an order is slower.
  double turns_taken(int order, double fringe_pitch_px) const;
  /// Returns the share of a wave of so many turns per px that squares of one level leave.
  double left_by_pixels(double per_px) const;
  bool operator==(const Raster&) const = default;
};
/// Returns c, px: the pixel in the middle of a projector's image, or the one after it.
inline double middle_of_raster_px(int size_px) { return size_px / 2; }
inline constexpr int kHighestRasterOrder = 4096;
inline constexpr std::size_t kMostRasterWaves = 32;

/// The shape of one period of the shown fringes.
struct Waveform {
  enum class Kind {
    sine,   ///< cos(t)
    table,  ///< values at equally spaced phases from 0 on, linear between, the last to the first again
    levels  ///< each value over an equal part of the period, from phase 0 on
  };
  Kind kind = Kind::sine;
  std::vector<double> values;  ///< 0: mean - amplitude, 1: mean + amplitude
  /// Returns the fringe at a phase in turns, from -1 to 1.
  double operator()(double turns) const;
  bool operator==(const Waveform&) const = default;
};

struct DirectionFringes {
  Axis axis = Axis::x;
  std::vector<double> pitches_px;         ///< projector px per period, in sequence order
  std::vector<double> phase_origin_px;    ///< one per pitch
  std::optional<GrayCode> gray = {};      ///< pitch of the code = the (single) pitch
  std::vector<Harmonics> harmonics = {};  ///< one list per pitch; none: fringes have no harmonics
  std::vector<double> contrast = {};      ///< one per pitch; none: each has all of it
  /// What the harmonics of every pitch have more away from the middle of the projector's image: a list per
  /// term, in the order of kHarmonicsFieldTerms; missing ones are 0.
  std::vector<Harmonics> harmonics_field = {};
  Raster raster = {};  ///< of every pitch
  /// Returns the harmonics of a pitch, an empty list where there are none.
  const Harmonics& harmonics_of(std::size_t pitch) const;
  bool has_own_harmonics() const;  ///< in the middle of the projector's image
  bool has_harmonics_field() const;
  /// Returns by how much the harmonics of the orders 2, 3 ... may be larger at some place, at most.
  std::vector<double> harmonics_field_sizes() const;
  /// Returns what is left of the swing of a pitch's light about its mean, 1 unless stated.
  double contrast_of(std::size_t pitch) const;
  /// Returns the index of the smallest pitch.
  int finest() const;
  bool operator==(const DirectionFringes&) const = default;
};

/// An arbitrary image the projector shows, pixel for pixel.
struct PatternImage {
  std::filesystem::path file;            ///< empty for one made in memory
  std::shared_ptr<const ImageF> levels;  ///< of the projector's size, fraction of full scale
  bool operator==(const PatternImage&) const = default;
};

struct Fringes {
  std::vector<DirectionFringes> directions;
  int steps = 4;  ///< 0 = Gray code only
  Unwrap unwrap = Unwrap::heterodyne;
  double mean = 0.5;  ///< fraction of the projector's full scale
  double amplitude = 0.5;
  Waveform waveform = {};
  std::vector<PatternImage> images;  ///< shown after all others; no phase comes from them
  /// Light that the fringes of each image of the sequence have besides what those of its pitch have, of the
  /// orders 1, 2, ...; empty: none, as lists of images that are no phase steps are.
  std::vector<Harmonics> image_harmonics = {};
  /// Returns the smallest pitch of all directions, infinity without any.
  double finest_pitch_px() const;
  /// Returns whether any fringe has less, or more, contrast than what is shown.
  bool has_contrast() const;
  /// Returns the largest contrast of all pitches with what any image has more, and 1 at least.
  double largest_contrast() const;
  /// Returns whether the light of any fringe has harmonics that are not shown, anywhere.
  bool has_harmonics() const;
  /// Returns whether they vary over the projector's image.
  bool has_harmonics_field() const;
  bool has_image_harmonics() const;
  bool has_raster() const;  ///< waves of the raster, of any direction
  /// Returns what an image of the sequence has of its own, an empty list where there is nothing.
  const Harmonics& harmonics_of_image(std::size_t image) const;
  /// Returns by how much the harmonics of the orders 2, 3 ... of a direction may be larger at some place and
  /// in some image, at most.
  std::vector<double> more_harmonics(const DirectionFringes& direction) const;
  bool operator==(const Fringes&) const = default;
};

/// One image of the sequence.
struct PatternSpec {
  enum class Kind { phase_step, gray_bit, gray_bit_inverse, complementary, complementary_inverse, image };
  Kind kind = Kind::phase_step;
  int direction = 0;  ///< index into Fringes::directions; -1 for an image, as pitch and step are
  int pitch = 0;      ///< index into pitches_px (phase_step)
  int step = 0;       ///< n of N (phase_step)
  int bit = 0;        ///< gray_bit: 0 = most significant, bits-1 = least, whatever the file order
  int image = -1;     ///< index into Fringes::images (image)
  bool is_image() const { return kind == Kind::image; }
  bool is_gray() const { return kind != Kind::phase_step && kind != Kind::image; }
  bool is_complementary() const { return kind == Kind::complementary || kind == Kind::complementary_inverse; }
  bool is_inverse() const { return kind == Kind::gray_bit_inverse || kind == Kind::complementary_inverse; }
  /// Returns what messages and tables call it, e.g. "x pitch 13 step 2/4", "x gray bit 3/6", where bit 1 is
  /// the most significant one whatever the order of the files.
  std::string label(const Fringes& fringes) const;
};

/// No sequence is longer: a thousand steps of three pitches in two directions have 6000 images, and a
/// projector of 60 Hz shows 10,000 in three minutes.
inline constexpr std::size_t kLongestSequence = 10'000;

/// Returns the sequence in its order, which is the file number: per direction all pitches x steps, then Gray
/// images (pattern, inverse where pairs are used), then the complementary bit; after all directions the
/// images.
std::vector<PatternSpec> expand_sequence(const Fringes& fringes);

/// Returns whether the sequence needs white and black reference images besides (threshold white-black).
bool needs_white_black(const Fringes& fringes);

/// Returns the shown value, fraction of full scale, at projector coordinate `coordinate_px` along the
/// pattern's axis (double-precision truth; before projector response and blur): what `capture` projects.
/// Gray bits are 1 (bright) or 0. Not for images.
double pattern_value(const Fringes& fringes, const PatternSpec& pattern, double coordinate_px);

/// Returns the light that a phase step has there besides the response to its shown value (before blur),
/// fraction of full scale: its harmonics. 0 for all other patterns.
double harmonic_light(const Fringes& fringes, const PatternSpec& pattern, double coordinate_px);

/// Returns the level of the image's pixel that holds the coordinate; the border pixels continue beyond the
/// image.
double image_level(const ImageF& levels, double x_px, double y_px);

/// Gray value (0/1) of `bit` (0 = MSB of `bits`) of word k.
inline int gray_code_bit(unsigned k, int bits, int bit) {
  return static_cast<int>(((k ^ (k >> 1)) >> (bits - 1 - bit)) & 1u);
}

}  // namespace fringetwin
