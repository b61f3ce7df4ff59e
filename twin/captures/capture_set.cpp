// SPDX-License-Identifier: Apache-2.0
// capture.toml, read and written. The images themselves: capture_images.cpp.
#include "twin/captures/capture_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/seal.hpp"
#include "twin/captures/numbered_name.hpp"
#include "twin/file/toml_reader.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

constexpr const char* kCaptureSchema = "fringetwin-captures/1";
constexpr std::size_t kMostCameras = 16;  // a twin has two; each may name 10,000 images

NumberedName parse_pattern(const TomlTable& table, const std::string& pattern) {
  const auto name = parse_numbered_name(pattern);
  if (!name)
    table.fail("pattern",
               fmt::format("must have one number such as %04d, and no \"..\" behind it, is \"{}\"", pattern),
               "or list the images: files = [...]");
  return *name;
}

/// Images on disk that the pattern names: the longest run of numbers from 0, without the white and
/// black reference images.
std::vector<fs::path> files_on_disk(const NumberedName& name, const fs::path& root,
                                    const CaptureCamera& camera) {
  std::vector<fs::path> files;
  std::error_code error;
  for (std::size_t number = 0; number <= kLongestSequence; ++number) {
    throw_if_cancelled();
    const fs::path file = tidy_path(root / name(static_cast<int>(number)));
    if (file == camera.white || file == camera.black) continue;
    if (!fs::exists(file, error)) break;
    files.push_back(file);
  }
  return files;
}

std::optional<double> read_gray_code_exposure(const TomlTable& table) {
  static const std::string key = "gray_code_exposure";
  if (table.is_string(key)) {
    table.choice(key, {"different"});
    return kNaN;
  }
  const std::optional<double> value = table.number(key, NumberRange::positive());
  return value == 1.0 ? std::nullopt : value;
}

void read_file_names(const TomlTable& table, const fs::path& root, const std::optional<int>& n_images,
                     CaptureCamera* camera) {
  if (table.has("pattern") == table.has("files"))
    table.fail(table.has("files") ? "files" : "",
               table.has("files") ? "and pattern exclude each other" : "needs pattern or files",
               "give one: pattern = \"left/%04d.png\" or files = [...]");
  if (const auto files = table.strings("files")) {
    if (files->size() > kLongestSequence)
      table.fail("files",
                 fmt::format("lists {} images, a sequence has at most {}", files->size(), kLongestSequence));
    for (const std::string& file : *files) camera->files.push_back(tidy_path(root / file));
    return;
  }
  const NumberedName name = parse_pattern(table, table.required_string("pattern"));
  camera->pattern = tidy_path(root / table.required_string("pattern")).string();
  std::vector<fs::path> on_disk = files_on_disk(name, root, *camera);
  camera->images_on_disk = static_cast<int>(on_disk.size());
  if (on_disk.size() > kLongestSequence && !n_images)
    table.fail("pattern", fmt::format("finds more than {} images, the most of a sequence", kLongestSequence));
  if (!n_images) camera->files = std::move(on_disk);
  for (int number = 0; number < n_images.value_or(0); ++number)
    camera->files.push_back(tidy_path(root / name(number)));
}

CaptureCamera read_camera(const TomlTable& table, const fs::path& folder,
                          const std::optional<int>& n_images) {
  table.allow({"name", "pattern", "files", "root", "white", "black", "gray_code_exposure"});
  CaptureCamera camera;
  camera.name = table.required_string("name");
  const fs::path root =
      resolve_path(table.string("root").value_or("."), folder, table.where("root"), ExitCode::input);
  if (table.has("white")) camera.white = tidy_path(root / table.required_string("white"));
  if (table.has("black")) camera.black = tidy_path(root / table.required_string("black"));
  camera.gray_code_exposure = read_gray_code_exposure(table);
  read_file_names(table, root, n_images, &camera);
  return camera;
}

}  // namespace

const CaptureCamera* CaptureSet::find(const std::string& camera) const {
  const auto it = std::ranges::find(cameras, camera, &CaptureCamera::name);
  return it == cameras.end() ? nullptr : &*it;
}

