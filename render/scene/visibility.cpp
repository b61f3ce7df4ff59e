// SPDX-License-Identifier: Apache-2.0
#include "render/scene/visibility.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace fringetwin::render {
namespace {

using Eigen::Vector3d;

// Describes a vertex as the eye sees it: on a plane at distance 1, and its depth.
struct Seen {
  double x, y, depth;
};

// Returns twice the area of a, b, p: exactly 0 where p is a or b.
double edge(const Seen& a, const Seen& b, const Seen& p) {
  return p.x == b.x && p.y == b.y ? 0.0 : (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

struct SeenTriangle {
  std::array<Seen, 3> v;
  double x0, x1, y0, y1, nearest, farthest;
};

SeenTriangle seen_triangle(const std::vector<Seen>& seen, const std::array<int, 3>& t) {
  SeenTriangle s;
  for (std::size_t k = 0; k < 3; ++k) s.v[k] = seen[t[k]];
  const auto [x0, x1] = std::minmax({s.v[0].x, s.v[1].x, s.v[2].x});
  const auto [y0, y1] = std::minmax({s.v[0].y, s.v[1].y, s.v[2].y});
  const auto [d0, d1] = std::minmax({s.v[0].depth, s.v[1].depth, s.v[2].depth});
  return {s.v, x0, x1, y0, y1, d0, d1};
}

// Does a side of `a` part the two triangles in the image?
bool side_parts(const SeenTriangle& a, const SeenTriangle& b) {
  const double turn = edge(a.v[0], a.v[1], a.v[2]) < 0.0 ? -1.0 : 1.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Seen &p = a.v[k], &q = a.v[(k + 1) % 3];
    bool outside = true;
    for (const Seen& r : b.v) outside = outside && turn * edge(p, q, r) <= 0.0;
    if (outside) return true;
  }
  return false;
}

// A triangle that spans more of the others is left to the rays.
constexpr int kMostComparisons = 512;

struct Plane {
  Vector3d normal;  // turned so that the eye has a positive value
  double offset;
};

// One grid over the image; each cell lists the triangles whose bounding box touches it.
class Grid {
 public:
  Grid(const std::vector<SeenTriangle>& triangles) {
    double x1 = -std::numeric_limits<double>::infinity(), y1 = x1;
    x0_ = y0_ = std::numeric_limits<double>::infinity();
    for (const SeenTriangle& t : triangles) {
      x0_ = std::min(x0_, t.x0);
      y0_ = std::min(y0_, t.y0);
      x1 = std::max(x1, t.x1);
      y1 = std::max(y1, t.y1);
    }
    // About one front and one back triangle a cell.
    const double n = std::max(1.0, 0.5 * static_cast<double>(triangles.size()));
    const double width = std::max(x1 - x0_, 1e-12), height = std::max(y1 - y0_, 1e-12);
    const double side = std::max({std::sqrt(width * height / n), width / kMostCells, height / kMostCells});
    per_cell_ = 1.0 / side;
    nx_ = static_cast<int>(width * per_cell_) + 1;
    ny_ = static_cast<int>(height * per_cell_) + 1;
    start_.assign(static_cast<std::size_t>(nx_) * ny_ + 1, 0);
    std::size_t entries = 0;
    for (const SeenTriangle& t : triangles) entries += cells(t);
    if (entries > kMostEntriesPerTriangle * (triangles.size() + 1000)) return;
    usable_ = true;
    for (const SeenTriangle& t : triangles) visit(t, [&](std::size_t cell) { ++start_[cell + 1]; });
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    list_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t i = 0; i < triangles.size(); ++i)
      visit(triangles[i], [&](std::size_t cell) { list_[next[cell]++] = static_cast<std::int32_t>(i); });
  }

  /// Returns false where the triangles' boxes overlap so much (slivers across the image) that comparing them
  /// is dearer than tracing rays.
  bool usable() const { return usable_; }

  /// Calls use(cell) for all cells that a triangle's bounding box touches.
  template <class Use>
  void visit(const SeenTriangle& t, Use use) const {
    const int i0 = static_cast<int>((t.x0 - x0_) * per_cell_),
              i1 = static_cast<int>((t.x1 - x0_) * per_cell_);
    const int j0 = static_cast<int>((t.y0 - y0_) * per_cell_),
              j1 = static_cast<int>((t.y1 - y0_) * per_cell_);
    for (int j = j0; j <= j1; ++j)
      for (int i = i0; i <= i1; ++i) use(static_cast<std::size_t>(j) * nx_ + i);
  }

  /// Calls use(other triangle) for all triangles in the same cells; stops at the first false and returns it.
  template <class Use>
  bool all_near(const SeenTriangle& t, Use use) const {
    bool all = true;
    visit(t, [&](std::size_t cell) {
      for (std::size_t k = start_[cell]; all && k < start_[cell + 1]; ++k)
        all = use(static_cast<std::size_t>(list_[k]));
    });
    return all;
  }

 private:
  static constexpr double kMostCells = 4096.0;
  static constexpr std::size_t kMostEntriesPerTriangle = 32;
  std::size_t cells(const SeenTriangle& t) const {
    const auto n = [this](double from, double to, double start) {
      return static_cast<std::size_t>((to - start) * per_cell_) -
             static_cast<std::size_t>((from - start) * per_cell_) + 1;
    };
    return n(t.x0, t.x1, x0_) * n(t.y0, t.y1, y0_);
  }
  bool usable_ = false;
  double x0_, y0_, per_cell_;
  int nx_, ny_;
  std::vector<std::size_t> start_;
  std::vector<std::int32_t> list_;
};

// Is the triangle on the far side of the plane, as the eye sees it? The allowance is a thousandth of the
// shadow offset.
bool beyond(const Plane& plane, const std::array<Vector3d, 3>& v, double allowance) {
  return std::ranges::all_of(
      v, [&](const Vector3d& p) { return plane.normal.dot(p) + plane.offset <= allowance; });
}

// Is it on the near side?
bool before(const Plane& plane, const std::array<Vector3d, 3>& v, double allowance) {
  return std::ranges::all_of(
      v, [&](const Vector3d& p) { return plane.normal.dot(p) + plane.offset >= -allowance; });
}

// Returns the vertices as the eye sees them that looks along the axis; none when one of them is not clearly
// in front of it.
std::vector<Seen> see_vertices(const Vector3d& eye, const std::vector<Eigen::Vector3f>& vertices,
                               const Vector3d& axis, double distance) {
  const Vector3d x = axis.unitOrthogonal(), y = axis.cross(x);
  std::vector<Seen> seen(vertices.size());
  bool in_front = true;
#pragma omp parallel for reduction(&& : in_front)
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    const Vector3d d = vertices[k].cast<double>() - eye;
    const double depth = d.dot(axis);
    in_front = in_front && depth > 1e-3 * distance;
    seen[k] = {d.dot(x) / depth, d.dot(y) / depth, depth};
  }
  if (!in_front) seen.clear();
  return seen;
}

