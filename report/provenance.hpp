// SPDX-License-Identifier: Apache-2.0
// The block at the foot of a page that says how the page came about: facts and input files go in, HTML comes
// out.
#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace fringetwin::report {

/// Name and value (text) of what a reader needs to make the page again: its twin, its command, its version …
using Facts = std::vector<std::pair<std::string, std::string>>;

/// Returns a table of the facts in their order.
std::string provenance_html(const Facts& facts);
/// Returns the same table and, folded below it, each input file with its SHA-256.
std::string provenance_html(const Facts& facts, const std::map<std::string, std::string>& inputs_sha256);

}  // namespace fringetwin::report
