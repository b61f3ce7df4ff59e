// SPDX-License-Identifier: Apache-2.0
#include "compare/run_page.hpp"

#include <vector>

namespace fringetwin::compare {
namespace fs = std::filesystem;

fs::path page_in(const fs::path& folder) {
  std::vector<const char*> names = {kRunPage, "index.html"};
  for (const OwnPage& page : kOwnPages) names.push_back(page.name);
  names.push_back(kUnfinishedStudyPage);
  std::error_code none;  // what cannot be looked at is not there
  for (const char* name : names)
    if (fs::exists(folder / name, none)) return folder / name;
  return {};
}

bool is_study_folder(const fs::path& folder) {
  std::error_code none;
  return fs::exists(folder / "study.db", none);
}

}  // namespace fringetwin::compare
