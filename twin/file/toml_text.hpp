// SPDX-License-Identifier: Apache-2.0
// Turns nodes of a parsed TOML file into words for messages and into TOML again. For toml_*.cpp only: the
// header takes toml++ along.
#pragma once
#include <toml++/toml.h>

#include <string>

#include "twin/base/errors.hpp"

namespace fringetwin {

/// Returns the document. Throws UserError(code) naming file and line for what is no TOML, or too much of it
/// (toml_bounds.hpp).
toml::table parsed_toml(const std::string& text, const std::string& file, ExitCode code);

/// Returns what a message calls the node's type: "an integer", "a table".
const char* type_name(const toml::node& node);
/// Returns a string, number, date ... without quotes.
std::string scalar_text(const toml::node& node);
/// Returns the value as TOML on one line, which reads back as the same value; whole numbers have no point.
std::string toml_text(const toml::node& node);

}  // namespace fringetwin
