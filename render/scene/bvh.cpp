// SPDX-License-Identifier: Apache-2.0
#include "render/scene/bvh.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr int kNBins = 16;
constexpr std::uint32_t kLeafSize = 4;
constexpr float kTraversalCost = 1.0F, kTriangleCost = 1.0F;
constexpr std::uint32_t kParallelSize = 8192;

struct Box {
  Eigen::Array3f min = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity());
  Eigen::Array3f max = Eigen::Array3f::Constant(-std::numeric_limits<float>::infinity());
  void add(const Eigen::Array3f& p) {
    min = min.min(p);
    max = max.max(p);
  }
  void add(const Box& b) {
    min = min.min(b.min);
    max = max.max(b.max);
  }
  float half_area() const {
    const Eigen::Array3f e = (max - min).max(0.0F);
    return e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
  }
};

struct Triangle {
  Box box;
  Eigen::Array3f centroid;
  std::uint32_t index;
};

struct Split {
  int axis = -1;
  int bin = 0;
  float cost = std::numeric_limits<float>::infinity();
};

class Builder {
 public:
  Builder(std::vector<Triangle> triangles, int max_depth)
      : triangles_(std::move(triangles)), max_depth_(max_depth) {
    // A subtree of n triangles needs at most n - 1 nodes; each gets its own stretch, so that the
    // result does not depend on the order in which threads build it. Compacted afterwards.
    nodes_.resize(std::max<std::size_t>(triangles_.size(), 1));
  }

  Bvh build() {
    const auto n = static_cast<std::uint32_t>(triangles_.size());
    Box all;
    for (const Triangle& t : triangles_) all.add(t.box);
    Bvh bvh{.box_min = all.min.matrix(), .box_max = all.max.matrix()};
    if (n <= kLeafSize) {
      // The traversal starts at a node: one leaf and an empty box.
      const Box nothing;
      set_node(0, all, leaf(0, n), nothing, leaf(0, 1));
      bvh.nodes = {nodes_[0]};
      bvh.depth = 1;
    } else {
#pragma omp parallel
#pragma omp single
      build_node(0, 0, n, 1);
      compact(bvh);
    }
    bvh.order.reserve(n);
    for (const Triangle& t : triangles_) bvh.order.push_back(t.index);
    return bvh;
  }

 private:
  static std::int32_t leaf(std::uint32_t first, std::uint32_t count) {
    return ~static_cast<std::int32_t>(first * 8 + count - 1);
  }

  void set_node(std::size_t slot, const Box& l, std::int32_t left, const Box& r, std::int32_t right) {
    nodes_[slot] = {l.min.matrix(), left, l.max.matrix(), 0, r.min.matrix(), right, r.max.matrix(), 0};
  }

  // Builds node `slot` over triangles [first, end), more than kLeafSize of them; its subtree owns the slots
  // [slot, slot + (end - first) - 1).
  void build_node(std::uint32_t slot, std::uint32_t first, std::uint32_t end, int depth) {
    const std::uint32_t middle = partition(first, end, depth);
    Box left, right;
    for (std::uint32_t i = first; i < middle; ++i) left.add(triangles_[i].box);
    for (std::uint32_t i = middle; i < end; ++i) right.add(triangles_[i].box);
    const bool left_leaf = middle - first <= kLeafSize, right_leaf = end - middle <= kLeafSize;
    const std::uint32_t left_slot = slot + 1, right_slot = slot + (middle - first);
    set_node(slot, left, left_leaf ? leaf(first, middle - first) : static_cast<std::int32_t>(left_slot),
             right, right_leaf ? leaf(middle, end - middle) : static_cast<std::int32_t>(right_slot));
    if (!left_leaf) {
#pragma omp task if (middle - first > kParallelSize)
      build_node(left_slot, first, middle, depth + 1);
    }
    if (!right_leaf) build_node(right_slot, middle, end, depth + 1);
#pragma omp taskwait
  }