// Returns the plane of a triangle whose corners are given relative to the eye.
Plane plane_of(const std::array<Vector3d, 3>& v) {
  Vector3d normal = (v[1] - v[0]).cross(v[2] - v[0]).normalized();
  if (normal.dot(v[0]) > 0.0) normal = -normal;
  return {normal, -normal.dot(v[0])};
}

// Do the triangles' images overlap nowhere, or only where `u` lies farther away than all of `t`?
bool apart(const SeenTriangle& t, const SeenTriangle& u) {
  return u.nearest >= t.farthest || u.x1 <= t.x0 || u.x0 >= t.x1 || u.y1 <= t.y0 || u.y0 >= t.y1 ||
         side_parts(t, u) || side_parts(u, t);
}

}  // namespace

Adjacency make_adjacency(const std::vector<std::array<int, 3>>& triangles, std::size_t n_vertices) {
  // The sides are sorted by their smaller vertex: by a counting sort, then the few of one vertex by the
  // other.
  std::vector<std::size_t> start(n_vertices + 1, 0);
  const auto ends = [&](std::size_t i, std::size_t k) {
    return std::pair(triangles[i][(k + 1) % 3], triangles[i][(k + 2) % 3]);
  };
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = ends(i, k);
      ++start[static_cast<std::size_t>(std::min(a, b)) + 1];
    }
  std::partial_sum(start.begin(), start.end(), start.begin());
  struct Entry {
    std::int32_t other, triangle;
    std::int8_t corner;
    bool forward;
  };
  std::vector<Entry> entries(3 * triangles.size());
  {
    std::vector<std::size_t> next(start.begin(), start.end() - 1);
    for (std::size_t i = 0; i < triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [a, b] = ends(i, k);
        entries[next[std::min(a, b)]++] = {std::max(a, b), static_cast<std::int32_t>(i),
                                           static_cast<std::int8_t>(k), a < b};
      }
  }
  Adjacency out;
  out.neighbours.assign(triangles.size(), {-1, -1, -1});
  bool closed = true;
