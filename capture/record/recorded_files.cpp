// SPDX-License-Identifier: Apache-2.0
#include "capture/record/recorded_files.hpp"

#include <algorithm>
#include <cctype>

#include "twin/image/image_io.hpp"

namespace fringetwin::capture {
namespace fs = std::filesystem;
namespace {

std::vector<fs::path> entries(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) found.push_back(entry.path());
  return found;
}

void add_set_folders(const fs::path& folder, std::vector<fs::path>* folders) {
  folders->push_back(folder);
  std::error_code error;
  for (const fs::path& entry : entries(folder))
    if (is_set_folder(entry.filename().string()) && fs::is_directory(entry, error))
      add_set_folders(entry, folders);
}

}  // namespace

bool is_set_folder(const std::string& name) {
  return name.starts_with("repeat_") || (name.starts_with("exposure_") && name.ends_with("_ms")) ||
         name == "dark" || name == "flat";
}

std::vector<fs::path> set_folders(const fs::path& dir) {
  std::vector<fs::path> folders;
  add_set_folders(dir, &folders);
  return folders;
}

bool is_recorded_image(const std::string& name) {
  if (name == "white.png" || name == "black.png") return true;
  return name.size() >= 8 && name.ends_with(".png") &&
         std::all_of(name.begin(), name.end() - 4, [](unsigned char c) { return std::isdigit(c) != 0; });
}

std::vector<std::string> recorded_images(const fs::path& dir, const Twin& twin) {
  std::vector<std::string> found;
  for (const fs::path& folder : set_folders(dir))
    for (const Camera& camera : twin.cameras)
      for (const fs::path& file : entries(folder / camera.name))
        if (is_recorded_image(file.filename().string()))
          found.push_back(file.lexically_relative(dir).generic_string());
  return found;
}

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

}  // namespace fringetwin::capture
