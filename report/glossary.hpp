// SPDX-License-Identifier: Apache-2.0
// Says what the words of the pages mean: at the heads of tables when pointed at, and in a list at a page's
// end.
#pragma once
#include <string>
#include <string_view>

namespace fringetwin::report {

/// Returns the meaning of a word as tables head columns with it, as text; empty where none is written down.
std::string_view meaning_of(std::string_view word);

/// Returns the words that occur in this HTML, with their meanings, as a list that opens when clicked; empty
/// where none does.
std::string glossary_html(const std::string& page_html);

}  // namespace fringetwin::report
