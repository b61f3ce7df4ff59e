// SPDX-License-Identifier: Apache-2.0
#include "measure/description/doubts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "measure/decode/decode.hpp"
#include "measure/description/repeated_images.hpp"
#include "measure/description/tiles.hpp"
#include "twin/base/constants.hpp"

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

// What counts as an answer: it leaves a quarter of the bad pixels, or of the jumps without losing pixels
// (edges and shadows that no reading decodes stay bad), or all of the offset but a twentieth of a period,
// alike everywhere.
constexpr double kLeftOver = 0.25;
constexpr double kSettledPeriods = 0.02;  ///< periods
constexpr double kLeastGain = 0.003;
constexpr std::uint64_t kFewestPixels = 500;

bool jumps_or_few(const ReadingScore& s) { return s.jumps > kManyJumps || s.valid < kFewValid; }
bool contradicted(const ReadingScore& s) {
  return jumps_or_few(s) || s.residual > kResidual || s.near < kFewNear;
}
bool only_moved(const ReadingScore& s) { return !contradicted(s) && std::abs(s.offset) > kOffset; }

/// Returns whether `other` takes away what speaks against `described`.
bool answers(const ReadingScore& described, const Reading& reading, const ReadingScore& other) {
  if (only_moved(described) || reading.shifts_only)
    return reading.shifts_only && std::abs(other.offset) < kSettledPeriods &&
           other.scatter < kSettledPeriods && std::abs(described.offset) > kOffset &&
           other.good >= described.good;
  if ((std::isnan(other.near) && !std::isnan(described.near)) || other.near < kFewNear) return false;
  if (described.residual > kResidual && other.residual <= kLeftOver * described.residual &&
      other.good >= described.good)
    return true;
  if (!(other.good > described.good + kLeastGain)) return false;
  if (described.jumps > kManyJumps && other.jumps <= kLeftOver * described.jumps &&
      other.valid > described.valid - kLeastGain)
    return true;
  return 1.0 - other.good <= kLeftOver * (1.0 - described.good);
}

/// Counts over all of an image.
struct Counts {
  std::uint64_t jumps = 0, valid = 0, reached = 0;
  bool jumps_or_few() const {
    return static_cast<double>(jumps) > kManyJumps * static_cast<double>(valid) ||
           static_cast<double>(valid) < kFewValid * static_cast<double>(reached);
  }
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
    out.valid += std::ranges::all_of(decoded.directions,
                                     [i](const DirectionDecode& d) {
                                       return !d.unwrapped || std::isfinite(d.coordinate_px.data[i]);
                                     })
                     ? 1
                     : 0;
  }
  return out;
}

/// Returns what a doubt is about that `answer` settles, or the described reading where none does.
DoubtKind kind_of(const Fringes& fringes, const ReadingScore& described, const Reading& answer) {
  const bool is_of_steps = described.residual > kResidual;  // each pitch by itself, whatever it is
  const bool turns = !std::ranges::equal(answer.fringes.directions, fringes.directions, {},
                                         &DirectionFringes::axis, &DirectionFringes::axis);
  return answer.single_images || turns || is_of_steps ? DoubtKind::other : DoubtKind::explained_by_pitches;
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
  if (reading.shifts_only)
    return fmt::format(
        "{} would leave {:.3f}; it may also be that the projector or an object is displaced by that part of "
        "a "
        "period",
        reading.name, s.offset);
  if (jumps_or_few(before))
    return fmt::format("{} would leave {}", reading.name,
                       count(decode(read_as(images, reading), reading.fringes, options), reached).text());
  if (before.residual > kResidual)
    return fmt::format("{} would leave {:.1f} %", reading.name, 100.0 * s.residual);
  return fmt::format("{} would leave {:.0f} %", reading.name, 100.0 * (1.0 - s.near));
}

/// The images of some tiles, which of their pixels the fringes reach, and where the twin expects them.
struct Sample {
  CameraImages images;
  ImageU8 reached;
  ExpectedCoordinates expected;

