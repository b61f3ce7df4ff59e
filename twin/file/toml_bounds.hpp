// SPDX-License-Identifier: Apache-2.0
// Says in one pass over a TOML text whether it is too deep or too full to be parsed: the library walks tables
// by recursion and takes a hundred times the memory of what it reads.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace fringetwin {

/// The deepest path of our files has 6 parts (fringes.x.gray.bits, keys of settings), the deepest value is an
/// array of arrays. Both bounds together keep recursion below some 1000 calls; --limits does not raise them.
inline constexpr std::size_t kMostKeyParts = 32, kDeepestValue = 32;

/// Marks between keys and values. The largest file we know, a capture set of 10,000 images with checksums,
/// has 60,000; a million takes the library less than 400 MB. Raised by --limits.
inline constexpr std::size_t kMostTomlMarks = 1'000'000;

/// Headers, and dots in keys and headers: for each the library looks through a list of the tables that it has
/// made so far, so that the time goes with the square. A twin of 1000 objects has 3000; so many take the
/// library less than a second. Raised by --limits.
inline constexpr std::size_t kMostTomlTables = 50'000;

struct TomlExcess {
  std::size_t line = 0;  ///< from 1
  std::string what, hint;
};

/// Returns what is too much in the text, and where; nothing where it may be parsed. A text that is no TOML is
/// judged up to its first fault, which the library finds.
std::optional<TomlExcess> toml_excess(std::string_view text);

}  // namespace fringetwin
