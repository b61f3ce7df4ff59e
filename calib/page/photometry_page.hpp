// SPDX-License-Identifier: Apache-2.0
// Turns the results of a photometric analysis into what `fringetwin photometry` writes: blocks for twin.toml,
// photometry.json, and a page.
#pragma once
#include <string>
#include <vector>

#include "calib/page/origin.hpp"
#include "calib/photometry/photometry.hpp"
#include "twin/merge/toml_block.hpp"

namespace fringetwin::calib {

/// Returns blocks for twin.toml, each number with its sigma in a comment; the text is itself valid TOML.
std::string photometry_toml(const Photometry& photometry);

/// Returns what of these blocks was measured, for a twin.toml that is there.
std::vector<TomlBlock> photometry_blocks(const Photometry& photometry);

/// Returns photometry.json, schema "fringetwin-photometry/1" (docs/CALIBRATION.md).
std::string photometry_json(const Photometry& photometry, const Origin& origin);
/// Returns the page as HTML: tables of sensor and projector, photon transfer curves, projector response,
/// contrast over pitch, harmonics.
std::string photometry_html(const Photometry& photometry, const Origin& origin);

}  // namespace fringetwin::calib
