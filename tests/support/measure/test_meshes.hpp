// SPDX-License-Identifier: Apache-2.0
// Makes small meshes with known geometry.
#pragma once
#include <cmath>
#include <vector>

#include "twin/mesh/mesh.hpp"

namespace fringetwin::testing {

/// Two triangles in the plane z = 0, normals +z.
inline Mesh square(float side_mm) {
  const float h = 0.5f * side_mm;
  Mesh mesh;
  mesh.vertices_mm = {{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// Closed cube about the origin, normals outward.
inline Mesh box(float side_mm) {
  const float h = 0.5f * side_mm;
  Mesh mesh;
  for (int k = 0; k < 8; ++k) mesh.vertices_mm.push_back({k & 1 ? h : -h, k & 2 ? h : -h, k & 4 ? h : -h});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// Closed free-form surface: radius * (1 + bumps), latitude-longitude grid of 2n x n cells, normals outward.
inline Mesh bumpy_sphere(double radius_mm, int n) {
  Mesh mesh;
  const double pi = std::acos(-1.0);
  const int columns = 2 * n;
  const auto add = [&](double theta, double phi) {
    const double bump =
        0.08 * std::sin(3 * phi + 0.3) * std::pow(std::sin(theta), 3) + 0.05 * std::cos(4 * theta);
    const double r = radius_mm * (1 + bump);
    mesh.vertices_mm.push_back(Eigen::Vector3d(r * std::sin(theta) * std::cos(phi),
                                               r * std::sin(theta) * std::sin(phi), r * std::cos(theta))
                                   .cast<float>());
  };
  add(0, 0);
  for (int i = 1; i < n; ++i)
    for (int j = 0; j < columns; ++j) add(pi * i / n, 2 * pi * j / columns);
  add(pi, 0);
  const auto at = [&](int i, int j) { return 1 + (i - 1) * columns + j % columns; };
  const int south = static_cast<int>(mesh.vertices_mm.size()) - 1;
  for (int j = 0; j < columns; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    for (int i = 1; i + 1 < n; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    mesh.triangles.push_back({south, at(n - 1, j + 1), at(n - 1, j)});
  }
  return mesh;
}

}  // namespace fringetwin::testing
