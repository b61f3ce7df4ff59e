// SPDX-License-Identifier: Apache-2.0
#include "render/base/disk_cache.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "twin/base/safe_file.hpp"
#include "twin/base/sha256.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::render {
namespace {

namespace fs = std::filesystem;

struct Header {
  std::array<char, 8> magic{'F', 'T', 'C', 'A', 'C', 'H', 'E', '2'};
  std::uint64_t size = 0;
  std::uint64_t checksum = 0;  // CRC-32 of name and content: against accidents, not against forgery
};

std::uint64_t checksum(std::uint64_t before, Bytes part) {
  return crc32_z(before, reinterpret_cast<const Bytef*>(part.data()), part.size());
}

// Begins with the name: a file that got another one is damaged.
std::uint64_t checksum_of(const std::string& name) { return checksum(0, std::as_bytes(std::span(name))); }

// Removes the oldest files until the folder is within kLargestCacheBytes.
void make_room(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::uintmax_t total = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    // A process that was killed while writing has left this.
    if (entry.path().extension() == ".tmp" &&
        entry.last_write_time() + std::chrono::hours(24) < fs::file_time_type::clock::now())
      fs::remove(entry.path());
    if (entry.path().extension() != ".cache" || !entry.is_regular_file()) continue;
    total += entry.file_size();
    files.emplace_back(entry.last_write_time(), entry.path());
  }
  std::ranges::sort(files);
  for (const auto& [time, file] : files) {
    if (total <= kLargestCacheBytes) break;
    total -= fs::file_size(file);
    fs::remove(file);
  }
}

}  // namespace

std::optional<fs::path> cache_folder() {
  if (const char* own = std::getenv("FRINGETWIN_CACHE"))
    return *own ? std::optional<fs::path>(own) : std::nullopt;
  if (const char* base = std::getenv("XDG_CACHE_HOME"); base && *base) return fs::path(base) / "fringetwin";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "fringetwin";
  return {};
}

std::string content_key(std::initializer_list<Bytes> parts) {
  Sha256 digest;
  for (const Bytes part : parts) {
    const std::uint64_t size = part.size();
    digest.add(std::as_bytes(std::span(&size, 1)));
    digest.add(part);
  }
  return digest.hex().substr(0, 40);
}

std::optional<std::vector<std::uint8_t>> read_cached(const std::optional<fs::path>& folder,
                                                     const std::string& name) {
  if (!folder) return {};
  const fs::path file = *folder / (name + ".cache");
  std::vector<std::uint8_t> bytes;
  try {
    bytes = read_whole_bytes(file, {.kind = FileKind::table, .what = "cache"});
  } catch (const UserError&) {
    return {};
  }
  Header header;
  if (bytes.size() < sizeof header) return {};
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes.erase(bytes.begin(), bytes.begin() + sizeof header);
  if (header.magic != Header{}.magic || header.size != bytes.size() ||
      checksum(checksum_of(name), std::as_bytes(std::span(bytes))) != header.checksum)
    return {};
  std::error_code ignored;
  fs::last_write_time(file, fs::file_time_type::clock::now(), ignored);  // used: others make room first
  return bytes;
}

void write_cached(const std::optional<fs::path>& folder, const std::string& name,
                  std::initializer_list<Bytes> parts) {
  if (!folder) return;
  try {
    Header header{.checksum = checksum_of(name)};
    for (const Bytes part : parts) {
      header.size += part.size();
      header.checksum = checksum(header.checksum, part);
    }
    if (header.size > kLargestCacheBytes / 4) return;
    std::vector<Bytes> all = {std::as_bytes(std::span(&header, 1))};
    all.insert(all.end(), parts);
    write_whole_file(*folder / (name + ".cache"), all);
    make_room(*folder);
  } catch (const std::exception&) {
    // The disk is full or read-only, or another process is at work: the next run makes the result again.
  }
}

}  // namespace fringetwin::render
