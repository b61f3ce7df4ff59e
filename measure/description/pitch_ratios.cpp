// SPDX-License-Identifier: Apache-2.0
#include "measure/description/pitch_ratios.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

constexpr double kWholeTurn = 2.0 * std::numbers::pi;
constexpr int kEveryLine = 4;         ///< lines next to each other say the same
constexpr double kLargestStep = 2.0;  ///< rad per pixel: beyond, a step may be one of another period
constexpr double kBend = 0.6;         ///< rad: a change of the step from pixel to pixel that is an edge
constexpr double kApart = 0.4;  ///< rad: what the steps of two pitches may differ by, else it is an edge
constexpr double kFewestTurns = 8.0;   ///< of a run
constexpr std::size_t kLineParts = 8;  ///< of the lines, for the scatter
constexpr std::size_t kFewestRuns = 24;
/// What counts as a contradiction: beyond chance, beyond what steps of the projector leave, and beyond what
/// harmonics leave in runs of so many turns.
constexpr double kPitchSigmas = 6.0, kLeastOff = 0.0015;
/// Turns by which harmonics of the response move the two ends of a run together: of three steps a gamma g
/// moves each by up to (g - 1) / (g + 2) rad, its second harmonic over its first, which is 0.046 turns of g
/// = 2.2; of four steps and more by 0.01 turns at most. It adds up over all lines of a scene whose ends have
/// one phase.
constexpr double kHarmonicTurns = 0.09;

/// The phases of all pitches summed over runs of pixels, each run with the sign of its own direction.
struct Turns {
  std::vector<double> sum_rad;
  std::size_t runs = 0;
};

double to_half_turn(double rad) { return rad - kWholeTurn * std::round(rad / kWholeTurn); }

/// Follows one line of pixels and adds its runs.
class LineWalk {
 public:
  LineWalk(const DirectionDecode& decoded, Turns& turns)
      : decoded_(decoded), turns_(turns), run_rad_(decoded.pitches_px.size()), step_rad_(run_rad_.size()) {}
  void step(int x, int y, int before_x, int before_y) {
    for (std::size_t k = 0; k < step_rad_.size(); ++k) {
      const ImageF& phase = decoded_.wrapped_rad[k];
      step_rad_[k] =
          to_half_turn(static_cast<double>(phase(x, y)) - static_cast<double>(phase(before_x, before_y)));
    }
    const double fine_rad = step_rad_[static_cast<std::size_t>(decoded_.finest)];
    const double step_px = fine_rad * decoded_.pitches_px[static_cast<std::size_t>(decoded_.finest)];
    bool goes_on = !last_rad_ || std::abs(fine_rad - *last_rad_) < kBend;
    for (std::size_t k = 0; k < step_rad_.size(); ++k)
      goes_on = goes_on && std::abs(step_rad_[k]) < kLargestStep &&
                std::abs(step_rad_[k] - step_px / decoded_.pitches_px[k]) < kApart;
    if (!goes_on) return end();
    last_rad_ = fine_rad;
    for (std::size_t k = 0; k < step_rad_.size(); ++k) run_rad_[k] += step_rad_[k];
  }
  void end() {
    const double fine_rad = run_rad_[static_cast<std::size_t>(decoded_.finest)];
    if (std::abs(fine_rad) > kFewestTurns * kWholeTurn) {
      ++turns_.runs;
      for (std::size_t k = 0; k < run_rad_.size(); ++k)
        turns_.sum_rad[k] += fine_rad > 0.0 ? run_rad_[k] : -run_rad_[k];
    }
    std::ranges::fill(run_rad_, 0.0);
    last_rad_.reset();
  }

 private:
  const DirectionDecode& decoded_;
  Turns& turns_;
  std::vector<double> run_rad_, step_rad_;
  std::optional<double> last_rad_;
};

