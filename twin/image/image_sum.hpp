// SPDX-License-Identifier: Apache-2.0
// An image that is a sum of others, pixel by pixel: all phase steps of a pitch are such sums of the same
// four.
#pragma once
#include <cstddef>
#include <memory>

namespace fringetwin {

/// Its value at pixel i is (constant + of_mean mean + of_cosine cosine - of_sine sine + more_constant
/// constant) factor, of the pixel's values, computed in this order in single precision.
struct ImageSum {
  std::shared_ptr<const void> owner = {};  ///< of the images, all of one size
  const float *constant = nullptr, *mean = nullptr, *cosine = nullptr, *sine = nullptr;
  float of_mean = 0.0F, of_cosine = 0.0F, of_sine = 0.0F, more_constant = 0.0F;
  const float* factor = nullptr;                  ///< null: 1 everywhere
  std::shared_ptr<const void> factor_owner = {};  ///< of that image

  float operator[](std::size_t i) const {
    float value = constant[i] + of_mean * mean[i] + of_cosine * cosine[i] - of_sine * sine[i];
    if (more_constant != 0.0F) value += more_constant * constant[i];
    return factor ? value * factor[i] : value;
  }
  /// Computes n values from `first` on.
  void compute(std::size_t first, std::size_t n, float* out) const {
    const float *a = constant + first, *m = mean + first, *c = cosine + first, *s = sine + first;
    for (std::size_t i = 0; i < n; ++i) out[i] = a[i] + of_mean * m[i] + of_cosine * c[i] - of_sine * s[i];
    if (more_constant != 0.0F)
      for (std::size_t i = 0; i < n; ++i) out[i] += more_constant * a[i];
    if (factor)
      for (std::size_t i = 0; i < n; ++i) out[i] *= factor[first + i];
  }
};

}  // namespace fringetwin
