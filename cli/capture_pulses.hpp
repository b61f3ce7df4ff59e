// SPDX-License-Identifier: Apache-2.0
// `capture` with a projector that runs by itself: the pictures it is loaded with, and the recording that its
// pulses lead.
#pragma once
#include <map>
#include <optional>
#include <string>

#include "capture/record/pulse_session.hpp"
#include "cli/capture_rig.hpp"

namespace fringetwin::cli {

struct PulseFlags {
  std::optional<double> wait_s, pause_ms;
  std::string patterns;  ///< folder to write them to; "": none asked for

  capture::PulseOptions options() const;
};

/// Adds --patterns, --wait-s and --pause-ms.
void add_pulse_flags(CLI::App& sub, PulseFlags& flags);

/// Throws UserError(usage) for --wait-s and --pause-ms without a line, and for what a projector that runs by
/// itself makes no sense with; `others` names options that were given, each with what to do instead.
void check_pulse_flags(const PulseFlags& flags, const RigFlags& rig, const capture::CapturePlan& plan,
                       const std::map<std::string, std::string>& others);

/// Writes the pictures and prints where they are.
void write_patterns(const Twin& twin, const PulseFlags& flags, bool overwrite);

}  // namespace fringetwin::cli
