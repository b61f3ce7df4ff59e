// SPDX-License-Identifier: Apache-2.0
// Checks whether a capture set is whole: every image decodes to its end and has the checksum it was recorded
// with, and none is missing or too many.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::capture {

struct SetCheck {
  int sets = 0;       ///< the set and those of its sub-folders that it names
  int cameras = 0;    ///< of the set itself
  int images = 0;     ///< decoded, of all sets, with white and black
  int checksums = 0;  ///< compared, of images and other files
  bool unfinished = false;
  std::vector<std::string> sets_without_checksums;
  std::vector<std::string> findings;  ///< a sentence each: file, what is wrong, what to do
  bool passed() const { return findings.empty(); }
  /// One line, for stdout.
  std::string summary() const;
};

/// Checks DIR and, where its provenance has `sets = "repeat_01 repeat_02"`, these sub-folders. With a twin
/// also that the images are those of its sequence and cameras. Checksums are the entries of
/// [provenance.sha256], file relative to DIR = digest; a set without any is checked as far as that goes, and
/// the result says so. Throws UserError(input) only where DIR is no folder; exit code 3 when findings are not
/// empty.
SetCheck verify_set(const std::filesystem::path& dir, const Twin* twin = nullptr);

}  // namespace fringetwin::capture
