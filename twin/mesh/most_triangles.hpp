// SPDX-License-Identifier: Apache-2.0
// How large a mesh may be.
#pragma once
#include <cstddef>

namespace fringetwin {

/// More triangles cannot be traced: the renderer numbers them in floats.
inline constexpr std::size_t kMostTriangles = (1U << 24) - 1;

}  // namespace fringetwin
