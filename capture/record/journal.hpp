// SPDX-License-Identifier: Apache-2.0
// The log of an unfinished recording (capture.journal): what is safe on disk, so that --resume can go on.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "capture/device/pattern_display.hpp"

namespace fringetwin::capture {

inline constexpr const char* kJournalName = "capture.journal";

/// The record of one frame and of what became of it.
struct FrameRecord {
  std::string camera;
  std::uint32_t sequence = 0;
  TimeNs timestamp_ns = 0;
  std::uint32_t flags = 0;
  std::string use;    ///< "0003" (the image it went into), "settling", "stale", "repeated", a fault's name
  Shown shown = {};   ///< its pattern: tried again, a step has several
  bool good = false;  ///< it went into an image; not kept in the journal
};

/// A finished step: its images are on disk.
struct StepRecord {
  int step = 0;
  std::string pattern;
  Shown shown;
  std::map<std::string, std::string> sha256;  ///< by file, relative to the set's folder
  std::vector<FrameRecord> frames;            ///< of all attempts
  std::uint32_t lost_frames = 0;              ///< gaps in the cameras' counts while frames were wanted
  int repeated_frames = 0, corrupt_frames = 0, attempts = 1;
  double skew_ms = 0.0;  ///< largest between two cameras' frames of the same picture
};

class Journal {
 public:
  /// A new one, written whole and renamed. `identity`: see plan_identity().
  static Journal begin(const std::filesystem::path& dir, const std::map<std::string, std::string>& identity);
  /// Reads what is there; a last line cut short is dropped. Throws UserError(input) for no journal or a
  /// damaged one, UserError(usage) when `identity` is another than it was begun with.
  static Journal resume(const std::filesystem::path& dir, const std::map<std::string, std::string>& identity);

  /// Returns what the recording in that folder was begun with; empty when there is none. Throws
  /// UserError(input).
  static std::map<std::string, std::string> identity(const std::filesystem::path& dir);
  /// Returns the journal of a recording that is complete: no file, no records.
  static Journal none() { return Journal({}); }

  /// Records found by resume() and appended since, in order of time.
  const std::vector<StepRecord>& records() const { return records_; }
  /// One line, on disk when this returns. Throws UserError(device) when the disk is full.
  void append(const StepRecord& record);
  /// Removes the file: the set is complete.
  void remove();

 private:
  explicit Journal(std::filesystem::path file) : file_(std::move(file)) {}
  std::filesystem::path file_;
  std::vector<StepRecord> records_;
};

}  // namespace fringetwin::capture
