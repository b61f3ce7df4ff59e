// SPDX-License-Identifier: Apache-2.0
#include "capture/record/verify_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "capture/record/journal.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/parallel.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/base/seal.hpp"
#include "twin/base/sha256.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/captures/numbered_name.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::capture {
namespace fs = std::filesystem;
namespace {

constexpr const char* kChecksumPrefix = "sha256.";
constexpr std::size_t kMostSubSets = 1000;  // a folder per repeat, exposure and kind of frame
constexpr const char* kMend = "; restore it from a copy, or record the set again";

std::string text_of(const ImageKind& kind) {
  return fmt::format("{} x {} px, {} bit", kind.width, kind.height, kind.bits);
}

struct Image {
  std::size_t camera = 0;
  fs::path file;
  ImageKind shape;  ///< the same for all images of a camera
  bool decoded = false, compared = false;
  std::string finding;
};

/// One folder with a capture.toml.
class Verifier {
 public:
  Verifier(const fs::path& dir, SetCheck* out)
      : dir_(dir), whole_(tidy_path(dir / "capture.toml").parent_path()), out_(*out) {}

  /// False when there is no capture.toml that can be read.
  bool open();
  void check_images(std::map<std::string, ImageKind>* shapes);
  void check_other_files();
  void find_numbers_beyond();
  void find_strangers();
  void check_against(const Twin& twin);
  std::vector<fs::path> sub_sets();
  std::size_t cameras() const { return set_.cameras.size(); }

 private:
  void find(const std::string& sentence) { out_.findings.push_back(sentence); }
  /// Returns the file's path as the user named the folder.
  fs::path shown(const fs::path& file) const;
  void check_toml();
  int number_of_images() const;
  std::set<fs::path> own_folders() const;
  void name_images();
  void check_image(Image& image) const;
  void report_images(std::size_t camera);
  void check_shapes(std::size_t camera, std::map<std::string, ImageKind>* shapes);

