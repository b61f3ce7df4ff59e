// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <set>

#include "twin/base/plain_text.hpp"
#include "twin/mesh/mesh_file.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin {
namespace {

// Headers of scanners and modellers have a few KB, 16 bytes a property.
constexpr std::size_t kMostPlyHeader = 1 << 20;

class Body;
/// A type of number, "uchar" or "float32": how a binary body's is read, and how many bytes it takes.
struct NumberType {
  double (Body::*read)();
  std::size_t bytes;
};
/// Returns the type of a name; nullptr for a name that is no type.
const NumberType* number_type(std::string_view name);

struct Property {
  std::string name;
  const NumberType* type = nullptr;
  const NumberType* list_count = nullptr;  ///< of the count where the property is a list
};
struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
  std::string fault;  ///< a property line that is not understood: fatal only where the element is read

  const Property* find(std::string_view property) const {
    const auto found = std::ranges::find(properties, property, &Property::name);
    return found == properties.end() ? nullptr : &*found;
  }
};
enum class Encoding { ascii, little_endian, big_endian };

/// The lines before the numbers.
class PlyHeader {
 public:
  PlyHeader(std::string_view bytes, const MeshRefusal& refuse)
      : text_(bytes.substr(0, kMostPlyHeader)), refuse_(refuse) {
    while (take_line()) {
      if (text_.skip_line()) continue;
      if (bytes.size() <= kMostPlyHeader) refuse_("is truncated (its PLY header has no end)");
      refuse_(fmt::format("has a PLY header of more than {} bytes", kMostPlyHeader));
    }
    if (!text_.skip_line()) refuse_("is truncated (its PLY header has no end)");
    body = text_.position();
  }

  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::size_t body = 0;  ///< offset of the first byte after end_header

 private:
  /// Takes the line's words; false at the last line.
  bool take_line() {
    const std::string_view keyword = text_.next_word_in_line();
    if (keyword == "end_header") return false;
    if (keyword == "format")
      take_format();
    else if (keyword == "element")
      take_element();
    else if (keyword == "property")
      take_property();
    else if (keyword != "ply" && keyword != "comment" && keyword != "obj_info" && !keyword.empty())
      refuse_(fmt::format("has a bad PLY header line {}: {}", text_.line(), quoted_excerpt(keyword)));
    return true;
  }

  void take_format() {
    const std::string_view name = text_.next_word_in_line();
    if (has_format_) refuse_("has two format lines in its PLY header");
    has_format_ = true;
    if (name == "binary_little_endian")
      encoding = Encoding::little_endian;
    else if (name == "binary_big_endian")
      encoding = Encoding::big_endian;
    else if (name != "ascii")
      refuse_(fmt::format("has the unknown PLY format {}", quoted_excerpt(name)));
  }

  void take_element() {
    Element element;
    element.name = text_.next_word_in_line();
    const std::string_view count = text_.next_word_in_line();
    const auto number = parse_number<std::size_t>(count);
    if (!number)
      refuse_(fmt::format("has a bad PLY header line {}: {} is no count of element {}", text_.line(),
                          quoted_excerpt(count), quoted_excerpt(element.name)));
    // Twice "vertex" would bound the faces' vertices by one and hold those of both.
    if (!element_names_.insert(element.name).second)
      refuse_(fmt::format("has two elements {} in its PLY header", quoted_excerpt(element.name)));
    element.count = *number;
    elements.push_back(element);
    property_names_.clear();
  }

  /// Appends a property; a line that is not understood becomes the element's fault (the Stanford bunny ends
  /// in an element whose properties have name and type swapped).
  void take_property() {
    if (elements.empty()) refuse_("has a PLY property before any element");
    Element& element = elements.back();
    Property property;
    std::string_view type = text_.next_word_in_line();
    const bool list = type == "list";
    if (list) {
      property.list_count = number_type(text_.next_word_in_line());
      type = text_.next_word_in_line();
    }
    property.type = number_type(type);
    property.name = text_.next_word_in_line();
    if (!property.type || property.name.empty() || (list && !property.list_count)) {
      if (element.fault.empty())
        element.fault = fmt::format("line {}, property {}", text_.line(), quoted_excerpt(property.name));
      return;
    }
    if (!property_names_.insert(property.name).second)
      refuse_(fmt::format("has two properties {} in element {} of its PLY header",
                          quoted_excerpt(property.name), quoted_excerpt(element.name)));
    element.properties.push_back(property);
  }

  MeshText text_;
  const MeshRefusal& refuse_;
  bool has_format_ = false;
  std::set<std::string> element_names_, property_names_;
};

