// SPDX-License-Identifier: Apache-2.0
// Puts values into the text of a twin.toml that someone has written: each value in its place, and every other
// byte of the file as it was.
#pragma once
#include <string>
#include <vector>

#include "twin/merge/toml_block.hpp"

namespace fringetwin {

/// Returns the text with the values of the blocks: a value that is there is replaced, a key that is missing
/// gets a line at the end of its table, a table that is missing stands behind its parent. Lines that an
/// exclusion names become comments. A block without keys only asks whether its table can be found. Throws
/// UserError(usage), which names `file`: for a text that is no TOML, for a table that is not there or not
/// told from another one, and for one that is written in a way that has no place for a value.
std::string merge_toml(const std::string& text, const std::vector<TomlBlock>& blocks,
                       const std::string& file);

}  // namespace fringetwin
