// SPDX-License-Identifier: Apache-2.0
// How the path of a result and the TOML text of a setting are shown to a reader: short name, unit, value.
#pragma once
#include <string>

namespace fringetwin::study {

/// Returns the text of a TOML string without its quotes, any other value as it is.
std::string plain_value(const std::string& toml);
/// Returns "ball radius_mm" for "fits.ball.measured.radius_mm", any other name as it is.
std::string display_name(const std::string& path);
/// Returns "mm" for "fits.ball.measured.center_mm[2]"; an empty string when the name does not say the unit.
std::string unit_of(const std::string& path);

}  // namespace fringetwin::study
