// SPDX-License-Identifier: Apache-2.0
#include "twin/file/toml_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "twin/base/nearest_word.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/file/toml_settings.hpp"
#include "twin/file/toml_text.hpp"
#include "twin/twin.hpp"

namespace fringetwin {
namespace fs = std::filesystem;

struct TomlTable::Impl {
  std::shared_ptr<const toml::table> document;
  const toml::table* table = nullptr;
  fs::path file;
  ExitCode code = ExitCode::usage;
  std::string path;  ///< "camera[0].sensor", empty for the file itself
};

namespace {

/// Returns the value as a double, integers included; nullopt for another type.
std::optional<double> as_double(const toml::node& node) {
  if (const auto* integer = node.as_integer()) return static_cast<double>(integer->get());
  if (const auto* real = node.as_floating_point()) return real->get();
  return std::nullopt;
}

// Returns what completes "must be ...".
std::string text_of(const NumberRange& r) {
  const bool has_min = r.min > -std::numeric_limits<double>::max();
  const bool has_max = r.max < std::numeric_limits<double>::max();
  const std::string low = fmt::format("{} {}", r.min_excluded ? ">" : ">=", r.min);
  const std::string high = fmt::format("{} {}", r.max_excluded ? "<" : "<=", r.max);
  if (has_min && has_max) return low + " and " + high;
  return has_min ? low : has_max ? high : "a number";
}

/// Empty, or what is wrong with a number ("must be > 0, is -1").
std::string number_fault(const toml::node& node, const NumberRange& range, double* value) {
  const std::optional<double> number = as_double(node);
  if (!number) return fmt::format("must be a number, is {}", type_name(node));
  if (!std::isfinite(*number)) return fmt::format("must be a finite number, is {}", *number);
  if (!range.contains(*number)) return fmt::format("must be {}, is {}", text_of(range), *number);
  if (*number > range.largest) return fmt::format("must be at most {}, is {}", range.largest, *number);
  if (*number < -range.largest) return fmt::format("must be at least {}, is {}", -range.largest, *number);
  if (*number > 0.0 && *number < range.smallest)
    return fmt::format("must be at least {}, is {}", range.smallest, *number);
  *value = *number;
  return "";
}

void flatten(const toml::node& node, const std::string& path, std::map<std::string, std::string>* out) {
  if (const auto* table = node.as_table()) {
    for (const auto& [key, child] : *table)
      flatten(child, path.empty() ? std::string(key.str()) : path + "." + std::string(key.str()), out);
  } else if (const auto* array = node.as_array()) {
    for (std::size_t i = 0; i < array->size(); ++i)
      flatten(*array->get(i), fmt::format("{}[{}]", path, i), out);
  } else {
    (*out)[path] = scalar_text(node);
  }
}

std::string place(const toml::source_region& source, const fs::path& file) {
  return source.begin.line == 0 ? file.string() : fmt::format("{}:{}", file.string(), source.begin.line);
}

bool is_put_in(const toml::node& node, const fs::path& file) {
  const auto& path = node.source().path;
  return path && *path != file.string();
}

/// "file:line"; what was put in instead of written there names its setting (toml_settings.hpp).
std::string place(const toml::node& node, const fs::path& file) {
  if (is_put_in(node, file)) return *node.source().path;
  return place(node.source(), file);
}

/// Returns the first text that holds a NUL, at which a path ends for the system; null without any.
const toml::node* text_with_nul(const toml::node& node) {
  const toml::node* found = nullptr;
  const auto look = [&found](const toml::node& child) {
    if (found == nullptr) found = text_with_nul(child);
  };
  if (const auto* table = node.as_table())
    for (const auto& [key, child] : *table) look(child);
  if (const auto* array = node.as_array())
    for (const toml::node& child : *array) look(child);
  if (const auto* text = node.as_string(); text != nullptr && text->get().find('\0') != std::string::npos)
    return &node;
  return found;
}

}  // namespace

fs::path resolve_path(const std::string& text, const fs::path& folder, const std::string& where,
                      ExitCode code) {
  static const std::string variable = "${FRINGETWIN_CAPTURES}";
  std::string expanded;
  std::size_t done = 0;  // what the variable holds is not looked at again
  for (auto at = text.find("${"); at != std::string::npos; at = text.find("${", done)) {
    if (text.compare(at, variable.size(), variable) != 0)
      throw UserError(code, where, fmt::format("unknown variable in the path \"{}\"", text),
                      "only " + variable + " is known");
    expanded += text.substr(done, at - done) + captures_root().string();
    done = at + variable.size();
  }
  const fs::path path(expanded + text.substr(done));
  return tidy_path(path.is_absolute() ? path : folder / path);
}

std::string toml_string(const std::string& text) {
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

TomlTable TomlTable::parse_file(const fs::path& file, ExitCode code,
                                const std::map<std::string, std::string>& settings) {
  std::error_code error;
  if (!fs::exists(file, error)) throw UserError(code, file.string(), "no such file");
  const std::string text = read_whole_text(file, {.what = "TOML file", .code = code});
  auto impl = std::make_shared<Impl>();
  toml::table document = parsed_toml(text, file.string(), code);
  put_settings(document, settings, file);
  if (const toml::node* broken = text_with_nul(document))
    throw UserError(code, place(*broken, file), "holds a NUL character", "leave out \\u0000");
  impl->document = std::make_shared<const toml::table>(std::move(document));
  impl->table = impl->document.get();
  impl->file = file;
  impl->code = code;
  return TomlTable(impl);
}

std::optional<double> TomlTable::number_at(const std::string& path) const {
  return fringetwin::number_at(*impl_->document, path, impl_->file);
}

std::string TomlTable::where(const std::string& key) const {
  if (!key.empty()) {
    for (const auto& [name, node] : *impl_->table)
      if (name.str() == key && name.source().begin.line != 0 && !is_put_in(node, impl_->file))
        return place(name.source(), impl_->file);
    if (const toml::node* node = impl_->table->get(key)) return place(*node, impl_->file);
  }
  if (impl_->path.empty()) return impl_->file.string();
  return place(*impl_->table, impl_->file);
}

std::string TomlTable::full_key(const std::string& key) const {
  if (key.empty()) return impl_->path;
  return impl_->path.empty() ? key : impl_->path + "." + key;
}

void TomlTable::fail(const std::string& key, const std::string& what, const std::string& hint) const {
  const std::string name = full_key(key);
  throw UserError(impl_->code, where(key), name.empty() ? what : name + " " + what, hint);
}

void TomlTable::allow(const std::vector<std::string>& known) const {
  for (const std::string& key : keys())
    if (std::ranges::find(known, key) == known.end()) {
      const std::string hint = did_you_mean(key, known);
      const std::string table = impl_->path.empty() ? "this file" : "[" + impl_->path + "]";
      throw UnknownKey(impl_->code, where(key), fmt::format("unknown key \"{}\" in {}", key, table),
                       hint.empty() ? fmt::format("known keys: {}", fmt::join(known, ", ")) : hint);
    }
}

template <class Value>
const Value* TomlTable::find(const std::string& key, const char* what) const {
  const toml::node* node = impl_->table->get(key);
  if (node == nullptr) return nullptr;
  const Value* value = node->as<Value>();
  if (value == nullptr) fail(key, fmt::format("must be {}, is {}", what, type_name(*node)));
  return value;
}

bool TomlTable::has(const std::string& key) const { return impl_->table->contains(key); }

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> names;
  for (const auto& [name, node] : *impl_->table) names.emplace_back(name.str());
  return names;
}

bool TomlTable::is_string(const std::string& key) const { return (*impl_->table)[key].is_string(); }
bool TomlTable::is_number(const std::string& key) const { return (*impl_->table)[key].is_number(); }
bool TomlTable::is_array(const std::string& key) const { return (*impl_->table)[key].is_array(); }
bool TomlTable::is_table(const std::string& key) const { return (*impl_->table)[key].is_table(); }

std::optional<double> TomlTable::number(const std::string& key, const NumberRange& range) const {
  const toml::node* node = impl_->table->get(key);
  if (node == nullptr) return std::nullopt;
  double value = 0.0;
  const std::string fault = number_fault(*node, range, &value);
  if (!fault.empty()) fail(key, fault);
  return value;
}

double TomlTable::number_or(const std::string& key, double otherwise, const NumberRange& range) const {
  return number(key, range).value_or(otherwise);
}

double TomlTable::required_number(const std::string& key, const NumberRange& range) const {
  const std::optional<double> value = number(key, range);
  if (!value) fail(key, "is missing", "it must be a number");
  return *value;
}

std::optional<int> TomlTable::integer(const std::string& key, int min, int max) const {
  const auto* value = find<toml::value<std::int64_t>>(key, "an integer");
  if (value == nullptr) return std::nullopt;
  if (value->get() < min || value->get() > max) {
    const std::string range = max == std::numeric_limits<int>::max() ? fmt::format(">= {}", min)
                                                                     : fmt::format("{} ... {}", min, max);
    fail(key, fmt::format("must be {}, is {}", range, value->get()));
  }
  return static_cast<int>(value->get());
}

int TomlTable::required_integer(const std::string& key, int min, int max) const {
  const std::optional<int> value = integer(key, min, max);
  if (!value) fail(key, "is missing", "it must be an integer");
  return *value;
}

std::optional<bool> TomlTable::boolean(const std::string& key) const {
  const auto* value = find<toml::value<bool>>(key, "true or false");
  return value == nullptr ? std::nullopt : std::optional(value->get());
}

std::optional<std::string> TomlTable::string(const std::string& key) const {
  const auto* value = find<toml::value<std::string>>(key, "a string");
  return value == nullptr ? std::nullopt : std::optional(value->get());
}

std::string TomlTable::required_string(const std::string& key) const {
  const std::optional<std::string> value = string(key);
  if (!value) fail(key, "is missing", "it must be a string");
  if (value->empty()) fail(key, "must not be empty");
  return *value;
}

std::string TomlTable::required_name() const {
  std::string name = required_string("name");
  const std::string fault = name_fault(name);
  if (!fault.empty()) fail("name", fault, kNameHint);
  return name;
}

std::optional<std::string> TomlTable::choice(const std::string& key,
                                             const std::vector<std::string>& choices) const {
  std::optional<std::string> value = string(key);
  if (value && std::ranges::find(choices, *value) == choices.end())
    fail(key, fmt::format("must be one of \"{}\", is \"{}\"", fmt::join(choices, "\", \""), *value),
         did_you_mean(*value, choices));
  return value;
}

std::string TomlTable::required_choice(const std::string& key,
                                       const std::vector<std::string>& choices) const {
  const std::optional<std::string> value = choice(key, choices);
  if (!value) fail(key, "is missing", fmt::format("it must be one of \"{}\"", fmt::join(choices, "\", \"")));
  return *value;
}

std::optional<std::vector<double>> TomlTable::numbers(const std::string& key,
                                                      const NumberRange& range) const {
  const auto* array = find<toml::array>(key, "an array of numbers");
  if (array == nullptr) return std::nullopt;
  std::vector<double> values(array->size());
  for (std::size_t i = 0; i < array->size(); ++i) {
    const std::string fault = number_fault(*array->get(i), range, &values[i]);
    if (!fault.empty())
      throw UserError(impl_->code, place(*array->get(i), impl_->file),
                      fmt::format("{}[{}] {}", full_key(key), i, fault));
  }
  return values;
}

std::optional<std::vector<std::vector<std::vector<double>>>> TomlTable::lists_of_rows(
    const std::string& key, std::size_t columns, const NumberRange& range) const {
  const auto* array = find<toml::array>(key, "an array of arrays of numbers");
  if (array == nullptr) return std::nullopt;
  const auto fail_at = [&](const toml::node& node, const std::string& name, const std::string& what) {
    throw UserError(impl_->code, place(node, impl_->file), full_key(key) + name + " " + what);
  };
  const auto as_array = [&](const toml::node& node, const std::string& name) -> const toml::array& {
    if (!node.is_array()) fail_at(node, name, fmt::format("must be an array, is {}", type_name(node)));
    return *node.as_array();
  };
  const auto read_rows = [&](const toml::array& rows, const std::string& name) {
    std::vector<std::vector<double>> out;
    for (const toml::node& node : rows) {
      const std::string row_name = fmt::format("{}[{}]", name, out.size());
      const toml::array& row = as_array(node, row_name);
      if (row.size() != columns)
        fail_at(node, row_name, fmt::format("must have {} numbers, has {}", columns, row.size()));
      std::vector<double> values(columns);
      for (std::size_t i = 0; i < columns; ++i) {
        const std::string fault = number_fault(*row.get(i), range, &values[i]);
        if (!fault.empty()) fail_at(*row.get(i), fmt::format("{}[{}]", row_name, i), fault);
      }
      out.push_back(std::move(values));
    }
    return out;
  };
  // Rows hold no arrays, lists of rows do; and where all are empty they are lists without rows.
  const auto is_list = [](const toml::node& entry) {
    const toml::array* inner = entry.as_array();
    return inner != nullptr &&
           std::any_of(inner->begin(), inner->end(), [](const toml::node& node) { return node.is_array(); });
  };
  const auto is_empty = [](const toml::node& entry) { return entry.is_array() && entry.as_array()->empty(); };
  const bool lists = std::any_of(array->begin(), array->end(), is_list) ||
                     (!array->empty() && std::all_of(array->begin(), array->end(), is_empty));
  std::vector<std::vector<std::vector<double>>> all;
  if (!lists) {
    all.push_back(read_rows(*array, ""));
    return all;
  }
  for (const toml::node& entry : *array) {
    const std::string name = fmt::format("[{}]", all.size());
    all.push_back(read_rows(as_array(entry, name), name));
  }
  return all;
}

std::optional<std::vector<std::string>> TomlTable::strings(const std::string& key) const {
  const auto* array = find<toml::array>(key, "an array of strings");
  if (array == nullptr) return std::nullopt;
  std::vector<std::string> values;
  for (std::size_t i = 0; i < array->size(); ++i) {
    const auto* text = array->get(i)->as_string();
    if (text == nullptr)
      throw UserError(
          impl_->code, place(*array->get(i), impl_->file),
          fmt::format("{}[{}] must be a string, is {}", full_key(key), i, type_name(*array->get(i))));
    values.push_back(text->get());
  }
  return values;
}

std::optional<std::vector<std::string>> TomlTable::toml_texts(const std::string& key) const {
  const auto* array = find<toml::array>(key, "an array");
  if (array == nullptr) return std::nullopt;
  std::vector<std::string> texts;
  for (const toml::node& entry : *array) texts.push_back(toml_text(entry));
  return texts;
}

std::optional<std::vector<std::vector<std::string>>> TomlTable::toml_rows(const std::string& key,
                                                                          std::size_t columns) const {
  if (!toml_texts(key)) return std::nullopt;
  std::vector<std::vector<std::string>> rows;
  for (const toml::node& entry : *impl_->table->get(key)->as_array()) {
    const toml::array* row = entry.as_array();
    const std::string name = fmt::format("{}[{}]", key, rows.size());
    if (row == nullptr) fail(key, fmt::format("must hold arrays, {} is {}", name, type_name(entry)));
    if (row->size() != columns)
      fail(key, fmt::format("must hold arrays of {}, {} has {}", columns, name, row->size()));
    rows.emplace_back();
    for (const toml::node& value : *row) rows.back().push_back(toml_text(value));
  }
  return rows;
}

std::optional<Eigen::VectorXd> TomlTable::vector(const std::string& key, int n,
                                                 const NumberRange& range) const {
  const std::optional<std::vector<double>> values = numbers(key, range);
  if (!values) return std::nullopt;
  if (values->size() != static_cast<std::size_t>(n))
    fail(key, fmt::format("must have {} numbers, has {}", n, values->size()));
  return Eigen::Map<const Eigen::VectorXd>(values->data(), n);
}

Eigen::Vector3d TomlTable::required_vector3(const std::string& key) const {
  const std::optional<Eigen::VectorXd> value = vector(key, 3);
  if (!value) fail(key, "is missing", "it must be an array of 3 numbers");
  return *value;
}

std::optional<TomlTable> TomlTable::table(const std::string& key) const {
  const toml::node* node = impl_->table->get(key);
  if (node == nullptr) return std::nullopt;
  const toml::table* child = node->as_table();
  if (child == nullptr) {
    const bool tables = node->is_array_of_tables();
    fail(key, fmt::format("must be a table, is {}", tables ? "a list of tables" : type_name(*node)),
         fmt::format("write [{}]", full_key(key)));
  }
  auto impl = std::make_shared<Impl>(*impl_);
  impl->table = child;
  impl->path = full_key(key);
  return TomlTable(impl);
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) const {
  const toml::node* node = impl_->table->get(key);
  if (node == nullptr) return {};
  const toml::array* array = node->as_array();
  if (array == nullptr)
    fail(key, fmt::format("must be a list of tables, is {}", type_name(*node)),
         fmt::format("write [[{}]]", full_key(key)));
  std::vector<TomlTable> children;
  for (std::size_t i = 0; i < array->size(); ++i) {
    auto impl = std::make_shared<Impl>(*impl_);
    impl->table = array->get(i)->as_table();
    if (impl->table == nullptr)
      fail(key, fmt::format("must be a list of tables, [{}] is {}", i, type_name(*array->get(i))),
           fmt::format("write [[{}]]", full_key(key)));
    impl->path = fmt::format("{}[{}]", full_key(key), i);
    children.push_back(TomlTable(impl));
  }
  return children;
}

std::map<std::string, std::string> TomlTable::flattened() const {
  std::map<std::string, std::string> out;
  flatten(*impl_->table, "", &out);
  return out;
}

}  // namespace fringetwin
