// SPDX-License-Identifier: Apache-2.0
#include "render/scene/bvh_cache.hpp"

#include <algorithm>
#include <cstring>
#include <string>

namespace fringetwin::render {
namespace {

struct Head {
  std::uint64_t n_nodes = 0, n_vertices = 0, n_triangles = 0;
  std::int32_t max_depth = 0, depth = 0;
  std::array<float, 6> box{};
};

// Returns whether a traversal meets only nodes and triangles that there are, and ends within a stack of
// `max_depth`: children stand after their node, as the builder puts them.
bool is_sound(const Bvh& bvh, int max_depth) {
  const std::size_t n_nodes = bvh.nodes.size(), n_triangles = bvh.order.size();
  std::vector<int> level(n_nodes, 1);
  for (std::size_t i = 0; i < n_nodes; ++i)
    for (const std::int32_t child : {bvh.nodes[i].left, bvh.nodes[i].right}) {
      if (child < 0) {
        const auto leaf = static_cast<std::uint32_t>(~child);
        if (leaf / 8 + leaf % 8 >= n_triangles) return false;
        continue;
      }
      const auto c = static_cast<std::size_t>(child);
      if (c <= i || c >= n_nodes || level[i] >= max_depth) return false;
      level[c] = std::max(level[c], level[i] + 1);
    }
  return std::ranges::all_of(bvh.order, [&](std::uint32_t t) { return t < n_triangles; });
}

// Returns the hierarchy in the bytes of a kept file, nothing where they are none of that many triangles.
std::optional<Bvh> unpack(const std::vector<std::uint8_t>& bytes, std::size_t n_triangles, int max_depth) {
  Head head;
  if (bytes.size() < sizeof head) return {};
  std::memcpy(&head, bytes.data(), sizeof head);
  if (head.n_triangles != n_triangles || head.n_nodes == 0 || head.n_nodes > n_triangles ||
      bytes.size() != sizeof head + head.n_nodes * sizeof(BvhNode) + n_triangles * sizeof(std::uint32_t))
    return {};
  Bvh bvh;
  bvh.nodes.resize(head.n_nodes);
  bvh.order.resize(n_triangles);
  const std::uint8_t* at = bytes.data() + sizeof head;
  std::memcpy(static_cast<void*>(bvh.nodes.data()), at, head.n_nodes * sizeof(BvhNode));
  std::memcpy(bvh.order.data(), at + head.n_nodes * sizeof(BvhNode), n_triangles * sizeof(std::uint32_t));
  bvh.depth = head.depth;
  bvh.box_min = {head.box[0], head.box[1], head.box[2]};
  bvh.box_max = {head.box[3], head.box[4], head.box[5]};
  if (!is_sound(bvh, max_depth)) return {};
  return bvh;
}

}  // namespace

Bvh cached_bvh(const std::vector<Eigen::Vector3f>& vertices_mm,
               const std::vector<std::array<int, 3>>& triangles, int max_depth,
               const std::optional<std::filesystem::path>& folder, std::size_t smallest) {
  if (!folder || triangles.size() < smallest) return build_bvh(vertices_mm, triangles, max_depth);
  const std::string builder = FRINGETWIN_CODE_DIGEST;  // of build_bvh and BvhNode (CMakeLists.txt)
  Head head{.n_vertices = vertices_mm.size(), .n_triangles = triangles.size(), .max_depth = max_depth};
  const auto bytes_of_head = [&head] { return std::as_bytes(std::span(&head, 1)); };
  const std::string name =
      "bvh-" + content_key({std::as_bytes(std::span(builder)), bytes_of_head(),
                            std::as_bytes(std::span(vertices_mm)), std::as_bytes(std::span(triangles))});
  if (const auto bytes = read_cached(folder, name))
    if (auto known = unpack(*bytes, triangles.size(), max_depth)) return *std::move(known);
  Bvh bvh = build_bvh(vertices_mm, triangles, max_depth);
  head.n_nodes = bvh.nodes.size();
  head.depth = bvh.depth;
  for (std::size_t k = 0; k < 3; ++k) {
    head.box[k] = bvh.box_min[static_cast<int>(k)];
    head.box[3 + k] = bvh.box_max[static_cast<int>(k)];
  }
  write_cached(folder, name,
               {bytes_of_head(), std::as_bytes(std::span(bvh.nodes)), std::as_bytes(std::span(bvh.order))});
  return bvh;
}

}  // namespace fringetwin::render
