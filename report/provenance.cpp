// SPDX-License-Identifier: Apache-2.0
#include "report/provenance.hpp"

#include <fmt/format.h>

#include "report/table.hpp"

namespace fringetwin::report {

std::string provenance_html(const Facts& facts) {
  Table table;
  table.columns = {text_column("provenance"), text_column("")};
  for (const auto& [name, value] : facts) table.add_row({name, value});
  return table.html();
}

std::string provenance_html(const Facts& facts, const std::map<std::string, std::string>& inputs_sha256) {
  Table files;
  files.columns = {text_column("input file"), text_column("SHA-256")};
  for (const auto& [file, digest] : inputs_sha256) files.add_row({file, digest});
  return provenance_html(facts) +
         fmt::format("<details><summary>{} input files with their SHA-256</summary>{}</details>",
                     inputs_sha256.size(), files.html());
}

}  // namespace fringetwin::report
