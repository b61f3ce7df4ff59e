// SPDX-License-Identifier: Apache-2.0
#include "measure/points/ply_vertices.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <span>
#include <utility>

#include "twin/image/image_io.hpp"

namespace fringetwin::measure {

static_assert(std::endian::native == std::endian::little, "the PLY is written as it lies in memory");

template <class T>
void PlyVertices::append(const char* type, const std::string& name, std::function<T(std::size_t)> value) {
  properties_.push_back(
      {type, name, sizeof(T),
       [value = std::move(value)](std::size_t first, std::size_t end, std::size_t record, char* to) {
         for (std::size_t i = first; i < end; ++i, to += record) {
           const T v = value(i);
           std::memcpy(to, &v, sizeof v);
         }
       }});
}

void PlyVertices::add_double(const std::string& name, std::function<double(std::size_t)> value) {
  append("double", name, std::move(value));
}
void PlyVertices::add_float(const std::string& name, std::function<float(std::size_t)> value) {
  append("float", name, std::move(value));
}
void PlyVertices::add_byte(const std::string& name, std::function<std::uint8_t(std::size_t)> value) {
  append("uchar", name, std::move(value));
}

void PlyVertices::write(const std::filesystem::path& file, const std::string& comment) const {
  constexpr std::size_t kAtATime = 1024;  // vertices, whose records stay in the cache
  std::string head = "ply\nformat binary_little_endian 1.0\ncomment " + comment + "\nelement vertex " +
                     std::to_string(n_) + "\n";
  std::size_t record = 0;
  for (const Property& property : properties_) {
    head += "property " + property.type + " " + property.name + "\n";
    record += property.bytes;
  }
  head += "end_header\n";
  std::vector<char> body(n_ * record);
#pragma omp parallel for schedule(static)
  for (std::size_t first = 0; first < n_; first += kAtATime) {
    const std::size_t end = std::min(n_, first + kAtATime);
    char* to = &body[first * record];
    for (const Property& property : properties_) {
      property.put(first, end, record, to);
      to += property.bytes;
    }
  }
  write_whole_file(file, {std::as_bytes(std::span(head)), std::as_bytes(std::span(body))});
}

}  // namespace fringetwin::measure
