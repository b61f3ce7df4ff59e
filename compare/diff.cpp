// SPDX-License-Identifier: Apache-2.0
#include "compare/diff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "compare/result/fit_keys.hpp"
#include "compare/result/tables.hpp"
#include "compare/result_file.hpp"
#include "report/json.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/not_copyable.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/safe_file.hpp"

namespace fringetwin::compare {
namespace {

using ReadJson = nlohmann::json;

constexpr double kMostQuantities = 2e5;        // a result of ours has some thousand; each becomes a line
constexpr std::size_t kLongestRowName = 1000;  // names in twins have 100 characters at most
constexpr std::size_t kWidestName = 100;       // of the table's first column
constexpr std::size_t kMostOfPart = 20;  // numbers that one result alone has, which are named one by one

/// One number of a result, for example "gain left gain_dn", and that of its standard error.
struct Quantity {
  std::string name, sigma;
  double value = 0.0;
  bool is_sigma = false;
  bool simulated_only = false;  ///< it stands without the real images
};

/// The numbers of one result, and each by its name: the first one where several share it.
class Quantities : NotCopyable {
 public:
  explicit Quantities(std::vector<Quantity> list) : list_(std::move(list)) {
    for (const Quantity& q : list_) by_name_.try_emplace(q.name, &q);
  }
  const std::vector<Quantity>& list() const { return list_; }
  const Quantity* find(const std::string& name) const {
    const auto found = by_name_.find(name);
    return found == by_name_.end() ? nullptr : found->second;
  }

 private:
  std::vector<Quantity> list_;
  std::unordered_map<std::string_view, const Quantity*> by_name_;
};

[[noreturn]] void fail(const ResultFile& result, const std::string& key, const ReadJson& value,
                       const char* what) {
  throw UserError(ExitCode::input, result.file.string(),
                  fmt::format("{} is {}, {} is expected", key, value.type_name(), what),
                  "give a result.json as cosim, compare or measure wrote it");
}

/// The text under a key of a row, "?" where there is none.
std::string text_in(const ResultFile& result, const ReadJson& row, const char* key) {
  if (!row.contains(key) || row[key].is_null()) return "?";
  if (!row[key].is_string()) fail(result, key, row[key], "a text");
  return plain_text(row[key].get<std::string>());
}

/// Collects the numbers of a result.
class Collector {
 public:
  explicit Collector(const ResultFile& result) : result_(result) {}

  std::vector<Quantity> collect() {
    const ReadJson& json = result_.json;
    if (json.contains("fits"))
      for (const ReadJson& row : rows_of("fits", json["fits"])) add_fit(row);
    for (const Table& table : tables()) {
      if (!json.contains(table.key) || json[table.key].is_null()) continue;
      const ReadJson& rows = json[table.key];
      if (rows.is_object())
        add_row(table.key, table.fields(), rows);
      else
        for (const ReadJson& row : rows_of(table.key, rows)) add_row(table.key, table.fields(), row);
    }
    return std::move(out_);
  }

 private:
  const ReadJson& rows_of(const std::string& key, const ReadJson& rows) const {
    if (!rows.is_array()) fail(result_, key, rows, "a list of rows");
    for (const ReadJson& row : rows)
      if (!row.is_object()) fail(result_, "a row of " + key, row, "a table");
    return rows;
  }

  /// Adds a number, or the numbers of a list with their index.
  void add_values(const Quantity& of, const ReadJson& value) {
    Quantity q = of;
    if (value.is_number()) {
      const double most = kMostQuantities * file_limits_factor();
      if (static_cast<double>(out_.size()) >= most)
        throw UserError(ExitCode::input, result_.file.string(),
                        fmt::format("has more than {:.0f} numbers", most),
                        "--limits 10 reads ten times as many");
      q.value = value.get<double>();
      out_.push_back(q);
    }
    if (value.is_number() || value.is_null()) return;
    if (!value.is_array()) fail(result_, of.name, value, "a number");
    for (std::size_t i = 0; i < value.size(); ++i) {
      q.name = fmt::format("{}[{}]", of.name, i);
      if (!of.sigma.empty()) q.sigma = fmt::format("{}[{}]", of.sigma, i);
      add_values(q, value[i]);
    }
  }