CaptureSet read_capture_set(const fs::path& dir, std::optional<int> n_images) {
  FT_CHECK(!n_images || *n_images > 0, fmt::format("a sequence of {} images", *n_images));
  std::error_code error;
  if (!fs::is_directory(dir, error))
    throw UserError(ExitCode::input, dir.string(), "no such folder",
                    "a capture set is a folder with a capture.toml");
  CaptureSet set;
  set.file = dir / "capture.toml";
  const TomlTable root = TomlTable::parse_file(set.file, ExitCode::input);
  const std::vector<std::string> keys = {"schema", "channel", "camera", "provenance"};
  if (!root.has("schema")) root.allow(keys);  // a misspelt "schema" is named as such
  if (root.required_string("schema") != kCaptureSchema)
    root.fail("schema",
              fmt::format("must be \"{}\", is \"{}\"", kCaptureSchema, root.required_string("schema")));
  root.allow(keys);
  set.channel = colour_channel_of(root.choice("channel", kColourChannelNames));
  std::set<std::string> names;
  const std::vector<TomlTable> tables = root.tables("camera");
  if (tables.size() > kMostCameras)
    root.fail("camera", fmt::format("is given {} times, at most {} are read", tables.size(), kMostCameras));
  for (const TomlTable& table : tables) {
    set.cameras.push_back(read_camera(table, fs::absolute(dir), n_images));
    if (!names.insert(set.cameras.back().name).second)
      table.fail("name",
                 fmt::format("\"{}\" is the name of an earlier camera, too", set.cameras.back().name));
  }
  if (set.cameras.empty()) root.fail("camera", "is missing", "a capture set needs a [[camera]]");
  if (const auto provenance = root.table("provenance")) set.provenance = provenance->flattened();
  return set;
}

std::vector<fs::path> files_of(const CaptureSet& set) {
  std::vector<fs::path> files{set.file};
  for (const CaptureCamera& camera : set.cameras) {
    files.insert(files.end(), camera.files.begin(), camera.files.end());
    if (camera.white) files.push_back(*camera.white);
    if (camera.black) files.push_back(*camera.black);
  }
  return files;
}

void write_capture_toml(const fs::path& dir, const std::vector<CaptureEntry>& cameras,
                        const std::map<std::string, std::string>& provenance,
                        const std::optional<ColourChannel>& channel) {
  std::string text = fmt::format("schema = \"{}\"\n", kCaptureSchema);
  if (channel) text += fmt::format("channel = {}\n", toml_string(colour_channel_name(*channel)));
  for (const CaptureEntry& camera : cameras) {
    FT_CHECK(camera.pattern.empty() != camera.files.empty(), "a pattern or files");
    text += fmt::format("\n[[camera]]\nname = {}\n", toml_string(camera.name));
    if (!camera.pattern.empty()) text += fmt::format("pattern = {}\n", toml_string(camera.pattern));
    if (!camera.files.empty()) {
      text += "files = [\n";
      for (const std::string& file : camera.files) text += fmt::format("  {},\n", toml_string(file));
      text += "]\n";
    }
    text += fmt::format("root = {}\n", toml_string(camera.root));
    if (camera.white) text += fmt::format("white = {}\n", toml_string(*camera.white));
    if (camera.black) text += fmt::format("black = {}\n", toml_string(*camera.black));
    if (const auto exposure = camera.gray_code_exposure)
      text += std::isnan(*exposure) ? "gray_code_exposure = \"different\"\n"
                                    : fmt::format("gray_code_exposure = {}\n", *exposure);
  }
  text += "\n[provenance]\n";
  for (const auto& [key, value] : provenance)
    text += fmt::format("{} = {}\n", toml_string(key), toml_string(value));
  write_text_file(dir / "capture.toml", seal(text));
}

void write_capture_toml(const fs::path& dir, const std::vector<const CameraImages*>& cameras,
                        const std::map<std::string, std::string>& provenance, const std::string& extension,
                        const std::string& root) {
  FT_CHECK(extension == "png" || extension == "exr", "extension " + extension);
  std::vector<CaptureEntry> entries;
  for (const CameraImages* camera : cameras) {
    const auto file = [&](const char* name) {
      return fmt::format("{}/{}.{}", camera->camera, name, extension);
    };
    CaptureEntry entry{.name = camera->camera, .pattern = file("%04d"), .root = root};
    if (camera->white) entry.white = file("white");
    if (camera->black) entry.black = file("black");
    entry.gray_code_exposure = camera->gray_code_exposure;
    entries.push_back(std::move(entry));
  }
  write_capture_toml(dir, entries, provenance);
}

}  // namespace fringetwin
