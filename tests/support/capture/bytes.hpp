// SPDX-License-Identifier: Apache-2.0
// Bytes as a camera sends them, written by hand.
#pragma once
#include <cstddef>
#include <initializer_list>
#include <vector>

namespace fringetwin::testing {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of(std::initializer_list<int> values) {
  Bytes bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

}  // namespace fringetwin::testing
