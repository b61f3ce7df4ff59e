// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <locale>
#include <map>
#include <sstream>

#include "twin/base/errors.hpp"
#include "twin/mesh/mesh_file.hpp"

namespace fringetwin {
namespace {

class Body;
/// Reads a number of one PLY type from a binary body.
using ReadNumber = double (Body::*)();
/// Returns the reader of a type, "uchar" or "float32"; nullptr for a name that is no type.
ReadNumber reader_of(const std::string& type);

struct Property {
  std::string name;
  ReadNumber type = nullptr;
  ReadNumber list_count = nullptr;  ///< of the count where the property is a list
};
struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
  std::string fault;  ///< a property line that is not understood: fatal only where the element is read
};
enum class Encoding { ascii, little_endian, big_endian };
struct PlyHeader {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::size_t body = 0;  ///< offset of the first byte after end_header
};

class Refusal {
 public:
  explicit Refusal(const std::filesystem::path& file) : file_(file.string()) {}
  [[noreturn]] void operator()(const std::string& what, const std::string& hint = "") const {
    throw UserError(ExitCode::input, file_, what, hint);
  }

 private:
  std::string file_;
};

Encoding parse_encoding(const std::string& name, const Refusal& refuse) {
  if (name == "ascii") return Encoding::ascii;
  if (name == "binary_little_endian") return Encoding::little_endian;
  if (name == "binary_big_endian") return Encoding::big_endian;
  refuse(fmt::format("has the unknown PLY format \"{}\"", name));
}

/// Appends the property of a header line; a line that is not understood becomes the element's fault
/// (the Stanford bunny ends in an element whose properties have name and type swapped).
void parse_property(std::istringstream& words, const std::string& line, Element* element) {
  Property property;
  std::string type, count;
  words >> type;
  if (type == "list") {
    words >> count >> type;
    property.list_count = reader_of(count);
  }
  property.type = reader_of(type);
  if (!property.type || !(words >> property.name) || (!count.empty() && !property.list_count)) {
    element->fault = line;
    return;
  }
  element->properties.push_back(property);
}

PlyHeader parse_header(const std::string& bytes, const Refusal& refuse) {
  PlyHeader header;
  std::size_t position = 0;
  while (true) {
    const std::size_t end = bytes.find('\n', position);
    if (end == std::string::npos) refuse("is truncated (its PLY header has no end)");
    std::string line = bytes.substr(position, end - position);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    position = end + 1;
    std::istringstream words(line);
    words.imbue(std::locale::classic());
    std::string keyword, name;
    words >> keyword;
    if (keyword == "end_header") break;
    if (keyword == "format") {
      words >> name;
      header.encoding = parse_encoding(name, refuse);
    } else if (keyword == "element") {
      Element element;
      long long count = -1;
      if (!(words >> element.name >> count) || count < 0)
        refuse(fmt::format("has a bad PLY header line: \"{}\"", line));
      element.count = static_cast<std::size_t>(count);
      header.elements.push_back(element);
    } else if (keyword == "property") {
      if (header.elements.empty()) refuse("has a PLY property before any element");
      parse_property(words, line, &header.elements.back());
    } else if (keyword != "ply" && keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
      refuse(fmt::format("has a bad PLY header line: \"{}\"", line));
    }
  }
  header.body = position;
  return header;
}

/// Hands out the numbers of the body one by one; never reads beyond the end.
class Body {
 public:
  Body(const std::string& bytes, const PlyHeader& header, const Refusal& refuse)
      : bytes_(bytes), position_(header.body), encoding_(header.encoding), refuse_(refuse) {}

  /// What is being read, for messages.
  void at(const Element& element, std::size_t index) {
    element_ = &element;
    index_ = index;
  }
  std::string place() const { return fmt::format("{} {} of {}", element_->name, index_, element_->count); }
  std::size_t bytes_left() const { return bytes_.size() - position_; }

  double next(ReadNumber type) { return encoding_ == Encoding::ascii ? next_word() : (this->*type)(); }

  template <class T>
  double next_binary() {
    if (bytes_left() < sizeof(T)) truncated();
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    const bool file_is_little = encoding_ == Encoding::little_endian;
    if (file_is_little != (std::endian::native == std::endian::little)) std::ranges::reverse(raw);
    return static_cast<double>(std::bit_cast<T>(raw));
  }

  std::size_t next_list_size(ReadNumber type) {
    const double size = next(type);
    if (!(size >= 0.0) || size != std::floor(size))
      refuse_(fmt::format("has a bad list length {} in {}", size, place()));
    if (size > static_cast<double>(bytes_left())) truncated();
    return static_cast<std::size_t>(size);
  }

  [[noreturn]] void truncated() const { refuse_(fmt::format("is truncated (it ends in {})", place())); }

 private:
  double next_word() {
    while (position_ < bytes_.size() && std::isspace(static_cast<unsigned char>(bytes_[position_])) != 0)
      ++position_;
    std::size_t end = position_;
    while (end < bytes_.size() && std::isspace(static_cast<unsigned char>(bytes_[end])) == 0) ++end;
    if (position_ == end) truncated();
    const char* first = bytes_.data() + position_ + (bytes_[position_] == '+' ? 1 : 0);
    const char* last = bytes_.data() + end;
    double value = 0.0;
    const auto [stop, error] = std::from_chars(first, last, value);
    if (stop != last || (error != std::errc{} && error != std::errc::result_out_of_range))
      refuse_(fmt::format("has \"{}\" where a number is needed, in {}",
                          bytes_.substr(position_, std::min<std::size_t>(end - position_, 40)), place()));
    position_ = end;
    return value;
  }

