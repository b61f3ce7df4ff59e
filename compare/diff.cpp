// SPDX-License-Identifier: Apache-2.0
#include "compare/diff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <string_view>
#include <vector>

#include "compare/result/fit_keys.hpp"
#include "compare/result/tables.hpp"
#include "report/json.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

using report::Json;

/// One number of a result, for example "gain left gain_dn", and that of its standard error.
struct Quantity {
  std::string name, sigma;
  double value = 0.0;
  bool is_sigma = false;
  bool simulated_only = false;  ///< it stands without the real images
};

/// The numbers of one result, in the order of the file.
struct Quantities {
  std::vector<Quantity> list;
  const Quantity* find(const std::string& name) const {
    for (const Quantity& q : list)
      if (q.name == name) return &q;
    return nullptr;
  }
};

Json load(const std::filesystem::path& path) {
  const std::filesystem::path file = std::filesystem::is_directory(path) ? path / "result.json" : path;
  std::ifstream in(file);
  if (!in)
    throw UserError(ExitCode::input, file.string(), "there is no such result",
                    "give the folder of a run, or its result.json");
  Json json;
  try {
    json = Json::parse(in);
  } catch (const Json::parse_error& error) {
    throw UserError(ExitCode::input, file.string(), std::string("this is no JSON: ") + error.what(),
                    "run the command that wrote it again");
  }
  if (!json.is_object() || json.value("schema", "") != "fringetwin-result/1")
    throw UserError(ExitCode::input, file.string(),
                    "this is no fringetwin result (schema fringetwin-result/1)",
                    "give a result.json of cosim, compare or measure");
  return json;
}

/// Adds a number, or the numbers of a list with their index.
void add_values(const Quantity& of, const Json& value, Quantities& out) {
  Quantity q = of;
  if (value.is_number()) {
    q.value = value.get<double>();
    out.list.push_back(q);
  }
  if (!value.is_array()) return;
  for (std::size_t i = 0; i < value.size(); ++i) {
    q.name = fmt::format("{}[{}]", of.name, i);
    if (!of.sigma.empty()) q.sigma = fmt::format("{}[{}]", of.sigma, i);
    add_values(q, value[i], out);
  }
}

/// Returns the texts of a row that say which one it is: " left x".
std::string name_of(const std::vector<Field>& fields, const Json& row) {
  std::string name;
  for (const Field& field : fields)
    if (field.role == Field::Role::name && row.contains(field.key)) {
      const Json& value = row[field.key];
      if (value.is_string()) name += " " + value.get<std::string>();
      if (value.is_array())
        for (const Json& part : value) name += " " + part.get<std::string>();
    }
  return name;
}

void add_row(const std::string& table, const std::vector<Field>& fields, const Json& row, Quantities& out) {
  const std::string prefix = table + name_of(fields, row) + " ";
  for (const Field& field : fields) {
    if (!row.contains(field.key)) continue;
    const Json& value = row[field.key];
    if (field.kind == Kind::rows)
      for (const Json& part : value) add_row(prefix + field.key, field.rows(), part, out);
    else
      add_values({.name = prefix + field.key,
                  .sigma = field.sigma.empty() ? "" : prefix + field.sigma,
                  .is_sigma = field.role == Field::Role::sigma,
                  .simulated_only = field.simulated_only},
                 value, out);
  }
}

/// Adds the numbers of a fit, which stand in maps, on four sides.
void add_fit(const Json& row, Quantities& out) {
  for (const char* side : {"measured", "simulated", "real", "difference"}) {
    if (!row.contains(side) || !row[side].is_object()) continue;
    const std::string prefix = fmt::format("fit {} {} ", row.value("object", "?"), side);
    for (const auto& [key, value] : row[side].items())
      add_values({.name = prefix + key,
                  .sigma = prefix + sigma_key(key),
                  .is_sigma = is_sigma_key(key),
                  .simulated_only = std::string_view(side) == "simulated"},
                 value, out);
  }
}

Quantities quantities(const Json& json) {
  Quantities out;
  for (const Json& row : json.value("fits", Json::array())) add_fit(row, out);
  for (const Table& table : tables()) {
    if (!json.contains(table.key)) continue;
    const Json& rows = json[table.key];
    if (rows.is_array())
      for (const Json& row : rows) add_row(table.key, table.fields(), row, out);
    else if (rows.is_object())
      add_row(table.key, table.fields(), rows, out);
  }
  return out;
}

/// Counts the images that both runs read: their noise and calibration are the same, so the numbers made from
/// them are not independent.
std::size_t shared_images(const Json& a, const Json& b) {
  const auto digests = [](const Json& json) {
    std::set<std::string> out;
    const Json none = Json::object();
    const Json inputs = json.value("provenance", none).value("inputs_sha256", none);
    for (const auto& [file, digest] : inputs.items()) {
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

std::string line(const std::string& name, std::size_t width, double a, double b, double z) {
  return fmt::format("{:<{}}  {:>14.7g}  {:>14.7g}  {:>14.7g}  {:>8}\n", name, width, a, b, b - a,
                     std::isfinite(z) ? fmt::format("{:.2f}", z) : "-");
}

}  // namespace

std::string diff_results(const std::filesystem::path& a, const std::filesystem::path& b) {
  const Json json_a = load(a), json_b = load(b);
  const Quantities qa = quantities(json_a), qb = quantities(json_b);
  std::size_t width = 10;
  for (const Quantity& q : qa.list) width = std::max(width, q.name.size());
  std::string out = fmt::format("A: {}\nB: {}\n\n{:<{}}  {:>14}  {:>14}  {:>14}  {:>8}\n", a.string(),
                                b.string(), "quantity", width, "A", "B", "B - A", "z");
  const std::size_t common_images = shared_images(json_a, json_b);
  std::size_t shared = 0;
  std::string only;
  for (const Quantity& q : qa.list) {
    const Quantity* other = qb.find(q.name);
    if (!other) {
      only += "only in A: " + q.name + "\n";
      continue;
    }
    ++shared;
    if (q.is_sigma) continue;
    const bool independent = common_images == 0 || q.simulated_only;
    out += line(q.name, width, q.value, other->value, independent ? z_score(q, *other, qa, qb) : kNaN);
  }
  for (const Quantity& q : qb.list)
    if (!qa.find(q.name)) only += "only in B: " + q.name + "\n";
  if (shared == 0) out += "no number is in both results\n";
  if (common_images > 0)
    out += fmt::format(
        "\nA and B read {} image files in common: what is made from them shares their errors, so no z is "
        "given there.\n",
        common_images);
  out += fmt::format("\nverdict: A {}, B {}\n", json_a.value("verdict", "?"), json_b.value("verdict", "?"));
  return out + only;
}

}  // namespace fringetwin::compare
