// SPDX-License-Identifier: Apache-2.0
#include "capture/record/plan.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>

#include "twin/base/errors.hpp"
#include "twin/base/sha256.hpp"

namespace fringetwin::capture {
namespace {

constexpr int kMostFrames = 10'000;
constexpr int kFramesAtOnce = 16;  ///< of dark and flat frames

std::string number_name(int number) { return fmt::format("{:04d}", number); }

std::string exposure_folder(double exposure_ms) { return fmt::format("exposure_{}_ms", exposure_ms); }

std::string repeat_folder(int repeat) { return repeat == 0 ? "" : fmt::format("repeat_{:02d}", repeat); }

bool has_references(const Fringes& fringes, const CapturePlan& plan) {
  return plan.references || needs_white_black(fringes);
}

void check_range(const char* option, double value, double low, double high) {
  if (!(value >= low && value <= high))
    throw UserError(ExitCode::usage, option, fmt::format("must be {} to {}, is {}", low, high, value));
}

/// Single frames of an even field, some at a time: they are held in memory until they are written.
void add_plain_frames(std::vector<Step>& steps, const Pattern& pattern, const std::string& set,
                      std::optional<double> exposure_ms, int n) {
  for (int i = 0; i < n; ++i) {
    if (i % kFramesAtOnce == 0) steps.push_back({pattern, exposure_ms, 1, false, {}});
    steps.back().pictures.push_back({set + (set.empty() ? "" : "/") + pattern.label, number_name(i)});
  }
}

/// The patterns whose images decide what a recording shows, as the projector gets them.
std::string patterns_digest(const Twin& twin) {
  Sha256 digest;
  for (const Pattern& pattern : sequence_patterns(twin.fringes)) {
    const ImageF levels =
        pattern_levels(twin.fringes, pattern, twin.projector->lens.width(), twin.projector->lens.height());
    digest.add(std::as_bytes(std::span(levels.data)));
  }
  return digest.hex();
}

}  // namespace

std::string Picture::file(const std::string& camera) const {
  return fmt::format("{}{}{}/{}.png", set, set.empty() ? "" : "/", camera, name);
}

void check_plan(const CapturePlan& plan) {
  check_range("--settle", plan.settle_frames, 0, kMostFrames);
  check_range("--latency-ms", plan.latency_ms, 0.0, 10'000.0);
  check_range("--average", plan.average, 1, kMostFrames);
  check_range("--repeats", plan.repeats, 1, 99);
  check_range("--dark", plan.dark_frames, 0, kMostFrames);
  check_range("--flat", plan.flat_frames, 0, kMostFrames);
  if (plan.max_skew_ms) check_range("--max-skew-ms", *plan.max_skew_ms, 0.0, 10'000.0);
  for (const double exposure : plan.exposures_ms) check_range("--exposure-ms", exposure, 1e-3, 1e5);
  std::vector<double> sorted = plan.exposures_ms;
  std::ranges::sort(sorted);
  if (std::ranges::adjacent_find(sorted) != sorted.end())
    throw UserError(ExitCode::usage, "--exposure-ms", "names one exposure twice");
  if (plan.brackets() && plan.repeats > 1)
    throw UserError(ExitCode::usage, "--repeats", "and several exposures exclude each other",
                    "record the repeats at one exposure");
}

std::vector<Step> make_steps(const Fringes& fringes, const CapturePlan& plan) {
  std::vector<Step> steps;
  std::vector<Pattern> patterns = sequence_patterns(fringes);
  if (has_references(fringes, plan)) {
    patterns.push_back(even_field(1.0, "white"));
    patterns.push_back(even_field(0.0, "black"));
  }
  std::vector<std::optional<double>> exposures(plan.exposures_ms.begin(), plan.exposures_ms.end());
  if (exposures.empty()) exposures.emplace_back();
  for (const auto& exposure_ms : exposures) {
    const std::string set = plan.brackets() ? exposure_folder(*exposure_ms) : "";
    add_plain_frames(steps, even_field(0.0, "dark"), set, exposure_ms, plan.dark_frames);
    for (const Pattern& pattern : patterns) {
      Step step{pattern, exposure_ms, plan.average, true, {}};
      const std::string name = pattern.index >= 0 ? number_name(pattern.index) : pattern.label;
      for (int repeat = 0; repeat < plan.repeats; ++repeat)
        step.pictures.push_back({plan.brackets() ? set : repeat_folder(repeat), name});
      steps.push_back(std::move(step));
    }
    add_plain_frames(steps, even_field(1.0, "flat"), set, exposure_ms, plan.flat_frames);
  }
  return steps;
}

std::vector<RecordedSet> recorded_sets(const Fringes& fringes, const CapturePlan& plan) {
  const bool references = has_references(fringes, plan);
  std::vector<RecordedSet> sets;
  if (plan.brackets()) {
    sets.push_back({"", *std::ranges::min_element(plan.exposures_ms), references});
    for (const double exposure_ms : plan.exposures_ms)
      sets.push_back({exposure_folder(exposure_ms), exposure_ms, references});
    return sets;
  }
  std::optional<double> exposure_ms;
  if (!plan.exposures_ms.empty()) exposure_ms = plan.exposures_ms.front();
  for (int repeat = 0; repeat < plan.repeats; ++repeat)
    sets.push_back({repeat_folder(repeat), exposure_ms, references});
  return sets;
}

std::map<std::string, std::string> plan_identity(const Twin& twin, const CapturePlan& plan) {
  std::map<std::string, std::string> identity = {
      {"patterns", patterns_digest(twin)},
      {"average", std::to_string(plan.average)},
      {"repeats", std::to_string(plan.repeats)},
      {"exposure-ms", fmt::format("{}", fmt::join(plan.exposures_ms, " "))},
      {"references", has_references(twin.fringes, plan) ? "yes" : "no"},
      {"dark", std::to_string(plan.dark_frames)},
      {"flat", std::to_string(plan.flat_frames)},
  };
  for (const Camera& camera : twin.cameras)
    identity["camera " + camera.name] = fmt::format("{} x {} px, {} bit", camera.lens.width(),
                                                    camera.lens.height(), camera.sensor.bit_depth) +
                                        (camera.channel ? ", " + text_of(*camera.channel) : "");
  return identity;
}

}  // namespace fringetwin::capture
