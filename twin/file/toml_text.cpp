// SPDX-License-Identifier: Apache-2.0
#include "twin/file/toml_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <locale>
#include <sstream>
#include <vector>

#include "twin/number/parse_number.hpp"

namespace fringetwin {
namespace {

std::string quoted(const std::string& text) {
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

}  // namespace

const char* type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "a string";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

std::string scalar_text(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* integer = node.as_integer()) return fmt::format("{}", integer->get());
  if (const auto* real = node.as_floating_point()) return fmt::format("{}", real->get());
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  if (const auto* date = node.as_date()) stream << date->get();
  if (const auto* time = node.as_time()) stream << time->get();
  if (const auto* date_time = node.as_date_time()) stream << date_time->get();
  return stream.str();
}

std::string toml_text(const toml::node& node) {
  std::vector<std::string> parts;
  if (const auto* table = node.as_table()) {
    for (const auto& [key, child] : *table)
      parts.push_back(fmt::format("{} = {}", quoted(std::string(key.str())), toml_text(child)));
    return fmt::format("{{ {} }}", fmt::join(parts, ", "));
  }
  if (const auto* array = node.as_array()) {
    for (const toml::node& child : *array) parts.push_back(toml_text(child));
    return fmt::format("[{}]", fmt::join(parts, ", "));
  }
  if (const auto* real = node.as_floating_point()) return number_text(real->get());
  const std::string text = scalar_text(node);
  return node.is_string() ? quoted(text) : text;
}

}  // namespace fringetwin
