// SPDX-License-Identifier: Apache-2.0
#include "twin/merge/toml_merge.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/file/toml_text.hpp"
#include "twin/merge/toml_statements.hpp"

namespace fringetwin {
namespace {

std::string entry_mark(std::size_t i) { return "[" + std::to_string(i) + "]"; }

TomlPath joined(TomlPath path, const TomlPath& more) {
  path.insert(path.end(), more.begin(), more.end());
  return path;
}

/// Collects the changes of one text, by the byte at which they are made.
class Merger {
 public:
  Merger(const std::string& text, const std::string& file)
      : text_(text),
        file_(file),
        document_(parsed_toml(text, file, ExitCode::usage)),
        statements_(toml_statements(text)),
        line_break_(text.find("\r\n") == std::string::npos ? "\n" : "\r\n") {}

  void merge(const TomlBlock& block) {
    const TomlPath table = path_of(block);
    refuse_inline(table);
    std::vector<TomlKey> keys = block.keys;
    if (!keys.empty())
      for (const TomlExclusion& exclusion : block.exclusions)
        if (comment_out(table, exclusion.keys)) {
          comment_out(table, exclusion.also);
          for (const TomlKey& key : exclusion.instead)
            if (std::ranges::find(keys, key.name, &TomlKey::name) == keys.end()) keys.push_back(key);
        }
    std::vector<TomlKey> new_keys;
    for (const TomlKey& key : keys) {
      const TomlPath path = joined(table, {key.name});
      want(path, key.value);
      if (!replace(path, key.value)) new_keys.push_back(key);
    }
    if (!new_keys.empty()) add(block, table, new_keys);
  }

  /// Returns the text with all changes, once it is known to say what was asked for and nothing else.
  std::string merged() const {
    std::string out = text_;
    for (auto change = changes_.rbegin(); change != changes_.rend(); ++change)
      out.replace(std::get<0>(change->first), change->second.length, change->second.text);
    bool is_right = false;
    try {
      is_right = toml::parse(out) == document_;
    } catch (const toml::parse_error&) {
      is_right = false;
    }
    if (!is_right)
      throw UserError(ExitCode::usage, file_, "is written in a way that has no place for these values",
                      "put them in by hand");
    return out;
  }

 private:
  struct Change {
    std::size_t length = 0;  ///< of what it replaces
    std::string text;
  };

  [[noreturn]] void fail(std::size_t line, const std::string& what, const std::string& hint) const {
    throw UserError(ExitCode::usage, line > 0 ? fmt::format("{}:{}", file_, line) : file_, what, hint);
  }

  /// Finds the table of a block: the entry of a list by its name.
  TomlPath path_of(const TomlBlock& block) const {
    const std::string& first = block.table.front();
    if (block.entry.empty()) {
      if (!block.may_be_new && document_.get(first) == nullptr)
        fail(0, fmt::format("has no [{}]", first), "is it the twin that these values are for?");
      return block.table;
    }
    const toml::node* list = document_.get(first);
    if (list != nullptr && !list->is_array_of_tables())
      fail(0, fmt::format("has no [[{}]] but another {}", first, first), "write each as a table of its own");
    std::vector<std::size_t> found;
    if (list != nullptr)
      for (std::size_t i = 0; i < list->as_array()->size(); ++i)
        if (list->as_array()->get(i)->as_table()->at_path("name").value<std::string>() == block.entry)
          found.push_back(i);
    if (found.size() != 1)
      fail(0,
           found.empty() ? fmt::format("has no [[{}]] with name = \"{}\"", first, plain_text(block.entry))
                         : fmt::format("has {} [[{}]] with name = \"{}\", so that it cannot be told which is "
                                       "meant",
                                       found.size(), first, plain_text(block.entry)),
           found.empty() ? "is it the twin that these values are for?" : "give each a name of its own");
    return joined({first, entry_mark(found.front())}, {block.table.begin() + 1, block.table.end()});
  }

  /// Refuses a table that is a value: `sensor = { ... }`, `camera = [{ ... }]`.
  void refuse_inline(const TomlPath& table) const {
    for (const TomlStatement& s : statements_)
      if (!s.is_header && begins_with(table, s.path))
        fail(s.line,
             fmt::format("{} is written as a value, which is not changed in parts", header_text(s.path)),
             fmt::format("write it as a table of its own, [{}]", header_text(table)));
  }

  /// Makes comments of the keys, and of tables of these names; returns whether there were any.
  bool comment_out(const TomlPath& table, const std::vector<std::string>& keys) {
    bool any = false;
    for (const std::string& key : keys) {
      const TomlPath path = joined(table, {key});
      for (const TomlStatement& s : statements_) {
        if (!begins_with(s.path, path)) continue;
        any = true;
        for (std::size_t at = s.begin; at < s.end; at = text_.find('\n', at) + 1) {
          change(at, 0, "# ");
          if (text_.find('\n', at) == std::string::npos) break;
        }
      }
      if (toml::table* at = table_at(table, false)) at->erase(key);
    }
    return any;
  }

