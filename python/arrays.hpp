// SPDX-License-Identifier: Apache-2.0
// Shows images and columns of numbers to numpy without copying them: an array keeps the object that owns its
// memory alive.
#pragma once
#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "twin/base/errors.hpp"
#include "twin/image/gray_image.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::python {
namespace py = pybind11;

/// Returns an array (height, width) over the image's own memory. `owner`: the Python object that holds it.
template <class T>
py::array_t<T> array_over(Image<T>& image, const py::object& owner) {
  return py::array_t<T>({image.height, image.width}, image.data.data(), owner);
}

/// Returns the same over an image that keeps its values as floats.
inline py::array_t<float> array_over(GrayImage& image, const py::object& owner) {
  FT_CHECK(image.bytes() == sizeof(float) * image.size(), "floats: nothing is converted below an array");
  return py::array_t<float>({image.height, image.width}, image.as_floats().data(), owner);
}

/// Returns an array (n, N) over a column of vectors of N numbers.
template <class T, int N>
py::array_t<T> array_over(std::vector<Eigen::Matrix<T, N, 1>>& column, const py::object& owner) {
  static_assert(sizeof(Eigen::Matrix<T, N, 1>) == N * sizeof(T), "vectors lie without gaps");
  return py::array_t<T>({static_cast<py::ssize_t>(column.size()), py::ssize_t{N}},
                        reinterpret_cast<T*>(column.data()), owner);
}

/// Returns an array (n) over a column of numbers.
template <class T>
py::array_t<T> array_over(std::vector<T>& column, const py::object& owner) {
  return py::array_t<T>({static_cast<py::ssize_t>(column.size())}, column.data(), owner);
}

/// Returns an array (height, width) that takes the image over.
template <class T>
py::array_t<T> array_of(Image<T>&& image) {
  auto* kept = new Image<T>(std::move(image));
  const py::capsule owner(kept, [](void* p) { delete static_cast<Image<T>*>(p); });
  return array_over(*kept, owner);
}

}  // namespace fringetwin::python