  /// Returns the texts of a row that say which one it is: " left x".
  std::string name_of(const std::vector<Field>& fields, const ReadJson& row) const {
    std::string name;
    for (const Field& field : fields) {
      if (field.role != Field::Role::name || !row.contains(field.key)) continue;
      const ReadJson& value = row[field.key];
      if (value.is_string()) name += " " + plain_text(value.get<std::string>());
      if (!value.is_array()) continue;
      for (const ReadJson& part : value) {
        if (!part.is_string()) fail(result_, "a part of " + field.key, part, "a text");
        name += " " + plain_text(part.get<std::string>());
      }
    }
    check_name(name);
    return name;
  }

  /// Every number of a row repeats its name.
  void check_name(const std::string& name) const {
    if (name.size() > kLongestRowName)
      throw UserError(ExitCode::input, result_.file.string(),
                      fmt::format("the name of a row has {} characters, at most {} are read", name.size(),
                                  kLongestRowName));
  }

  void add_row(const std::string& table, const std::vector<Field>& fields, const ReadJson& row) {
    const std::string prefix = table + name_of(fields, row) + " ";
    for (const Field& field : fields) {
      if (!row.contains(field.key) || row[field.key].is_null()) continue;
      const ReadJson& value = row[field.key];
      if (field.kind == Kind::rows)
        for (const ReadJson& part : rows_of(field.key, value))
          add_row(prefix + field.key, field.rows(), part);
      else if (field.kind != Kind::text && field.kind != Kind::texts && field.kind != Kind::flag)
        add_values({.name = prefix + field.key,
                    .sigma = field.sigma.empty() ? "" : prefix + field.sigma,
                    .is_sigma = field.role == Field::Role::sigma,
                    .simulated_only = field.simulated_only},
                   value);
    }
  }

  /// Adds the numbers of a fit, which stand in maps, on four sides.
  void add_fit(const ReadJson& row) {
    const std::string object = text_in(result_, row, "object");
    check_name(object);
    for (const char* side : {"measured", "simulated", "real", "difference"}) {
      if (!row.contains(side) || row[side].is_null()) continue;
      if (!row[side].is_object()) fail(result_, side, row[side], "a table");
      const std::string prefix = fmt::format("fit {} {} ", object, side);
      for (const auto& [key, value] : row[side].items()) {
        if (key == "warning") continue;
        check_name(key);
        add_values({.name = prefix + plain_text(key),
                    .sigma = prefix + sigma_key(plain_text(key)),
                    .is_sigma = is_sigma_key(key),
                    .simulated_only = std::string_view(side) == "simulated"},
                   value);
      }
    }
  }

