// SPDX-License-Identifier: Apache-2.0
// Packs arrays as mrcal keeps its optimization_inputs: numpy's .npz in memory, as Python's base85 text.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace fringetwin::calib {

/// A zip archive of .npy arrays, deflated; as numpy.savez_compressed writes it.
class NpzWriter {
 public:
  /// Row-major; shape {} is a scalar.
  void add(const std::string& key, std::span<const double> values, const std::vector<std::size_t>& shape);
  void add(const std::string& key, std::span<const std::int32_t> values,
           const std::vector<std::size_t>& shape);
  void add(const std::string& key, bool value);
  void add(const std::string& key, double value);
  /// ASCII; an empty text stands for None in mrcal.
  void add(const std::string& key, const std::string& text);
  std::string bytes() const;

 private:
  void add_raw(const std::string& key, const std::string& descr, const std::vector<std::size_t>& shape,
               const void* data, std::size_t n_bytes);
  struct Entry {
    std::string name, deflated;
    std::uint32_t crc = 0, size = 0;
  };
  std::vector<Entry> entries_;
};

/// base64.b85encode() of Python (the alphabet of git, RFC 1924's order), without padding.
std::string base85(const std::string& bytes);

}  // namespace fringetwin::calib
