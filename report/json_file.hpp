// SPDX-License-Identifier: Apache-2.0
// Reads a JSON file that someone else may have written.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>

#include "twin/base/safe_file.hpp"

namespace fringetwin::report {

/// Returns the content of the file, keys in alphabetical order (looking one up takes no walk along all of
/// them). Throws UserError(use.code) where the file cannot be read, is no JSON, stands deeper in itself or
/// has more values than any file of ours (docs/FORMATS.md, "Limits"), or holds a number that is none (1e999).
nlohmann::json read_json_file(const std::filesystem::path& file, const FileUse& use);

}  // namespace fringetwin::report
