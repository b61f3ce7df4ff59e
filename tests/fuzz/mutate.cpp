// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutate.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <string_view>

namespace fringetwin::fuzz {
namespace {

const std::vector<std::string> kNumbers = {"0",
                                           "-0",
                                           "-1",
                                           "1",
                                           "2",
                                           "0.5",
                                           "255",
                                           "256",
                                           "65535",
                                           "65536",
                                           "2147483647",
                                           "2147483648",
                                           "-2147483649",
                                           "4294967295",
                                           "4294967296",
                                           "9000000000000000000",
                                           "9223372036854775808",
                                           "18446744073709551616",
                                           "99999999999999999999999999999999",
                                           "1e38",
                                           "3.5e38",
                                           "1e154",
                                           "1e308",
                                           "1e999",
                                           "-1e999",
                                           "5e-324",
                                           "nan",
                                           "inf",
                                           "-inf",
                                           "0x7fffffff",
                                           "1_000",
                                           "1e",
                                           ""};
/// What may stand for a value where another kind is expected; TOML, JSON, YAML and Python alike.
const std::vector<std::string> kValues = {"[]",          "{}",
                                          "\"\"",        "\"x\"",
                                          "''",          "null",
                                          "true",        "None",
                                          "[[]]",        "[1, \"a\", {}]",
                                          "[{}]",        "{a = 1}",
                                          "{\"a\": 1}",  "1979-05-27",
                                          "b''",         "~",
                                          "&a",          "*a",
                                          "../x",        "/dev/zero",
                                          "pipe",        ".",
                                          "\"\\u0000\"", "\"\xff\xfe\"",
                                          "%s%n",        "-",
                                          "@",           "\t",
                                          "()"};

bool in_number(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' || c == 'e' || c == 'E' || c == '+' ||
         c == '-';
}

struct Span {
  std::size_t begin = 0, end = 0;
};

/// Where numbers stand in a text.
std::vector<Span> numbers_in(const std::string& text) {
  std::vector<Span> spans;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool starts =
        std::isdigit(static_cast<unsigned char>(text[i])) != 0 ||
        (text[i] == '-' && i + 1 < text.size() && std::isdigit(static_cast<unsigned char>(text[i + 1])) != 0);
    if (!starts) continue;
    Span span{i, i};
    while (span.end < text.size() && in_number(text[span.end])) ++span.end;
    spans.push_back(span);
    i = span.end;
  }
  return spans;
}

/// Where values stand: what follows '=', ':', '[' or ',' up to the next ',', ']', '}' or the line's end.
std::vector<Span> values_in(const std::string& text) {
  std::vector<Span> spans;
  std::size_t end = text.size();
  for (std::size_t i = text.size(); i-- > 0;) {
    if (std::string_view("=:[,").find(text[i]) != std::string_view::npos && i + 1 < text.size())
      spans.push_back({i + 1, end});
    if (std::string_view(",]}\n").find(text[i]) != std::string_view::npos) end = i;
  }
  return spans;
}

std::string replaced(const std::string& text, const Span& span, const std::string& by) {
  return text.substr(0, span.begin) + by + text.substr(span.end);
}

Span some_span(const std::string& input, std::size_t longest, Random& random) {
  const std::size_t begin = random.below(input.size() + 1);
  return {begin, begin + random.below(std::min(longest, input.size() - begin) + 1)};
}

std::string flip(const std::string& input, Random& random) {
  std::string out = input;
  for (std::size_t n = 1 + random.below(4); n > 0 && !out.empty(); --n)
    out[random.below(out.size())] ^= static_cast<char>(1u << random.below(8));
  return out;
}

std::string put_number(const std::string& input, Random& random) {
  std::string out = input;
  std::uint64_t bits = extreme_bits(random);
  const std::size_t size = std::size_t{1} << random.below(4);
  if (out.size() < size) return out;
  std::array<char, sizeof(bits)> raw{};
  std::memcpy(raw.data(), &bits, sizeof(bits));
  if (random.one_in(2)) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
  std::copy_n(raw.begin(), size,
              out.begin() + static_cast<std::ptrdiff_t>(random.below(out.size() - size + 1)));
  return out;
}

std::string remove(const std::string& input, Random& random) {
  return replaced(input, some_span(input, random.one_in(2) ? 8 : input.size(), random), "");
}

std::string copy(const std::string& input, Random& random) {
  const Span from = some_span(input, random.one_in(2) ? 16 : input.size(), random);
  const std::size_t to = random.below(input.size() + 1);
  return replaced(input, {to, random.one_in(2) ? to : std::min(input.size(), to + from.end - from.begin)},
                  input.substr(from.begin, from.end - from.begin));
}

/// Many times the same few bytes: levels of nesting, long lines, long lists.
std::string repeat(const std::string& input, Random& random) {
  const Span from = some_span(input, 12, random);
  const std::string part = input.substr(from.begin, from.end - from.begin);
  if (part.empty()) return input;
  const std::size_t room = kLargestInput > input.size() ? (kLargestInput - input.size()) / part.size() : 0;
  const std::size_t most = random.one_in(8) ? room : std::min<std::size_t>(room, 300);
  std::string many;
  for (std::size_t n = random.below(most + 1); n > 0; --n) many += part;
  return replaced(input, {from.begin, from.begin}, many);
}

std::string truncate(const std::string& input, Random& random) {
  return input.substr(0, random.below(input.size() + 1));
}

std::string fill(const std::string& input, Random& random) {
  std::string out = input;
  const Span span = some_span(input, 16, random);
  for (std::size_t i = span.begin; i < span.end; ++i) out[i] = static_cast<char>(random.next());
  return out;
}

std::string change_span(const std::string& input, const std::vector<Span>& spans, const std::string& by,
                        Random& random) {
  return spans.empty() ? input : replaced(input, random.of(spans), by);
}

std::string change_number(const std::string& input, Random& random) {
  return change_span(input, numbers_in(input), extreme_number(random), random);
}

std::string change_value(const std::string& input, Random& random) {
  return change_span(input, values_in(input), " " + random.of(kValues), random);
}

/// A value of the text in the place of another.
std::string exchange_value(const std::string& input, Random& random) {
  const std::vector<Span> spans = values_in(input);
  if (spans.empty()) return input;
  const Span& from = random.of(spans);
  return change_span(input, spans, input.substr(from.begin, from.end - from.begin), random);
}

std::string change_lines(const std::string& input, Random& random) {
  std::vector<std::string> lines = split_lines(input);
  if (lines.empty()) return input;
  const std::size_t at = random.below(lines.size());
  const auto place = lines.begin() + static_cast<std::ptrdiff_t>(at);
  switch (random.below(4)) {
    case 0:
      lines.erase(place);
      break;
    case 1:
      lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(random.below(lines.size() + 1)),
                   std::string(lines[at]));
      break;
    case 2:
      std::swap(lines[at], random.of(lines));
      break;
    default:
      lines.insert(place, 1 + random.below(50), std::string(lines[at]));
  }
  return joined(lines);
}

