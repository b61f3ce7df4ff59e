// SPDX-License-Identifier: Apache-2.0
#include "measure/description/reading.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace fringetwin::measure {
namespace {

/// The first of equals is named: half a period off is the commonest mistake.
constexpr double kQuarters[] = {0.5, 0.25, 0.75};
/// Of codes whose bits change where the fringes are dark, in the last of a series that halves its periods.
constexpr double kOffsetsOfHalfPeriodBits[] = {-0.5, -0.25, 0.5, 0.25};
constexpr std::size_t kMostPitches = 4;  ///< 23 other orders

/// Collects readings that differ from the described one in what a function changes.
class Readings {
 public:
  explicit Readings(const Fringes& fringes)
      : described_(described_reading(fringes)), sequence_(expand_sequence(fringes)) {}

  /// Adds the reading with the fringes that `change` leaves, where they ask for as many images.
  template <class Change>
  void fringes(std::string name, Change change, bool shifts_only = false) {
    Reading reading = described_;
    change(reading.fringes);
    if (reading.fringes == described_.fringes) return;
    if (expand_sequence(reading.fringes).size() != sequence_.size()) return;
    if (needs_white_black(reading.fringes) != needs_white_black(described_.fringes)) return;
    reading.name = std::move(name);
    reading.shifts_only = shifts_only;
    out_.push_back(std::move(reading));
  }
  void order(std::string name, std::vector<int> image_of, bool single_images = true) {
    Reading reading = described_;
    reading.name = std::move(name);
    reading.image_of = std::move(image_of);
    reading.single_images = single_images;
    out_.push_back(std::move(reading));
  }

  void descriptions();
  void reversed_steps();
  void pitch_orders();
  void exchanged_images();
  void late_and_early();
  std::vector<Reading> take() { return std::move(out_); }

 private:
  Reading described_;
  std::vector<PatternSpec> sequence_;
  std::vector<Reading> out_;
};

void Readings::descriptions() {
  const auto each_code = [](auto change) {
    return [change](Fringes& f) {
      for (DirectionFringes& d : f.directions)
        if (d.gray) change(*d.gray);
    };
  };
  fringes("the other direction", [](Fringes& f) {
    for (DirectionFringes& d : f.directions) d.axis = d.axis == Axis::x ? Axis::y : Axis::x;
  });
  fringes("the bits of the code in the other order",
          each_code([](GrayCode& c) { c.lsb_first = !c.lsb_first; }));
  fringes("a complementary bit as the last of the code", each_code([](GrayCode& c) {
            if (!c.complementary && c.bits > 1) c.complementary = true, --c.bits;
          }));
  for (const double offset : kOffsetsOfHalfPeriodBits)
    fringes(fmt::format("a complementary bit as the last of the code and offset_periods = {:g}", offset),
            each_code([offset](GrayCode& c) {
              if (!c.complementary && c.bits > 1) c.complementary = true, --c.bits, c.offset_periods = offset;
            }));
  fringes("no complementary bit", each_code([](GrayCode& c) {
            if (c.complementary) c.complementary = false, ++c.bits;
          }));
  Reading inverted = described_;
  inverted.name = "the complementary bit inverted";
  for (std::size_t i = 0; i < sequence_.size(); ++i)
    if (sequence_[i].is_complementary()) inverted.negatives.push_back(i);
  if (!inverted.negatives.empty()) out_.push_back(std::move(inverted));
  for (const double quarter : kQuarters)
    fringes(fmt::format("the code {:g} of a period further (offset_periods)", quarter),
            each_code([quarter](GrayCode& c) { c.offset_periods += quarter; }));
  for (const double quarter : kQuarters)
    fringes(
        fmt::format("phase_origin_px {:g} of a period further", quarter),
        [quarter](Fringes& f) {
          for (DirectionFringes& d : f.directions)
            for (std::size_t p = 0; p < d.pitches_px.size(); ++p)
              d.phase_origin_px[p] += quarter * d.pitches_px[p];
        },
        described_.fringes.directions.size() > 0 &&
            described_.fringes.directions.front().pitches_px.size() == 1);
}

void Readings::reversed_steps() {
  const int n = described_.fringes.steps;
  if (n < 3) return;
  std::vector<int> backwards = described_.image_of, mirrored = described_.image_of;
  for (std::size_t i = 0; i < sequence_.size(); ++i)
    if (sequence_[i].kind == PatternSpec::Kind::phase_step) {
      const int first = static_cast<int>(i) - sequence_[i].step;
      backwards[i] = first + n - 1 - sequence_[i].step;
      mirrored[i] = first + (n - sequence_[i].step) % n;
    }
  order("steps in reverse order", std::move(mirrored), false);
  order("steps from the last to the first", std::move(backwards), false);
}

void Readings::pitch_orders() {
  for (const DirectionFringes& d : described_.fringes.directions)
    if (d.pitches_px.size() != described_.fringes.directions.front().pitches_px.size()) return;
  const std::size_t pitches = described_.fringes.directions.front().pitches_px.size();
  if (pitches < 2 || pitches > kMostPitches || described_.fringes.steps < 3) return;
  std::vector<int> shown(pitches);
  std::iota(shown.begin(), shown.end(), 0);
  while (std::next_permutation(shown.begin(), shown.end())) {
    std::vector<int> image_of = described_.image_of;
    for (std::size_t i = 0; i < sequence_.size(); ++i)
      if (const PatternSpec& p = sequence_[i]; p.kind == PatternSpec::Kind::phase_step)
        image_of[i] += (shown[p.pitch] - p.pitch) * described_.fringes.steps;
    // the place of pitch p reads block shown[p], so that this block shows pitch p
    std::vector<double> pitch_of_block(pitches);
    for (std::size_t p = 0; p < pitches; ++p)
      pitch_of_block[shown[p]] = described_.fringes.directions.front().pitches_px[p];
    order(fmt::format("pitches in the order {}", fmt::join(pitch_of_block, ", ")), std::move(image_of),
          false);
  }
}

void Readings::exchanged_images() {
  const auto is_step = [this](std::size_t i) { return sequence_[i].kind == PatternSpec::Kind::phase_step; };
  const auto reach = static_cast<std::size_t>(std::max(1, described_.fringes.steps));
  for (std::size_t i = 0; i < sequence_.size(); ++i)
    for (std::size_t j = i + 1; j < sequence_.size() && j - i < reach; ++j) {
      if (sequence_[i].is_image() || sequence_[j].is_image() || !(is_step(i) || is_step(j))) continue;
      std::vector<int> image_of = described_.image_of;
      std::swap(image_of[i], image_of[j]);
      order(fmt::format("images {} and {} swapped", i, j), std::move(image_of));
    }
}

void Readings::late_and_early() {
  const int n = static_cast<int>(sequence_.size());
  for (int first = 0; first + 1 < n; ++first) {
    std::vector<int> late = described_.image_of, early = described_.image_of;
    for (int i = first; i < n; ++i) {
      late[i] = i + 1 < n ? i + 1 : kNotRecorded;
      early[i] = i > first ? i - 1 : kNotRecorded;
    }
    order(first == 0 ? "a sequence that starts one image late"
                     : fmt::format("every image from {} on one place earlier (image {} is one too many)",
                                   first, first),
          std::move(late));
    order(first == 0
              ? "a sequence that starts one image early"
              : fmt::format("every image from {} on one place later (the pattern of image {} was lost)",
                            first, first),
          std::move(early));
  }
}

/// Returns the step that `place` should show, from the other steps of its pitch and the mean of another
/// pitch: the steps of a pitch add up to N times the mean, which does not depend on the pitch. Empty where
/// the sequence has no such images.
ImageF missing_step(const std::vector<const GrayImage*>& images, const std::vector<PatternSpec>& sequence,
                    int steps, std::size_t place) {
  const PatternSpec& missing = sequence[place];
  if (missing.kind != PatternSpec::Kind::phase_step) return {};
  std::vector<const GrayImage*> others, whole;
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const PatternSpec& p = sequence[i];
    if (!images[i] || p.kind != PatternSpec::Kind::phase_step || p.direction != missing.direction) continue;
    (p.pitch == missing.pitch ? others : whole).push_back(images[i]);
  }
  if (static_cast<int>(others.size()) != steps - 1 || static_cast<int>(whole.size()) < steps) return {};
  ImageF out(others.front()->width, others.front()->height);
  const float share = static_cast<float>(steps) / static_cast<float>(whole.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    float sum = 0.0f;
    for (const GrayImage* image : whole) sum += share * (*image)[i];
    for (const GrayImage* image : others) sum -= (*image)[i];
    out.data[i] = sum;
  }
  return out;
}

