// SPDX-License-Identifier: Apache-2.0
// Paths as the user means them, and the names that become part of file names.
#pragma once
#include <filesystem>
#include <string>

namespace fringetwin {

/// Absolute. Without ".." only "." and doubled slashes go, and links stay as written; with ".." as the
/// operating system walks it: the parent of a linked folder is the parent of what the link points to.
std::filesystem::path tidy_path(const std::filesystem::path& path);

/// Empty, or why `name` (of a camera or an object) cannot become part of a file name: letters, digits,
/// _ - . and space, at most 100 of them, not starting with a dot, no space at either end.
std::string name_fault(const std::string& name);
/// The hint beside it.
inline constexpr const char* kNameHint = "use letters, digits, _ - . and space, not starting with a dot";

}  // namespace fringetwin
