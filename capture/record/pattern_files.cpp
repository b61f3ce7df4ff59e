// SPDX-License-Identifier: Apache-2.0
#include "capture/record/pattern_files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <set>
#include <sstream>

#include "capture/record/plan.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/not_copyable.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::capture {
namespace fs = std::filesystem;
namespace {

constexpr int kPatternBits = 8;
constexpr std::size_t kFewestDigits = 3;

/// Removes the folder at its end: what is not put in place, or was replaced by it.
class FolderInProgress : NotCopyable {
 public:
  explicit FolderInProgress(fs::path dir) : dir_(std::move(dir)) {
    std::error_code error;
    fs::remove_all(dir_, error);
    fs::create_directories(dir_, error);
    if (error)
      throw UserError(ExitCode::usage, dir_.string(),
                      fmt::format("cannot make this folder ({})", error.message()));
  }
  ~FolderInProgress() {
    std::error_code ignored;
    fs::remove_all(dir_, ignored);
  }
  const fs::path& path() const { return dir_; }

 private:
  fs::path dir_;
};

/// Beside the folder, so that renaming is one step; hidden, as other unfinished files.
fs::path hidden_beside(const fs::path& dir, const char* what) {
  const fs::path tidy = dir.lexically_normal();
  const fs::path own = tidy.has_filename() ? tidy : tidy.parent_path();
  return own.parent_path() / fmt::format(".{}.{}.{}.tmp", own.filename().string(), what, ::getpid());
}

/// Returns the names of the files that were written with the table that is in the folder; none without one.
std::set<std::string> written_before(const fs::path& dir) {
  const fs::path table = dir / kPatternTableName;
  std::error_code error;
  if (!fs::is_regular_file(table, error)) return {};
  std::set<std::string> names{kPatternTableName};
  std::istringstream lines(
      read_whole_text(table, {FileKind::text, "table of patterns", ExitCode::usage, ""}));
  for (std::string line; std::getline(lines, line);) {  // number,file,...
    const auto begin = line.find(',');
    if (begin != std::string::npos)
      names.insert(line.substr(begin + 1, line.find(',', begin + 1) - begin - 1));
  }
  return names;
}

/// What is there already is replaced when all of it was written by us: a recording's images have such names,
/// too.
void check_pattern_folder(const fs::path& dir, bool overwrite) {
  std::error_code error;
  if (!fs::exists(dir, error)) return;
  if (!fs::is_directory(dir, error))
    throw UserError(ExitCode::usage, dir.string(), "is no folder", "choose another for --patterns");
  const std::set<std::string> ours = written_before(dir);
  for (const auto& entry : fs::directory_iterator(dir, error)) {
    if (!overwrite)
      throw UserError(ExitCode::usage, dir.string(), "is not empty",
                      "choose another folder, or replace earlier patterns with --overwrite");
    if (!ours.contains(entry.path().filename().string()) || !entry.is_regular_file(error))
      throw UserError(ExitCode::usage, entry.path().string(),
                      "is no file of --patterns, which replace a folder", "choose another folder");
  }
  if (error)
    throw UserError(ExitCode::usage, dir.string(), fmt::format("cannot be read ({})", error.message()));
}

/// "phase step,x,13,2,,": kind, direction, pitch, step and bit from 1.
std::string what_it_is(const Fringes& fringes, const std::vector<PatternSpec>& sequence,
                       const Pattern& pattern) {
  if (pattern.index < 0) return fmt::format("{},,,,", pattern.label);
  const PatternSpec& spec = sequence.at(static_cast<std::size_t>(pattern.index));
  if (spec.is_image()) return "image,,,,";
  const DirectionFringes& direction = fringes.directions.at(static_cast<std::size_t>(spec.direction));
  const char* axis = direction.axis == Axis::x ? "x" : "y";
  const std::string inverse = spec.is_inverse() ? " inverse" : "";
  const double pitch_px = direction.pitches_px.at(static_cast<std::size_t>(spec.pitch));
  if (spec.kind == PatternSpec::Kind::phase_step)
    return fmt::format("phase step,{},{},{},", axis, pitch_px, spec.step + 1);
  if (spec.is_complementary()) return fmt::format("complementary bit{},{},{},,", inverse, axis, pitch_px);
  return fmt::format("gray bit{},{},{},,{}", inverse, axis, pitch_px, spec.bit + 1);
}

void write_picture(const fs::path& file, const Fringes& fringes, const Pattern& pattern, int width,
                   int height) {
  const ImageU16 values = quantise_levels(pattern_levels(fringes, pattern, width, height), kPatternBits);
  ImageF image(width, height);
  std::ranges::copy(values.data, image.data.begin());
  write_gray_png(file, image, kPatternBits);
}

void put_in_place(const fs::path& made, const fs::path& dir) {
  const fs::path old = hidden_beside(dir, "old");
  std::error_code error, ignored;
  // In one step where the file system has it: what is removed afterwards is then the old folder.
  if (::renameat2(AT_FDCWD, made.c_str(), AT_FDCWD, dir.c_str(), RENAME_EXCHANGE) == 0) return;
  fs::remove_all(old, ignored);
  const bool replaces = fs::exists(dir, ignored);
  if (replaces) fs::rename(dir, old, error);
  if (!error) fs::rename(made, dir, error);
  if (error) {
    if (replaces && !fs::exists(dir, ignored)) fs::rename(old, dir, ignored);
    throw UserError(ExitCode::usage, dir.string(), fmt::format("cannot be written ({})", error.message()));
  }
  fs::remove_all(old, ignored);
}

}  // namespace

std::size_t write_pattern_files(const Twin& twin, const fs::path& dir, bool overwrite) {
  check_pattern_folder(dir, overwrite);
  const std::vector<Step> steps = make_steps(twin.fringes, CapturePlan());
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  const Lens& projector = twin.projector->lens;
  const FolderInProgress made(hidden_beside(dir, "new"));
  const std::size_t digits = std::max(kFewestDigits, std::to_string(steps.size() - 1).size());
  std::string table = "number,file,kind,direction,pitch_px,step,bit,pattern\n";
  Progress progress("patterns", steps.size());
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Pattern& pattern = steps[k].pattern;
    const std::string name = fmt::format("{:0{}d}.png", k, digits);
    write_picture(made.path() / name, twin.fringes, pattern, projector.width(), projector.height());
    table +=
        fmt::format("{},{},{},{}\n", k, name, what_it_is(twin.fringes, sequence, pattern), pattern.label);
    progress.advance();
  }
  write_text_file(made.path() / kPatternTableName, table);
  put_in_place(made.path(), dir);
  return steps.size();
}

}  // namespace fringetwin::capture
