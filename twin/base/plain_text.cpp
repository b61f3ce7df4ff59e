// SPDX-License-Identifier: Apache-2.0
#include "twin/base/plain_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

namespace fringetwin {
namespace {

constexpr std::string_view kGap = "...";
constexpr std::size_t kLongestWord =
    200;                                  // of a sentence that is too long; file names have 255 bytes at most
constexpr std::size_t kBeginOfWord = 50;  // its end says more: the file's own name

bool continues(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

/// Returns the length of the well-formed character at the text's begin (RFC 3629) and its number; 0 where
/// there is none.
std::size_t first_character(std::string_view text, std::uint32_t* number) {
  const auto lead = static_cast<unsigned char>(text[0]);
  *number = lead;
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < length) return 0;
  *number = lead & (0xffu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if (!continues(text[i])) return 0;
    *number = *number << 6 | (static_cast<unsigned char>(text[i]) & 0x3fu);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = *number >= 0xd800 && *number <= 0xdfff;
  return *number < kLeast[length] || *number > 0x10ffff || surrogate ? 0 : length;
}

bool breaks_line(std::uint32_t c) {
  return (c >= '\t' && c <= '\r') || c == 0x85 || c == 0x2028 || c == 0x2029;
}

/// Control characters (C0, DEL, C1) and marks of direction, which show a text in another order than it has.
bool steers(std::uint32_t c) {
  return c < 0x20 || (c >= 0x7f && c <= 0x9f) || c == 0x061c || c == 0x200e || c == 0x200f ||
         (c >= 0x202a && c <= 0x202e) || (c >= 0x2066 && c <= 0x2069);
}

/// Returns the text with its middle left out, `most` bytes at most, of which up to `begin` stand before the
/// gap. Characters stay whole.
std::string without_middle(std::string_view text, std::size_t begin, std::size_t most) {
  std::size_t rest = text.size() - (most - begin - kGap.size());
  while (begin > 0 && continues(text[begin])) --begin;
  while (rest < text.size() && continues(text[rest])) ++rest;
  return std::string(text.substr(0, begin)).append(kGap).append(text.substr(rest));
}

std::string with_short_words(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string_view word = text.substr(at, end - at);
    out += word.size() > kLongestWord ? without_middle(word, kBeginOfWord, kLongestWord) : std::string(word);
    if (end < text.size()) out += ' ';
    at = end + 1;
  }
  return out;
}

}  // namespace

std::string plain_text(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    std::uint32_t c = 0;
    const std::size_t length = first_character(text, &c);
    if (length > 0 && breaks_line(c))
      out += ' ';
    else if (length == 0 || steers(c))
      out += '?';
    else
      out += text.substr(0, length);
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

std::string plain_lines(std::string_view text) {
  std::string out;
  for (std::size_t end; (end = text.find('\n')) != std::string_view::npos; text.remove_prefix(end + 1))
    out += plain_text(text.substr(0, end)) + '\n';
  return out + plain_text(text);
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    std::uint32_t c = 0;
    const std::size_t length = first_character(text, &c);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

std::string quoted_excerpt(std::string_view word) {
  constexpr std::size_t kShown = 40;
  std::string quoted = "\"";
  quoted += word.substr(0, kShown);
  if (word.size() > kShown) quoted += kGap;
  return quoted + "\"";
}

std::string toml_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      out += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + "\"";
}

std::string plain_sentence(std::string_view text, std::size_t most) {
  std::string sentence = plain_text(text);
  if (sentence.size() > most) sentence = with_short_words(sentence);
  return sentence.size() > most ? without_middle(sentence, most / 2, most) : sentence;
}

}  // namespace fringetwin
