// SPDX-License-Identifier: Apache-2.0
// Says which version this is, for the command line and the Python module.
#pragma once
#include <string>

namespace fringetwin::cli {

/// Returns this program's version with the commit it was built from, where it was built from a checkout:
/// "0.2.0 (1a2b3c4d5e6f, Release, g++ 12.2.0)"; with "-dirty" behind the commit where files differed from it.
std::string version_string();

}  // namespace fringetwin::cli
