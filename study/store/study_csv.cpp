// SPDX-License-Identifier: Apache-2.0
// Writes the table of a study as CSV (RFC 4180).
#include <fmt/format.h>

#include <cmath>
#include <set>

#include "report/text.hpp"
#include "study/plan/recorded_numbers.hpp"
#include "study/store/study_store.hpp"

namespace fringetwin::study {

const char* status_name(PointStatus status) {
  return status == PointStatus::done ? "done" : status == PointStatus::failed ? "failed" : "pending";
}

std::string study_csv(const std::vector<StoredPoint>& rows) {
  std::set<std::string> keys, results;
  for (const StoredPoint& row : rows) {
    for (const auto& [key, value] : row.point.settings) keys.insert(key);
    for (const auto& [name, value] : row.outcome.numbers) results.insert(name);
  }
  std::string out = "id";
  for (const std::string& key : keys) out += "," + report::csv_cell(key);
  out += ",noise_seed,status,reason";
  for (const std::string& name : results) out += "," + report::csv_cell(name);
  out += "\r\n";
  for (const StoredPoint& row : rows) {
    out += fmt::format("{}", row.point.id);
    for (const std::string& key : keys) {
      const auto value = row.point.settings.find(key);
      out += "," + (value == row.point.settings.end() ? "" : report::csv_cell(plain_value(value->second)));
    }
    out += fmt::format(",{},{},{}", row.point.seed, status_name(row.status),
                       report::csv_cell(row.outcome.reason));
    for (const std::string& name : results) {
      const auto value = row.outcome.numbers.find(name);
      const bool known = value != row.outcome.numbers.end() && !std::isnan(value->second);
      out += "," + (known ? fmt::format("{}", value->second) : "");
    }
    out += "\r\n";
  }
  return out;
}

}  // namespace fringetwin::study
