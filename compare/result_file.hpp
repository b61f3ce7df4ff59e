// SPDX-License-Identifier: Apache-2.0
// Finds and reads a result.json that cosim, compare or measure wrote.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>

namespace fringetwin::compare {

/// The file of a result, and its content.
struct ResultFile {
  std::filesystem::path file;
  nlohmann::json json;
};

/// Reads a result.json, or that of the folder of a run. Throws UserError(input) for a missing file, broken
/// JSON or another schema.
ResultFile read_result_file(const std::filesystem::path& path);

}  // namespace fringetwin::compare
