// SPDX-License-Identifier: Apache-2.0
#include "twin/file/toml_settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>

#include "twin/base/errors.hpp"
#include "twin/base/nearest_word.hpp"
#include "twin/file/toml_bounds.hpp"
#include "twin/file/toml_text.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin {
namespace {

/// Walks along one path.
class Setter {
 public:
  Setter(const std::string& key, const std::string& text, const std::filesystem::path& file)
      : key_(key),
        text_(text),
        file_(file.string()),
        source_(fmt::format("{} with {} = {}", file_, key, text)) {}

  /// Nothing where there is no number. Tables on the way to it are made all the same.
  std::optional<double> number(toml::table& document) {
    reading_ = true;
    source_ = fmt::format("{}: {}", file_, key_);
    put(document);
    return found_ == nullptr ? std::nullopt : found_->value<double>();
  }

  void put(toml::table& document) {
    toml::table* table = &document;
    for (std::size_t parts = 1;; ++parts) {
      if (parts > kMostKeyParts) fail(fmt::format("has more than {} parts", kMostKeyParts), "");
      const std::string name = take_name();
      if (rest_at_ == key_.size()) {
        if (reading_)
          found_ = table->get(name);
        else
          table->insert_or_assign(name, parsed(text_));
        return;
      }
      if (key_[rest_at_] == '[') {
        toml::node* node = table->get(name);
        if (node == nullptr || !node->is_array())
          unknown(
              fmt::format("{} is no list that [...] could count in", done_),
              node == nullptr ? "it is not in the file; write it there first, whole, with its defaults" : "");
        table = into_array(*node->as_array());
        if (table == nullptr) return;
        ++rest_at_;  // the point behind ]
        continue;
      }
      ++rest_at_;
      if (!table->contains(name)) table->insert(name, parsed("{}"));
      toml::node& node = *table->get(name);
      if (node.is_table()) {
        table = node.as_table();
      } else if (node.is_array_of_tables()) {
        table = entry_by_name(*node.as_array());
        if (table == nullptr) fail("ends at an entry of a list", "a key of it must follow");
      } else {
        unknown(fmt::format("{} is {}, no table", done_, type_name(node)), "");
      }
    }
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& hint) const {
    throw UserError(ExitCode::usage, source_, what, hint);
  }
  [[noreturn]] void unknown(const std::string& what, const std::string& hint) const {
    throw UnknownKey(ExitCode::usage, source_, what, hint);
  }

  /// The bare word at rest_at_, up to the next point or bracket.
  std::string take_name() {
    const std::size_t end = std::min(key_.find_first_of(".[", rest_at_), key_.size());
    std::string name = key_.substr(rest_at_, end - rest_at_);
    const bool ends_badly = end < key_.size() && end + 1 == key_.size();
    if (name.empty() || ends_badly) fail("is no path of a key", "e.g. camera.left.sensor.gain_dn");
    advance_to(end);
    return name;
  }

  /// "[3]" at rest_at_: sets the value there, or returns the table there for a path that goes on.
  toml::table* into_array(toml::array& array) {
    const std::size_t close = std::min(key_.find(']', rest_at_), key_.size());
    const std::string digits = key_.substr(rest_at_ + 1, close - rest_at_ - 1);
    const std::optional<std::size_t> number = parse_number<std::size_t>(digits);
    if (close == key_.size() || digits.size() > 6 || !number)
      fail("is no path of a key", "an index is a whole number from 0 in brackets");
    const std::size_t index = *number;
    if (index >= array.size())
      unknown(fmt::format("{} has {} entries, counted from 0", done_, array.size()), "");
    advance_to(close + 1);
    if (rest_at_ == key_.size()) {
      if (reading_)
        found_ = array.get(index);
      else
        array.replace(array.cbegin() + static_cast<std::ptrdiff_t>(index), parsed(text_));
      return nullptr;
    }
    toml::table* table = array[index].as_table();
    if (key_[rest_at_] != '.' || table == nullptr) unknown(fmt::format("{} is no table", done_), "");
    return table;
  }

  /// Names may hold points, so the longest one that fits counts. nullptr: nothing follows the name.
  toml::table* entry_by_name(toml::array& array) {
    const std::string rest = key_.substr(rest_at_);
    toml::table* found = nullptr;
    std::string longest;
    std::vector<std::string> names;
    for (toml::node& entry : array) {
      for (const char* naming : {"name", "object"}) {
        const auto name = entry.as_table()->at_path(naming).value<std::string>();
        if (!name) continue;
        names.push_back(*name);
        const bool fits =
            rest.starts_with(*name) && (rest.size() == name->size() || rest[name->size()] == '.');
        if (fits && name->size() > longest.size()) {
          found = entry.as_table();
          longest = *name;
        }
        break;
      }
    }
    if (found == nullptr) {
      const std::string word = rest.substr(0, rest.find('.'));
      const std::string hint = did_you_mean(word, names);
      unknown(fmt::format("no {} is named \"{}\"", done_, word),
              hint.empty() ? fmt::format("there are: {}", fmt::join(names, ", ")) : hint);
    }
    advance_to(rest_at_ + longest.size());
    if (rest_at_ == key_.size() || ++rest_at_ == key_.size()) return nullptr;
    return found;
  }

  void advance_to(std::size_t at) {
    rest_at_ = at;
    done_ = key_.substr(0, at);
  }

  /// Moved, not copied, into its place: a copy forgets its source.
  toml::node&& parsed(const std::string& text) {
    const std::string line = fmt::format("value = {}", text);
    if (const auto excess = toml_excess(line)) fail(excess->what, excess->hint);
    try {
      document_ = toml::parse(line, std::string_view(source_));
    } catch (const toml::parse_error& e) {
      fail("the value is no TOML", std::string(e.description()));
    }
    if (document_.size() != 1) fail("the value is no TOML", "one value on one line is needed");
    return std::move(*document_.get("value"));
  }

  const std::string &key_, &text_;
  std::string file_, source_;
  std::string done_;
  std::size_t rest_at_ = 0;
  toml::table document_;
  bool reading_ = false;
  const toml::node* found_ = nullptr;
};

}  // namespace

void put_settings(toml::table& document, const std::map<std::string, std::string>& settings,
                  const std::filesystem::path& file) {
  for (const auto& [key, text] : settings) Setter(key, text, file).put(document);
}

std::optional<double> number_at(toml::table document, const std::string& key,
                                const std::filesystem::path& file) {
  const std::string no_text;
  return Setter(key, no_text, file).number(document);
}

}  // namespace fringetwin
