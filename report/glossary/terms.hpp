// SPDX-License-Identifier: Apache-2.0
// Says what the words of the pages mean: heads and cells of tables and the verdict say it when pointed at,
// and a list at a page's end.
#pragma once
#include <span>
#include <string_view>

namespace fringetwin::report {

struct Term {
  std::string_view word, meaning;  ///< text, not HTML
};
/// Returns the words that are written down, by rising alphabet; Greek letters stand where their names do.
std::span<const Term> glossary();

/// Returns the meaning of a word as pages write it; empty where none is written down.
std::string_view meaning_of(std::string_view word);

}  // namespace fringetwin::report
