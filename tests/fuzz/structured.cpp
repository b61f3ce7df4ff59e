// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/structured.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <vector>

#include "tests/fuzz/mutate.hpp"

namespace fringetwin::fuzz {
namespace {

using Lines = std::vector<std::string>;

// ---- TOML

/// Where the key of a line ends; npos for a line that sets none.
std::size_t end_of_key(const std::string& line) {
  const std::size_t equals = line.find('=');
  return equals == std::string::npos || line[0] == '#' || line[0] == '['
             ? std::string::npos
             : line.find_last_not_of(' ', equals - 1) + 1;
}

std::string other_key(const std::string& key, const Lines& lines, Random& random) {
  const std::string& line = random.of(lines);
  const std::size_t end = end_of_key(line);
  const std::string other = end == std::string::npos ? "x" : line.substr(0, end);
  switch (random.below(6)) {
    case 0:
      return other;
    case 1:
      return key + "." + other;
    case 2:
      return "\"" + key + "\"";
    case 3:
      return "\"\"";
    case 4: {
      std::string dotted = key;
      for (std::size_t n = random.one_in(8) ? 20000 : random.below(40); n > 0; --n) dotted += ".a";
      return dotted;
    }
    default:
      return key + key.back();
  }
}

/// [a] -> [[a]], [a.b], [a.a.a...], and the other way round.
std::string other_header(const std::string& line, Random& random) {
  const std::size_t end = line.find_last_of(']');
  if (end == std::string::npos) return line;
  switch (random.below(3)) {
    case 0:
      return line.rfind("[[", 0) == 0 && end > 1 ? line.substr(1, end - 1) + "\n"
                                                 : "[" + line.substr(0, end + 1) + "]\n";
    case 1:
      return line.substr(0, line.find(']')) + ".x" + line.substr(line.find(']'));
    default:
      return line + line;
  }
}

/// Puts a table into arrays or inline tables, some or many levels deep.
std::string nested(const std::string& line, std::size_t end, Random& random) {
  const std::size_t depth = random.one_in(8) ? 30000 : 1 + random.below(40);
  const bool arrays = random.one_in(2);
  std::string open, close;
  for (std::size_t i = 0; i < depth; ++i) {
    open += arrays ? "[" : "{a=";
    close += arrays ? "]" : "}";
  }
  std::string value = line.substr(std::min(line.size(), line.find('=', end) + 1));
  if (!value.empty() && value.back() == '\n') value.pop_back();
  return line.substr(0, end) + " = " + open + value + close + "\n";
}

// ---- PLY

const std::array<const char*, 9> kPlyTypes = {"char", "uchar", "short",  "ushort", "int",
                                              "uint", "float", "double", "float64"};

std::string ply_property(Random& random) {
  static const std::array<const char*, 8> kNames = {
      "x", "y", "z", "albedo", "vertex_indices", "vertex_index", "nx", "red"};
  return random.one_in(3) ? fmt::format("property list {} {} {}\n", random.of(kPlyTypes),
                                        random.of(kPlyTypes), random.of(kNames))
                          : fmt::format("property {} {}\n", random.of(kPlyTypes), random.of(kNames));
}

std::string ply_element(Random& random) {
  static const std::array<const char*, 4> kNames = {"vertex", "face", "edge", "x"};
  const std::string count = random.one_in(2) ? std::to_string(random.below(6)) : extreme_number(random);
  return fmt::format("element {} {}\n", random.of(kNames), count);
}

std::string change_ply_line(const std::string& line, Random& random) {
  if (line.rfind("element", 0) == 0) return ply_element(random);
  if (line.rfind("property", 0) == 0) return ply_property(random);
  if (line.rfind("format", 0) == 0) {
    static const std::array<const char*, 3> kFormats = {"ascii", "binary_little_endian", "binary_big_endian"};
    return fmt::format("format {} 1.0\n", random.of(kFormats));
  }
  return line;
}

// ---- PNG

struct Chunk {
  std::string type, data;
};

std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = (value << 8) | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(value >> shift));
  return bytes;
}

constexpr std::size_t kPngSignature = 8;

std::vector<Chunk> chunks_of(const std::string& png) {
  std::vector<Chunk> chunks;
  for (std::size_t at = kPngSignature; at + 12 <= png.size();) {
    const std::size_t size = big_endian(png, at);
    if (size > png.size() - at - 12) break;
    chunks.push_back({png.substr(at + 4, 4), png.substr(at + 8, size)});
    at += 12 + size;
  }
  return chunks;
}

std::string png_of(const std::string& signature, const std::vector<Chunk>& chunks) {
  std::string png = signature;
  for (const Chunk& chunk : chunks) {
    const std::string checked = chunk.type + chunk.data;
    png += big_endian(static_cast<std::uint32_t>(chunk.data.size())) + checked;
    png += big_endian(static_cast<std::uint32_t>(
        ::crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()))));
  }
  return png;
}

