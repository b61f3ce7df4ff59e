// SPDX-License-Identifier: Apache-2.0
#include "measure/fit/closest_point.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <unordered_map>

#include "twin/base/errors.hpp"

namespace fringetwin::measure {
namespace {

constexpr int kLeafSize = 4;

enum class Feature { a, b, c, ab, bc, ca, face };

/// Ericson, Real-Time Collision Detection, 5.1.5.
Eigen::Vector3d closest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                    const Eigen::Vector3d& b, const Eigen::Vector3d& c, Feature& feature) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return feature = Feature::a, a;
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return feature = Feature::b, b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return feature = Feature::ab, a + d1 / (d1 - d3) * ab;
  const Eigen::Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return feature = Feature::c, c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return feature = Feature::ca, a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return feature = Feature::bc, b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  feature = Feature::face;
  const double scale = 1.0 / (va + vb + vc);
  return a + ab * (vb * scale) + ac * (vc * scale);
}

double box_distance_sq(const Eigen::Vector3d& p, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
}

double corner_angle(const Eigen::Vector3d& at, const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  const Eigen::Vector3d x = u - at, y = v - at;
  return std::atan2(x.cross(y).norm(), x.dot(y));
}

/// Returns the angle-weighted normal of the triangle's feature that a closest point lies on.
template <class Triangle>
Eigen::Vector3d pseudo_normal(const Triangle& t, Feature feature,
                              const std::vector<Eigen::Vector3d>& vertex_normal) {
  switch (feature) {
    case Feature::a:
      return vertex_normal[t.vertex[0]];
    case Feature::b:
      return vertex_normal[t.vertex[1]];
    case Feature::c:
      return vertex_normal[t.vertex[2]];
    case Feature::ab:
      return t.edge_normal[0].template cast<double>();
    case Feature::bc:
      return t.edge_normal[1].template cast<double>();
    case Feature::ca:
      return t.edge_normal[2].template cast<double>();
    case Feature::face:
      break;
  }
  return t.normal;
}

}  // namespace

MeshDistance::MeshDistance(const Mesh& mesh) {
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    Triangle t;
    t.vertex = mesh.triangles[i];
    t.index = static_cast<int>(i);
    t.edge_normal.fill(Eigen::Vector3f::Zero());
    t.a = mesh.vertices_mm[t.vertex[0]].cast<double>();
    t.b = mesh.vertices_mm[t.vertex[1]].cast<double>();
    t.c = mesh.vertices_mm[t.vertex[2]].cast<double>();
    const Eigen::Vector3d n = (t.b - t.a).cross(t.c - t.a);
    if (!(n.norm() > 0.0)) continue;
    t.normal = n.normalized();
    triangles.push_back(t);
  }
  if (triangles.empty()) throw UserError(ExitCode::input, "", "the mesh has no triangle to measure against");
  vertex_normal_.assign(mesh.vertices_mm.size(), Eigen::Vector3d::Zero());
  triangles_.reserve(triangles.size());
  nodes_.reserve(triangles.size());
  std::vector<int> order(triangles.size());
  std::iota(order.begin(), order.end(), 0);
  build(order, triangles, 0, static_cast<int>(order.size()));
  set_pseudo_normals();
}

void MeshDistance::build(std::vector<int>& order, std::vector<Triangle>& triangles, int first, int count) {
  const auto id = nodes_.size();
  nodes_.emplace_back();
  const double inf = std::numeric_limits<double>::infinity();
  Eigen::Vector3d low(inf, inf, inf), high = -low, mid_low = low, mid_high = -low;
  const auto middle = [&](int i) -> Eigen::Vector3d {
    return triangles[i].a + triangles[i].b + triangles[i].c;
  };
  for (int k = first; k < first + count; ++k) {
    const Triangle& t = triangles[order[k]];
    low = low.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c);
    high = high.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
    mid_low = mid_low.cwiseMin(middle(order[k]));
    mid_high = mid_high.cwiseMax(middle(order[k]));
  }
  nodes_[id].low = low;
  nodes_[id].high = high;
  if (count <= kLeafSize) {
    nodes_[id].first = static_cast<int>(triangles_.size());
    nodes_[id].count = count;
    for (int k = first; k < first + count; ++k) triangles_.push_back(triangles[order[k]]);
    return;
  }
  int axis = 0;
  (mid_high - mid_low).maxCoeff(&axis);
  const int half = count / 2;
  std::nth_element(order.begin() + first, order.begin() + first + half, order.begin() + first + count,
                   [&](int i, int j) {
                     const double x = middle(i)[axis], y = middle(j)[axis];
                     return x < y || (x == y && i < j);
                   });
  build(order, triangles, first, half);
  nodes_[id].first = static_cast<int>(nodes_.size());
  build(order, triangles, first + half, count - half);
}

