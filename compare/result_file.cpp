// SPDX-License-Identifier: Apache-2.0
#include "compare/result_file.hpp"

#include "report/json_file.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {

ResultFile read_result_file(const std::filesystem::path& path) {
  const std::filesystem::path file = std::filesystem::is_directory(path) ? path / "result.json" : path;
  ResultFile result{file,
                    report::read_json_file(
                        file, {.what = "result", .hint = "give the folder of a run, or its result.json"})};
  const nlohmann::json& json = result.json;
  if (!json.is_object() || !json.contains("schema") || json["schema"] != "fringetwin-result/1")
    throw UserError(ExitCode::input, file.string(),
                    "this is no fringetwin result (schema fringetwin-result/1)",
                    "give a result.json of cosim, compare or measure");
  return result;
}

}  // namespace fringetwin::compare
