// SPDX-License-Identifier: Apache-2.0
#include "study/kind/check_study.hpp"

#include <fmt/format.h>

#include <optional>
#include <set>

#include "compare/result/provenance.hpp"
#include "compare/verdict/limits.hpp"
#include "study/uncertain/uncertain_inputs.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/twin.hpp"

namespace fringetwin::study {
namespace fs = std::filesystem;
namespace {

/// So many points that are no valid twins before the first that is one: the twin itself is at fault.
constexpr std::size_t kMostFaults = 1000;

Settings settings_with_strings(const Settings& settings) {
  Settings strings;
  for (const auto& [key, text] : settings)
    if (text.find('"') != std::string::npos) strings[key] = text;
  return strings;
}

/// Returns the files that the twin has read and those that its objects will be read from. A file that is
/// missing fails its points.
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

}  // namespace

StudyIdentity check_study(const StudyHead& study, const PointSequence& points) {
  StudyIdentity identity;
  for (const auto& [key, text] : study.content) identity.study += fmt::format("{} = {}\n", key, text);
  std::set<fs::path> files;
  std::set<Settings> seen;  // what names files
  bool readable = false;
  std::optional<UserError> first_fault;
  std::optional<Settings> tried;
  std::size_t faults = 0;
  for (const StudyPoint& point : points) {
    throw_if_cancelled();
    if (tried == point.settings) continue;  // another noise seed
    tried = point.settings;
    const Settings strings = settings_with_strings(point.settings);
    if (readable && (strings.empty() || seen.contains(strings))) continue;
    try {
      const Settings keys = keys_of_twin(point.settings);
      const std::vector<fs::path> read = files_of(compare::load_checked_twin(study.twin, keys));
      files.insert(read.begin(), read.end());
      seen.insert(strings);
      readable = true;
    } catch (const UnknownKey&) {
      throw;
    } catch (const UserError& e) {
      if (!first_fault) first_fault = e;
      if (!readable && ++faults == kMostFaults) throw UserError(*first_fault);
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
