// SPDX-License-Identifier: Apache-2.0
// Writes the pictures that a projector which runs by itself is to be loaded with: the values that `capture`
// shows on a display, as files.
#pragma once
#include <filesystem>

#include "twin/twin.hpp"

namespace fringetwin::capture {

inline constexpr const char* kPatternTableName = "patterns.csv";

/// Writes 000.png ... of 8 bit and of the projector's size in the order of the sequence, white and black
/// behind it where the twin needs them, and patterns.csv, which says what each is. The folder is there as a
/// whole or not at all. Returns the number of pictures.
/// Throws UserError(usage) when the folder holds something: with `overwrite`, only when some of it is not of
/// an earlier call.
std::size_t write_pattern_files(const Twin& twin, const std::filesystem::path& dir, bool overwrite);

}  // namespace fringetwin::capture
