// SPDX-License-Identifier: Apache-2.0
#include "measure/points/ply_vertices.hpp"

#include <bit>
#include <cstring>
#include <span>

#include "twin/base/errors.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::measure {

static_assert(std::endian::native == std::endian::little, "the PLY is written as it lies in memory");

template <class T>
void PlyVertices::append(const char* type, const std::string& name, const std::vector<T>& values) {
  FT_CHECK(values.size() == n_, "a property of a PLY has a value for each vertex");
  const auto* first = reinterpret_cast<const char*>(values.data());
  properties_.push_back({type, name, sizeof(T), {first, first + n_ * sizeof(T)}});
}

void PlyVertices::add(const std::string& name, const std::vector<double>& values) {
  append("double", name, values);
}
void PlyVertices::add(const std::string& name, const std::vector<float>& values) {
  append("float", name, values);
}
void PlyVertices::add(const std::string& name, const std::vector<std::uint8_t>& values) {
  append("uchar", name, values);
}

void PlyVertices::write(const std::filesystem::path& file, const std::string& comment) const {
  std::string head = "ply\nformat binary_little_endian 1.0\ncomment " + comment + "\nelement vertex " +
                     std::to_string(n_) + "\n";
  std::size_t record = 0;
  for (const Property& property : properties_) {
    head += "property " + property.type + " " + property.name + "\n";
    record += property.bytes;
  }
  head += "end_header\n";
  std::vector<char> body(n_ * record);
  std::size_t at = 0;
  for (const Property& property : properties_) {
    for (std::size_t i = 0; i < n_; ++i)
      std::memcpy(&body[i * record + at], &property.values[i * property.bytes], property.bytes);
    at += property.bytes;
  }
  write_whole_file(file, {std::as_bytes(std::span(head)), std::as_bytes(std::span(body))});
}

}  // namespace fringetwin::measure
