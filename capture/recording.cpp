// SPDX-License-Identifier: Apache-2.0
#include "capture/recording.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

#include "capture/exposure_merge.hpp"
#include "twin/capture_set.hpp"
#include "twin/errors.hpp"
#include "twin/image_io.hpp"
#include "twin/progress.hpp"
#include "twin/sha256.hpp"

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

/// "0000.png", "white.png", "black.png": what a recording writes, and nothing of the user's.
bool is_recorded_image(const std::string& name) {
  if (name == "white.png" || name == "black.png") return true;
  return name.size() >= 8 && name.ends_with(".png") &&
         std::all_of(name.begin(), name.end() - 4, [](unsigned char c) { return std::isdigit(c) != 0; });
}

bool is_set_folder(const std::string& name) {
  return name.starts_with("repeat_") || (name.starts_with("exposure_") && name.ends_with("_ms")) ||
         name == "dark" || name == "flat";
}

std::vector<fs::path> set_folders(const fs::path& dir) {
  std::vector<fs::path> folders = {dir};
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(dir, error))
    if (entry.is_directory(error) && is_set_folder(entry.path().filename().string()))
      folders.push_back(entry.path());
  return folders;
}

/// Removes, in the cameras' folders, the files whose name `is_it`.
void remove_images(const fs::path& dir, const Twin& twin, bool (*is_it)(const std::string&)) {
  std::error_code error;
  for (const fs::path& folder : set_folders(dir))
    for (const Camera& camera : twin.cameras) {
      std::vector<fs::path> found;
      for (const auto& entry : fs::directory_iterator(folder / camera.name, error))
        if (is_it(entry.path().filename().string())) found.push_back(entry.path());
      for (const fs::path& file : found) fs::remove(file, error);
    }
}

void remove_left_overs(const fs::path& dir, const Twin& twin) {
  remove_images(dir, twin, is_temporary_name);
  std::error_code error;
  for (const fs::path& folder : set_folders(dir)) {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder, error))
      if (is_temporary_name(entry.path().filename().string())) found.push_back(entry.path());
    for (const fs::path& file : found) fs::remove(file, error);
  }
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
      text += fmt::format("{},{},{},{},{},{},{},0x{:x},{}\n", r.step, r.pattern, r.shown.at_ns,
                          r.shown.sequence, f.camera, f.sequence, f.timestamp_ns, f.flags, f.use);
  return text;
}

}  // namespace

Recording::Recording(const fs::path& dir, const Twin& twin, const CapturePlan& plan,
                     const std::map<std::string, std::string>& identity, Existing existing)
    : dir_(dir), twin_(twin), plan_(plan), identity_(identity), journal_(open(existing)) {
  for (const Camera& camera : twin.cameras)
    if (is_set_folder(camera.name))
      throw UserError(ExitCode::usage, fmt::format("camera \"{}\"", camera.name),
                      "has the name of a folder that a recording makes for itself", "name it otherwise");
  take_over_records();
}

void Recording::refuse_existing(bool has_journal) const {
  if (has_journal)
    throw UserError(ExitCode::usage, dir_.string(), "holds an unfinished recording",
                    "go on with --resume, or begin anew with --overwrite");
  if (fs::exists(dir_ / kTomlName))
    throw UserError(ExitCode::usage, dir_.string(), "holds a capture set already",
                    "choose another folder, or replace it with --overwrite");
  for (const Camera& camera : twin_.cameras) {
    const fs::path first = dir_ / camera.name / "0000.png";
    if (fs::exists(first))
      throw UserError(ExitCode::usage, first.string(), "is there already, and no journal says whose it is",
                      "choose another folder, or replace it with --overwrite");
  }
}

Journal Recording::open(Existing existing) {
  const bool has_journal = Journal::has_records(dir_), has_toml = fs::exists(dir_ / kTomlName);
  if (existing == Existing::resume && has_toml) {
    const int n_images = static_cast<int>(expand_sequence(twin_.fringes).size());
    const auto provenance = read_capture_set(dir_, n_images).provenance;
    const auto plan = provenance.find("plan_sha256");
    if (plan == provenance.end() || plan->second != identity_digest(identity_))
      throw UserError(ExitCode::usage, dir_.string(), "holds a complete set recorded otherwise",
                      "choose another folder, or replace it with --overwrite");
    complete_ = true;
    std::error_code ignored;
    fs::remove(dir_ / kJournalName, ignored);  // a kill came between the two
    return Journal::none();
  }
  if (existing == Existing::resume && has_journal) return Journal::resume(dir_, identity_);
  if (existing != Existing::overwrite) refuse_existing(has_journal);
  std::error_code error;
  fs::create_directories(dir_, error);
  if (existing == Existing::overwrite) {
    fs::remove(dir_ / kTomlName, error);  // first: what is half removed is no set
    fs::remove(dir_ / kJournalName, error);
    for (const fs::path& folder : set_folders(dir_)) fs::remove(folder / kTomlName, error);
    remove_images(dir_, twin_, is_recorded_image);
  }
  return Journal::begin(dir_, identity_);
}

void Recording::take_over_records() {
  std::map<int, const StepRecord*> latest;  // a step recorded again has two
  for (const StepRecord& record : journal_.records()) latest[record.step] = &record;
  for (const auto& [step, entry] : latest) {
    const StepRecord& record = *entry;
    const bool intact = std::all_of(record.sha256.begin(), record.sha256.end(), [&](const auto& image) {
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
  const StepRecord record = pending_.get();
  done_.insert(record.step);
  for (const auto& [file, sum] : record.sha256) sha256_[file] = sum;
}

void Recording::merge_brackets() {
  const std::vector<Step> steps = make_steps(twin_.fringes, plan_);
  for (const Camera& camera : twin_.cameras) {
    std::vector<std::string> names;
    std::map<double, std::string> folders;
    for (const Step& step : steps) {
      if (!step.exposure_ms) continue;  // dark, flat
      folders[*step.exposure_ms] = step.pictures.front().set;
      if (*step.exposure_ms == plan_.exposures_ms.front()) names.push_back(step.pictures.front().name);
    }
    std::vector<BracketExposure> exposures;
    for (const auto& [exposure_ms, folder] : folders)
      exposures.push_back({exposure_ms, [this, &names, &camera, set = folder](std::size_t k) {
                             return read_gray(dir_ / Picture{set, names[k]}.file(camera.name)).image;
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

void Recording::finish(const std::map<std::string, std::string>& provenance) {
  flush();
  if (plan_.brackets()) merge_brackets();
  write_text_file(dir_ / kFramesName, frames_csv(journal_.records()));
  remove_left_overs(dir_, twin_);
  const std::vector<RecordedSet> sets = recorded_sets(twin_.fringes, plan_);
  std::vector<std::string> others;
  for (const RecordedSet& set : sets) {
    if (set.folder.empty()) continue;
    write_set(set, provenance);
    others.push_back(set.folder);
  }
  std::map<std::string, std::string> all = provenance;
  all["plan_sha256"] = identity_digest(identity_);
  all[std::string("sha256.") + kFramesName] = sha256_of_file(dir_ / kFramesName);
  if (!others.empty()) all["sets"] = fmt::format("{}", fmt::join(others, " "));
  write_set(sets.front(), all);
  journal_.remove();
  complete_ = true;
}

}  // namespace fringetwin::capture