  fs::path dir_, whole_;
  SetCheck& out_;
  CaptureSet set_;
  std::map<fs::path, std::string> checksums_;
  std::vector<Image> images_;
  std::set<fs::path> named_;
  std::set<std::string> faulty_cameras_;
};

fs::path Verifier::shown(const fs::path& file) const {
  const fs::path relative = file.lexically_relative(whole_);
  return relative.empty() || *relative.begin() == ".." ? file : dir_ / relative;
}

bool Verifier::open() {
  ++out_.sets;
  std::error_code error;
  const bool journal = fs::exists(dir_ / kJournalName, error);
  if (!fs::exists(dir_ / "capture.toml", error)) {
    out_.unfinished = out_.unfinished || journal;
    find(journal
             ? fmt::format("{}: the recording has not ended (there is a {}); run the same command with "
                           "--resume",
                           dir_.string(), kJournalName)
             : fmt::format("{}: has no capture.toml, so it is no capture set; check the name, or record it",
                           dir_.string()));
    return false;
  }
  if (journal) {
    out_.unfinished = true;
    find(
        fmt::format("{}: says that the recording has not ended, though capture.toml is there; run the same "
                    "command with --resume",
                    (dir_ / kJournalName).string()));
  }
  try {
    set_ = read_capture_set(dir_, 1);
    for (const auto& [key, value] : set_.provenance)
      if (key.starts_with(kChecksumPrefix))
        checksums_[tidy_path(whole_ / key.substr(std::string(kChecksumPrefix).size()))] = value;
    set_ = read_capture_set(dir_, number_of_images());
  } catch (const UserError& fault) {
    check_toml();
    find(fault.what());
    return false;
  }
  check_toml();
  if (checksums_.empty()) out_.sets_without_checksums.push_back(dir_.string());
  name_images();
  return true;
}

/// Checksums are believed only in a capture.toml that is as it was written.
void Verifier::check_toml() {
  const fs::path file = dir_ / "capture.toml";
  std::string text;
  try {
    text = read_whole_text(file, {});
  } catch (const UserError&) {
    return;  // what reads the set has said so
  }
  const Seal state = check_seal(text);
  if (state == Seal::intact || (state == Seal::none && checksums_.empty())) return;
  find(fmt::format("{}: {}; restore it from a copy, or, if the change is yours, make \"{}\" its first line",
                   file.string(),
                   state == Seal::broken ? "was changed after it was written" : "has lost its first line",
                   right_seal(text)));
}

/// Returns how many images a `pattern` names: by the checksums, without these by what is on disk, up to the
/// first gap. What lies beyond a gap is found as superfluous.
int Verifier::number_of_images() const {
  int n = 1;
  for (const CaptureCamera& camera : set_.cameras) {
    if (camera.pattern.empty()) continue;
    const auto name = parse_numbered_name(camera.pattern);
    int here = 0;
    for (int number = 0; name; ++number) {
      const fs::path file = tidy_path((*name)(number));
      if (file == camera.white || file == camera.black) continue;
      if (!checksums_.contains(file)) break;
      ++here;
    }
    n = std::max(n, checksums_.empty() || !name ? *camera.images_on_disk : here);
  }
  return std::min(n, static_cast<int>(kLongestSequence));
}

void Verifier::name_images() {
  for (std::size_t c = 0; c < set_.cameras.size(); ++c) {
    const CaptureCamera& camera = set_.cameras[c];
    for (const fs::path& file : camera.files) images_.push_back({c, file, {}, false, false, ""});
    for (const auto& reference : {camera.white, camera.black})
      if (reference) images_.push_back({c, *reference, {}, false, false, ""});
  }
  for (const Image& image : images_) named_.insert(image.file);
}

/// Decodes and compares; missing files are reported together.
void Verifier::check_image(Image& image) const {
  const fs::path file = shown(image.file);
  std::error_code error;
  if (!fs::exists(file, error)) return;
  try {
    image.shape = is_exr_name(file) ? check_exr(file) : check_gray(file, set_.channel);
    image.decoded = true;
    if (checksums_.empty()) return;
    const auto expected = checksums_.find(image.file);
    if (expected == checksums_.end()) {
      image.finding = file.string() + ": has no checksum in [provenance.sha256], as the others have" + kMend;
      return;
    }
    image.compared = true;
    if (sha256_of_file(file) != expected->second)
      image.finding = file.string() + ": is not the image that was recorded (its SHA-256 differs)" + kMend;
  } catch (const UserError& fault) {
    image.finding = fault.what();
    if (image.finding.find("; ") == std::string::npos) image.finding += kMend;
  }
}

void Verifier::check_images(std::map<std::string, ImageKind>* shapes) {
  for_each_parallel(static_cast<int>(images_.size()), [&](int i) { check_image(images_[i]); });
  for (const Image& image : images_) {
    out_.images += image.decoded;
    out_.checksums += image.compared;
  }
  for (std::size_t c = 0; c < set_.cameras.size(); ++c) {
    const std::size_t before = out_.findings.size();
    report_images(c);
    check_shapes(c, shapes);
    if (out_.findings.size() > before) faulty_cameras_.insert(set_.cameras[c].name);
  }
  const CaptureCamera& first = set_.cameras.front();
  for (const CaptureCamera& camera : set_.cameras)
    if (camera.files.size() != first.files.size())
      find(fmt::format(R"({}: camera "{}" has {} images, camera "{}" {}; both record the same sequence)",
                       (dir_ / "capture.toml").string(), camera.name, camera.files.size(), first.name,
                       first.files.size()));
}

void Verifier::report_images(std::size_t camera) {
  int missing = 0, all = 0;
  const Image* first = nullptr;
  for (const Image& image : images_) {
    if (image.camera != camera) continue;
    ++all;
    if (!image.finding.empty()) find(image.finding);
    if (image.decoded || !image.finding.empty()) continue;
    if (missing++ == 0) first = &image;
  }
  if (missing > 0)
    find(fmt::format(R"({}: no such image{}{})", shown(first->file).string(),
                     missing == 1 ? ""
                                  : fmt::format(R"(; {} of the {} images of camera "{}" are missing)",
                                                missing, all, set_.cameras[camera].name),
                     kMend));
}

/// Reports images of another shape: that of most images of the camera is taken for right; a sub-set must
/// agree with the set.
void Verifier::check_shapes(std::size_t camera, std::map<std::string, ImageKind>* shapes) {
  std::map<ImageKind, int> votes;
  for (const Image& image : images_)
    if (image.camera == camera && image.decoded) ++votes[image.shape];
  if (votes.empty()) return;
  const auto most =
      std::ranges::max_element(votes, [](const auto& a, const auto& b) { return a.second < b.second; });
  const std::string& name = set_.cameras[camera].name;
  const ImageKind right = shapes->try_emplace(name, most->first).first->second;
  for (const Image& image : images_)
    if (image.camera == camera && image.decoded && image.shape != right)
      find(fmt::format(R"({}: is {}, the others of camera "{}" are {}{})", shown(image.file).string(),
                       text_of(image.shape), name, text_of(right), kMend));
}

/// Checksums of files that are no images, e.g. the list of all frames.
void Verifier::check_other_files() {
  for (const auto& [file, digest] : checksums_) {
    if (named_.contains(file)) continue;
    const fs::path name = shown(file);
    std::error_code error;
    if (!fs::exists(name, error)) {
      find(name.string() + ": is missing, though capture.toml has its checksum" + kMend);
      continue;
    }
    try {
      ++out_.checksums;
      if (sha256_of_file(name) != digest)
        find(name.string() + ": is not the file that was recorded (its SHA-256 differs)" + kMend);
    } catch (const UserError& fault) {
      find(fault.what());
    }
  }
}

/// Beside the images of a pattern: a number that it would name.
void Verifier::find_numbers_beyond() {
  for (const CaptureCamera& camera : set_.cameras) {
    if (camera.pattern.empty()) continue;
    const fs::path pattern = camera.pattern;
    const auto name = parse_numbered_name(pattern.filename().string());
    std::error_code error;
    if (!name) continue;
    for (const auto& entry : fs::directory_iterator(pattern.parent_path(), error)) {
      const fs::path& file = entry.path();
      if (!name->number_of(file.filename().string()) || !named_.insert(file).second) continue;
      find(fmt::format(
          "{}: is no image of this set, which ends at number {}; move it elsewhere, or restore what "
          "is missing before it",
          shown(file).string(), camera.files.size() - 1));
      faulty_cameras_.insert(camera.name);
    }
  }
}

/// The folders of the set's own files; what a foreign set describes lies where it lies.
std::set<fs::path> Verifier::own_folders() const {
  std::set<fs::path> folders{whole_};
  const auto add = [&](const fs::path& file) {
    const fs::path relative = file.lexically_relative(whole_);
    if (!relative.empty() && *relative.begin() != "..") folders.insert(file.parent_path());
  };
  for (const Image& image : images_) add(image.file);
  for (const auto& [file, digest] : checksums_) add(file);
  return folders;
}

/// Reports strange files in the set's own folders: leftovers of a write, and with checksums any image they do
/// not list.
void Verifier::find_strangers() {
  const bool recorded =
      !checksums_.empty() &&
      std::ranges::any_of(set_.cameras, [](const CaptureCamera& camera) { return !camera.pattern.empty(); });
  for (const fs::path& folder : own_folders()) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      const fs::path& file = entry.path();
      if (is_temporary_name(file.filename().string()))
        find(
            fmt::format("{}: is left over from a write that was broken off; delete it, or run the same "
                        "command with --resume",
                        shown(file).string()));
      else if (recorded && file.extension() == ".png" && !named_.contains(file) && !checksums_.contains(file))
        find(fmt::format("{}: is no image of this set; move it elsewhere", shown(file).string()));
    }
  }
}