/// The rows of an image, other bytes, compressed anew.
std::string other_rows(Random& random) {
  std::string rows(random.below(4096), '\0');
  for (char& c : rows) c = static_cast<char>(random.below(7));
  uLongf size = ::compressBound(static_cast<uLong>(rows.size()));
  std::string out(size, '\0');
  ::compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
             static_cast<uLong>(rows.size()));
  out.resize(size);
  return out;
}

void change_header(std::string& data, Random& random) {
  if (data.size() < 13) return;
  if (random.one_in(2)) {  // width or height
    data.replace(random.one_in(2) ? 0 : 4, 4, big_endian(static_cast<std::uint32_t>(extreme_bits(random))));
  } else {  // bits, colour, compression, filter, interlace
    static const std::array<char, 6> kFields = {0, 1, 2, 4, 8, 16};
    data[8 + random.below(5)] = random.of(kFields);
  }
}

void change_chunks(std::vector<Chunk>& chunks, Random& random) {
  static const std::array<const char*, 8> kTypes = {"PLTE", "tRNS", "gAMA", "IDAT",
                                                    "iCCP", "zTXt", "sBIT", "IEND"};
  Chunk& chunk = random.of(chunks);
  switch (random.below(6)) {
    case 0:
      change_header(chunks.front().data, random);
      break;
    case 1:
      chunk.data = mutate_bytes(chunk.data, random);
      break;
    case 2:
      chunk.data = other_rows(random);
      break;
    case 3:
      chunk.type = random.of(kTypes);
      break;
    case 4:
      chunks.push_back(Chunk(chunk));
      std::swap(chunks.back(), random.of(chunks));
      break;
    default:
      std::swap(chunk, chunks.back());
      chunks.pop_back();
  }
}

}  // namespace

std::string mutate_toml(const std::string& input, Random& random) {
  Lines lines = split_lines(input);
  if (lines.empty() || random.one_in(2)) return mutate_text(input, random);
  std::string& line = random.of(lines);
  const std::size_t end = end_of_key(line);
  if (line[0] == '[')
    line = other_header(line, random);
  else if (end == std::string::npos || end == 0)
    return mutate_text(input, random);
  else
    line = random.one_in(3) ? nested(line, end, random)
                            : other_key(line.substr(0, end), lines, random) + line.substr(end);
  std::string text = joined(lines);
  if (text.size() > kLargestInput) text.resize(kLargestInput);
  return text;
}

std::string mutate_ply(const std::string& input, Random& random) {
  const std::size_t end = input.find("end_header");
  if (end == std::string::npos) return mutate_bytes(input, random);
  Lines header = split_lines(input.substr(0, end));
  if (header.size() < 2) return mutate_bytes(input, random);
  const std::size_t at = 1 + random.below(header.size() - 1);
  const auto place = header.begin() + static_cast<std::ptrdiff_t>(at);
  switch (random.below(5)) {
    case 0:
      header.erase(place);
      break;
    case 1:
      header.insert(place, ply_element(random));
      break;
    case 2:
      header.insert(place, ply_property(random));
      break;
    case 3:
      std::swap(header[at], header[1 + random.below(header.size() - 1)]);
      break;
    default:
      header[at] = change_ply_line(header[at], random);
  }
  return joined(header) + (random.one_in(4) ? mutate_text(input.substr(end), random) : input.substr(end));
}

std::string lens_name(Random& random) {
  static const std::array<const char*, 14> kNames = {"PINHOLE",
                                                     "STEREOGRAPHIC",
                                                     "LONLAT",
                                                     "LATLON",
                                                     "OPENCV4",
                                                     "OPENCV5",
                                                     "OPENCV8",
                                                     "OPENCV12",
                                                     "CAHV",
                                                     "CAHVOR",
                                                     "CAHVORE_linearity=0.34",
                                                     "CAHVORE_linearity=",
                                                     "SPLINED_STEREOGRAPHIC",
                                                     "OPENCV"};
  if (random.one_in(2)) return fmt::format("LENSMODEL_{}", random.of(kNames));
  const auto number = [&](std::size_t usual) {
    return random.one_in(3) ? extreme_number(random) : std::to_string(random.below(usual));
  };
  return fmt::format("LENSMODEL_SPLINED_STEREOGRAPHIC_order={}_Nx={}_Ny={}_fov_x_deg={}", number(5),
                     number(12), number(12), number(200));
}

std::string mutate_lens(const std::string& input, Random& random) {
  const std::size_t at = input.find("LENSMODEL_");
  if (at == std::string::npos || random.one_in(2)) return mutate_text(input, random);
  const std::size_t end = std::min(input.find_first_of("'\" \n", at), input.size());
  return input.substr(0, at) + lens_name(random) + input.substr(end);
}

std::string mutate_png(const std::string& input, Random& random) {
  std::vector<Chunk> chunks = chunks_of(input);
  if (chunks.empty()) return mutate_bytes(input, random);
  change_chunks(chunks, random);
  return png_of(input.substr(0, kPngSignature), chunks);
}

}  // namespace fringetwin::fuzz
