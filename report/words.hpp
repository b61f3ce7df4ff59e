// SPDX-License-Identifier: Apache-2.0
// Marks words of the glossary in what a page says, so that each says what it means when pointed at.
#pragma once
#include <string>

namespace fringetwin::report {

/// Returns a text as HTML; where it is a word of the glossary, it says its meaning when pointed at.
std::string word_html(const std::string& text);

/// Returns a text as HTML, in which every part between commas, colons and semicolons that is a word of the
/// glossary says its meaning when pointed at: "phase: not explained; no limits set". A single Latin letter
/// may be a coordinate and stays as it is.
std::string words_html(const std::string& text);

}  // namespace fringetwin::report
