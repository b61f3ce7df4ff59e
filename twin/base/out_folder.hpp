// SPDX-License-Identifier: Apache-2.0
// Takes the folder that a run writes into (--out): refuses it before the work when it cannot be written, and
// keeps it from looking complete while it is not.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace fringetwin {

/// Throws UserError(usage) unless `dir` is a folder that can be written, or one that can be made. It makes
/// nothing: a run that fails leaves nothing behind.
void check_out_folder(const std::filesystem::path& dir);

/// Makes `dir` and removes the files (relative to it) that an earlier run wrote last, which a reader takes
/// for the sign that all the others are there. Throws UserError(usage).
void begin_output(const std::filesystem::path& dir, const std::vector<std::string>& last_files);

}  // namespace fringetwin