  const std::string& bytes_;
  std::size_t position_;
  Encoding encoding_;
  const Refusal& refuse_;
  const Element* element_ = nullptr;
  std::size_t index_ = 0;
};

ReadNumber reader_of(const std::string& type) {
  static const std::map<std::string, ReadNumber> readers = {
      {"char", &Body::next_binary<std::int8_t>},     {"int8", &Body::next_binary<std::int8_t>},
      {"uchar", &Body::next_binary<std::uint8_t>},   {"uint8", &Body::next_binary<std::uint8_t>},
      {"short", &Body::next_binary<std::int16_t>},   {"int16", &Body::next_binary<std::int16_t>},
      {"ushort", &Body::next_binary<std::uint16_t>}, {"uint16", &Body::next_binary<std::uint16_t>},
      {"int", &Body::next_binary<std::int32_t>},     {"int32", &Body::next_binary<std::int32_t>},
      {"uint", &Body::next_binary<std::uint32_t>},   {"uint32", &Body::next_binary<std::uint32_t>},
      {"float", &Body::next_binary<float>},          {"float32", &Body::next_binary<float>},
      {"double", &Body::next_binary<double>},        {"float64", &Body::next_binary<double>}};
  const auto found = readers.find(type);
  return found == readers.end() ? nullptr : found->second;
}

void read_vertices(const Element& element, Body& body, RawMesh* mesh, const Refusal& refuse) {
  int axis_of[3] = {-1, -1, -1};
  bool has_albedo = false;
  for (std::size_t k = 0; k < element.properties.size(); ++k) {
    const std::string& name = element.properties[k].name;
    if (name == "x" || name == "y" || name == "z") axis_of[name[0] - 'x'] = static_cast<int>(k);
    has_albedo = has_albedo || name == "albedo";
  }
  if (axis_of[0] < 0 || axis_of[1] < 0 || axis_of[2] < 0) refuse("has no x, y and z in its PLY vertices");
  std::vector<double> values(element.properties.size());
  for (std::size_t i = 0; i < element.count; ++i) {
    body.at(element, i);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const Property& property = element.properties[k];
      if (!property.list_count) {
        values[k] = body.next(property.type);
        continue;
      }
      for (std::size_t n = body.next_list_size(property.list_count); n > 0; --n) body.next(property.type);
    }
    mesh->vertices.emplace_back(values[axis_of[0]], values[axis_of[1]], values[axis_of[2]]);
    if (!has_albedo) continue;
    for (std::size_t k = 0; k < values.size(); ++k)
      if (element.properties[k].name == "albedo") mesh->albedo.push_back(static_cast<float>(values[k]));
  }
}

void read_polygon(const Property& property, std::size_t n_vertices, Body& body, RawMesh* mesh,
                  const Refusal& refuse) {
  std::vector<int> corners(body.next_list_size(property.list_count));
  for (int& corner : corners) {
    const double index = body.next(property.type);
    if (!(index >= 0.0 && index < static_cast<double>(n_vertices)) || index != std::floor(index))
      refuse(fmt::format("{} names vertex {}, there are {}", body.place(), index, n_vertices));
    corner = static_cast<int>(index);
  }
  if (corners.size() < 3) ++mesh->other_faces;
  for (std::size_t k = 2; k < corners.size(); ++k)
    mesh->triangles.push_back({corners[0], corners[k - 1], corners[k]});
}

void read_other_element(const Element& element, std::size_t n_vertices, Body& body, RawMesh* mesh,
                        const Refusal& refuse) {
  for (std::size_t i = 0; i < element.count; ++i) {
    body.at(element, i);
    for (const Property& property : element.properties) {
      const bool polygon = element.name == "face" && property.list_count &&
                           (property.name == "vertex_indices" || property.name == "vertex_index");
      if (polygon)
        read_polygon(property, n_vertices, body, mesh, refuse);
      else
        for (std::size_t n = property.list_count ? body.next_list_size(property.list_count) : 1; n > 0; --n)
          body.next(property.type);
    }
  }
}

}  // namespace

RawMesh read_ply(const std::filesystem::path& file, const std::string& bytes) {
  const Refusal refuse(file);
  const PlyHeader header = parse_header(bytes, refuse);
  std::size_t n_vertices = 0;
  for (const Element& element : header.elements) {
    if (element.name == "vertex") n_vertices = element.count;
    // every entry takes a byte at least: no huge allocation for a damaged count
    if (element.name == "face" && n_vertices == 0) refuse("has no vertices before its faces");
    const bool has_body = !element.properties.empty() || element.name == "vertex";
    if (has_body && element.count > bytes.size() - header.body)
      refuse(fmt::format("is truncated (it announces {} of element {}, the file has {} bytes)", element.count,
                         element.name, bytes.size()));
  }
  RawMesh mesh;
  mesh.vertices.reserve(n_vertices);
  mesh.vertex_name = [](std::size_t i) { return fmt::format("vertex {}", i); };
  Body body(bytes, header, refuse);
  for (const Element& element : header.elements) {
    if (!element.fault.empty())
      refuse(fmt::format("has a PLY header line that is not understood: \"{}\"", element.fault));
    if (element.name == "vertex")
      read_vertices(element, body, &mesh, refuse);
    else
      read_other_element(element, n_vertices, body, &mesh, refuse);
    if (element.name == "face") break;  // what follows is of no use here
  }
  return mesh;
}

}  // namespace fringetwin
