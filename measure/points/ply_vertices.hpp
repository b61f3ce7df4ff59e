// SPDX-License-Identifier: Apache-2.0
// Collects the properties of points and writes them as the vertices of a binary PLY file.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace fringetwin::measure {

/// What a name begins with so that CloudCompare shows the property as a scalar field without being asked.
inline constexpr const char* kScalarField = "scalar_";

/// The vertices of a PLY file, property by property.
class PlyVertices {
 public:
  explicit PlyVertices(std::size_t n) : n_(n) {}
  std::size_t size() const { return n_; }
  /// Appends a property whose value at a vertex is `value(vertex)`, asked for when the file is written, by
  /// several threads.
  void add_double(const std::string& name, std::function<double(std::size_t)> value);
  void add_float(const std::string& name, std::function<float(std::size_t)> value);
  void add_byte(const std::string& name, std::function<std::uint8_t(std::size_t)> value);
  /// Writes binary little-endian, first under a temporary name. `comment`: a line of the header.
  void write(const std::filesystem::path& file, const std::string& comment) const;

 private:
  struct Property {
    std::string type, name;
    std::size_t bytes;  ///< of a value
    /// Puts the values of the vertices first ... end - 1 into records of so many bytes, from `to` on.
    std::function<void(std::size_t first, std::size_t end, std::size_t record, char* to)> put;
  };
  template <class T>
  void append(const char* type, const std::string& name, std::function<T(std::size_t)> value);

  std::size_t n_;
  std::vector<Property> properties_;
};

}  // namespace fringetwin::measure