/// Hands out the numbers of the body one by one; never reads beyond the end.
class Body {
 public:
  Body(const std::string& bytes, const PlyHeader& header, const MeshRefusal& refuse)
      : bytes_(bytes),
        position_(header.body),
        text_(bytes, header.body),
        encoding_(header.encoding),
        refuse_(refuse) {}

  /// What is being read, for messages.
  void at(const Element& element, std::size_t index) {
    throw_if_cancelled();
    element_ = &element;
    index_ = index;
  }
  std::string place() const {
    return fmt::format("{} {} of {}", std::string_view(element_->name).substr(0, 40), index_,
                       element_->count);
  }

  double next(const NumberType& type) {
    return encoding_ == Encoding::ascii ? next_word() : (this->*type.read)();
  }

  template <class T>
  double next_binary() {
    if (bytes_.size() - position_ < sizeof(T)) truncated();
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    const bool file_is_little = encoding_ == Encoding::little_endian;
    if (file_is_little != (std::endian::native == std::endian::little)) std::ranges::reverse(raw);
    return static_cast<double>(std::bit_cast<T>(raw));
  }

  /// Returns how many numbers of the property follow: 1, or the size of its list.
  std::size_t next_size(const Property& property) {
    if (!property.list_count) return 1;
    const double size = next(*property.list_count);
    if (!(size >= 0.0) || size != std::floor(size))
      refuse_(fmt::format("has a bad list length {} in {}", size, place()));
    if (size > static_cast<double>(bytes_.size())) truncated();
    return static_cast<std::size_t>(size);
  }

  void skip(const Property& property) {
    for (std::size_t n = next_size(property); n > 0; --n) {
      heed_cancel(n);
      next(*property.type);
    }
  }

 private:
  [[noreturn]] void truncated() const { refuse_(fmt::format("is truncated (it ends in {})", place())); }

  double next_word() {
    const std::string_view word = text_.next_word();
    if (word.empty()) truncated();
    const std::optional<double> number = mesh_number(word);
    if (!number)
      refuse_(fmt::format("has {} where a number is needed, in {}", quoted_excerpt(word), place()));
    return *number;
  }

  const std::string& bytes_;
  std::size_t position_;  ///< in a binary body
  MeshText text_;
  Encoding encoding_;
  const MeshRefusal& refuse_;
  const Element* element_ = nullptr;
  std::size_t index_ = 0;
};

template <class T>
constexpr NumberType kNumber{&Body::next_binary<T>, sizeof(T)};

const NumberType* number_type(std::string_view name) {
  static const std::map<std::string_view, const NumberType*> types = {
      {"char", &kNumber<std::int8_t>},     {"int8", &kNumber<std::int8_t>},
      {"uchar", &kNumber<std::uint8_t>},   {"uint8", &kNumber<std::uint8_t>},
      {"short", &kNumber<std::int16_t>},   {"int16", &kNumber<std::int16_t>},
      {"ushort", &kNumber<std::uint16_t>}, {"uint16", &kNumber<std::uint16_t>},
      {"int", &kNumber<std::int32_t>},     {"int32", &kNumber<std::int32_t>},
      {"uint", &kNumber<std::uint32_t>},   {"uint32", &kNumber<std::uint32_t>},
      {"float", &kNumber<float>},          {"float32", &kNumber<float>},
      {"double", &kNumber<double>},        {"float64", &kNumber<double>}};
  const auto found = types.find(name);
  return found == types.end() ? nullptr : found->second;
}

/// Refuses a count that the file is too short for, before anything is allocated or read for it.
void check_announced(const Element& element, const PlyHeader& header, std::uintmax_t file_bytes,
                     const MeshRefusal& refuse) {
  std::size_t entry = 0;  // bytes at least: each list may be empty, each number be one digit and a blank
  for (const Property& property : element.properties)
    entry += header.encoding == Encoding::ascii ? 2
             : property.list_count              ? property.list_count->bytes
                                                : property.type->bytes;
  // The last number of a text needs no blank.
  if (entry > 0 && element.count > (file_bytes - header.body + 1) / entry)
    refuse(fmt::format("is truncated (it announces {} of element {}, the file has {} bytes)", element.count,
                       quoted_excerpt(element.name), file_bytes));
}

/// Returns the place of a property among the vertex's; -1 without it.
int place_of(const char* name, const Element& element, const MeshRefusal& refuse) {
  const Property* property = element.find(name);
  if (!property) return -1;
  if (property->list_count) refuse(fmt::format("has a list where a vertex has its {}", name));
  return static_cast<int>(property - element.properties.data());
}