  Sample(const Tiles& tiles, const CameraImages& all, const ExpectedCoordinates& expected_of_all,
         double min_modulation_dn)
      : images(tiles.cut(all)), reached(reached_pixels(images, min_modulation_dn)) {
    if (!expected_of_all.x_px.empty()) expected.x_px = tiles.cut(expected_of_all.x_px, kNaN);
    if (!expected_of_all.y_px.empty()) expected.y_px = tiles.cut(expected_of_all.y_px, kNaN);
  }
  ReadingScore score(const Reading& reading, const DecodeOptions& options) const {
    return score_reading(images, reached, reading, options, expected);
  }
};

struct Answer {
  Reading reading;
  ReadingScore score;
};

/// A tile, and how the described reading does there.
struct ScoredTile {
  const Sample* tile = nullptr;
  ReadingScore described;
};

/// Returns the tiles that readings are tried on first: of those that contradict the described one (or of all,
/// where none does by itself) the middle one, the worst and the best. Some may be places that no reading
/// decodes.
std::vector<ScoredTile> telling_tiles(const std::vector<Sample>& tiles, const Fringes& fringes,
                                      const DecodeOptions& options) {
  const Reading as_described = described_reading(fringes);
  std::vector<ScoredTile> contradicting, all;
  for (const Sample& tile : tiles) {
    const ReadingScore score = tile.score(as_described, options);
    if (score.n == 0) continue;
    all.push_back({&tile, score});
    if (contradicted(score)) contradicting.push_back(all.back());
  }
  const auto good = [](const ScoredTile& t) { return t.described.good; };
  if (contradicting.empty()) {
    const auto worst = std::ranges::min_element(all, {}, good);
    return worst == all.end() ? all : std::vector<ScoredTile>{*worst};
  }
  std::ranges::stable_sort(contradicting, {}, good);
  std::vector<ScoredTile> out{contradicting[contradicting.size() / 2]};
  for (const ScoredTile& t : {contradicting.front(), contradicting.back()})
    if (std::ranges::find(out, t.tile, &ScoredTile::tile) == out.end()) out.push_back(t);
  return out;
}

/// Returns the places in `readings` of those that answer in a tile, the best six, and of the one that does
/// best there: one tile tells most of them apart at a ninth of the cost of all.
std::set<std::size_t> screened(const ScoredTile& at, const std::vector<Reading>& readings, bool single_images,
                               const DecodeOptions& options) {
  constexpr std::size_t kMost = 6;
  std::vector<std::pair<double, std::size_t>> answering;  // good, place
  std::pair<double, std::size_t> best{at.described.good, readings.size()};
  for (std::size_t k = 0; k < readings.size(); ++k) {
    if (readings[k].single_images && !single_images) continue;
    const ReadingScore score = at.tile->score(readings[k], options);
    if (!readings[k].shifts_only && score.good > best.first) best = {score.good, k};
    if (answers(at.described, readings[k], score)) answering.emplace_back(score.good, k);
  }
  std::ranges::stable_sort(answering, [](const auto& a, const auto& b) { return a.first > b.first; });
  answering.resize(std::min(answering.size(), kMost));
  std::set<std::size_t> out;
  for (const auto& [good, k] : answering) out.insert(k);
  if (best.second < readings.size()) out.insert(best.second);
  return out;
}

/// Other readings of a set.
struct Tried {
  std::optional<Answer> best;     ///< of those that answer
  std::optional<Answer> nearest;  ///< the best of all
};

