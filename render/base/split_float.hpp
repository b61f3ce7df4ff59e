// SPDX-License-Identifier: Apache-2.0
// Splits doubles for the shaders into a float and the rest that rounding to it left, together 48 bits.
#pragma once
#include <array>

#include "render/shaders/shared.h"

namespace fringetwin::render {

using Double4 = std::array<double, 4>;

/// Returns the four numbers rounded to single precision.
inline gpu::vec4 rounded(const Double4& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]),
          static_cast<float>(v[3])};
}
/// Returns the difference between the four numbers and rounded(), in single precision.
inline gpu::vec4 rest_of(const Double4& v) {
  const auto rest = [](double x) {
    return static_cast<float>(x - static_cast<double>(static_cast<float>(x)));
  };
  return {rest(v[0]), rest(v[1]), rest(v[2]), rest(v[3])};
}

/// The uniform block of the kernels: all parameters rounded, then their rests.
struct ParamsBlock {
  gpu::Params values, rest;
  /// Sets one vec4 of the parameters and of their rests.
  void set(gpu::vec4 gpu::Params::*member, const Double4& v) {
    values.*member = rounded(v);
    rest.*member = rest_of(v);
  }
};

}  // namespace fringetwin::render
