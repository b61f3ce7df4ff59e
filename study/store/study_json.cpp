// SPDX-License-Identifier: Apache-2.0
// Writes the table of a study as JSON.
#include "report/json.hpp"
#include "study/plan/recorded_numbers.hpp"
#include "study/store/study_store.hpp"

namespace fringetwin::study {

std::string study_table_json(const std::vector<StoredPoint>& rows) {
  report::Json points = report::Json::array();
  for (const StoredPoint& row : rows) {
    report::Json settings = report::Json::object(), results = report::Json::object();
    for (const auto& [key, toml] : row.point.settings) settings[key] = plain_value(toml);
    for (const auto& [name, value] : row.outcome.numbers) results[name] = report::json_number(value);
    points.push_back({{"id", row.point.id},
                      {"settings", settings},
                      {"noise_seed", row.point.seed},
                      {"status", status_name(row.status)},
                      {"reason", row.outcome.reason},
                      {"results", results}});
  }
  const report::Json table = {{"schema", "fringetwin-study-table/1"}, {"points", points}};
  return table.dump(2, ' ', false, report::Json::error_handler_t::replace) + "\n";
}

}  // namespace fringetwin::study
