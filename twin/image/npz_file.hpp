// SPDX-License-Identifier: Apache-2.0
// Writes arrays as a .npz file, which numpy.load() reads: a ZIP archive, not compressed, of one .npy each.
#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "twin/image/image_io.hpp"

namespace fringetwin {

/// An array of a .npz file; refers to numbers that someone else keeps.
struct NpzArray {
  std::string name;                ///< plain ASCII, without an ending
  std::string type;                ///< as numpy writes it: "<f4"
  std::vector<std::size_t> shape;  ///< the last index runs fastest
  FileBytes values;
};

namespace npy {
template <class T>
inline constexpr const char* kType = nullptr;
template <>
inline constexpr const char* kType<float> = "<f4";
template <>
inline constexpr const char* kType<double> = "<f8";
template <>
inline constexpr const char* kType<unsigned char> = "|u1";
template <>
inline constexpr const char* kType<bool> = "|b1";
}  // namespace npy

/// Names numbers that lie in memory one after the other.
template <class T>
NpzArray npz_array(const std::string& name, std::vector<std::size_t> shape, std::span<const T> values) {
  static_assert(npy::kType<T> != nullptr, "a type of number that numpy has");
  return {name, npy::kType<T>, std::move(shape), std::as_bytes(values)};
}
/// The same of an image: (height, width).
template <class T>
NpzArray npz_array(const std::string& name, const Image<T>& image) {
  return npz_array(name, {static_cast<std::size_t>(image.height), static_cast<std::size_t>(image.width)},
                   std::span<const T>(image.data));
}

/// Writes the arrays, first under a temporary name. The archive has the 64-bit fields of ZIP throughout, so
/// neither an array nor the file has a limit of 4 GiB. Throws UserError(usage) where it cannot be written.
void write_npz(const std::filesystem::path& file, const std::vector<NpzArray>& arrays);

}  // namespace fringetwin
