// SPDX-License-Identifier: Apache-2.0
#include "render/bvh_cache.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <span>

#include "twin/errors.hpp"
#include "twin/image_io.hpp"

namespace fringetwin::render {
namespace {

namespace fs = std::filesystem;

// Raised whenever build_bvh would give another tree or BvhNode another layout.
constexpr std::uint64_t format_version = 1;

struct Header {
  char magic[8] = {'F', 'T', 'B', 'V', 'H', '\0', '\0', '\0'};
  std::uint64_t version = format_version;
  std::uint64_t n_nodes = 0, n_triangles = 0;
  std::int32_t depth = 0;
  std::uint32_t checksum = 0;
  float box[6] = {};
};
static_assert(sizeof(Header) == 64);

template <class T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

std::string content_key(const std::vector<Eigen::Vector3f>& vertices,
                        const std::vector<std::array<int, 3>>& triangles, int max_depth) {
  static_assert(sizeof(Eigen::Vector3f) == 12);
  const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  FT_CHECK(context && EVP_DigestInit_ex(context.get(), EVP_blake2b512(), nullptr) == 1,
           "OpenSSL has BLAKE2b");
  const std::uint64_t sizes[] = {format_version, vertices.size(), triangles.size(),
                                 static_cast<std::uint64_t>(max_depth)};
  EVP_DigestUpdate(context.get(), sizes, sizeof sizes);
  EVP_DigestUpdate(context.get(), vertices.data(), bytes_of(vertices).size());
  EVP_DigestUpdate(context.get(), triangles.data(), bytes_of(triangles).size());
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  EVP_DigestFinal_ex(context.get(), digest.data(), nullptr);
  std::string key;
  for (std::size_t i = 0; i < 20; ++i) key += fmt::format("{:02x}", digest[i]);
  return key;
}

// Over all of the file but itself.
std::uint32_t checksum(Header header, const Bvh& bvh) {
  header.checksum = 0;
  uLong sum = crc32_z(0, reinterpret_cast<const Bytef*>(&header), sizeof header);
  for (const auto part : {bytes_of(bvh.nodes), bytes_of(bvh.order)})
    sum = crc32_z(sum, reinterpret_cast<const Bytef*>(part.data()), part.size());
  return static_cast<std::uint32_t>(sum);
}

std::optional<Bvh> read(const fs::path& file, std::size_t n_triangles) {
  std::ifstream in(file, std::ios::binary);
  Header header;
  const Header expected;
  if (!in.read(reinterpret_cast<char*>(&header), sizeof header)) return {};
  if (!std::equal(std::begin(header.magic), std::end(header.magic), std::begin(expected.magic)) ||
      header.version != format_version || header.n_triangles != n_triangles || header.n_nodes == 0 ||
      header.n_nodes > n_triangles)
    return {};
  Bvh bvh;
  bvh.nodes.resize(header.n_nodes);
  bvh.order.resize(n_triangles);
  in.read(reinterpret_cast<char*>(bvh.nodes.data()),
          static_cast<std::streamsize>(bytes_of(bvh.nodes).size()));
  in.read(reinterpret_cast<char*>(bvh.order.data()),
          static_cast<std::streamsize>(bytes_of(bvh.order).size()));
  if (!in || in.peek() != std::ifstream::traits_type::eof() || checksum(header, bvh) != header.checksum)
    return {};
  bvh.depth = header.depth;
  bvh.box_min = {header.box[0], header.box[1], header.box[2]};
  bvh.box_max = {header.box[3], header.box[4], header.box[5]};
  return bvh;
}

void write(const fs::path& file, const Bvh& bvh) {
  Header header;
  header.n_nodes = bvh.nodes.size();
  header.n_triangles = bvh.order.size();
  header.depth = bvh.depth;
  for (int k = 0; k < 3; ++k) {
    header.box[k] = bvh.box_min[k];
    header.box[3 + k] = bvh.box_max[k];
  }
  header.checksum = checksum(header, bvh);
  TemporaryFile temporary(file);
  std::ofstream out(temporary.path(), std::ios::binary);
  out.write(reinterpret_cast<const char*>(&header), sizeof header);
  for (const auto part : {bytes_of(bvh.nodes), bytes_of(bvh.order)})
    out.write(reinterpret_cast<const char*>(part.data()), static_cast<std::streamsize>(part.size()));
  out.close();
  if (out) temporary.commit();
}

void make_room(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::uintmax_t total = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".bvh") continue;
    total += entry.file_size();
    files.emplace_back(entry.last_write_time(), entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const auto& [time, file] : files) {
    if (total <= largest_cache_bytes) break;
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

Bvh cached_bvh(const std::vector<Eigen::Vector3f>& vertices_mm,
               const std::vector<std::array<int, 3>>& triangles, int max_depth,
               const std::optional<fs::path>& folder) {
  if (!folder || triangles.size() < smallest_cached_mesh) return build_bvh(vertices_mm, triangles, max_depth);
  const fs::path file = *folder / (content_key(vertices_mm, triangles, max_depth) + ".bvh");
  if (auto known = read(file, triangles.size())) return *std::move(known);
  Bvh bvh = build_bvh(vertices_mm, triangles, max_depth);
  try {
    fs::create_directories(*folder);
    write(file, bvh);
    make_room(*folder);
  } catch (const std::exception&) {
    // full, read-only or another process at work: the next run builds it again
  }
  return bvh;
}

}  // namespace fringetwin::render
