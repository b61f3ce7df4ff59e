// SPDX-License-Identifier: Apache-2.0
// What every STUDY.toml says whatever the kind of the study, and what identifies the study's results.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "study/plan/study_tables.hpp"

namespace fringetwin::study {

struct StudyHead {
  std::filesystem::path file, twin;  ///< absolute
  std::string name;
  std::vector<Record> records;  ///< none: all numbers of the fits
  /// Every key as text but `name`, `twin` and where a Monte Carlo study stops: what its points depend on,
  /// whatever the file's layout.
  std::map<std::string, std::string> content;
};

/// What a study's results come from; two that are equal give the same table.
struct StudyIdentity {
  std::string study;                          ///< its content, a line per key
  std::map<std::string, std::string> inputs;  ///< file -> SHA-256: the twin and every file it names
  /// Returns the SHA-256 of the content and of the files' bytes, not of their names.
  std::string digest() const;
};

}  // namespace fringetwin::study