/// Count, size and bit depth as `measure` will ask for them; of cameras without another finding.
void Verifier::check_against(const Twin& twin) {
  const int n = static_cast<int>(expand_sequence(twin.fringes).size());
  for (const Camera& camera : twin.cameras) {
    if (faulty_cameras_.contains(camera.name)) continue;
    try {
      load_camera_images(read_capture_set(dir_, n), camera, twin.fringes);
    } catch (const UserError& fault) {
      find(fault.what());
    }
  }
}

/// The main set names them all, also those two folders deep.
std::vector<fs::path> Verifier::sub_sets() {
  std::vector<fs::path> folders;
  const auto named = set_.provenance.find("sets");
  if (named == set_.provenance.end()) return folders;
  std::istringstream words(named->second);
  std::set<fs::path> known;
  for (std::string word; words >> word;) {
    const fs::path folder = fs::path(word).lexically_normal();
    if (!known.insert(folder).second) continue;
    if (known.size() > kMostSubSets) {
      find(fmt::format("{}: `sets` names more than {} sub-folders; mend the file",
                       (dir_ / "capture.toml").string(), kMostSubSets));
      break;
    }
    if (folder.is_absolute() || folder == "." || *folder.begin() == "..")
      find(fmt::format("{}: `sets` names {}, which is no sub-folder; mend the file",
                       (dir_ / "capture.toml").string(), word));
    else
      folders.push_back(dir_ / folder);
  }
  return folders;
}

}  // namespace

SetCheck verify_set(const fs::path& dir, const Twin* twin) {
  std::error_code error;
  if (!fs::is_directory(dir, error))
    throw UserError(ExitCode::input, dir.string(), "no such folder",
                    "a capture set is a folder with a capture.toml");
  SetCheck check;
  std::map<std::string, ImageKind> shapes;
  const auto check_files = [&](Verifier& verifier) {
    verifier.check_images(&shapes);
    verifier.check_other_files();
    verifier.find_numbers_beyond();
    verifier.find_strangers();
  };
  Verifier main(dir, &check);
  if (!main.open()) return check;
  check.cameras = static_cast<int>(main.cameras());
  check_files(main);
  if (twin != nullptr) main.check_against(*twin);
  for (const fs::path& folder : main.sub_sets()) {
    Verifier part(folder, &check);
    if (part.open()) check_files(part);
  }
  return check;
}

std::string SetCheck::summary() const {
  std::string text = fmt::format("{} image{} of {} camera{}", images, images == 1 ? "" : "s", cameras,
                                 cameras == 1 ? "" : "s");
  if (sets > 1) text += fmt::format(" in {} sets", sets);
  text += fmt::format(", {} checksum{} compared", checksums, checksums == 1 ? "" : "s");
  if (!findings.empty())
    return text + fmt::format(": {}{} finding{}", unfinished ? "not finished, " : "", findings.size(),
                              findings.size() == 1 ? "" : "s");
  if (sets_without_checksums.empty()) return text + ": complete";
  return text + fmt::format(": every image decodes, but {} no checksums",
                            sets == 1 ? std::string("the set has")
                                      : fmt::format("{} of the sets have", sets_without_checksums.size()));
}

}  // namespace fringetwin::capture