  // Sorts the triangles [first, end) into two groups and returns where the second begins.
  std::uint32_t partition(std::uint32_t first, std::uint32_t end, int depth) {
    const std::uint32_t n = end - first;
    Box centroids;
    for (std::uint32_t i = first; i < end; ++i) centroids.add(triangles_[i].centroid);
    const Eigen::Array3f extent = centroids.max - centroids.min;
    // Balanced splits from here on still end within max_depth.
    const int levels_needed = std::bit_width((n + kLeafSize - 1) / kLeafSize);
    const bool balanced = depth + levels_needed >= max_depth_;
    if (!balanced) {
      const Split split = best_split(first, end, centroids);
      if (split.axis >= 0) {
        const float scale = bins_per_mm(extent[split.axis]);
        const float start = centroids.min[split.axis];
        const auto middle = std::partition(
            triangles_.begin() + first, triangles_.begin() + end,
            [&](const Triangle& t) { return bin_of(t.centroid[split.axis], start, scale) <= split.bin; });
        const auto m = static_cast<std::uint32_t>(middle - triangles_.begin());
        if (m > first && m < end) return m;
      }
    }
    Eigen::Index axis = 0;
    extent.maxCoeff(&axis);
    const std::uint32_t middle = first + n / 2;
    std::nth_element(triangles_.begin() + first, triangles_.begin() + middle, triangles_.begin() + end,
                     [axis](const Triangle& a, const Triangle& b) {
                       return std::pair(a.centroid[axis], a.index) < std::pair(b.centroid[axis], b.index);
                     });
    return middle;
  }

  // Returns infinity where no plane can tell the centroids apart: they coincide, or lie closer than float can
  // divide by (denormal extents).
  static float bins_per_mm(float extent) { return static_cast<float>(kNBins) / extent; }

  static int bin_of(float centroid, float start, float scale) {
    return static_cast<int>(std::clamp((centroid - start) * scale, 0.0F, static_cast<float>(kNBins - 1)));
  }

  // Returns the cheapest split between bins of centroids; its axis is -1 where there is none.
  Split best_split(std::uint32_t first, std::uint32_t end, const Box& centroids) const {
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
      const float extent = centroids.max[axis] - centroids.min[axis];
      const float scale = bins_per_mm(extent), start = centroids.min[axis];
      if (!std::isfinite(scale)) continue;
      Box boxes[kNBins];
      std::uint32_t counts[kNBins] = {};
      for (std::uint32_t i = first; i < end; ++i) {
        const int bin = bin_of(triangles_[i].centroid[axis], start, scale);
        boxes[bin].add(triangles_[i].box);
        ++counts[bin];
      }
      float right_area[kNBins] = {};
      Box right;
      for (int i = kNBins - 1; i > 0; --i) {
        right.add(boxes[i]);
        right_area[i] = right.half_area();
      }
      Box left;
      std::uint32_t n_left = 0;
      const std::uint32_t n = end - first;
      for (int i = 0; i + 1 < kNBins; ++i) {
        left.add(boxes[i]);
        n_left += counts[i];
        if (n_left == 0 || n_left == n) continue;
        const float cost =
            kTraversalCost + kTriangleCost * (left.half_area() * static_cast<float>(n_left) +
                                              right_area[i + 1] * static_cast<float>(n - n_left));
        if (cost < best.cost) best = {axis, i, cost};
      }
    }
    return best;
  }

  // Copies the nodes into depth-first order without the gaps.
  void compact(Bvh& bvh) const {
    struct Item {
      std::int32_t slot;
      std::int32_t parent;
      bool is_left;
      int depth;
    };
    std::vector<Item> stack{{0, -1, false, 1}};
    while (!stack.empty()) {
      const Item item = stack.back();
      stack.pop_back();
      const auto index = static_cast<std::int32_t>(bvh.nodes.size());
      const BvhNode& node = nodes_[item.slot];
      bvh.nodes.push_back(node);
      bvh.depth = std::max(bvh.depth, item.depth);
      if (item.parent >= 0) {
        BvhNode& parent = bvh.nodes[item.parent];
        (item.is_left ? parent.left : parent.right) = index;
      }
      if (node.right >= 0) stack.push_back({node.right, index, false, item.depth + 1});
      if (node.left >= 0) stack.push_back({node.left, index, true, item.depth + 1});
    }
  }

  std::vector<Triangle> triangles_;
  std::vector<BvhNode> nodes_;
  int max_depth_;
};

}  // namespace

Bvh build_bvh(const std::vector<Eigen::Vector3f>& vertices_mm,
              const std::vector<std::array<int, 3>>& triangles, int max_depth) {
  FT_CHECK(!triangles.empty(), "a BVH needs a triangle");
  FT_CHECK(triangles.size() < (1U << 28), "more triangles than a leaf can address");
  const auto n = static_cast<int>(triangles.size());
  std::vector<Triangle> work(triangles.size());
#pragma omp parallel for
  for (int i = 0; i < n; ++i) {
    Triangle& t = work[i];
    for (const int v : triangles[i]) t.box.add(vertices_mm[v].array());
    t.centroid = 0.5F * (t.box.min + t.box.max);
    t.index = static_cast<std::uint32_t>(i);
  }
  return Builder(std::move(work), max_depth).build();
}

}  // namespace fringetwin::render
