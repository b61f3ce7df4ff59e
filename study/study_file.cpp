// SPDX-License-Identifier: Apache-2.0
#include "study/study_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "study/design/design_plan.hpp"
#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/optimise/optimise.hpp"
#include "study/volume_map/volume_map.hpp"
#include "twin/base/paths.hpp"
#include "twin/file/toml_reader.hpp"
#include "twin/twin.hpp"

namespace fringetwin::study {
namespace fs = std::filesystem;
namespace {

constexpr const char* kStudySchema = "fringetwin-study/1";

/// How the file of a kind is read: its keys, and its plan with what the kind records by itself.
struct FileOfKind {
  const char* name;
  std::vector<std::string> (*keys)();
  void (*read)(const TomlTable& root, StudyFile* study);
};
constexpr FileOfKind kKinds[] = {
    {"design", design_keys, [](const TomlTable& root, StudyFile* study) { study->plan = read_design(root); }},
    {"monte-carlo", monte_carlo_keys,
     [](const TomlTable& root, StudyFile* study) {
       study->plan = read_monte_carlo(root, study->head.twin);
       study->head.content.erase("most_trials");  // says when to stop: each trial is the same without it
       // what tells the trials from the points of their shares, which had other ids until 0.2.0
       study->head.content["(shares begin at point)"] = std::to_string(kFirstRowId);
     }},
    {"volume-map", volume_map_keys,
     [](const TomlTable& root, StudyFile* study) {
       VolumeMapPlan plan = read_volume_map(root, study->head.twin);
       study->head.records = volume_map_records(plan.object);
       study->plan = std::move(plan);
     }},
    {"optimise", optimise_keys,
     [](const TomlTable& root, StudyFile* study) {
       OptimisePlan plan = read_optimise(root, study->head.twin);
       study->head.records = optimise_records(plan);
       study->plan = std::move(plan);
     }},
};

const FileOfKind& read_kind(const TomlTable& root) {
  std::vector<std::string> names;
  for (const FileOfKind& kind : kKinds) names.emplace_back(kind.name);
  const std::string name = root.has("kind") ? root.required_choice("kind", names) : names.front();
  return kKinds[std::ranges::find(names, name) - names.begin()];
}

}  // namespace

StudyFile load_study(const fs::path& file) {
  const TomlTable root = TomlTable::parse_file(file, ExitCode::usage);
  const FileOfKind& kind = read_kind(root);
  std::vector<std::string> keys = {"schema", "name", "twin", "kind", "seed"};
  const std::vector<std::string> own = kind.keys();
  keys.insert(keys.end(), own.begin(), own.end());
  if (!root.has("schema")) root.allow(keys);  // a misspelt "schema" is named as such
  if (root.required_string("schema") != kStudySchema)
    root.fail("schema",
              fmt::format("must be \"{}\", is \"{}\"", kStudySchema, root.required_string("schema")));
  root.allow(keys);
  StudyFile study;
  StudyHead& head = study.head;
  head.file = tidy_path(file);
  head.name = root.string("name").value_or(head.file.stem().string());
  head.twin = twin_file_of(resolve_path(root.required_string("twin"), head.file.parent_path(),
                                        root.where("twin"), ExitCode::usage));
  head.content = root.flattened();
  head.content.erase("name");
  head.content.erase("twin");
  head.records = read_records(root);
  kind.read(root, &study);
  return study;
}

std::unique_ptr<Kind> kind_of(const StudyFile& file) {
  return std::visit([&](const auto& plan) { return make_kind(file.head, plan); }, file.plan);
}

}  // namespace fringetwin::study
