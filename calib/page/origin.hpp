// SPDX-License-Identifier: Apache-2.0
// Where a calibration's or a photometry's result comes from, and the block at the foot of its page that says
// so.
#pragma once
#include <map>
#include <string>
#include <vector>

namespace fringetwin::calib {

struct Origin {
  std::vector<std::string> argv;
  std::string version;
  std::map<std::string, std::string> inputs_sha256;  ///< file -> digest
};

/// Returns the foot of the page, HTML.
std::string origin_html(const Origin& origin);

}  // namespace fringetwin::calib
