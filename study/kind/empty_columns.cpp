// SPDX-License-Identifier: Apache-2.0
#include "study/kind/empty_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "compare/verdict/limits.hpp"
#include "study/noise/theory_scope.hpp"
#include "study/uncertain/uncertain_inputs.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

/// Of a parameter that is drawn every point has a reason of its own: so many are told.
constexpr std::size_t kMostScopeReasons = 3;

std::string column_of(const Record& record) { return record.name.empty() ? record.result : record.name; }

bool is_of_theory(const Record& record) { return record.result.starts_with("theory."); }

/// Returns whether the study names what it records; other kinds record what they need by themselves.
bool names_its_records(const StudyHead& head) {
  return std::ranges::any_of(head.content, [](const auto& key) { return key.first.starts_with("record"); });
}

/// Returns the first record of the theory; nothing where there is none.
const Record* first_of_theory(const StudyHead& head) {
  const auto found = std::ranges::find_if(head.records, is_of_theory);
  return found == head.records.end() ? nullptr : &*found;
}

/// Returns what the twin of these settings has that the theory does not know, of the objects that the records
/// name; empty where there is nothing. Throws UserError where the settings make no valid twin.
std::string outside_theory_of(const StudyHead& head, const Settings& settings) {
  const Twin twin = compare::load_checked_twin(head.twin, keys_of_twin(settings));
  for (const Object& object : twin.objects) {
    const std::string path = "theory." + object.name + ".";
    if (std::ranges::none_of(head.records, [&](const Record& r) { return r.result.starts_with(path); }))
      continue;
    if (has_drawn_form(settings, object.name)) return "the uncertain form of \"" + object.name + "\"";
    if (std::string outside = outside_noise_theory(twin, object.name); !outside.empty()) return outside;
  }
  return "";
}

/// Answers for one setting after the other: seeds of one setting follow each other and share its answer.
class TheoryScope {
 public:
  explicit TheoryScope(const StudyHead& head) : head_(head) {}

  /// Returns nothing where the settings make no valid twin.
  const std::optional<std::string>& outside(const Settings& settings) {
    if (settings_ == settings) return outside_;
    settings_ = settings;
    try {
      outside_ = outside_theory_of(head_, settings);
    } catch (const UserError&) {
      outside_.reset();
    }
    return outside_;
  }

 private:
  const StudyHead& head_;
  std::optional<Settings> settings_;
  std::optional<std::string> outside_;
};

using Reasons = std::map<std::string, std::size_t>;  // what the theory does not know -> points

/// Returns "a (3 points), b (1 point) and 5 other reasons", those of most points first.
std::string reasons_text(const Reasons& reasons) {
  std::vector<std::pair<std::string, std::size_t>> order(reasons.begin(), reasons.end());
  std::ranges::stable_sort(order, [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string out;
  for (std::size_t i = 0; i < std::min(order.size(), kMostScopeReasons); ++i)
    out += fmt::format("{}{} ({} {})", i == 0 ? "" : ", ", order[i].first, order[i].second,
                       order[i].second == 1 ? "point" : "points");
  if (order.size() > kMostScopeReasons)
    out += fmt::format(" and {} more like these", order.size() - kMostScopeReasons);
  return out;
}

bool lacks_a_number_of_theory(const StudyHead& head, const StoredPoint& row) {
  return std::ranges::any_of(head.records, [&](const Record& record) {
    return is_of_theory(record) && std::isnan(row.outcome.number(column_of(record)));
  });
}

Reasons reasons_outside_theory(const StudyHead& head, const std::vector<const StoredPoint*>& done) {
  Reasons out;
  if (first_of_theory(head) == nullptr) return out;
  TheoryScope scope(head);
  for (const StoredPoint* row : done) {
    throw_if_cancelled();
    if (!lacks_a_number_of_theory(head, *row)) continue;
    const std::optional<std::string>& outside = scope.outside(row->point.settings);
    if (outside && !outside->empty()) ++out[*outside];
  }
  return out;
}

std::string null_everywhere(const Record& record, std::size_t runs) {
  const std::string name = fmt::format("\"{}\"", column_of(record));
  const std::string out =
      runs == 1 ? name + " is null in the only run" : fmt::format("{} is null in all {} runs", name, runs);
  if (record.result.find(".method_bias") == std::string::npos) return out;
  return out +
         ": a study does not measure the bias of the method; `fringetwin measure --method-bias` does, of one "
         "capture";
}

}  // namespace

void refuse_outside_noise_theory(const StudyHead& head, const PointSequence& points) {
  const Record* record = first_of_theory(head);
  if (record == nullptr) return;
  TheoryScope scope(head);
  std::string first;
  for (const StudyPoint& point : points) {
    throw_if_cancelled();
    const std::optional<std::string>& outside = scope.outside(point.settings);
    if (outside && outside->empty()) return;
    if (outside && first.empty()) first = *outside;
  }
  if (first.empty()) return;  // no valid twin at all: not for the theory to say
  throw UserError(ExitCode::usage, head.file.string(),
                  fmt::format("no point has a number for \"{}\": the theory of the noise does not know {}",
                              column_of(*record), first),
                  "record the fits alone");
}

std::vector<std::string> empty_column_warnings(const StudyHead& head, const std::vector<StoredPoint>& rows) {
  std::vector<const StoredPoint*> done;
  for (const StoredPoint& row : rows)
    if (row.status == PointStatus::done) done.push_back(&row);
  std::vector<std::string> out;
  if (done.empty()) return out;
  const Reasons reasons = reasons_outside_theory(head, done);
  std::size_t outside = 0;
  for (const auto& [reason, points] : reasons) outside += points;
  if (outside > 0)
    out.push_back(fmt::format(
        "the theory of the noise has no number for {} of {} points, their columns of it are empty: it does "
        "not know {}",
        outside, done.size(), reasons_text(reasons)));
  if (!names_its_records(head)) return out;
  for (const Record& record : head.records) {
    if (is_of_theory(record) && outside == done.size()) continue;  // said already
    if (std::ranges::all_of(
            done, [&](const StoredPoint* row) { return std::isnan(row->outcome.number(column_of(record))); }))
      out.push_back(null_everywhere(record, done.size()));
  }
  return out;
}

}  // namespace fringetwin::study
