// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/seen_image.hpp"

#include <algorithm>
#include <cmath>

#include "render/indirect/surface_roughness.hpp"

namespace fringetwin::render {

bool on_one_surface(const SurfacePlace& a, const SurfacePlace& b, const SurfaceLimits& limits) {
  if (a.n.dot(b.n) < limits.least_cosine) return false;
  if (limits.of_one_primitive && a.primitive != b.primitive) return false;
  const Eigen::Vector3f way = b.p_mm - a.p_mm;
  const float out = std::max(std::abs(way.dot(a.n)), std::abs(way.dot(b.n)));
  return out <= limits.most_out_of_plane * way.norm();
}

SeenImage seen_image(int width, int height, const SeenPlaces& seen, int around_px) {
  SeenImage image{.width = width, .height = height};
  image.at.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), -1);
  for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
    image.at[seen.pixels[i]] = static_cast<std::int32_t>(i);
    image.own_normals.push_back(seen.places[i].n);
  }
  image.places = seen.places;
  const SurfaceRoughness roughness(image, 1);
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
    const SurfacePlace& own = seen.places[i];
    const int x = static_cast<int>(seen.pixels[i]) % width, y = static_cast<int>(seen.pixels[i]) / width;
    const SurfaceLimits limits = roughness.widened(kRough, x, y);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (int v = std::max(0, y - around_px); v <= std::min(height - 1, y + around_px); ++v)
      for (int u = std::max(0, x - around_px); u <= std::min(width - 1, x + around_px); ++u) {
        const std::int32_t at = image.at[static_cast<std::size_t>(v * width + u)];
        if (at < 0) continue;
        const SurfacePlace& other = seen.places[static_cast<std::size_t>(at)];
        if (on_one_surface(own, other, limits)) sum += other.n;
      }
    image.places[i].n = sum.normalized();
  }
  return image;
}

}  // namespace fringetwin::render
