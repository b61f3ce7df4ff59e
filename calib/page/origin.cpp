// SPDX-License-Identifier: Apache-2.0
#include "calib/page/origin.hpp"

#include "report/provenance.hpp"
#include "report/text.hpp"

namespace fringetwin::calib {

std::string origin_html(const Origin& origin) {
  report::Facts facts{{"command", report::shell_command(origin.argv)}, {"version", origin.version}};
  facts.insert(facts.end(), origin.inputs_sha256.begin(), origin.inputs_sha256.end());
  return report::provenance_html(facts) +
         "<p>Every formula: docs/CALIBRATION.md of the fringetwin source.</p>";
}

}  // namespace fringetwin::calib