  /// Replaces the value of a key; returns false where there is no such key.
  bool replace(const TomlPath& path, const std::string& value) {
    for (const TomlStatement& s : statements_) {
      if (!begins_with(s.path, path)) continue;
      if (s.is_header || s.path != path)
        fail(s.line, fmt::format("{} is written as a table of its own", header_text(path)),
             fmt::format("write it as one value, as in {} = {}", path.back(), value));
      change(s.value_begin, s.value_end - s.value_begin, value);
      return true;
    }
    return false;
  }

  /// Adds lines at the end of the table, with it where there is none.
  void add(const TomlBlock& block, const TomlPath& table, const std::vector<TomlKey>& keys) {
    const TomlStatement* last = nullptr;  // of the table, under its header or as "sensor.gain_dn = 1"
    for (const TomlStatement& s : statements_)
      if (s.is_header ? s.path == table : begins_with(s.path, table) && begins_with(table, s.table))
        last = &s;
    std::string lines;
    if (last == nullptr) {
      lines = line_break_ + "[" + header_text(block.table) + "]" + line_break_;
      for (const TomlKey& key : keys) lines += line_of(key, "");
      insert_behind(end_of_section(table), lines);
      return;
    }
    const std::string dotted =
        header_text({table.begin() + static_cast<std::ptrdiff_t>(last->table.size()), table.end()});
    for (const TomlKey& key : keys) lines += line_of(key, dotted.empty() ? "" : dotted + ".");
    insert_behind(last->end, lines);
  }

  std::string line_of(const TomlKey& key, const std::string& before) const {
    const std::string line = before + key.name + " = " + key.value;
    return (key.comment.empty() ? line : fmt::format("{:<32}# {}", line, key.comment)) + line_break_;
  }

  /// Returns where the section ends that says most of the way to the table; of none, where the text ends.
  std::size_t end_of_section(const TomlPath& table) const {
    for (std::size_t n = table.size(); n > 0; --n) {
      const TomlPath parent(table.begin(), table.begin() + static_cast<std::ptrdiff_t>(n));
      for (std::size_t i = statements_.size(); i-- > 0;) {
        if (!begins_with(statements_[i].path, parent)) continue;
        while (i + 1 < statements_.size() && !statements_[i + 1].is_header) ++i;
        return statements_[i].end;
      }
    }
    return text_.size();
  }

  void insert_behind(std::size_t at, const std::string& lines) {
    const auto first = changes_.lower_bound({at, false, 0});
    const bool is_first = first == changes_.end() || std::get<0>(first->first) != at;
    const bool is_open = at > 0 && text_[at - 1] != '\n';  // the last line has no break
    changes_[{at, false, changes_.size()}] = {0, (is_open && is_first ? line_break_ : "") + lines};
  }

  void change(std::size_t at, std::size_t length, std::string text) {
    changes_[{at, true, changes_.size()}] = {length, std::move(text)};
  }

  /// Returns the table of the document that is to come, null where there is none and none is made.
  toml::table* table_at(const TomlPath& path, bool make) {
    toml::table* table = &document_;
    for (std::size_t i = 0; i < path.size(); ++i) {
      if (!table->contains(path[i])) {
        if (!make) return nullptr;
        table->insert(path[i], toml::table{});
      }
      toml::node* node = table->get(path[i]);
      if (i + 1 < path.size() && path[i + 1].starts_with('[') && node->is_array()) {
        ++i;
        node = node->as_array()->get(std::stoul(path[i].substr(1)));
      }
      table = node == nullptr ? nullptr : node->as_table();
      if (table == nullptr) return nullptr;
    }
    return table;
  }

  /// Notes what the merged text must say.
  void want(const TomlPath& path, const std::string& value) {
    toml::table* table = table_at({path.begin(), path.end() - 1}, true);
    FT_CHECK(table != nullptr, "the table of a block has been found");
    toml::table line = toml::parse("value = " + value);
    table->insert_or_assign(path.back(), std::move(*line.get("value")));
  }

  const std::string& text_;
  const std::string& file_;
  toml::table document_;
  std::vector<TomlStatement> statements_;
  std::string line_break_;
  /// By their place; what stands before a line comes before what changes the line, else in the order in which
  /// they were asked for.
  std::map<std::tuple<std::size_t, bool, std::size_t>, Change> changes_;
};

}  // namespace

std::string merge_toml(const std::string& text, const std::vector<TomlBlock>& blocks,
                       const std::string& file) {
  Merger merger(text, file);
  for (const TomlBlock& block : blocks) merger.merge(block);
  return merger.merged();
}

}  // namespace fringetwin
