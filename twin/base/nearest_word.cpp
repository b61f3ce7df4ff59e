// SPDX-License-Identifier: Apache-2.0
#include "twin/base/nearest_word.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace fringetwin {
namespace {

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

}  // namespace

const std::string* nearest(const std::string& word, const std::vector<std::string>& candidates) {
  // Names of ours have 100 characters at most: what is longer, or one of very many, was not mistyped.
  constexpr std::size_t kLongest = 200, kMostCandidates = 10'000;
  if (word.size() > kLongest || candidates.size() > kMostCandidates) return nullptr;
  const std::string* best = nullptr;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : candidates) {
    if (candidate.size() > kLongest) continue;
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance && 2 * distance <= std::max(word.size(), candidate.size())) {
      best = &candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates) {
  const std::string* close = nearest(word, candidates);
  return close != nullptr ? "did you mean \"" + *close + "\"?" : "";
}

}  // namespace fringetwin
