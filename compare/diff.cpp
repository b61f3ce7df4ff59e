// SPDX-License-Identifier: Apache-2.0
#include "compare/diff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <vector>

#include "compare/result/fit_keys.hpp"
#include "compare/result/rows.hpp"
#include "report/json.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

using report::Json;

/// "left x pitch 13 step 0/4 rms_dn" -> value, in the order of the file.
struct Quantities {
  std::vector<std::pair<std::string, double>> list;
  const double* find(const std::string& name) const {
    for (const auto& [key, value] : list)
      if (key == name) return &value;
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

void add_values(const std::string& name, const Json& value, Quantities& out) {
  if (value.is_number()) out.list.emplace_back(name, value.get<double>());
  if (value.is_array() && value.size() == 3)
    for (std::size_t i = 0; i < 3; ++i)
      if (value[i].is_number()) out.list.emplace_back(fmt::format("{}[{}]", name, i), value[i].get<double>());
}

void add_rows(const Json& json, const char* table, const std::vector<std::string>& names, Quantities& out) {
  if (!json.contains(table) || !json[table].is_array()) return;
  for (const Json& row : json[table]) {
    std::string prefix = table;
    for (const std::string& name : names) prefix += fmt::format(" {}", row.value(name, "?"));
    for (const auto& [key, value] : row.items()) add_values(prefix + " " + key, value, out);
  }
}

Quantities quantities(const Json& json) {
  Quantities out;
  if (json.contains("fits"))
    for (const Json& row : json["fits"])
      for (const char* side : {"measured", "simulated", "real", "difference"})
        if (row.contains(side) && row[side].is_object())
          for (const auto& [key, value] : row[side].items())
            add_values("fit " + row.value("object", "?") + " " + side + " " + key, value, out);
  add_rows(json, "gain", {"camera"}, out);
  add_rows(json, "gray", {"camera", "pattern"}, out);
  add_rows(json, "phase", {"camera", "direction"}, out);
  add_rows(json, "noise", {"camera", "direction"}, out);
  add_rows(json, "shift", {"camera"}, out);
  return out;
}

/// "fit ball real radius_mm" -> "fit ball real radius_sigma_mm"; keeps an index.
std::string sigma_name(const std::string& name) {
  const std::size_t bracket = name.rfind('[');
  const std::string index = bracket == std::string::npos ? "" : name.substr(bracket);
  const std::string plain = name.substr(0, name.size() - index.size());
  const std::size_t at = plain.rfind(' ');
  return plain.substr(0, at + 1) + sigma_key(plain.substr(at + 1)) + index;
}

/// Images that both runs read: their noise and calibration are the same, so the numbers made from them are
/// not independent.
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
      std::count_if(in_a.begin(), in_a.end(), [&](const std::string& d) { return in_b.contains(d); }));
}

/// Only the simulated side of a fit stands without the real images.
bool depends_on_images(const std::string& name) {
  return !(name.starts_with("fit ") && name.find(" simulated ") != std::string::npos);
}

double z_score(const std::string& name, double difference, const Quantities& a, const Quantities& b) {
  const double *sa = a.find(sigma_name(name)), *sb = b.find(sigma_name(name));
  if (!sa || !sb) return kUnknown;
  const double sigma = std::hypot(*sa, *sb);
  return sigma > 0.0 ? difference / sigma : kUnknown;
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
  for (const auto& [name, value] : qa.list) width = std::max(width, name.size());
  std::string out = fmt::format("A: {}\nB: {}\n\n{:<{}}  {:>14}  {:>14}  {:>14}  {:>8}\n", a.string(),
                                b.string(), "quantity", width, "A", "B", "B - A", "z");
  const std::size_t common_images = shared_images(json_a, json_b);
  std::size_t shared = 0;
  std::string only;
  for (const auto& [name, value] : qa.list) {
    const double* other = qb.find(name);
    if (!other) {
      only += "only in A: " + name + "\n";
      continue;
    }
    ++shared;
    if (is_sigma_key(name)) continue;
    const bool independent = common_images == 0 || !depends_on_images(name);
    out += line(name, width, value, *other, independent ? z_score(name, *other - value, qa, qb) : kUnknown);
  }
  for (const auto& [name, value] : qb.list)
    if (!qa.find(name)) only += "only in B: " + name + "\n";
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