/// Returns the median size of the finest phase's steps from pixel to pixel, along x or y; 0 without any.
double median_step_rad(const ImageF& phase, int dx, int dy) {
  std::vector<double> steps_rad;
  for (int y = dy; y < phase.height; y += kEveryLine)
    for (int x = dx; x < phase.width; x += kEveryLine) {
      const double step_rad =
          to_half_turn(static_cast<double>(phase(x, y)) - static_cast<double>(phase(x - dx, y - dy)));
      if (std::isfinite(step_rad)) steps_rad.push_back(std::abs(step_rad));
    }
  return steps_rad.empty() ? 0.0 : upper_median(std::span<double>(steps_rad));
}

/// Returns whether the fringes follow each other along the image's x, however the camera is turned.
bool fringes_follow_x(const DirectionDecode& decoded) {
  const ImageF& finest = decoded.wrapped_rad[static_cast<std::size_t>(decoded.finest)];
  return median_step_rad(finest, 1, 0) >= median_step_rad(finest, 0, 1);
}

/// Sums the runs of the lines, along x or y, that belong to a part of the image.
Turns turns_of(const DirectionDecode& decoded, bool along_x, std::size_t part) {
  Turns turns{std::vector<double>(decoded.pitches_px.size(), 0.0)};
  const ImageF& phase = decoded.wrapped_rad.front();
  const int lines = along_x ? phase.height : phase.width, pixels = along_x ? phase.width : phase.height;
  LineWalk walk(decoded, turns);
  for (int line = 0; line < lines; line += kEveryLine) {
    if (static_cast<std::size_t>(line) * kLineParts / static_cast<std::size_t>(lines) != part) continue;
    for (int i = 1; i < pixels; ++i)
      along_x ? walk.step(i, line, i - 1, line) : walk.step(line, i, line, i - 1);
    walk.end();
  }
  return turns;
}

/// Returns the pitches that these turns say, the median of them over what is stated being 1.
std::vector<double> told_pitches(const std::vector<double>& turns_rad, const std::vector<double>& stated_px) {
  std::vector<double> told, ratio;
  const double most = *std::ranges::max_element(turns_rad);
  for (std::size_t k = 0; k < stated_px.size(); ++k) {
    // Of the fewest turns that count, a pitch four times as wide makes two: its harmonics would tell.
    constexpr double kWidest = 4.0;
    const bool is_told = turns_rad[k] * kWidest > most;
    told.push_back(is_told ? 1.0 / turns_rad[k] : 0.0);
    if (is_told) ratio.push_back(told.back() / stated_px[k]);
  }
  const double scale = upper_median(std::span<double>(ratio));
  for (double& pitch_px : told) pitch_px /= scale;
  return told;
}

double worst_of(const std::vector<double>& told_px, const std::vector<double>& stated_px) {
  double worst = 0.0;
  for (std::size_t k = 0; k < told_px.size(); ++k)
    if (told_px[k] > 0.0) worst = std::max(worst, std::abs(told_px[k] / stated_px[k] - 1.0));
  return worst;
}

/// Returns by how much pitches are off where each may be any of those that are stated.
double off_in_any_order(const std::vector<double>& told_px, const std::vector<double>& stated_px) {
  std::vector<double> told, stated, ratio;
  for (std::size_t k = 0; k < told_px.size(); ++k) {
    if (!(told_px[k] > 0.0)) continue;
    told.push_back(told_px[k]);
    stated.push_back(stated_px[k]);
  }
  std::ranges::sort(told);
  std::ranges::sort(stated);
  for (std::size_t k = 0; k < told.size(); ++k) ratio.push_back(told[k] / stated[k]);
  const double scale = upper_median(std::span<double>(ratio));
  for (double& pitch_px : told) pitch_px /= scale;
  return worst_of(told, stated);
}

