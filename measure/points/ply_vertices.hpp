// SPDX-License-Identifier: Apache-2.0
// Collects the properties of points and writes them as the vertices of a binary PLY file.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
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
  /// Appends a property; its values are those of the vertices in their order.
  void add(const std::string& name, const std::vector<double>& values);
  void add(const std::string& name, const std::vector<float>& values);
  void add(const std::string& name, const std::vector<std::uint8_t>& values);
  /// Writes binary little-endian, first under a temporary name. `comment`: a line of the header.
  void write(const std::filesystem::path& file, const std::string& comment) const;

 private:
  struct Property {
    std::string type, name;
    std::size_t bytes;         ///< of a value
    std::vector<char> values;  ///< one after the other
  };
  template <class T>
  void append(const char* type, const std::string& name, const std::vector<T>& values);

  std::size_t n_;
  std::vector<Property> properties_;
};

}  // namespace fringetwin::measure
