// SPDX-License-Identifier: Apache-2.0
#include "twin/captures/natural_order.hpp"

#include <charconv>
#include <cstdlib>
#include <sstream>
#include <string_view>

namespace fringetwin {
namespace {

constexpr int kMostNumbers = 100000;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Returns the run of digits that begins at `at`, without leading zeros; `at` moves behind it.
std::string_view take_number(const std::string& text, std::size_t* at) {
  std::size_t end = *at;
  while (end < text.size() && is_digit(text[end])) ++end;
  while (*at + 1 < end && text[*at] == '0') ++*at;
  const std::string_view digits = std::string_view(text).substr(*at, end - *at);
  *at = end;
  return digits;
}

/// Appends the numbers of "7" or "0-11". Returns false when the item is neither.
bool append_range(const std::string& item, std::vector<int>* out) {
  const char* end = item.data() + item.size();
  int first = -1;
  const auto [dash, error] = std::from_chars(item.data(), end, first);
  if (error != std::errc() || first < 0) return false;
  int last = first;
  if (dash != end) {
    const auto [stop, fault] = std::from_chars(dash + 1, end, last);
    if (*dash != '-' || fault != std::errc() || stop != end || last < 0) return false;
  }
  if (std::abs(last - first) >= kMostNumbers) return false;
  for (int n = first;; n += last < first ? -1 : 1) {
    out->push_back(n);
    if (n == last) return out->size() <= kMostNumbers;
  }
}

}  // namespace

bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0, k = 0;
  while (i < a.size() && k < b.size()) {
    if (is_digit(a[i]) && is_digit(b[k])) {
      const std::string_view left = take_number(a, &i), right = take_number(b, &k);
      if (left.size() != right.size()) return left.size() < right.size();
      if (left != right) return left < right;
    } else {
      const auto left = static_cast<unsigned char>(a[i++]), right = static_cast<unsigned char>(b[k++]);
      if (left != right) return left < right;
    }
  }
  if (i < a.size() || k < b.size()) return i >= a.size();
  return a < b;  // they differ in leading zeros
}

std::vector<int> parse_number_list(const std::string& text) {
  std::vector<int> numbers;
  if (text.ends_with(',')) return {};
  std::istringstream items(text);
  for (std::string item; std::getline(items, item, ',');)
    if (!append_range(item, &numbers)) return {};
  return numbers;
}

}  // namespace fringetwin
