// SPDX-License-Identifier: Apache-2.0
// Puts values that a command has found into a twin.toml, which is then whole under its name or as it was.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "twin/merge/toml_block.hpp"

namespace fringetwin {

/// Throws UserError(usage) where merge_into_twin() could not put values into these tables: before the work
/// whose results go there.
void check_merge_into_twin(const std::filesystem::path& file, const std::vector<TomlBlock>& blocks);

/// Rewrites the values of these keys, quoted names of files that lie in `dir`, to the files' paths from the
/// folder of `into`.
void name_files_from(const std::filesystem::path& into, const std::filesystem::path& dir,
                     const std::vector<std::string>& keys, std::vector<TomlBlock>& blocks);

/// Merges the blocks into the file (toml_merge.hpp). What comes out is written under another name, loaded as
/// a twin, and renamed. A link stays a link. Throws UserError as merge_toml() and load_twin() do, and where
/// the file cannot be written; it is as it was then. Returns how many keys have got a value.
std::size_t merge_into_twin(const std::filesystem::path& file, const std::vector<TomlBlock>& blocks);

}  // namespace fringetwin
