// SPDX-License-Identifier: Apache-2.0
#include "study/plan/study_head.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "twin/base/sha256.hpp"

namespace fringetwin::study {

std::string StudyIdentity::digest() const {
  std::vector<std::string> parts;
  for (const auto& [file, sha256] : inputs) parts.push_back(sha256);
  std::ranges::sort(parts);
  return sha256_of_text(fmt::format("{}\n{}", study, fmt::join(parts, "\n")));
}

}  // namespace fringetwin::study
