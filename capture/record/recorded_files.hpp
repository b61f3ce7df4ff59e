// SPDX-License-Identifier: Apache-2.0
// Tells which files below a recording's folder are its own.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::capture {

/// Names that a recording gives to folders beside the cameras': repeat_01, exposure_2_ms, dark, flat.
bool is_set_folder(const std::string& name);
/// The folder itself and those of them that are there, dark and flat frames of an exposure included.
std::vector<std::filesystem::path> set_folders(const std::filesystem::path& dir);

/// "0000.png", "white.png", "black.png": what a recording writes, and nothing of the user's.
bool is_recorded_image(const std::string& name);
/// Files of that kind in the cameras' folders, relative to `dir`.
std::vector<std::string> recorded_images(const std::filesystem::path& dir, const Twin& twin);
/// Removes what a program that was killed left under temporary names.
void remove_temporary_files(const std::filesystem::path& dir, const Twin& twin);

}  // namespace fringetwin::capture
