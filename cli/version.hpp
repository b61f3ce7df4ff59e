// SPDX-License-Identifier: Apache-2.0
// Says which program this is, for --version and for every result.
#pragma once
#include <string>

namespace fringetwin::cli {

/// Returns e.g. "0.1.0 (Release, g++ 12.2.0)"
std::string version_string();

}  // namespace fringetwin::cli
