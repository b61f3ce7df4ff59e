// SPDX-License-Identifier: Apache-2.0
// Writes the folder of a recording: images as they come, the journal beside them, capture.toml at the very
// end.
#pragma once
#include <filesystem>
#include <future>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "capture/record/journal.hpp"
#include "capture/record/plan.hpp"
#include "twin/image/image.hpp"
#include "twin/twin.hpp"

namespace fringetwin::capture {

enum class Existing { refuse, resume, overwrite };
enum class Found { nothing, unfinished, complete };

/// An image of one camera, to be written to `file` (relative to the folder).
struct RecordedImage {
  std::string file;
  int bit_depth = 8;
  ImageF image;
};

class Recording {
 public:
  /// Returns what the folder holds, before anything is opened or changed; images of a complete set are
  /// checked. Throws UserError(usage) when it holds something that `existing` does not allow to go on with.
  static Found look_into(const std::filesystem::path& dir, const Twin& twin, const CapturePlan& plan,
                         Existing existing);

  /// `identity`: plan_identity() and what else must not change before a --resume.
  /// Makes the folder and its journal, or reads what is there. Throws UserError(usage) when the folder holds
  /// a recording and `existing` is refuse, or another one when it is resume.
  Recording(const std::filesystem::path& dir, const Twin& twin, const CapturePlan& plan,
            const std::map<std::string, std::string>& identity, Existing existing);

  /// The set is complete already: nothing left to do for resume.
  bool complete() const { return complete_; }
  /// Steps whose images are on disk with the sums that the journal says.
  bool has(int step) const { return done_.contains(step); }
  std::size_t n_done() const { return done_.size(); }

  /// Writes the images and then the journal's line, in the background: the next pattern may be shown
  /// meanwhile. Throws what the one before threw (a full disk).
  void store(StepRecord record, std::vector<RecordedImage> images);
  /// Makes store() wait until the image is written, for benchmarks.
  void write_at_once() { at_once_ = true; }
  /// Waits for what store() began.
  void flush();

  /// Merges brackets, writes frames.csv and every capture.toml, the main one last; then the journal goes.
  void finish(const std::map<std::string, std::string>& provenance);

  const std::vector<StepRecord>& records() const { return journal_.records(); }

 private:
  Journal open(Existing existing);
  void take_over_records();
  void merge_brackets();
  void sync() const;
  void write_set(const RecordedSet& set, std::map<std::string, std::string> provenance) const;

  std::filesystem::path dir_;
  const Twin& twin_;
  CapturePlan plan_;
  std::map<std::string, std::string> identity_;
  bool complete_ = false, at_once_ = false;
  Journal journal_;
  std::set<int> done_;
  std::map<std::string, std::string> sha256_;  ///< by file, relative to dir_
  std::future<StepRecord> pending_;
};

}  // namespace fringetwin::capture
