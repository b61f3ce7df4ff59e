// SPDX-License-Identifier: Apache-2.0
#include "cli/capture_pulses.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "capture/record/pattern_files.hpp"
#include "cli/option_groups.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cli {

capture::PulseOptions PulseFlags::options() const {
  capture::PulseOptions options;
  if (wait_s) options.wait = std::chrono::milliseconds(std::llround(1000.0 * *wait_s));
  if (pause_ms) options.pause = std::chrono::milliseconds(std::llround(*pause_ms));
  return options;
}

void add_pulse_flags(CLI::App& sub, PulseFlags& flags) {
  begin_group(sub, "A projector that runs by itself (--trigger LINE)");
  sub.add_option(
         "--patterns", flags.patterns,
         "Write the pictures that it is loaded with, 000.png ..., and what they are; nothing is recorded")
      ->type_name("DIR");
  sub.add_option("--wait-s", flags.wait_s, "For the first pulse of a run")
      ->type_name("S")
      ->check(CLI::Range(0.1, 86'400.0))
      ->default_str("60");
  sub.add_option("--pause-ms", flags.pause_ms, "Without a pulse, after which a run has ended")
      ->type_name("MS")
      ->check(CLI::Range(50.0, 60'000.0))
      ->default_str("500");
}

void check_pulse_flags(const PulseFlags& flags, const RigFlags& rig, const capture::CapturePlan& plan,
                       const std::map<std::string, std::string>& others) {
  const std::string line = rig.trigger_line();
  if (line.empty()) {
    for (const auto& [option, given] : {std::pair{"--wait-s", flags.wait_s}, {"--pause-ms", flags.pause_ms}})
      if (given)
        throw UserError(ExitCode::usage, option, "is for a projector that runs by itself",
                        "add --trigger LINE, or leave it out");
    return;
  }
  for (const auto& [option, instead] : others)
    throw UserError(ExitCode::usage, option, fmt::format("and --trigger {} exclude each other", line),
                    instead);
  if (!rig.display.empty())
    throw UserError(ExitCode::usage, "--display", fmt::format("and --trigger {} exclude each other", line),
                    "the projector shows the sequence by itself, load it with the pictures of --patterns");
  capture::check_pulse_plan(plan, line);
}

void write_patterns(const Twin& twin, const PulseFlags& flags, bool overwrite) {
  check_out_folder(flags.patterns);
  const std::size_t n = capture::write_pattern_files(twin, flags.patterns, overwrite);
  say(fmt::format("{} pictures of {} x {} px: {}", n, twin.projector->lens.width(),
                  twin.projector->lens.height(), flags.patterns));
}

}  // namespace fringetwin::cli
