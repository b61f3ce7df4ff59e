// SPDX-License-Identifier: Apache-2.0
#include "study/plan/result_names.hpp"

#include <set>

namespace fringetwin::study {

std::string plain_value(const std::string& toml) {
  const bool simple = toml.size() >= 2 && toml.front() == '"' && toml.back() == '"' &&
                      toml.find_first_of("\"\\", 1) == toml.size() - 1;
  return simple ? toml.substr(1, toml.size() - 2) : toml;
}

std::string display_name(const std::string& path) {
  const std::string start = "fits.", middle = ".measured.";
  const std::size_t at = path.find(middle);
  if (!path.starts_with(start) || at == std::string::npos) return path;
  return path.substr(start.size(), at - start.size()) + " " + path.substr(at + middle.size());
}

std::string unit_of(const std::string& path) {
  std::string last = path.substr(path.rfind('.') + 1);  // without a '.' the whole path
  last = last.substr(0, last.find('['));
  const std::size_t at = last.rfind('_');
  const std::string end = at == std::string::npos ? "" : last.substr(at + 1);
  static const std::set<std::string> units = {"mm", "rad", "px", "s", "ms", "deg"};
  return units.contains(end) ? end : end == "dn" ? "DN" : "";
}

}  // namespace fringetwin::study
