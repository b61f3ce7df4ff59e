// SPDX-License-Identifier: Apache-2.0
// Makes text of strangers (names of files, words of a file, messages of libraries) harmless to show: nothing
// in it steers a terminal, gnuplot, a page or a file of lines.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace fringetwin {

/// Returns the text as one line of well-formed UTF-8. Line breaks and tabs become a space; every other
/// control character (ESC and NUL among them), every byte that is no UTF-8, and the marks that turn the
/// direction of writing become a question mark. Quotes and backslashes stay: quoting is for the one who
/// writes the format.
std::string plain_text(std::string_view text);

/// Returns plain_text() of each line; the line breaks stay.
std::string plain_lines(std::string_view text);

/// Returns whether the text is well-formed UTF-8.
bool is_utf8(std::string_view text);

/// Returns a word of a file in quotes for a sentence: its first 40 bytes, and "..." where there are more.
std::string quoted_excerpt(std::string_view word);

/// Returns a text as a string of TOML, in its quotes.
std::string toml_string(std::string_view text);

/// A sentence on the console, with what the program puts before it, has at most so many bytes.
inline constexpr std::size_t kLongestSentence = 500;

/// Returns plain_text() of a sentence, cut to `most` bytes where it is longer: long words (paths) keep their
/// begin and their end, and if that is not enough the sentence does. "..." stands for what is left out.
std::string plain_sentence(std::string_view text, std::size_t most = kLongestSentence);

}  // namespace fringetwin