std::string bounded(std::string text) {
  if (text.size() > kLargestInput) text.resize(kLargestInput);
  return text;
}

}  // namespace

std::string extreme_number(Random& random) { return random.of(kNumbers); }

std::uint64_t extreme_bits(Random& random) {
  static constexpr std::array<std::uint64_t, 14> kBits = {0,
                                                          1,
                                                          2,
                                                          0x7f,
                                                          0x80,
                                                          0xff,
                                                          0x7fff,
                                                          0xffff,
                                                          0x10000,
                                                          0x7fffffff,
                                                          0x80000000,
                                                          0xffffffff,
                                                          0x7fffffffffffffff,
                                                          0xffffffffffffffff};
  return random.one_in(4) ? random.next() : random.of(kBits);
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    lines.push_back(text.substr(at, end - at));
    at = end;
  }
  return lines;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += part;
  return text;
}

std::string mutate_bytes(const std::string& input, Random& random) {
  static constexpr std::array kChanges = {flip, flip,   put_number, put_number, remove,
                                          copy, repeat, truncate,   fill};
  return bounded(random.of(kChanges)(input, random));
}

std::string mutate_text(const std::string& input, Random& random) {
  static constexpr std::array kChanges = {change_number,  change_number, change_value,
                                          exchange_value, change_lines,  change_lines};
  return bounded(random.of(kChanges)(input, random));
}

std::string insert_word(const std::string& input, const std::vector<std::string>& words, Random& random) {
  if (words.empty()) return input;
  const std::string& word = random.of(words);
  const std::size_t at = random.below(input.size() + 1);
  return bounded(
      replaced(input, {at, random.one_in(2) ? at : std::min(input.size(), at + word.size())}, word));
}

std::string splice(const std::string& a, const std::string& b, Random& random) {
  return bounded(a.substr(0, random.below(a.size() + 1)) + b.substr(random.below(b.size() + 1)));
}

}  // namespace fringetwin::fuzz
