// SPDX-License-Identifier: Apache-2.0
#include "twin/captures/foreign_set.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "twin/base/errors.hpp"
#include "twin/base/parallel.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/sha256.hpp"
#include "twin/sequence_outline.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

/// Returns the innermost folder that holds all the files.
fs::path common_folder(const std::vector<fs::path>& files) {
  fs::path common = files.front().parent_path();
  for (const fs::path& file : files) {
    const fs::path folder = file.parent_path();
    const auto [end, ignored] = std::mismatch(common.begin(), common.end(), folder.begin(), folder.end());
    fs::path shared;
    for (auto part = common.begin(); part != end; ++part) shared /= *part;
    common = shared;
  }
  return common;
}

std::vector<fs::path> all_files(const CaptureCamera& camera) {
  std::vector<fs::path> files = camera.files;
  if (camera.white) files.push_back(*camera.white);
  if (camera.black) files.push_back(*camera.black);
  return files;
}

void check_not_shared(const CaptureSet& set) {
  std::map<fs::path, const CaptureCamera*> owner;
  for (const CaptureCamera& camera : set.cameras)
    for (const fs::path& file : camera.files) {
      const CaptureCamera* other = owner.try_emplace(file, &camera).first->second;
      if (other != &camera)
        throw UserError(
            ExitCode::input, file.string(),
            fmt::format(R"(is an image of both camera "{}" and camera "{}")", other->name, camera.name),
            "name each camera's own images");
    }
}

/// TOML is UTF-8; names of files may be any bytes.
void check_names(const CaptureEntry& entry) {
  std::vector<std::string> names = entry.files;
  names.push_back(entry.root);
  for (const auto& reference : {entry.white, entry.black})
    if (reference) names.push_back(*reference);
  for (const std::string& name : names)
    if (!is_utf8(name))
      throw UserError(ExitCode::input, name, "is no UTF-8, so capture.toml cannot name it",
                      "rename the file or its folder");
}

}  // namespace

void check_foreign_set(const CaptureSet& set, const Twin& twin) {
  const std::size_t n = expand_sequence(twin.fringes).size();
  for (const CaptureCamera& camera : set.cameras)
    if (camera.files.size() != n)
      throw UserError(ExitCode::input, camera.pattern,
                      fmt::format("gives {} images, the sequence has {}", camera.files.size(), n),
                      "by number: " + sequence_outline(twin.fringes));
  check_not_shared(set);
  for (const Camera& camera : twin.cameras) load_camera_images(set, camera, twin.fringes);
}

void write_foreign_set(const CaptureSet& set) {
  const fs::path dir = fs::weakly_canonical(set.file.parent_path());
  // Where links lead: "../raw" is meant as the operating system walks it.
  const auto real = [](const fs::path& file) { return fs::canonical(file.parent_path()) / file.filename(); };
  std::vector<CaptureEntry> entries;
  std::vector<fs::path> images;
  for (const CaptureCamera& camera : set.cameras) {
    std::vector<fs::path> files = all_files(camera);
    std::transform(files.begin(), files.end(), files.begin(), real);
    images.insert(images.end(), files.begin(), files.end());
    const fs::path root = common_folder(files);
    const auto name = [&](const fs::path& file) {
      return real(file).lexically_relative(root).generic_string();
    };
    CaptureEntry entry{.name = camera.name, .root = root.lexically_relative(dir).generic_string()};
    for (const fs::path& file : camera.files) entry.files.push_back(name(file));
    if (camera.white) entry.white = name(*camera.white);
    if (camera.black) entry.black = name(*camera.black);
    entry.gray_code_exposure = camera.gray_code_exposure;
    check_names(entry);
    entries.push_back(std::move(entry));
  }
  std::vector<std::string> digests(images.size());
  for_each_parallel(static_cast<int>(images.size()), [&](int i) { digests[i] = sha256_of_file(images[i]); });
  std::map<std::string, std::string> provenance = set.provenance;
  for (std::size_t i = 0; i < images.size(); ++i)
    provenance["sha256." + images[i].lexically_relative(dir).generic_string()] = digests[i];
  write_capture_toml(set.file.parent_path(), entries, provenance, set.channel);
}

}  // namespace fringetwin