#pragma omp parallel for schedule(dynamic, 1024) reduction(&& : closed)
  for (std::size_t v = 0; v < n_vertices; ++v) {
    const auto first = entries.begin() + static_cast<std::ptrdiff_t>(start[v]),
               last = entries.begin() + static_cast<std::ptrdiff_t>(start[static_cast<std::size_t>(v) + 1]);
    std::sort(first, last, [](const Entry& a, const Entry& b) {
      return std::pair(a.other, a.triangle) < std::pair(b.other, b.triangle);
    });
    for (auto i = first; i != last;) {
      auto j = i;
      while (j != last && j->other == i->other) ++j;
      if (j - i == 2) {
        const auto second = i + 1;
        out.neighbours[i->triangle][i->corner] = second->triangle;
        out.neighbours[second->triangle][second->corner] = i->triangle;
        closed = closed && i->forward != second->forward;
      } else {
        closed = false;
      }
      i = j;
    }
  }
  out.closed = closed;
  return out;
}

std::vector<std::uint8_t> clear_from(const Vector3d& eye, const std::vector<Eigen::Vector3f>& vertices,
                                     const std::vector<std::array<int, 3>>& triangles) {
  std::vector<std::uint8_t> clear(triangles.size(), 0);
  Vector3d middle = Vector3d::Zero();
  for (const auto& v : vertices) middle += v.cast<double>();
  middle /= static_cast<double>(vertices.size());
  const double distance = (middle - eye).norm();
  if (!(distance > 0.0)) return clear;
  const std::vector<Seen> seen = see_vertices(eye, vertices, (middle - eye) / distance, distance);
  if (seen.empty()) return clear;

  std::vector<SeenTriangle> image(triangles.size());
  std::vector<Plane> planes(triangles.size());
  const auto corners = [&](std::size_t i) {
    std::array<Vector3d, 3> v;
    for (std::size_t k = 0; k < 3; ++k) v[k] = vertices[triangles[i][k]].cast<double>() - eye;
    return v;
  };
#pragma omp parallel for
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    image[i] = seen_triangle(seen, triangles[i]);
    planes[i] = plane_of(corners(i));
  }
  const Grid grid(image);
  if (!grid.usable()) return clear;
  const double allowance = 1e-9 * distance;
#pragma omp parallel for schedule(dynamic, 256)
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto own = corners(i);
    int compared = 0;
    clear[i] = grid.all_near(image[i], [&](std::size_t k) {
      if (k == i) return true;
      if (++compared > kMostComparisons) return false;
      return apart(image[i], image[k]) || beyond(planes[i], corners(k), allowance) ||
             before(planes[k], own, allowance);
    });
  }
  return clear;
}

}  // namespace fringetwin::render
