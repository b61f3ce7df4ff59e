// SPDX-License-Identifier: Apache-2.0
// Makes paths absolute as the user means them, and checks names that become part of file names.
#pragma once
#include <filesystem>
#include <string>

namespace fringetwin {

/// Returns the path made absolute. Without ".." only "." and doubled slashes go, and links stay as written;
/// with ".." as the operating system walks it: the parent of a linked folder is the parent of what the link
/// points to. Throws UserError(usage) for a path that is no UTF-8: it becomes part of results.
std::filesystem::path tidy_path(const std::filesystem::path& path);

/// Returns the text with its ASCII letters in lower case.
std::string lower_case(std::string text);

/// Returns the file's extension with its dot, in lower case: ".png".
std::string lower_extension(const std::filesystem::path& file);

/// Returns an empty text, or why `name` (of a camera or an object) cannot become part of a file name:
/// letters, digits, _ - . and space, at most 100 of them, not starting with a dot, no space at either end.
std::string name_fault(const std::string& name);
/// The hint that an error message gives beside it.
inline constexpr const char* kNameHint = "use letters, digits, _ - . and space, not starting with a dot";

}  // namespace fringetwin