/// Returns the turns of the widest pitch that is told.
double least_turns(const std::vector<double>& turns_rad, const std::vector<double>& told_px) {
  double least_rad = *std::ranges::max_element(turns_rad);
  for (std::size_t k = 0; k < told_px.size(); ++k)
    if (told_px[k] > 0.0) least_rad = std::min(least_rad, turns_rad[k]);
  return least_rad / kWholeTurn;
}

}  // namespace

std::optional<PitchRatios> pitch_ratios(const DirectionDecode& decoded) {
  const std::size_t n = decoded.pitches_px.size();
  if (n < 2 || decoded.wrapped_rad.size() != n) return std::nullopt;
  const bool along_x = fringes_follow_x(decoded);
  std::array<Turns, kLineParts> parts;
  Turns all{std::vector<double>(n, 0.0)};
  for (std::size_t part = 0; part < kLineParts; ++part) {
    parts[part] = turns_of(decoded, along_x, part);
    all.runs += parts[part].runs;
    for (std::size_t k = 0; k < n; ++k) all.sum_rad[k] += parts[part].sum_rad[k];
  }
  if (all.runs < kFewestRuns || !std::ranges::all_of(all.sum_rad, [](double rad) { return rad > 0.0; }))
    return std::nullopt;
  PitchRatios out{.pitches_px = told_pitches(all.sum_rad, decoded.pitches_px)};
  if (std::ranges::count_if(out.pitches_px, [](double px) { return px > 0.0; }) < 2) return std::nullopt;
  out.worst = worst_of(out.pitches_px, decoded.pitches_px);
  out.turns_per_run = least_turns(all.sum_rad, out.pitches_px) / static_cast<double>(all.runs);
  // Jackknife: each pitch without one part, largest of all pitches.
  double used = 0.0;
  std::vector<double> squares(n, 0.0);
  for (const Turns& part : parts) {
    if (part.runs == 0) continue;
    used += 1.0;
    std::vector<double> rest = all.sum_rad;
    for (std::size_t k = 0; k < n; ++k) rest[k] -= part.sum_rad[k];
    if (!std::ranges::all_of(rest, [](double rad) { return rad > 0.0; })) return std::nullopt;
    const std::vector<double> without = told_pitches(rest, decoded.pitches_px);
    for (std::size_t k = 0; k < n; ++k)
      if (out.pitches_px[k] > 0.0) squares[k] += std::pow(without[k] / out.pitches_px[k] - 1.0, 2);
  }
  if (used < 2.0) return std::nullopt;
  out.sigma = std::sqrt(*std::ranges::max_element(squares) * (used - 1.0) / used);
  return out;
}

std::optional<std::string> pitch_doubt(const DirectionDecode& decoded) {
  const std::optional<PitchRatios> told = pitch_ratios(decoded);
  if (!told) return std::nullopt;
  const double least_off =
      std::max({kLeastOff, kHarmonicTurns / told->turns_per_run, kPitchSigmas * told->sigma});
  if (told->worst < least_off) return std::nullopt;
  // Right pitches in another order: a reading of the images in that order says so, and mends all.
  if (off_in_any_order(told->pitches_px, decoded.pitches_px) < least_off) return std::nullopt;
  std::vector<std::string> stated, seen;
  for (std::size_t k = 0; k < told->pitches_px.size(); ++k) {
    if (!(told->pitches_px[k] > 0.0)) continue;
    stated.push_back(fmt::format("{:g}", decoded.pitches_px[k]));
    seen.push_back(fmt::format("{:.5g}", told->pitches_px[k]));
  }
  return fmt::format(
      "direction \"{}\": the phases say that the pitches are as {}, [fringes] pitches_px says {}: {:.2g} % "
      "off, {:.0f} times what the noise allows; only what they are to each other is told, not their scale",
      axis_name(decoded.axis), fmt::join(seen, " : "), fmt::join(stated, " : "), 100.0 * told->worst,
      told->worst / std::max(told->sigma, 1e-6));
}

}  // namespace fringetwin::measure
