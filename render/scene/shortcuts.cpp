// SPDX-License-Identifier: Apache-2.0
#include "render/scene/shortcuts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "twin/base/constants.hpp"

namespace fringetwin::render {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMostViews = 4;  // of one mesh: two cameras and a projector
constexpr std::uint32_t kLargestTileShift = 4;
constexpr int kDilations = 2;  // tiles beside the mesh: pixels at its silhouette start there

// Returns the projections of the vertices; NaN where there is none.
std::vector<Vector2d> project_vertices(const PackedScene::MeshInstance& instance, const Lens& lens) {
  const Pose T_cam_object = instance.T_object_cam.inverse();
  const auto& vertices = instance.geometry->vertices;
  std::vector<Vector2d> q(vertices.size());
#pragma omp parallel for
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    const Vector3d p = T_cam_object * vertices[k].cast<double>();
    const auto projected = lens.project(p);
    q[k] = projected.value_or(Vector2d::Constant(kNaN));
  }
  return q;
}

// The image in square tiles, each with a triangle to start from, -1 where there is none.
class Tiles {
 public:
  Tiles(const Lens& lens, std::uint32_t shift)
      : side_(1 << shift),
        nx_((lens.width() + side_ - 1) / side_),
        ny_((lens.height() + side_ - 1) / side_),
        start_(static_cast<std::size_t>(nx_) * ny_, -1) {}

  // Enters a triangle into all tiles whose middle it covers, and into that of its own middle if nothing else
  // is there.
  void add(std::int32_t triangle, const std::array<Vector2d, 3>& q) {
    const Vector2d middle = (q[0] + q[1] + q[2]) / 3.0;
    if (!middle.allFinite()) return;
    const auto [x0, x1] = std::minmax({q[0].x(), q[1].x(), q[2].x()});
    const auto [y0, y1] = std::minmax({q[0].y(), q[1].y(), q[2].y()});
    // The middle of tile i lies at side (i + 1/2) - 1/2.
    const auto first = [&](double x) {
      return static_cast<int>(std::ceil((std::max(x, -1.0) + 0.5) / side_ - 0.5));
    };
    const auto last = [&](double x, int n) {
      return static_cast<int>(std::floor((std::min(x, 1.0 * n * side_) + 0.5) / side_ - 0.5));
    };
    const double turn = area(q[0], q[1], q[2]) < 0.0 ? -1.0 : 1.0;
    for (int j = std::max(0, first(y0)); j <= std::min(ny_ - 1, last(y1, ny_)); ++j)
      for (int i = std::max(0, first(x0)); i <= std::min(nx_ - 1, last(x1, nx_)); ++i) {
        const Vector2d p(side_ * (i + 0.5) - 0.5, side_ * (j + 0.5) - 0.5);
        if (turn * area(q[0], q[1], p) >= 0.0 && turn * area(q[1], q[2], p) >= 0.0 &&
            turn * area(q[2], q[0], p) >= 0.0)
          at(i, j) = triangle;
      }
    const double i = std::floor((middle.x() + 0.5) / side_), j = std::floor((middle.y() + 0.5) / side_);
    if (i >= 0.0 && j >= 0.0 && i < nx_ && j < ny_) {
      std::int32_t& start = at(static_cast<int>(i), static_cast<int>(j));
      if (start < 0) start = triangle;
    }
  }

  // Gives tiles without a triangle one of a neighbour.
  void dilate() {
    const std::vector<std::int32_t> before = start_;
    const auto old = [&](int i, int j) {
      return i < 0 || j < 0 || i >= nx_ || j >= ny_ ? -1 : before[place(i, j)];
    };
    for (int j = 0; j < ny_; ++j)
      for (int i = 0; i < nx_; ++i)
        if (at(i, j) < 0) at(i, j) = std::max({old(i - 1, j), old(i + 1, j), old(i, j - 1), old(i, j + 1)});
  }

  std::uint32_t columns() const { return static_cast<std::uint32_t>(nx_); }
  const std::vector<std::int32_t>& start() const { return start_; }

 private:
  static double area(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
    return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
  }
  std::size_t place(int i, int j) const { return static_cast<std::size_t>(j) * nx_ + i; }
  std::int32_t& at(int i, int j) { return start_[place(i, j)]; }

  int side_, nx_, ny_;
  std::vector<std::int32_t> start_;
};

// Per mesh instance: where its vertices lie in the image, and which of its triangles nothing hides.
using Projected = std::vector<std::vector<Vector2d>>;
using Clear = std::vector<std::vector<std::uint8_t>>;

std::array<Vector2d, 3> corners(const std::vector<Vector2d>& q, const std::array<int, 3>& t) {
  return {q[t[0]], q[t[1]], q[t[2]]};
}

// Chooses tiles about as large as a triangle, so that a walk takes a step or two.
std::uint32_t choose_tile_shift(const PackedScene& scene, const Projected& projected, const Clear& seen) {
  double area = 0.0;
  std::size_t n = 0;
  for (std::size_t m = 0; m < scene.instances.size(); ++m)
    for (std::size_t i = 0; i < seen[m].size(); ++i) {
      if (!seen[m][i]) continue;
      const auto q = corners(projected[m], scene.instances[m].geometry->indices[i]);
      const Vector2d a = q[1] - q[0], b = q[2] - q[0];
      const double twice = std::abs(a.x() * b.y() - a.y() * b.x());
      if (!std::isfinite(twice)) continue;
      area += 0.5 * twice;
      ++n;
    }
  std::uint32_t shift = 0;
  const double side = n > 0 ? std::sqrt(area / static_cast<double>(n)) : 1.0;
  while (shift < kLargestTileShift && (1 << (shift + 1)) <= 1.3 * side) ++shift;
  return shift;
}