  const ResultFile& result_;
  std::vector<Quantity> out_;
};

/// Counts the images that both runs read: their noise and calibration are the same, so the numbers made from
/// them are not independent.
std::size_t shared_images(const ReadJson& a, const ReadJson& b) {
  const auto digests = [](const ReadJson& json) {
    std::set<std::string> out;
    static const ReadJson::json_pointer kInputs("/provenance/inputs_sha256");
    if (!json.contains(kInputs)) return out;
    for (const auto& [file, digest] : json[kInputs].items()) {
      const std::string extension = std::filesystem::path(file).extension().string();
      if (extension != ".toml" && extension != ".ply" && extension != ".stl" && extension != ".obj" &&
          extension != ".yml" && extension != ".yaml" && extension != ".xml" && extension != ".cameramodel" &&
          digest.is_string())
        out.insert(digest.get<std::string>());
    }
    return out;
  };
  const std::set<std::string> in_a = digests(a), in_b = digests(b);
  return static_cast<std::size_t>(
      std::ranges::count_if(in_a, [&](const std::string& d) { return in_b.contains(d); }));
}

/// Returns (B - A) / sigma; NaN where one of the two has no standard error.
double z_score(const Quantity& in_a, const Quantity& in_b, const Quantities& a, const Quantities& b) {
  const Quantity *sa = a.find(in_a.sigma), *sb = b.find(in_b.sigma);
  if (!sa || !sb) return kNaN;
  const double sigma = std::hypot(sa->value, sb->value);
  return sigma > 0.0 ? (in_b.value - in_a.value) / sigma : kNaN;
}

std::string line(const Difference& row, std::size_t width) {
  return fmt::format("{:<{}}  {:>14.7g}  {:>14.7g}  {:>14.7g}  {:>8}\n", row.name, width, row.a, row.b,
                     row.b - row.a, std::isfinite(row.z) ? fmt::format("{:.2f}", row.z) : "-");
}

/// Lists what only one result has; of a part of the result with many numbers, as the causes tested, how many.
std::string only_in(const char* side, const std::vector<std::string>& names) {
  const auto part_of = [](const std::string& name) { return name.substr(0, name.find(' ')); };
  std::map<std::string, std::size_t> n_of_part;
  for (const std::string& name : names) ++n_of_part[part_of(name)];
  std::string out;
  for (const std::string& name : names) {
    std::size_t& n = n_of_part[part_of(name)];
    if (n > kMostOfPart)
      out += fmt::format("only in {}: {} numbers of {} (--json names them)\n", side, n, part_of(name));
    else if (n > 0)
      out += fmt::format("only in {}: {}\n", side, name);
    if (n > kMostOfPart) n = 0;  // said
  }
  return out;
}

}  // namespace

Differences diff_results(const std::filesystem::path& a, const std::filesystem::path& b) {
  const ResultFile file_a = read_result_file(a), file_b = read_result_file(b);
  const Quantities qa(Collector(file_a).collect()), qb(Collector(file_b).collect());
  Differences out{.a = plain_text(a.string()),
                  .b = plain_text(b.string()),
                  .verdict_a = text_in(file_a, file_a.json, "verdict"),
                  .verdict_b = text_in(file_b, file_b.json, "verdict"),
                  .common_images = shared_images(file_a.json, file_b.json)};
  for (const Quantity& q : qa.list()) {
    const Quantity* other = qb.find(q.name);
    if (!other) {
      out.only_in_a.push_back(q.name);
      continue;
    }
    ++out.n_shared;
    if (q.is_sigma) continue;
    const bool independent = out.common_images == 0 || q.simulated_only;
    out.rows.push_back({q.name, q.value, other->value, independent ? z_score(q, *other, qa, qb) : kNaN});
  }
  for (const Quantity& q : qb.list())
    if (!qa.find(q.name)) out.only_in_b.push_back(q.name);
  return out;
}

std::string differences_text(const Differences& d) {
  std::size_t width = 10;
  for (const Difference& row : d.rows) width = std::max(width, std::min(row.name.size(), kWidestName));
  std::string out = fmt::format("A: {}\nB: {}\n\n{:<{}}  {:>14}  {:>14}  {:>14}  {:>8}\n", d.a, d.b,
                                "quantity", width, "A", "B", "B - A", "z");
  for (const Difference& row : d.rows) out += line(row, width);
  if (d.n_shared == 0) out += "no number is in both results\n";
  if (d.common_images > 0)
    out += fmt::format(
        "\nA and B read {} image files in common: what is made from them shares their errors, so no z is "
        "given there.\n",
        d.common_images);
  out += fmt::format("\nverdict: A {}, B {}\n", d.verdict_a, d.verdict_b);
  return out + only_in("A", d.only_in_a) + only_in("B", d.only_in_b);
}

std::string differences_json(const Differences& d) {
  report::Json rows = report::Json::array();
  for (const Difference& row : d.rows) {
    rows.push_back({{"name", row.name}, {"a", row.a}, {"b", row.b}, {"difference", row.b - row.a}});
    rows.back()["z"] = std::isfinite(row.z) ? report::Json(row.z) : nullptr;
  }
  const report::Json all{{"schema", "fringetwin-diff/1"},
                         {"a", d.a},
                         {"b", d.b},
                         {"verdict_a", d.verdict_a},
                         {"verdict_b", d.verdict_b},
                         {"common_images", d.common_images},
                         {"differences", rows},
                         {"only_in_a", d.only_in_a},
                         {"only_in_b", d.only_in_b}};
  // a path may be of any bytes
  return all.dump(1, ' ', false, report::Json::error_handler_t::replace) + "\n";
}

}  // namespace fringetwin::compare
