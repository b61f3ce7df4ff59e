// SPDX-License-Identifier: Apache-2.0
// What STUDY.toml says (docs/FORMATS.md), after checking.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "study/monte_carlo/monte_carlo_file.hpp"
#include "study/optimise/optimise_file.hpp"
#include "study/plan/study_point.hpp"
#include "study/plan/study_tables.hpp"
#include "study/volume_map/volume_map_file.hpp"

namespace fringetwin::study {

enum class Design { grid, list, latin_hypercube, sobol };

struct StudyFile {
  std::filesystem::path file, twin;  ///< absolute
  std::string name;
  Design design = Design::grid;
  int points = 0;  ///< of latin_hypercube and sobol
  std::uint64_t seed = 1;
  int noise_seeds = 1;
  std::uint64_t first_noise_seed = 1;
  std::vector<Variation> vary;
  // At most one of these; with it: no design, no variations.
  std::optional<MonteCarloSettings> monte_carlo;
  std::optional<VolumeMapSettings> volume_map;
  std::optional<OptimiseSettings> optimise;
  std::vector<Record> records;  ///< none: all numbers of the fits
  /// Every key as text but `name` and `twin`: what the results depend on, whatever the file's layout.
  std::map<std::string, std::string> content;
};

/// Throws UserError(usage) with file, line and key.
StudyFile load_study(const std::filesystem::path& file);

/// What a study's results come from; two that are equal give the same table.
struct StudyIdentity {
  std::string study;                          ///< its content, a line per key
  std::map<std::string, std::string> inputs;  ///< file -> SHA-256: the twin and every file it names
  std::string digest() const;                 ///< of the content and the files' bytes, not of their names
};
/// Loads the twin with the settings of the first point that can be read, and of every point that sets a
/// string, which may name a file. A key path that does not exist, and a design none of whose points can be
/// read, is a UserError(usage): points that fail alone are for the runner to record.
StudyIdentity check_study(const StudyFile& study, const std::vector<StudyPoint>& points);

}  // namespace fringetwin::study
