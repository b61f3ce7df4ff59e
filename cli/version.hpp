// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace fringetwin::cli {

/// "0.1.0 (Release, g++ 12.2.0)"
std::string version_string();

}  // namespace fringetwin::cli
