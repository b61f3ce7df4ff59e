// SPDX-License-Identifier: Apache-2.0
#include "report/json_file.hpp"

#include "twin/file/json_bounds.hpp"

namespace fringetwin::report {

nlohmann::json read_json_file(const std::filesystem::path& file, const FileUse& use) {
  const std::string text = read_whole_text(file, use);
  if (const std::string excess = json_excess(text); !excess.empty())
    throw UserError(use.code, file.string(), excess);
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    throw UserError(use.code, file.string(), std::string("this is no JSON: ") + error.what(),
                    "run the command that wrote it again");
  }
}

}  // namespace fringetwin::report
