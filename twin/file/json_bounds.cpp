// SPDX-License-Identifier: Apache-2.0
#include "twin/file/json_bounds.hpp"

#include <fmt/format.h>

#include "twin/base/safe_file.hpp"

namespace fringetwin {
namespace {

// Ours stand 8 deep; whoever walks along a value goes down by recursion.
constexpr std::size_t kDeepestJson = 64;
// A covariance of 500 parameters has 250,000. The library takes up to 240 bytes and 3 us for each.
constexpr double kMostJsonValues = 1e6;

}  // namespace

std::string json_excess(std::string_view text) {
  const double most = kMostJsonValues * file_limits_factor();
  std::size_t depth = 0, values = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"')
      for (++i; i < text.size() && text[i] != '"'; ++i) i += text[i] == '\\' ? 1u : 0u;
    const bool opens = c == '[' || c == '{';
    if (opens && ++depth > kDeepestJson)
      return fmt::format("lists or tables stand more than {} deep in each other", kDeepestJson);
    if ((c == ']' || c == '}') && depth > 0) --depth;
    values += opens || c == ',' ? 1u : 0u;
    if (static_cast<double>(values) > most)
      return fmt::format("has more than {:.0f} values (--limits 10 reads ten times as many)", most);
  }
  return "";
}

}  // namespace fringetwin
