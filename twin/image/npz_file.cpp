// SPDX-License-Identifier: Apache-2.0
// ZIP: APPNOTE.TXT 6.3 of PKWARE, sections 4.3 (records) and 4.5.3 (64-bit fields). NPY:
// numpy.lib.format, 1.0.
#include "twin/image/npz_file.hpp"

#include <zlib.h>

#include <bit>
#include <cstdint>

namespace fringetwin {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

constexpr std::uint16_t kVersion = 45;        ///< of ZIP: the first with 64-bit fields
constexpr std::uint16_t kStored = 0;          ///< no compression
constexpr std::uint16_t kFirstDay = 0x0021;   ///< 1980-01-01: equal arrays make equal files
constexpr std::uint32_t kIn64 = 0xFFFFFFFF;   ///< the number stands in the 64-bit field
constexpr std::uint16_t kCountIn64 = 0xFFFF;  ///< the same of a count
constexpr std::uint16_t kField64 = 1;         ///< name of the 64-bit field
constexpr std::size_t kNpyAlignment = 64;     ///< of the first number in a .npy

/// Bytes of a record, number by number.
class Record {
 public:
  explicit Record(std::uint32_t signature) { add(signature); }
  template <class T>
  Record& add(T number) {
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof number);
    return *this;
  }
  Record& text(const std::string& words) {
    bytes_ += words;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// A file of the archive.
struct Entry {
  std::string name;
  std::uint32_t crc = 0;
  std::uint64_t size = 0, offset = 0;
};

/// Returns what a .npy has before its numbers.
std::string npy_head(const NpzArray& array) {
  std::string shape;  // as Python writes it: (3,) or (2, 3)
  for (const std::size_t n : array.shape) shape += (shape.empty() ? "" : ", ") + std::to_string(n);
  if (array.shape.size() == 1) shape += ",";
  std::string words = "{'descr': '" + array.type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
  constexpr std::size_t kBefore = 10;  // magic word, version, length of the words
  words.append(kNpyAlignment - 1 - (kBefore + words.size()) % kNpyAlignment, ' ');
  words += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  const auto length = static_cast<std::uint16_t>(words.size());
  head.append(reinterpret_cast<const char*>(&length), sizeof length);
  return head + words;
}

/// Appends what the record before a file and the one of the list at the end have in common.
Record& add_common(const Entry& entry, Record& record) {
  return record.add(kVersion)
      .add(std::uint16_t{0})  // flags
      .add(kStored)
      .add(std::uint16_t{0})  // time of day
      .add(kFirstDay)
      .add(entry.crc)
      .add(kIn64)
      .add(kIn64)
      .add(static_cast<std::uint16_t>(entry.name.size()));
}

std::string record_before(const Entry& entry) {
  Record record(0x04034b50);
  return add_common(entry, record)
      .add(std::uint16_t{20})  // bytes of the 64-bit field
      .text(entry.name)
      .add(kField64)
      .add(std::uint16_t{16})
      .add(entry.size)
      .add(entry.size)
      .bytes();
}

std::string record_of_list(const Entry& entry) {
  Record record(0x02014b50);
  record.add(kVersion);  // made by
  return add_common(entry, record)
      .add(std::uint16_t{28})  // bytes of the 64-bit field
      .add(std::uint16_t{0})   // no comment
      .add(std::uint16_t{0})   // disk
      .add(std::uint16_t{0})   // attributes
      .add(std::uint32_t{0})
      .add(kIn64)
      .text(entry.name)
      .add(kField64)
      .add(std::uint16_t{24})
      .add(entry.size)
      .add(entry.size)
      .add(entry.offset)
      .bytes();
}

std::string records_at_end(std::uint64_t n, std::uint64_t list_size, std::uint64_t list_offset) {
  Record end64(0x06064b50);
  end64
      .add(std::uint64_t{44})  // bytes that follow
      .add(kVersion)
      .add(kVersion)
      .add(std::uint32_t{0})  // disks
      .add(std::uint32_t{0})
      .add(n)
      .add(n)
      .add(list_size)
      .add(list_offset);
  Record where(0x07064b50);
  where.add(std::uint32_t{0}).add(list_offset + list_size).add(std::uint32_t{1});
  Record end(0x06054b50);
  end.add(std::uint16_t{0})
      .add(std::uint16_t{0})
      .add(kCountIn64)
      .add(kCountIn64)
      .add(kIn64)
      .add(kIn64)
      .add(std::uint16_t{0});  // no comment
  return end64.bytes() + where.bytes() + end.bytes();
}

std::uint32_t crc_of(const std::string& head, FileBytes values) {
  const auto bytes = [](const void* data) { return static_cast<const Bytef*>(data); };
  const uLong crc = crc32_z(crc32_z(0, nullptr, 0), bytes(head.data()), head.size());
  return static_cast<std::uint32_t>(values.empty() ? crc : crc32_z(crc, bytes(values.data()), values.size()));
}

}  // namespace

void write_npz(const std::filesystem::path& file, const std::vector<NpzArray>& arrays) {
  std::vector<std::string> heads;
  std::string list;
  std::uint64_t at = 0;
  for (const NpzArray& array : arrays) {
    const std::string head = npy_head(array);
    const Entry entry{array.name + ".npy", crc_of(head, array.values), head.size() + array.values.size(), at};
    heads.push_back(record_before(entry) + head);
    list += record_of_list(entry);
    at += heads.back().size() + array.values.size();
  }
  const std::string end = list + records_at_end(arrays.size(), list.size(), at);
  std::vector<FileBytes> parts;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    parts.push_back(std::as_bytes(std::span(heads[i])));
    parts.push_back(arrays[i].values);
  }
  parts.push_back(std::as_bytes(std::span(end)));
  write_whole_file(file, parts);
}

}  // namespace fringetwin
