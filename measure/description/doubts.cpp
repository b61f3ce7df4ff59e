// SPDX-License-Identifier: Apache-2.0
#include "measure/description/doubts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "measure/decode/decode.hpp"
#include "measure/description/repeated_images.hpp"
#include "measure/description/tiles.hpp"

namespace fringetwin::measure {
namespace {

// What is doubted. Rigs that are described rightly stay below: their jumps are single pixels at edges, their
// residuals noise and harmonics of the projector.
constexpr double kManyJumps = 0.005;    ///< per valid pixel
constexpr double kFewValid = 0.5;       ///< of the pixels that the fringes reach
constexpr double kResidual = 0.12;      ///< of the amplitude, median: what other readings are tried for
constexpr double kLargeResidual = 0.4;  ///< and what is told though none fits
constexpr double kFewNear = 0.5;        ///< of the expected pixels, within a period
constexpr double kOffset = 0.1;         ///< periods, median

// What counts as an answer: it leaves a quarter of the bad pixels, or all of the offset but a twentieth of a
// period, alike everywhere.
constexpr double kLeftOver = 0.25;
constexpr double kSettled = 0.02;  ///< periods
constexpr double kLeastGain = 0.003;

bool jumps_or_few(const ReadingScore& s) { return s.jumps > kManyJumps || s.valid < kFewValid; }
bool contradicted(const ReadingScore& s) {
  return jumps_or_few(s) || s.residual > kResidual || s.near < kFewNear;
}
bool only_moved(const ReadingScore& s) { return !contradicted(s) && std::abs(s.offset) > kOffset; }

/// Returns whether `other` takes away what speaks against `described`.
bool answers(const ReadingScore& described, const Reading& reading, const ReadingScore& other) {
  if (only_moved(described) || reading.shifts_only)
    return reading.shifts_only && std::abs(other.offset) < kSettled && other.scatter < kSettled &&
           std::abs(described.offset) > kOffset && other.good >= described.good;
  if (std::isnan(other.near) != std::isnan(described.near) || other.near < kFewNear) return false;
  if (described.residual > kResidual && other.residual <= kLeftOver * described.residual &&
      other.good >= described.good)
    return true;
  return 1.0 - other.good <= kLeftOver * (1.0 - described.good) && other.good > described.good + kLeastGain;
}

/// Counts over all of an image.
struct Counts {
  std::uint64_t jumps = 0, valid = 0, reached = 0;
  std::string text() const {
    return fmt::format(
        "{} jumps of the fringe order and {:.0f} % of the {} pixels that the fringes reach decoded", jumps,
        100.0 * static_cast<double>(valid) / static_cast<double>(std::max<std::uint64_t>(reached, 1)),
        reached);
  }
};
Counts count(const CameraDecode& decoded, const ImageU8& reached) {
  Counts out;
  for (const DirectionDecode& d : decoded.directions) out.jumps += d.repair.n_left;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (reached.data[i] == 0) continue;
    ++out.reached;
    out.valid += std::all_of(decoded.directions.begin(), decoded.directions.end(),
                             [i](const DirectionDecode& d) {
                               return !d.unwrapped || std::isfinite(d.coordinate_px.data[i]);
                             })
                     ? 1
                     : 0;
  }
  return out;
}

std::string what_is_wrong(const ReadingScore& s, const Counts& counts) {
  if (jumps_or_few(s)) return counts.text();
  if (s.residual > kResidual)
    return fmt::format("the phase steps leave residuals of {:.0f} % of the fringe's amplitude",
                       100.0 * s.residual);
  if (s.near < kFewNear)
    return fmt::format("{:.0f} % of the pixels decode more than a period from where the twin expects them",
                       100.0 * (1.0 - s.near));
  return fmt::format("the coordinates lie {:.2f} periods from where the twin expects them", s.offset);
}

std::string what_would_be(const ReadingScore& before, const Reading& reading, const ReadingScore& s,
                          const CameraImages& images, const DecodeOptions& options, const ImageU8& reached) {
  if (reading.shifts_only) return fmt::format("{} would leave {:.3f}", reading.name, s.offset);
  if (jumps_or_few(before))
    return fmt::format("{} would leave {}", reading.name,
                       count(decode(read_as(images, reading), reading.fringes, options), reached).text());
  if (before.residual > kResidual)
    return fmt::format("{} would leave {:.1f} %", reading.name, 100.0 * s.residual);
  return fmt::format("{} would leave {:.0f} %", reading.name, 100.0 * (1.0 - s.near));
}

}  // namespace

std::vector<std::string> description_doubts(const CameraImages& images, const Fringes& fringes,
                                            const DecodeOptions& options, const CameraDecode& decoded,
                                            const ExpectedCoordinates& expected) {
  std::vector<std::string> out;
  if (images.radiance || images.images.empty()) return out;
  const Tiles tiles(images, options.min_modulation_dn);
  if (tiles.empty()) return out;
  const auto tell = [&](std::string sentence) {
    out.push_back(fmt::format("camera \"{}\": {}", images.camera, sentence));
  };
  DecodeOptions all_steps = options;
  all_steps.use_steps.clear();
  const CameraImages some = tiles.cut(images);
  ExpectedCoordinates there;
  if (!expected.x_px.empty()) there.x_px = tiles.cut(expected.x_px, std::numeric_limits<double>::quiet_NaN());
  if (!expected.y_px.empty()) there.y_px = tiles.cut(expected.y_px, std::numeric_limits<double>::quiet_NaN());

  const ReadingScore described = score_reading(some, described_reading(fringes), all_steps, there);
  const std::vector<std::pair<int, int>> repeated =
      repeated_images(some, fringes, reached_pixels(some, options.min_modulation_dn));
  if (!contradicted(described) && !only_moved(described) && repeated.empty()) return out;

  std::optional<std::pair<Reading, ReadingScore>> best;
  const bool only_elsewhere = !jumps_or_few(described) && described.residual <= kResidual;
  for (Reading& reading : other_readings(fringes)) {
    if (reading.single_images && only_elsewhere) continue;
    const ReadingScore score = score_reading(some, reading, all_steps, there);
    if (answers(described, reading, score) && (!best || score.good > best->second.good + 1e-3))
      best.emplace(std::move(reading), score);
  }
  const ImageU8 reached = reached_pixels(images, options.min_modulation_dn);
  const std::string wrong = what_is_wrong(described, count(decoded, reached));
  for (const auto& [earlier, later] : repeated)
    tell(fmt::format("image {} repeats image {}, so that one pattern of the sequence is missing", later,
                     earlier));
  if (best)
    tell(fmt::format("the images are not as described: {}; {}", wrong,
                     what_would_be(described, best->first, best->second, images, all_steps, reached)));
  else if (repeated.empty() && (jumps_or_few(described) || described.residual > kLargeResidual))
    tell(fmt::format("{}; no other reading of [fringes] that was tried fits better", wrong));
  return out;
}

}  // namespace fringetwin::measure
