// SPDX-License-Identifier: Apache-2.0
// What `photometry` writes: the numbers of an analysis as blocks for twin.toml, as photometry.json and as a
// page.
#pragma once
#include <string>

#include "calib/page/origin.hpp"
#include "calib/photometry/photometry.hpp"

namespace fringetwin::calib {

/// Returns blocks for twin.toml, each number with its sigma in a comment; the text is itself valid TOML.
std::string photometry_toml(const Photometry& photometry);

/// Returns photometry.json, schema "fringetwin-photometry/1" (docs/CALIBRATION.md).
std::string photometry_json(const Photometry& photometry, const Origin& origin);
std::string photometry_html(const Photometry& photometry, const Origin& origin);

}  // namespace fringetwin::calib
