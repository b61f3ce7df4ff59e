// SPDX-License-Identifier: Apache-2.0
// Asks the libraries that read strangers' files, and those that compute, for the versions they run with:
// those of the machine, which may be newer than the ones the program was built with.
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace fringetwin::cli {

/// Returns {"OpenCV", "4.6.0"} and so on; without those that have no call for it.
std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace fringetwin::cli
