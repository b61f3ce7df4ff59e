// SPDX-License-Identifier: Apache-2.0
#include "twin/file/toml_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <locale>
#include <sstream>
#include <vector>

#include "twin/file/toml_bounds.hpp"
#include "twin/file/toml_reader.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin {

toml::table parsed_toml(const std::string& text, const std::string& file, ExitCode code) {
  if (const auto excess = toml_excess(text))
    throw UserError(code, fmt::format("{}:{}", file, excess->line), excess->what, excess->hint);
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& e) {
    throw UserError(code, fmt::format("{}:{}", file, e.source().begin.line),
                    fmt::format("is no valid TOML: {}", e.description()));
  }
}

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
      parts.push_back(fmt::format("{} = {}", toml_string(std::string(key.str())), toml_text(child)));
    return fmt::format("{{ {} }}", fmt::join(parts, ", "));
  }
  if (const auto* array = node.as_array()) {
    for (const toml::node& child : *array) parts.push_back(toml_text(child));
    return fmt::format("[{}]", fmt::join(parts, ", "));
  }
  if (const auto* real = node.as_floating_point()) return number_text(real->get());
  const std::string text = scalar_text(node);
  return node.is_string() ? toml_string(text) : text;
}

}  // namespace fringetwin
