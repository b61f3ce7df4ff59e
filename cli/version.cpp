// SPDX-License-Identifier: Apache-2.0
// Says which version this is. Alone in its file: the commit changes oftener than anything else.
#include "cli/version.hpp"

#include "fringetwin_commit.h"  // made by cmake/commit.cmake

namespace fringetwin::cli {

std::string version_string() {
  const std::string commit = FRINGETWIN_COMMIT;
  return FRINGETWIN_VERSION " (" + commit + (commit.empty() ? "" : ", ") +
         FRINGETWIN_BUILD_TYPE ", g++ " __VERSION__ ")";
}

}  // namespace fringetwin::cli