void MeshDistance::set_pseudo_normals() {
  std::unordered_map<std::uint64_t, Eigen::Vector3d> edge;
  edge.reserve(2 * triangles_.size());
  const auto key = [](int i, int j) {
    return (static_cast<std::uint64_t>(std::min(i, j)) << 32) | static_cast<std::uint64_t>(std::max(i, j));
  };
  for (const Triangle& t : triangles_) {
    const Eigen::Vector3d* corner[3] = {&t.a, &t.b, &t.c};
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3, last = (k + 2) % 3;
      vertex_normal_[t.vertex[k]] += corner_angle(*corner[k], *corner[next], *corner[last]) * t.normal;
      edge.try_emplace(key(t.vertex[k], t.vertex[next]), Eigen::Vector3d::Zero()).first->second += t.normal;
    }
  }
  for (Triangle& t : triangles_)
    for (int k = 0; k < 3; ++k)
      t.edge_normal[k] = edge.at(key(t.vertex[k], t.vertex[(k + 1) % 3])).cast<float>();
}

ClosestPoint MeshDistance::query(const Eigen::Vector3d& p, double max_distance_mm) const {
  ClosestPoint result;
  double best_sq = max_distance_mm * max_distance_mm;
  int best = -1;
  Feature best_feature = Feature::face;
  struct Entry {
    int node;
    double distance_sq;
  };
  Entry stack[64];  // depth of a balanced tree of 2^31 triangles is 31
  int size = 0;
  stack[size++] = {0, box_distance_sq(p, nodes_[0].low, nodes_[0].high)};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (!(entry.distance_sq <= best_sq)) continue;
    const Node& node = nodes_[entry.node];
    if (node.count > 0) {
      for (int k = node.first; k < node.first + node.count; ++k) {
        Feature feature = Feature::face;
        const Triangle& t = triangles_[k];
        const Eigen::Vector3d q = closest_on_triangle(p, t.a, t.b, t.c, feature);
        const double distance_sq = (p - q).squaredNorm();
        if (distance_sq < best_sq || (best < 0 && distance_sq <= best_sq)) {
          best_sq = distance_sq;
          best = k;
          best_feature = feature;
          result.point_mm = q;
        }
      }
      continue;
    }
    const int left = entry.node + 1, right = node.first;
    const Entry l{left, box_distance_sq(p, nodes_[left].low, nodes_[left].high)};
    const Entry r{right, box_distance_sq(p, nodes_[right].low, nodes_[right].high)};
    const bool left_first = l.distance_sq <= r.distance_sq;
    stack[size++] = left_first ? r : l;
    stack[size++] = left_first ? l : r;
  }
  if (best < 0) return result;
  const Triangle& t = triangles_[best];
  const Eigen::Vector3d side = pseudo_normal(t, best_feature, vertex_normal_);
  result.triangle = t.index;
  result.normal = t.normal;
  const double distance = std::sqrt(best_sq);
  result.signed_distance_mm = side.dot(p - result.point_mm) < 0.0 ? -distance : distance;
  return result;
}

std::shared_ptr<const MeshDistance> mesh_distance_for(const std::shared_ptr<const Mesh>& mesh) {
  FT_CHECK(mesh != nullptr, "mesh not loaded");
  struct Cached {
    std::weak_ptr<const Mesh> mesh;
    std::shared_ptr<const MeshDistance> tree;
  };
  static std::mutex mutex;
  static std::vector<Cached> cache;
  const std::scoped_lock lock(mutex);
  std::erase_if(cache, [](const Cached& c) { return c.mesh.expired(); });
  for (const Cached& c : cache)
    if (c.mesh.lock() == mesh) return c.tree;
  cache.push_back({mesh, std::make_shared<const MeshDistance>(*mesh)});
  return cache.back().tree;
}

}  // namespace fringetwin::measure