/// `is_settled`: the images themselves say what is wrong, so that one tile is enough.
Tried try_other_readings(const Sample& all, const std::vector<Sample>& tiles, const Fringes& fringes,
                         const ReadingScore& described, const DecodeOptions& options, bool is_settled) {
  constexpr double kSame = 1e-3;  // the first of those that are equally good is named
  const bool single_images = jumps_or_few(described) || described.residual > kResidual;
  const std::vector<Reading> readings = other_readings(fringes);
  std::set<std::size_t> tried;
  Tried out;
  for (const ScoredTile& at : telling_tiles(tiles, fringes, options)) {
    for (const std::size_t k : screened(at, readings, single_images, options)) {
      if (!tried.insert(k).second) continue;
      const ReadingScore score = all.score(readings[k], options);
      if (!readings[k].shifts_only &&
          score.good > (out.nearest ? out.nearest->score.good + kSame : described.good + kLeastGain))
        out.nearest = Answer{readings[k], score};
      if (answers(described, readings[k], score) && (!out.best || score.good > out.best->score.good + kSame))
        out.best = Answer{readings[k], score};
    }
    if (out.best || is_settled) break;
  }
  return out;
}

/// Returns the modulation that counts as reached: the twin's, and beyond the range that known noise makes in
/// some ten images.
double least_modulation(const DecodeOptions& options, const CameraDecode& decoded) {
  constexpr double kSigmas = 4.0;
  double least = options.min_modulation_dn;
  for (const DirectionDecode& d : decoded.directions)
    if (d.noise_source == NoiseSource::known) least = std::max(least, kSigmas * d.noise_dn);
  return least;
}

}  // namespace

std::vector<Doubt> description_doubts(const CameraImages& images, const Fringes& fringes,
                                      const DecodeOptions& options, const CameraDecode& decoded,
                                      const ExpectedCoordinates& expected) {
  std::vector<Doubt> out;
  if (images.radiance || images.images.empty()) return out;
  DecodeOptions all_steps = options;
  all_steps.min_modulation_dn = least_modulation(options, decoded);
  const Tiles tiles(images, all_steps.min_modulation_dn);
  if (tiles.empty()) return out;
  all_steps.use_steps.clear();
  const Sample sample(tiles, images, expected, all_steps.min_modulation_dn);
  const ReadingScore described = sample.score(described_reading(fringes), all_steps);
  const std::vector<std::pair<int, int>> repeated = repeated_images(sample.images, fringes, sample.reached);
  if (described.n < kFewestPixels) return out;  // single pixels that noise lifts over the bound
  if (!contradicted(described) && !only_moved(described)) return out;

  std::vector<Sample> each;
  for (std::size_t k = 0; k < tiles.size(); ++k)
    each.emplace_back(tiles.only(k), images, expected, all_steps.min_modulation_dn);
  const Tried tried = try_other_readings(sample, each, fringes, described, all_steps, !repeated.empty());
  const std::optional<Answer>& best = tried.best;
  const auto tell = [&](const std::string& sentence, bool shows_other_fringes, DoubtKind kind) {
    out.push_back({fmt::format("camera \"{}\": {}", images.camera, sentence), shows_other_fringes, kind});
  };
  const ImageU8 reached = reached_pixels(images, all_steps.min_modulation_dn);
  const Counts everywhere = count(decoded, reached);
  const std::string wrong = what_is_wrong(described, everywhere);
  const auto would_be = [&](const Answer& a) {
    return what_would_be(described, a.reading, a.score, images, all_steps, reached);
  };
  for (const auto& [earlier, later] : repeated)
    tell(fmt::format("image {} repeats image {}, so that one pattern of the sequence is missing", later,
                     earlier),
         true, DoubtKind::repeated_image);
  if (best)
    tell(fmt::format("the images {} not as described: {}; {}", best->reading.shifts_only ? "may be" : "are",
                     wrong, would_be(*best)),
         !best->reading.shifts_only, kind_of(fringes, described, best->reading));
  else if (repeated.empty() && (everywhere.jumps_or_few() || described.residual > kLargeResidual))
    tell(fmt::format(
             "{}; no other reading of [fringes] that was tried takes most of this away{}", wrong,
             tried.nearest && jumps_or_few(described) ? " (the best, " + would_be(*tried.nearest) + ")" : ""),
         false, kind_of(fringes, described, described_reading(fringes)));
  return out;
}

}  // namespace fringetwin::measure
