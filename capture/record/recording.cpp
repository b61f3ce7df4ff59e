// SPDX-License-Identifier: Apache-2.0
#include "capture/record/recording.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>

#include "capture/record/exposure_merge.hpp"
#include "capture/record/verify_set.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/sha256.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::capture {
namespace fs = std::filesystem;
namespace {

constexpr const char* kTomlName = "capture.toml";
constexpr const char* kFramesName = "frames.csv";

std::string identity_digest(const std::map<std::string, std::string>& identity) {
  std::string text;
  for (const auto& [key, value] : identity) text += key + " = " + value + "\n";
  return sha256_of_text(text);
}

StepRecord write_images(const fs::path& dir, StepRecord record, const std::vector<RecordedImage>& images,
                        Journal* journal) {
  for (const RecordedImage& image : images) {
    write_gray_png(dir / image.file, image.image, image.bit_depth <= 8 ? 8 : 16);
    record.sha256[image.file] = sha256_of_file(dir / image.file);
  }
  journal->append(record);
  return record;
}

std::string frames_csv(const std::vector<StepRecord>& records) {
  std::string text = "step,pattern,shown_ns,display_sequence,camera,sequence,timestamp_ns,flags,use\n";
  for (const StepRecord& r : records)
    for (const FrameRecord& f : r.frames)
      text += fmt::format("{},{},{},{},{},{},{},0x{:x},{}\n", r.step, r.pattern, f.shown.at_ns,
                          f.shown.sequence, f.camera, f.sequence, f.timestamp_ns, f.flags, f.use);
  return text;
}

std::vector<fs::path> entries(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) found.push_back(entry.path());
  return found;
}

/// Returns whether a recording gives this name to a folder beside the cameras': repeat_01, exposure_2_ms,
/// dark, flat.
bool is_set_folder(const std::string& name) {
  return name.starts_with("repeat_") || (name.starts_with("exposure_") && name.ends_with("_ms")) ||
         name == "dark" || name == "flat";
}

void add_set_folders(const fs::path& folder, std::vector<fs::path>* folders) {
  folders->push_back(folder);
  std::error_code error;
  for (const fs::path& entry : entries(folder))
    if (is_set_folder(entry.filename().string()) && fs::is_directory(entry, error))
      add_set_folders(entry, folders);
}

/// Returns the folder itself and those of them that are there, dark and flat frames of an exposure included.
std::vector<fs::path> set_folders(const fs::path& dir) {
  std::vector<fs::path> folders;
  add_set_folders(dir, &folders);
  return folders;
}

