// SPDX-License-Identifier: Apache-2.0
#include "calib/board/npz.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <bit>

#include "twin/base/errors.hpp"

namespace fringetwin::calib {

static_assert(std::endian::native == std::endian::little, "the .npy headers below say little-endian");

namespace {

/// Raw deflate, as a zip archive holds it.
std::string deflated(const std::string& bytes) {
  z_stream z = {};
  FT_CHECK(deflateInit2(&z, 6, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) == Z_OK, "zlib");
  std::string out(deflateBound(&z, bytes.size()), '\0');
  std::string in = bytes;  // zlib's pointer is not const
  z.next_in = reinterpret_cast<Bytef*>(in.data());
  z.avail_in = static_cast<uInt>(in.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  const int status = deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  FT_CHECK(status == Z_STREAM_END, "zlib did not finish");
  return out;
}

void put16(std::string& out, std::uint32_t value) {
  for (int i = 0; i < 2; ++i) out += static_cast<char>((value >> (8 * i)) & 0xFFU);
}
void put32(std::string& out, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) out += static_cast<char>((value >> (8 * i)) & 0xFFU);
}

/// Version 1.0: magic, length, a Python dict padded so that the data start at a multiple of 64.
std::string npy_header(const std::string& descr, const std::vector<std::size_t>& shape) {
  std::string tuple = "(";
  for (const std::size_t n : shape) tuple += fmt::format("{}, ", n);
  if (shape.size() > 1) tuple.resize(tuple.size() - 2);
  if (shape.size() == 1) tuple.pop_back();
  tuple += ")";
  std::string dict = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", descr, tuple);
  constexpr std::size_t kPrefix = 10;
  while ((kPrefix + dict.size() + 1) % 64 != 0) dict += ' ';
  dict += '\n';
  std::string out = std::string("\x93NUMPY\x01", 7) + '\0';
  put16(out, static_cast<std::uint32_t>(dict.size()));
  return out + dict;
}

/// Appends the fields that a local header and its entry in the directory share; the date is 1 January 1980.
void put_common(std::string& out, std::uint32_t crc, std::size_t compressed, std::size_t size,
                std::size_t name) {
  put16(out, 20);  // version needed
  put16(out, 0);
  put16(out, 8);  // deflate
  put16(out, 0);
  put16(out, 0x21);
  put32(out, crc);
  put32(out, static_cast<std::uint32_t>(compressed));
  put32(out, static_cast<std::uint32_t>(size));
  put16(out, static_cast<std::uint32_t>(name));
  put16(out, 0);
}

}  // namespace

void NpzWriter::add_raw(const std::string& key, const std::string& descr,
                        const std::vector<std::size_t>& shape, const void* data, std::size_t n_bytes) {
  std::string npy = npy_header(descr, shape);
  if (n_bytes > 0) npy.append(static_cast<const char*>(data), n_bytes);
  Entry entry;
  entry.name = key + ".npy";
  entry.size = static_cast<std::uint32_t>(npy.size());
  entry.crc = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(npy.data()), static_cast<uInt>(npy.size())));
  entry.deflated = deflated(npy);
  entries_.push_back(std::move(entry));
}

void NpzWriter::add(const std::string& key, std::span<const double> values,
                    const std::vector<std::size_t>& shape) {
  add_raw(key, "<f8", shape, values.data(), values.size_bytes());
}

void NpzWriter::add(const std::string& key, std::span<const std::int32_t> values,
                    const std::vector<std::size_t>& shape) {
  add_raw(key, "<i4", shape, values.data(), values.size_bytes());
}

void NpzWriter::add(const std::string& key, bool value) {
  const char byte = value ? 1 : 0;
  add_raw(key, "|b1", {}, &byte, 1);
}

void NpzWriter::add(const std::string& key, double value) { add_raw(key, "<f8", {}, &value, sizeof value); }

void NpzWriter::add(const std::string& key, const std::string& text) {
  std::u32string wide(text.begin(), text.end());
  if (wide.empty()) wide.push_back(U'\0');  // numpy's '' is <U1 holding NUL
  add_raw(key, fmt::format("<U{}", wide.size()), {}, wide.data(), wide.size() * sizeof(char32_t));
}

std::string NpzWriter::bytes() const {
  std::string out, directory;
  for (const Entry& e : entries_) {
    const auto offset = static_cast<std::uint32_t>(out.size());
    put32(out, 0x04034b50);
    put_common(out, e.crc, e.deflated.size(), e.size, e.name.size());
    out += e.name + e.deflated;
    put32(directory, 0x02014b50);
    put16(directory, 20);  // made by
    put_common(directory, e.crc, e.deflated.size(), e.size, e.name.size());
    for (int i = 0; i < 3; ++i) put16(directory, 0);  // comment, disk, internal attributes
    put32(directory, 0);
    put32(directory, offset);
    directory += e.name;
  }
  const auto n = static_cast<std::uint32_t>(entries_.size());
  const auto start = static_cast<std::uint32_t>(out.size());
  out += directory;
  put32(out, 0x06054b50);
  put32(out, 0);
  put16(out, n);
  put16(out, n);
  put32(out, static_cast<std::uint32_t>(directory.size()));
  put32(out, start);
  put16(out, 0);
  return out;
}

std::string base85(const std::string& bytes) {
  static constexpr char kAlphabet[] =
      "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;<=>?@^_`{|}~";
  std::string out;
  out.reserve(bytes.size() * 5 / 4 + 5);
  for (std::size_t i = 0; i < bytes.size(); i += 4) {
    std::uint32_t word = 0;
    const std::size_t n = std::min<std::size_t>(4, bytes.size() - i);
    for (std::size_t k = 0; k < 4; ++k)
      word = (word << 8) | (k < n ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    std::array<char, 5> digits{};
    for (std::size_t k = 5; k-- > 0; word /= 85) digits[k] = kAlphabet[word % 85];
    out.append(digits.data(), n + 1);
  }
  return out;
}

}  // namespace fringetwin::calib
