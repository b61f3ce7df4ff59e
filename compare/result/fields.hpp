// SPDX-License-Identifier: Apache-2.0
// Describes every number of a result once: its key, unit, meaning, where it stands in its row, which number
// is its standard error, how the page prints it, and whether a twin may limit it. From it follow result.json,
// its schema, `diff`, the limits and the plain tables of the page.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "compare/result/field_options.hpp"
#include "report/json.hpp"

namespace fringetwin::compare {

/// What stands under a key of result.json. An unknown number is null.
enum class Kind {
  text,
  texts,     ///< a list of texts
  number,    ///< any finite number
  positive,  ///< a number that is never below 0
  count,     ///< a whole number >= 0, always known
  flag,
  vector,   ///< three numbers: x, y, z
  numbers,  ///< a list of numbers
  matrix,   ///< a list of rows of numbers
  rows      ///< a list of rows that have fields of their own
};

/// One key of a row. `json` takes the row's address.
struct Field {
  enum class Role { value, name, sigma };
  std::string key;
  std::string unit;     ///< "DN", "rad", "mm", "px"; empty for a ratio, a count or a text
  std::string meaning;  ///< what the number says, for a reader who does not know the key
  Kind kind = Kind::number;
  std::function<report::Json(const void* row)> json;
  const std::vector<Field>& (*rows)() = nullptr;  ///< fields of the rows of Kind::rows

  /// The name fields of a row say which one it is; sigma fields are statements on another number's error.
  Role role = Role::value;
  std::string sigma;                 ///< key of this number's standard error; empty where there is none
  std::vector<std::string> choices;  ///< the only texts there are; empty = any text
  std::optional<Limit> limit;
  std::optional<Column> column;
  bool required = true;              ///< false: results of earlier versions may lack the key
  bool omit_empty = false;           ///< the key is left out where the text is empty
  bool empty_is_null = false;        ///< an empty text is written as null
  bool always_known = false;         ///< the number is never null
  bool simulated_only = false;       ///< the number holds nothing of the real images
  std::size_t fewest = 0, most = 0;  ///< items of a list; most = 0: any number

  Field& in(std::string its_unit) { return unit = std::move(its_unit), *this; }
  Field& error() { return role = Role::sigma, *this; }
  Field& one_of(std::vector<std::string> texts) { return choices = std::move(texts), *this; }
  Field& limited(Limit on) { return limit = std::move(on), *this; }
  Field& shown(Column as) { return column = std::move(as), *this; }
  Field& not_required() { return required = false, *this; }
  Field& or_absent() { return required = false, omit_empty = true, *this; }
  Field& or_null() { return empty_is_null = true, *this; }
  Field& known() { return always_known = true, *this; }
  Field& without_images() { return simulated_only = true, *this; }
  Field& items(std::size_t at_least, std::size_t at_most) { return fewest = at_least, most = at_most, *this; }
};

/// Returns the unit that the end of a key names: "gain_dn" -> "DN", "total_rad2" -> "rad²"; empty without
/// one.
std::string unit_of_key(const std::string& key);

template <class Row>
class Fields;

/// The fields of a row type, made once by its describe().
template <class Row>
const std::vector<Field>& fields() {
  static const std::vector<Field> all = [] {
    Fields<Row> f;
    Row::describe(f);
    return f.take();
  }();
  return all;
}

/// Every number and vector that a fit, or the difference of two fits, may have. They have no `json`: the rows
/// hold them in maps, by key.
const std::vector<Field>& fit_fields();

/// Returns the field of that key, or null.
const Field* find_field(const std::vector<Field>& all, const std::string& key);

/// Writes a row as a JSON object, key by key as `all` describes it.
report::Json row_json(const std::vector<Field>& all, const void* row);

template <class Row>
report::Json row_json(const Row& row) {
  return row_json(fields<Row>(), &row);
}

template <class Row>
report::Json rows_json(const std::vector<Row>& rows) {
  report::Json out = report::Json::array();
  for (const Row& row : rows) out.push_back(row_json(row));
  return out;
}

template <class Row>
std::vector<const void*> row_addresses(const std::vector<Row>& rows) {
  std::vector<const void*> out;
  for (const Row& row : rows) out.push_back(&row);
  return out;
}

template <class T>
inline constexpr bool kIsList = false;
template <class T>
inline constexpr bool kIsList<std::vector<T>> = true;

/// Collects the fields of a row type, which its describe() puts in the order of result.json. `get` is a
/// member, a member function or a callable of the row; its type decides the kind of the field, the end of the
/// key its unit.
template <class Row>
class Fields {
 public:
  template <class Get>
  Field& add(const std::string& key, const std::string& meaning, Get get) {
    using Value = std::decay_t<std::invoke_result_t<Get, const Row&>>;
    Field& f = fields_.emplace_back();
    f.key = key, f.unit = unit_of_key(key), f.meaning = meaning;
    f.json = [get](const void* row) { return to_json(std::invoke(get, *static_cast<const Row*>(row))); };
    if constexpr (std::is_same_v<Value, bool>)
      f.kind = Kind::flag;
    else if constexpr (std::is_integral_v<Value>)
      f.kind = Kind::count;
    else if constexpr (std::is_same_v<Value, std::string>)
      f.kind = Kind::text;
    else if constexpr (std::is_same_v<Value, std::vector<std::string>>)
      f.kind = Kind::texts;
    else if constexpr (std::is_same_v<Value, std::vector<double>>)
      f.kind = Kind::numbers;
    else if constexpr (std::is_same_v<Value, std::vector<std::vector<double>>>)
      f.kind = Kind::matrix;
    else if constexpr (kIsList<Value>) {
      f.kind = Kind::rows;
      f.rows = &fields<typename Value::value_type>;
    } else
      static_assert(std::is_same_v<Value, double>, "a field is a number, a text, a flag or a list");
    return f;
  }
  /// Adds what says which row it is.
  template <class Get>
  Field& name(const std::string& key, const std::string& meaning, Get get) {
    Field& f = add(key, meaning, get);
    f.role = Field::Role::name;
    return f;
  }
  /// Adds a number that is never below 0.
  template <class Get>
  Field& positive(const std::string& key, const std::string& meaning, Get get) {
    Field& f = add(key, meaning, get);
    f.kind = Kind::positive;
    return f;
  }
  /// Adds the standard error of the number that was added last.
  template <class Get>
  Field& sigma(const std::string& key, const std::string& meaning, Get get) {
    fields_.back().sigma = key;
    return positive(key, meaning, get).error();
  }

  std::vector<Field> take() { return std::move(fields_); }

 private:
  template <class Value>
  static report::Json to_json(const Value& value) {
    if constexpr (std::is_same_v<Value, double>)
      return report::json_number(value);
    else if constexpr (std::is_same_v<Value, std::vector<double>>)
      return report::json_numbers(value);
    else if constexpr (std::is_same_v<Value, std::vector<std::vector<double>>>) {
      report::Json out = report::Json::array();
      for (const std::vector<double>& row : value) out.push_back(report::json_numbers(row));
      return out;
    } else if constexpr (kIsList<Value> && !std::is_same_v<Value, std::vector<std::string>>)
      return rows_json(value);
    else
      return value;
  }

  std::vector<Field> fields_;
};

}  // namespace fringetwin::compare