// Returns the volume of a closed mesh, positive where the winding is outward.
double volume(const MeshGeometry& g) {
  double sum = 0.0;
  for (const auto& t : g.indices) {
    const auto v = [&](std::size_t k) -> Vector3d { return g.vertices[t[k]].cast<double>(); };
    sum += v(0).dot(v(1).cross(v(2)));
  }
  return sum / 6.0;
}

// Adds the links of all instances' triangles, with marks of those that nothing hides from the camera or the
// projector.
void add_links(const PackedScene& scene, const Vector3d& light_cam, bool walk, VisibilityStore& store,
               std::vector<std::array<std::int32_t, 4>>* links) {
  for (const auto& instance : scene.instances) {
    const MeshGeometry& g = *instance.geometry;
    const Adjacency& adjacency = store.adjacency(g);
    // Copied: another instance's eye may push a view out of the store.
    const std::vector<std::uint8_t> from_camera = walk ? store.clear(g, instance.T_object_cam.translation_mm)
                                                       : std::vector<std::uint8_t>(g.indices.size(), 0);
    const std::vector<std::uint8_t> from_light = scene.shadow
                                                     ? store.clear(g, instance.T_object_cam * light_cam)
                                                     : std::vector<std::uint8_t>(g.indices.size(), 0);
    for (std::size_t i = 0; i < g.indices.size(); ++i) {
      const auto& n = adjacency.neighbours[i];
      links->push_back({n[0], n[1], n[2],
                        (from_camera[i] ? LINK_SEEN : 0) | (from_light[i] ? LINK_LIT : 0) |
                            (adjacency.closed ? LINK_CLOSED : 0)});
    }
  }
}

// Adds the triangles to start from, for each instance and tile of the image; out->links must be there.
void add_starts(const PackedScene& scene, const Lens& lens, Shortcuts* out) {
  Projected projected;
  Clear seen;
  std::size_t first = 0;
  for (const auto& instance : scene.instances) {
    projected.push_back(project_vertices(instance, lens));
    auto& clear = seen.emplace_back(instance.geometry->indices.size());
    for (std::size_t i = 0; i < clear.size(); ++i) clear[i] = (out->links[first + i][3] & LINK_SEEN) != 0;
    first += clear.size();
  }
  out->tile_shift = choose_tile_shift(scene, projected, seen);
  for (std::size_t m = 0; m < scene.instances.size(); ++m) {
    Tiles tiles(lens, out->tile_shift);
    const auto& indices = scene.instances[m].geometry->indices;
    for (std::size_t i = 0; i < indices.size(); ++i)
      if (seen[m][i]) tiles.add(static_cast<std::int32_t>(i), corners(projected[m], indices[i]));
    for (int k = 0; k < kDilations; ++k) tiles.dilate();
    out->tiles_x = tiles.columns();
    out->tiles = static_cast<std::uint32_t>(tiles.start().size());
    out->starts.insert(out->starts.end(), tiles.start().begin(), tiles.start().end());
  }
}

}  // namespace

VisibilityStore::Entry& VisibilityStore::entry(const MeshGeometry& g) {
  std::erase_if(entries_, [](const auto& e) { return e->mesh.expired(); });
  for (const auto& e : entries_)
    if (e->geometry == &g && e->mesh.lock() == g.mesh) return *e;
  entries_.push_back(std::make_unique<Entry>());
  Entry& e = *entries_.back();
  e.mesh = g.mesh;
  e.geometry = &g;
  e.adjacency = make_adjacency(g.indices, g.vertices.size());
  e.adjacency.closed = e.adjacency.closed && volume(g) > 0.0;
  return e;
}

const Adjacency& VisibilityStore::adjacency(const MeshGeometry& g) { return entry(g).adjacency; }

const std::vector<std::uint8_t>& VisibilityStore::clear(const MeshGeometry& g, const Vector3d& eye_mm) {
  Entry& e = entry(g);
  for (const auto& [eye, view] : e.views)
    if (eye == eye_mm) return *view;
  if (e.views.size() >= kMostViews) e.views.erase(e.views.begin());
  e.views.emplace_back(
      eye_mm, std::make_unique<std::vector<std::uint8_t>>(clear_from(eye_mm, g.vertices, g.indices)));
  return *e.views.back().second;
}

Shortcuts make_shortcuts(const Twin& twin, const Camera& camera, const PackedScene& scene,
                         std::size_t most_triangles, VisibilityStore& store) {
  Shortcuts out;
  std::size_t n_triangles = 0;
  for (const auto& instance : scene.instances) n_triangles += instance.geometry->indices.size();
  if (n_triangles == 0 || n_triangles > most_triangles) return out;
  const bool walk = !camera.optics;  // rays from all over a lens see more
  out.kinds = (scene.shadow ? LINKS_SHADOW : 0) | (walk ? LINKS_WALK : 0);
  if (out.kinds == 0) return out;

  const Vector3d light_cam =
      (twin.projector->T_proj_world * camera.T_cam_world.inverse()).inverse().translation_mm;
  out.links.reserve(n_triangles);
  add_links(scene, light_cam, walk, store, &out.links);
  if (walk) add_starts(scene, camera.lens, &out);
  return out;
}

}  // namespace fringetwin::render
