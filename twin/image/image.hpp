// SPDX-License-Identifier: Apache-2.0
// A single-channel image in memory, row by row without gaps.
#pragma once
#include <cstddef>
#include <vector>

namespace fringetwin {

/// Row-major, no padding; (0,0) is the top-left pixel, whose CENTRE is the coordinate origin.
template <class T>
struct Image {
  int width = 0;
  int height = 0;
  std::vector<T> data;

  Image() = default;
  Image(int w, int h, T fill = T{}) : width(w), height(h), data(static_cast<std::size_t>(w) * h, fill) {}

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
  T& operator()(int x, int y) { return data[index(x, y)]; }
  const T& operator()(int x, int y) const { return data[index(x, y)]; }
  /// The i-th value in the order of the rows, as GrayImage has it.
  T operator[](std::size_t i) const { return data[i]; }
  std::size_t size() const { return data.size(); }
  bool empty() const { return data.empty(); }
  template <class Other>
  bool same_size(const Other& o) const {
    return width == o.width && height == o.height;
  }
};

using ImageF = Image<float>;
using ImageD = Image<double>;
using ImageU8 = Image<unsigned char>;

}  // namespace fringetwin