/// Returns one of the images with the bright and the dark ones of each pixel exchanged.
ImageF negative(const std::vector<GrayImage>& images, std::size_t which) {
  ImageF out = images[which].floats();
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto [dark, bright] = std::minmax_element(
        images.begin(), images.end(), [i](const GrayImage& a, const GrayImage& b) { return a[i] < b[i]; });
    out.data[i] = (*dark)[i] + (*bright)[i] - out.data[i];
  }
  return out;
}

}  // namespace

Reading described_reading(const Fringes& fringes) {
  Reading reading{.name = "as described", .fringes = fringes};
  reading.image_of.resize(expand_sequence(fringes).size());
  std::iota(reading.image_of.begin(), reading.image_of.end(), 0);
  return reading;
}

std::vector<Reading> other_readings(const Fringes& fringes) {
  Readings readings(fringes);
  readings.descriptions();
  readings.reversed_steps();
  readings.pitch_orders();
  readings.exchanged_images();
  readings.late_and_early();
  return readings.take();
}

CameraImages read_as(const CameraImages& images, const Reading& reading) {
  const std::vector<PatternSpec> sequence = expand_sequence(reading.fringes);
  std::vector<const GrayImage*> chosen;
  std::vector<bool> used(images.images.size(), false);
  for (const int image : reading.image_of) {
    chosen.push_back(image == kNotRecorded ? nullptr : &images.images[image]);
    if (image != kNotRecorded) used[image] = true;
  }
  const auto left_over = static_cast<std::size_t>(std::ranges::find(used, false) - used.begin());
  CameraImages out{.camera = images.camera,
                   .images = {},
                   .white = images.white,
                   .black = images.black,
                   .bit_depth = images.bit_depth,
                   .radiance = images.radiance,
                   .gray_code_exposure = images.gray_code_exposure,
                   .clip = images.clip};
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    out.images.push_back(chosen[i] ? *chosen[i] : missing_step(chosen, sequence, reading.fringes.steps, i));
    if (out.images[i].empty()) out.images[i] = images.images.at(left_over);
  }
  for (const std::size_t i : reading.negatives) out.images[i] = negative(images.images, i);
  return out;
}

}  // namespace fringetwin::measure