struct VertexPlaces {
  VertexPlaces(const Element& element, const MeshRefusal& refuse)
      : x(place_of("x", element, refuse)),
        y(place_of("y", element, refuse)),
        z(place_of("z", element, refuse)),
        albedo(place_of("albedo", element, refuse)) {
    if (x < 0 || y < 0 || z < 0) refuse("has no x, y and z in its PLY vertices");
  }
  int x, y, z, albedo;
};

/// Returns a face's list of vertices; nullptr for any other element.
const Property* polygon_of(const Element& element, const MeshRefusal& refuse) {
  if (element.name != "face") return nullptr;
  const Property* polygon = element.find("vertex_indices");
  if (!polygon) polygon = element.find("vertex_index");
  if (polygon && !polygon->list_count) refuse("has no list of vertices in its PLY faces");
  return polygon;
}

/// Refuses what nothing in the body could mend.
void check_header(const PlyHeader& header, std::uintmax_t file_bytes, const MeshRefusal& refuse) {
  for (const Element& element : header.elements) check_announced(element, header, file_bytes, refuse);
  std::size_t vertices = 0;
  for (const Element& element : header.elements) {
    if (!element.fault.empty())
      refuse(fmt::format("has a PLY header line that is not understood: {}", element.fault));
    if (element.name == "vertex") {
      const VertexPlaces all_there(element, refuse);
      check_vertex_count(element.count, refuse);
      vertices = element.count;
    }
    if (element.name != "face") continue;
    if (vertices == 0) refuse("has no vertices before its faces");
    polygon_of(element, refuse);
    return;  // what follows is of no use here
  }
}

void read_vertices(const Element& element, Body& body, RawMesh* mesh) {
  const auto [x, y, z, albedo] = VertexPlaces(element, mesh->refuse);
  mesh->expect_vertices(element.count);
  std::vector<double> values(element.properties.size());
  for (std::size_t i = 0; i < element.count; ++i) {
    body.at(element, i);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const Property& property = element.properties[k];
      if (property.list_count)
        body.skip(property);
      else
        values[k] = body.next(*property.type);
    }
    mesh->add_vertex({values[x], values[y], values[z]});
    if (albedo < 0) continue;
    if (!(values[albedo] >= 0.0 && values[albedo] <= 1.0))
      mesh->refuse(fmt::format("{} has the albedo {}, a factor between 0 and 1 is needed", body.place(),
                               values[albedo]),
                   values[albedo] > 1.0 ? "divide all by the largest, and put that into the object's diffuse"
                                        : "mend the mesh");
    mesh->albedo.push_back(static_cast<float>(values[albedo]));
  }
}

void read_polygon(const Property& property, Body& body, std::vector<int>* corners, RawMesh* mesh) {
  const std::size_t n_vertices = mesh->vertices.size();
  corners->clear();
  for (std::size_t n = body.next_size(property); n > 0; --n) {
    heed_cancel(n);
    const double index = body.next(*property.type);
    if (!(index >= 0.0 && index < static_cast<double>(n_vertices)) || index != std::floor(index))
      mesh->refuse(fmt::format("{} names vertex {}, there are {}", body.place(), index, n_vertices));
    corners->push_back(static_cast<int>(index));
  }
  mesh->add_polygon(*corners);
}

/// Reads the polygons of the faces; of any other element nothing.
void read_other_element(const Element& element, Body& body, RawMesh* mesh) {
  if (element.properties.empty()) return;  // it takes no byte, whatever its count is
  const Property* polygon = polygon_of(element, mesh->refuse);
  std::vector<int> corners;
  for (std::size_t i = 0; i < element.count; ++i) {
    body.at(element, i);
    for (const Property& property : element.properties) {
      if (&property == polygon)
        read_polygon(property, body, &corners, mesh);
      else
        body.skip(property);
    }
  }
}

}  // namespace

void check_ply_header(const std::filesystem::path& file, const MeshStart& start) {
  const MeshRefusal refuse(file);
  check_header(PlyHeader(start.bytes, refuse), start.file_bytes, refuse);
}

RawMesh read_ply(const std::filesystem::path& file, const std::string& bytes) {
  RawMesh mesh(file);
  const PlyHeader header(bytes, mesh.refuse);
  mesh.vertex_name = [](std::size_t i) { return fmt::format("vertex {}", i); };
  Body body(bytes, header, mesh.refuse);
  for (const Element& element : header.elements) {
    if (element.name == "vertex")
      read_vertices(element, body, &mesh);
    else
      read_other_element(element, body, &mesh);
    if (element.name == "face") break;
  }
  return mesh;
}

}  // namespace fringetwin
