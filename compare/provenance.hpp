// SPDX-License-Identifier: Apache-2.0
// Where a result comes from: enough to make it again.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace fringetwin::compare {

struct Provenance {
  std::vector<std::string> argv;  ///< the command as typed
  std::string version;
  std::vector<std::filesystem::path> input_files;  ///< every file read
  std::string device;                              ///< of the renderer; empty = nothing was rendered
  std::uint64_t seed = 0;
};

/// Lower-case hex SHA-256 of a file's bytes. Throws UserError(input) when it cannot be read.
std::string sha256_of_file(const std::filesystem::path& file);

/// Path as given -> digest, each file once.
std::map<std::string, std::string> sha256_of_files(const std::vector<std::filesystem::path>& files);

}  // namespace fringetwin::compare
