// SPDX-License-Identifier: Apache-2.0
#include "tests/support/freeform.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <utility>

namespace fringetwin::testing {
namespace {

struct Directions {
  std::vector<Eigen::Vector3d> units;
  std::vector<std::array<int, 3>> triangles;
};

Directions icosahedron() {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  Directions d;
  for (const auto& [x, y, z] : std::vector<std::array<double, 3>>{{-1, g, 0},
                                                                  {1, g, 0},
                                                                  {-1, -g, 0},
                                                                  {1, -g, 0},
                                                                  {0, -1, g},
                                                                  {0, 1, g},
                                                                  {0, -1, -g},
                                                                  {0, 1, -g},
                                                                  {g, 0, -1},
                                                                  {g, 0, 1},
                                                                  {-g, 0, -1},
                                                                  {-g, 0, 1}})
    d.units.push_back(Eigen::Vector3d(x, y, z).normalized());
  d.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  return d;
}

Directions subdivide(const Directions& coarse) {
  Directions fine{coarse.units, {}};
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [entry, fresh] =
        middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(fine.units.size()));
    if (fresh)
      fine.units.push_back(
          (fine.units[static_cast<std::size_t>(a)] + fine.units[static_cast<std::size_t>(b)]).normalized());
    return entry->second;
  };
  for (const auto& [a, b, c] : coarse.triangles) {
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.triangles.insert(fine.triangles.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return fine;
}

}  // namespace

std::vector<Bump> default_bumps() {
  const auto unit = [](double x, double y, double z) { return Eigen::Vector3d(x, y, z).normalized(); };
  return {{unit(0.1, -0.2, -1.0), 0.10, 14.0},   {unit(-0.6, 0.3, -0.8), 0.08, 20.0},
          {unit(0.7, 0.4, -0.6), -0.06, 12.0},   {unit(0.3, -0.8, -0.5), 0.07, 25.0},
          {unit(-0.4, -0.6, -0.7), -0.05, 18.0}, {unit(0.0, 0.7, -0.7), 0.05, 40.0},
          {unit(1.0, 0.0, 0.2), 0.12, 8.0},      {unit(-1.0, 0.2, 0.3), 0.06, 10.0},
          {unit(0.0, 0.1, 1.0), -0.08, 6.0}};
}

double bumpy_radius(double radius_mm, const std::vector<Bump>& bumps, const Eigen::Vector3d& n) {
  double factor = 1.0;
  for (const Bump& b : bumps) factor += b.height * std::exp(b.sharpness * (n.dot(b.direction) - 1.0));
  return radius_mm * factor;
}

Mesh make_bumpy_icosphere(int subdivisions, double radius_mm, const std::vector<Bump>& bumps) {
  Directions d = icosahedron();
  for (int i = 0; i < subdivisions; ++i) d = subdivide(d);
  Mesh mesh;
  for (const Eigen::Vector3d& n : d.units)
    mesh.vertices_mm.push_back((bumpy_radius(radius_mm, bumps, n) * n).cast<float>());
  mesh.triangles = d.triangles;
  return mesh;
}

}  // namespace fringetwin::testing