/// Returns whether a recording writes images of this name, "0000.png", "white.png", "black.png", and nothing
/// of the user's.
bool is_recorded_image(const std::string& name) {
  if (name == "white.png" || name == "black.png") return true;
  return name.size() >= 8 && name.ends_with(".png") &&
         std::all_of(name.begin(), name.end() - 4, [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// Returns the files of that kind in the cameras' folders, relative to `dir`.
std::vector<std::string> recorded_images(const fs::path& dir, const Twin& twin) {
  std::vector<std::string> found;
  for (const fs::path& folder : set_folders(dir))
    for (const Camera& camera : twin.cameras)
      for (const fs::path& file : entries(folder / camera.name))
        if (is_recorded_image(file.filename().string()))
          found.push_back(file.lexically_relative(dir).generic_string());
  return found;
}

/// Removes what a program that was killed left under temporary names.
void remove_temporary_files(const fs::path& dir, const Twin& twin) {
  std::error_code ignored;
  for (const fs::path& folder : set_folders(dir)) {
    std::vector<fs::path> folders = {folder};
    for (const Camera& camera : twin.cameras) folders.push_back(folder / camera.name);
    for (const fs::path& inside : folders)
      for (const fs::path& file : entries(inside))
        if (is_temporary_name(file.filename().string())) fs::remove(file, ignored);
  }
}

}  // namespace

Recording::Recording(const fs::path& dir, const Twin& twin, const CapturePlan& plan,
                     const std::map<std::string, std::string>& identity, Existing existing)
    : dir_(dir), twin_(twin), plan_(plan), identity_(identity), journal_(open(existing)) {
  take_over_records();
}

namespace {

[[noreturn]] void refuse(const fs::path& where, const std::string& what) {
  throw UserError(ExitCode::usage, where.string(), what,
                  "choose another folder, or replace it with --overwrite");
}

bool is_of_plan(const fs::path& dir, const Twin& twin, const CapturePlan& plan) {
  const int n_images = static_cast<int>(expand_sequence(twin.fringes).size());
  const auto provenance = read_capture_set(dir, n_images).provenance;
  const auto digest = provenance.find("plan_sha256");
  return digest != provenance.end() && digest->second == identity_digest(plan_identity(twin, plan));
}

void check_complete(const fs::path& dir, const Twin& twin) {
  std::error_code ignored;
  fs::remove(dir / kJournalName, ignored);  // a kill came between the two
  const SetCheck check = verify_set(dir, &twin);
  if (!check.passed())
    throw UserError(ExitCode::input, check.findings.front(), "the set was complete once",
                    "restore it from a copy, or record it again with --overwrite");
}

}  // namespace

Found Recording::look_into(const fs::path& dir, const Twin& twin, const CapturePlan& plan,
                           Existing existing) {
  for (const Camera& camera : twin.cameras)
    if (is_set_folder(camera.name))
      throw UserError(ExitCode::usage, fmt::format("camera \"{}\"", camera.name),
                      "has the name of a folder that a recording makes for itself", "name it otherwise");
  if (existing == Existing::overwrite) return Found::nothing;
  const bool has_journal = fs::exists(dir / kJournalName), has_toml = fs::exists(dir / kTomlName);
  if (existing == Existing::resume && has_toml && is_of_plan(dir, twin, plan)) {
    check_complete(dir, twin);
    return Found::complete;
  }
  // Beside an older set: --overwrite was killed.
  if (existing == Existing::resume && has_journal) return Found::unfinished;
  if (existing == Existing::resume && has_toml) refuse(dir, "holds a complete set recorded otherwise");
  if (has_toml) refuse(dir, "holds a capture set already");
  const std::vector<std::string> images = recorded_images(dir, twin);
  if (images.empty()) return Found::nothing;
  if (has_journal)
    throw UserError(ExitCode::usage, dir.string(), "holds an unfinished recording",
                    "go on with --resume, or begin anew with --overwrite");
  refuse(dir / images.front(), "is there already, and no journal says whose it is");
}

Journal Recording::open(Existing existing) {
  const Found found = look_into(dir_, twin_, plan_, existing);
  complete_ = found == Found::complete;
  if (complete_) return Journal::none();
  std::error_code error;
  fs::create_directories(dir_, error);
  if (!hold_folder(dir_))
    throw UserError(ExitCode::usage, dir_.string(), "another program is recording into this folder",
                    "wait until it has ended, or choose another folder");
  // The journal before what it replaces goes: --resume can go on at any moment.
  Journal journal =
      found == Found::unfinished ? Journal::resume(dir_, identity_) : Journal::begin(dir_, identity_);
  for (const fs::path& folder : set_folders(dir_)) fs::remove(folder / kTomlName, error);
  return journal;
}

void Recording::take_over_records() {
  std::map<int, const StepRecord*> latest;  // a step recorded again has two
  for (const StepRecord& record : journal_.records()) latest[record.step] = &record;
  for (const auto& [step, entry] : latest) {
    const StepRecord& record = *entry;
    const bool intact = std::ranges::all_of(record.sha256, [&](const auto& image) {
      std::error_code error;
      return fs::exists(dir_ / image.first, error) && sha256_of_file(dir_ / image.first) == image.second;
    });
    if (!intact) {
      warn(fmt::format("{}: an image of \"{}\" is missing or damaged; it is recorded again", dir_.string(),
                       record.pattern));
      continue;
    }
    done_.insert(step);
    for (const auto& [file, sum] : record.sha256) sha256_[file] = sum;
  }
  if (complete_) return;
  // Of an overwritten set, or of the step that was broken off.
  for (const std::string& file : recorded_images(dir_, twin_)) {
    std::error_code ignored;
    if (!sha256_.contains(file)) fs::remove(dir_ / file, ignored);
  }
  remove_temporary_files(dir_, twin_);
}

void Recording::store(StepRecord record, std::vector<RecordedImage> images) {
  flush();
  pending_ = std::async(std::launch::async,
                        [this, record = std::move(record), images = std::move(images)]() mutable {
                          return write_images(dir_, std::move(record), images, &journal_);
                        });
  if (at_once_) flush();
}

void Recording::flush() {
  if (!pending_.valid()) return;
  StepRecord record;
  try {
    record = pending_.get();
  } catch (const UserError& error) {  // a full disk
    throw UserError(ExitCode::device, "", error.what(), "what is recorded is kept, go on with --resume");
  }
  done_.insert(record.step);
  for (const auto& [file, sum] : record.sha256) sha256_[file] = sum;
}

void Recording::merge_brackets() {
  const std::vector<Step> steps = make_steps(twin_.fringes, plan_);
  for (const Camera& camera : twin_.cameras) {
    std::vector<std::string> names;
    std::map<double, std::string> folders;
    for (const Step& step : steps) {
      if (!step.in_sequence) continue;
      folders[*step.exposure_ms] = step.pictures.front().set;
      if (*step.exposure_ms == plan_.exposures_ms.front()) names.push_back(step.pictures.front().name);
    }
    std::vector<BracketExposure> exposures;
    for (const auto& [exposure_ms, folder] : folders)
      exposures.push_back(
          {exposure_ms, [this, &names, &camera, set = folder](std::size_t k) {
             return read_camera_gray(dir_ / Picture{set, names[k]}.file(camera.name), camera).image;
           }});
    merge_exposures(exposures, names.size(), camera.sensor.black_level_dn, camera.sensor.max_dn(),
                    [&](std::size_t k, const ImageF& image) {
                      throw_if_cancelled();
                      const std::string file = Picture{"", names[k]}.file(camera.name);
                      write_gray_png(dir_ / file, image, camera.sensor.bit_depth <= 8 ? 8 : 16);
                      sha256_[file] = sha256_of_file(dir_ / file);
                    });
  }
}

void Recording::write_set(const RecordedSet& set, std::map<std::string, std::string> provenance) const {
  const std::string folder = set.folder.empty() ? "" : set.folder + "/";
  for (const auto& [file, sum] : sha256_) {
    if (!file.starts_with(folder)) continue;
    const std::string inside = file.substr(folder.size());
    // the main set answers for dark and flat frames, too, not for the other sets
    if (set.folder.empty() && is_set_folder(inside.substr(0, inside.find('/'))) &&
        !inside.starts_with("dark/") && !inside.starts_with("flat/"))
      continue;
    provenance["sha256." + inside] = sum;
  }
  std::vector<CameraImages> cameras(twin_.cameras.size());
  std::vector<const CameraImages*> pointers;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    cameras[c].camera = twin_.cameras[c].name;
    if (set.exposure_ms) provenance["exposure_ms " + cameras[c].camera] = fmt::format("{}", *set.exposure_ms);
    if (set.references) cameras[c].white = cameras[c].black = ImageF();
    pointers.push_back(&cameras[c]);
  }
  write_capture_toml(dir_ / set.folder, pointers, provenance, "png");
}

// A power cut must not leave a capture.toml, or no journal, before the images are on the disk.
void Recording::sync() const {
  const int folder = ::open(dir_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0)
    throw UserError(ExitCode::device, dir_.string(),
                    fmt::format("cannot be opened ({})", std::strerror(errno)));
  const int error = ::syncfs(folder) == 0 ? 0 : errno;
  ::close(folder);
  if (error != 0)
    throw UserError(ExitCode::device, dir_.string(),
                    fmt::format("cannot be brought to the disk ({})", std::strerror(error)),
                    "what is recorded is kept, go on with --resume");
}

void Recording::finish(const std::map<std::string, std::string>& provenance) {
  flush();
  if (plan_.brackets()) merge_brackets();
  write_text_file(dir_ / kFramesName, frames_csv(journal_.records()));
  remove_temporary_files(dir_, twin_);
  const std::vector<RecordedSet> sets = recorded_sets(twin_.fringes, plan_);
  std::vector<std::string> others;
  for (const RecordedSet& set : sets) {
    if (set.folder.empty()) continue;
    write_set(set, provenance);
    others.push_back(set.folder);
  }
  std::map<std::string, std::string> all = provenance;
  all["plan_sha256"] = identity_digest(plan_identity(twin_, plan_));
  all[std::string("sha256.") + kFramesName] = sha256_of_file(dir_ / kFramesName);
  if (!others.empty()) all["sets"] = fmt::format("{}", fmt::join(others, " "));
  sync();
  write_set(sets.front(), all);
  sync();
  journal_.remove();
  complete_ = true;
}

}  // namespace fringetwin::capture
