// SPDX-License-Identifier: Apache-2.0
#include "study/study_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "compare/result/provenance.hpp"
#include "render/base/sobol.hpp"
#include "study/design/design.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/sha256.hpp"
#include "twin/file/toml_reader.hpp"
#include "twin/twin.hpp"

namespace fringetwin::study {
namespace fs = std::filesystem;
namespace {

constexpr const char* kStudySchema = "fringetwin-study/1";

bool is_sampled(Design design) { return design == Design::latin_hypercube || design == Design::sobol; }

Design read_design(const TomlTable& root) {
  const std::string name =
      root.choice("design", {"grid", "list", "latin-hypercube", "sobol"}).value_or("grid");
  if (name == "list") return Design::list;
  if (name == "latin-hypercube") return Design::latin_hypercube;
  return name == "sobol" ? Design::sobol : Design::grid;
}

std::size_t list_length(const Variation& v) {
  return v.range ? static_cast<std::size_t>(v.range->count.value_or(0)) : v.values.size();
}

/// Points without the repetition by noise seeds.
double count_points(const TomlTable& root, const StudyFile& study) {
  if (is_sampled(study.design)) return study.points;
  double n = 1.0;
  const std::vector<TomlTable> tables = root.tables("vary");
  for (std::size_t i = 0; i < study.vary.size(); ++i) {
    const auto length = static_cast<double>(list_length(study.vary[i]));
    if (study.design == Design::grid) {
      n *= length;
    } else {
      if (i > 0 && length != n)
        tables[i].fail("", fmt::format("has {} values, the first [[vary]] has {}", length, n),
                       "a list takes them side by side");
      n = length;
    }
  }
  return n;
}

void read_sampling(const TomlTable& root, StudyFile* study) {
  if (!is_sampled(study->design)) {
    for (const char* key : {"points", "seed"})
      if (root.has(key)) root.fail(key, "has no effect with a grid or list");
    return;
  }
  study->points = root.required_integer("points", 1, kMostPoints);
  study->seed = static_cast<std::uint64_t>(root.integer("seed", 0, kMostSeed).value_or(1));
  if (study->design == Design::sobol && study->vary.size() > std::size_t{render::kSobolDimensions})
    root.fail("vary", fmt::format("is given {} times, a Sobol design takes at most {}", study->vary.size(),
                                  render::kSobolDimensions));
}

Settings settings_with_strings(const Settings& settings) {
  Settings strings;
  for (const auto& [key, text] : settings)
    if (text.find('"') != std::string::npos) strings[key] = text;
  return strings;
}

/// What the twin has read, and what its objects will be read from. A file that is missing fails its points.
std::vector<fs::path> files_of(const Twin& twin) {
  std::vector<fs::path> files = twin.input_files;
  const auto take = [&](const fs::path& file) {
    std::error_code error;
    if (fs::is_regular_file(file, error)) files.push_back(file);
  };
  for (const Object& object : twin.objects)
    for (const fs::path& file : shape_files(object.shape)) take(file);
  return files;
}

std::vector<std::string> keys_of(const std::string& kind) {
  std::vector<std::string> keys = {"schema", "name", "twin", "kind", "seed"};
  const auto add = [&](const std::vector<std::string>& more) {
    keys.insert(keys.end(), more.begin(), more.end());
  };
  if (kind == "design" || kind == "monte-carlo") keys.emplace_back("record");
  if (kind == "design") {
    add({"design", "points", "noise_seeds", "first_noise_seed", "vary"});
    return keys;
  }
  add(uncertain_keys());
  add(kind == "monte-carlo"  ? monte_carlo_keys()
      : kind == "volume-map" ? volume_map_keys()
                             : optimise_keys());
  return keys;
}

}  // namespace

StudyFile load_study(const fs::path& file) {
  const TomlTable root = TomlTable::parse_file(file, ExitCode::usage);
  const std::string kind =
      root.has("kind") ? root.required_choice("kind", {"design", "monte-carlo", "volume-map", "optimise"})
                       : "design";
  const std::vector<std::string> keys = keys_of(kind);
  if (!root.has("schema")) root.allow(keys);  // a misspelt "schema" is named as such
  if (root.required_string("schema") != kStudySchema)
    root.fail("schema",
              fmt::format("must be \"{}\", is \"{}\"", kStudySchema, root.required_string("schema")));
  root.allow(keys);
  StudyFile study;
  study.file = tidy_path(file);
  study.name = root.string("name").value_or(study.file.stem().string());
  study.twin = resolve_path(root.required_string("twin"), study.file.parent_path(), root.where("twin"),
                            ExitCode::usage);
  study.content = root.flattened();
  study.content.erase("name");
  study.content.erase("twin");
  study.records = read_records(root);
  if (kind == "monte-carlo") {
    study.monte_carlo = read_monte_carlo(root, study.twin);
    return study;
  }
  if (kind == "volume-map") {
    study.volume_map = read_volume_map(root, study.twin);
    study.records = volume_map_records(study.volume_map->plan.object);
    return study;
  }
  if (kind == "optimise") {
    study.optimise = read_optimise(root, study.twin);
    study.records = optimise_records(study.optimise->plan);
    return study;
  }
  study.design = read_design(root);
  study.noise_seeds = root.integer("noise_seeds", 1, kMostPoints).value_or(1);
  study.first_noise_seed =
      static_cast<std::uint64_t>(root.integer("first_noise_seed", 0, kMostSeed).value_or(1));
  std::set<std::string> taken;
  for (const TomlTable& table : root.tables("vary"))
    study.vary.push_back(read_variation(table, is_sampled(study.design), &taken));
  read_sampling(root, &study);
  if (study.vary.empty() && (study.noise_seeds == 1 || is_sampled(study.design)))
    root.fail("vary", "is missing: the design is empty", "give a [[vary]], or noise_seeds of a plain grid");
  const double runs = count_points(root, study) * study.noise_seeds;
  if (runs > kMostPoints)
    root.fail("", fmt::format("asks for {:.0f} runs, at most {} are possible", runs, kMostPoints));
  return study;
}

std::string StudyIdentity::digest() const {
  std::vector<std::string> parts;
  for (const auto& [file, sha256] : inputs) parts.push_back(sha256);
  std::sort(parts.begin(), parts.end());
  return sha256_of_text(fmt::format("{}\n{}", study, fmt::join(parts, "\n")));
}

StudyIdentity check_study(const StudyFile& study, const std::vector<StudyPoint>& points) {
  StudyIdentity identity;
  for (const auto& [key, text] : study.content) identity.study += fmt::format("{} = {}\n", key, text);
  std::set<fs::path> files;
  std::set<Settings> seen;  // what names files
  bool readable = false;
  std::optional<UserError> first_fault;
  const Settings* tried = nullptr;
  for (const StudyPoint& point : points) {
    if (tried != nullptr && *tried == point.settings) continue;  // another noise seed
    tried = &point.settings;
    const Settings strings = settings_with_strings(point.settings);
    if (readable && (strings.empty() || seen.contains(strings))) continue;
    try {
      const std::vector<fs::path> read = files_of(load_twin(study.twin, keys_of_twin(point.settings)));
      files.insert(read.begin(), read.end());
      seen.insert(strings);
      readable = true;
    } catch (const UnknownKey&) {
      throw;
    } catch (const UserError& e) {
      if (!first_fault) first_fault = e;
    }
  }
  if (!readable) {
    FT_CHECK(first_fault.has_value(), "a study has points");
    throw UserError(*first_fault);
  }
  identity.inputs = compare::sha256_of_files({files.begin(), files.end()});
  return identity;
}

}  // namespace fringetwin::study
