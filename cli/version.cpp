// SPDX-License-Identifier: Apache-2.0
#include "cli/version.hpp"

namespace fringetwin::cli {

std::string version_string() {
  return FRINGETWIN_VERSION " (" FRINGETWIN_BUILD_TYPE ", g++ " __VERSION__ ")";
}

}  // namespace fringetwin::cli
