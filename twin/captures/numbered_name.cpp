// SPDX-License-Identifier: Apache-2.0
#include "twin/captures/numbered_name.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "twin/number/parse_number.hpp"

namespace fringetwin {

std::string NumberedName::operator()(int number) const {
  return fmt::format("{}{:0{}}{}", before, number, digits, after);
}

std::optional<int> NumberedName::number_of(const std::string& name) const {
  if (name.size() <= before.size() + after.size()) return {};
  const std::string_view inner = std::string_view(name).substr(before.size());
  const std::optional<int> number = parse_number<int>(inner.substr(0, inner.size() - after.size()));
  if (!number || *number < 0 || (*this)(*number) != name) return {};
  return number;
}

std::optional<NumberedName> parse_numbered_name(const std::string& text) {
  const auto percent = text.find('%');
  if (percent == std::string::npos || text.find('%', percent + 1) != std::string::npos) return {};
  const auto end = text.find_first_not_of("0123456789", percent + 1);
  if (end == std::string::npos || text[end] != 'd') return {};
  const std::string width = text.substr(percent + 1, end - percent - 1);
  if (width.size() > 3 || (!width.empty() && width[0] != '0')) return {};  // %4d pads with blanks
  // "%04d/.." leads to one file whatever the number is
  const std::filesystem::path behind = text.substr(end + 1);
  if (std::ranges::find(behind, "..") != behind.end()) return {};
  const int digits = parse_number<int>(width).value_or(0);
  if (digits > 20) return {};
  return NumberedName{text.substr(0, percent), text.substr(end + 1), digits};
}

}  // namespace fringetwin
