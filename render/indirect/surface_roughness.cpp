// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/surface_roughness.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "twin/base/statistics.hpp"

namespace fringetwin::render {
namespace {

constexpr int kTilePx = 64;
constexpr int kLookStepPx = 2;          // from one pixel that is looked at to the next
constexpr std::size_t kLeastSeen = 50;  // of them
constexpr float kMostAngleRad = 1.31F;  // 75 degrees: beyond, normals say nothing

}  // namespace

SurfaceRoughness::SurfaceRoughness(const SeenImage& seen, int step_px)
    : tiles_across_((seen.width + kTilePx - 1) / kTilePx) {
  const int down = (seen.height + kTilePx - 1) / kTilePx;
  tiles_.resize(static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(down));
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < tiles_.size(); ++i)
    tiles_[i] = look_at_tile(seen, step_px, static_cast<int>(i) % tiles_across_ * kTilePx,
                             static_cast<int>(i) / tiles_across_ * kTilePx);
}

SurfaceRoughness::Tile SurfaceRoughness::look_at_tile(const SeenImage& seen, int step_px, int x0, int y0) {
  std::vector<float> angles, outs;
  for (const auto& [dx, dy] : {std::array{step_px, 0}, std::array{0, step_px}})
    for (int y = std::max(y0, dy); y < std::min(y0 + kTilePx, seen.height - dy); y += kLookStepPx)
      for (int x = std::max(x0, dx); x < std::min(x0 + kTilePx, seen.width - dx); x += kLookStepPx) {
        const std::size_t pixel = seen.pixel_of(x, y), before = seen.pixel_of(x - dx, y - dy),
                          after = seen.pixel_of(x + dx, y + dy);
        if (!seen.sees(pixel) || !seen.sees(before) || !seen.sees(after)) continue;
        const SurfacePlace &place = seen.place(pixel), &a = seen.place(before), &b = seen.place(after);
        if (a.primitive != place.primitive || b.primitive != place.primitive) continue;
        const Eigen::Vector3f n = a.n + b.n;
        const float length = n.norm(), half = 0.5F * (a.p_mm - b.p_mm).norm();
        if (!(length > 0.0F) || !(half > 0.0F)) continue;
        angles.push_back(std::acos(std::clamp(place.n.dot(n) / length, -1.0F, 1.0F)));
        outs.push_back(std::abs((place.p_mm - 0.5F * (a.p_mm + b.p_mm)).dot(n)) / (length * half));
      }
  if (angles.size() < kLeastSeen) return {};
  return {static_cast<float>(upper_median(angles)), static_cast<float>(upper_median(outs))};
}

SurfaceLimits SurfaceRoughness::widened(const SurfaceLimits& limits, int x, int y) const {
  const Tile& tile = tiles_[static_cast<std::size_t>(y / kTilePx * tiles_across_ + x / kTilePx)];
  SurfaceLimits wide{
      std::min(limits.least_cosine, std::cos(std::min(kUsualMedians * tile.angle_rad, kMostAngleRad))),
      std::max(limits.most_out_of_plane,
               std::min(kUsualMedians * tile.out_of_plane, kNoStep.most_out_of_plane))};
  wide.of_one_primitive = limits.of_one_primitive || is_rough(wide, limits);
  return wide;
}

const SurfaceRoughness& RoughnessAtSteps::at(int step_px) {
  const auto known = known_.find(step_px);
  return known != known_.end() ? known->second
                               : known_.emplace(step_px, SurfaceRoughness(seen_, step_px)).first->second;
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
