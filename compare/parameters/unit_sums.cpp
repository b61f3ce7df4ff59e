// SPDX-License-Identifier: Apache-2.0
#include "compare/parameters/unit_sums.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "render/pattern/unit_fringes.hpp"

namespace fringetwin::compare {

namespace {

/// Gray values of one rendering, at most: a camera that cannot be thinned is rendered whole.
constexpr std::size_t kMostRendered = 100'000'000;

/// Returns the fringes in lists of at most so many pitches, in their order.
std::vector<std::vector<DirectionFringes>> parts_of(const std::vector<DirectionFringes>& all,
                                                    std::size_t most) {
  std::vector<std::vector<DirectionFringes>> parts;
  std::size_t room = 0;
  for (const DirectionFringes& d : all)
    for (std::size_t p = 0; p < d.pitches_px.size(); ++p, --room) {
      if (room == 0) parts.emplace_back(), room = most;
      std::vector<DirectionFringes>& part = parts.back();
      if (part.empty() || p == 0) part.push_back({d.axis, {}, {}, {}});
      part.back().pitches_px.push_back(d.pitches_px[p]);
      part.back().phase_origin_px.push_back(d.phase_origin_px[p]);
    }
  return parts;
}

void add_unit_sums(const std::vector<ImageF>& images, const GridSamples& samples, UnitSums& sums) {
  for (std::size_t w = 0; w < images.size() / 3; ++w) {  // m + A (C cos(2 pi n/3) - S sin(2 pi n/3))
    std::vector<float>& of_fringe = sums.emplace_back(2 * samples.n_pixels());
    for (std::size_t p = 0; p < samples.n_pixels(); ++p) {
      const auto e = [&](std::size_t n) {
        return static_cast<double>(images[3 * w + n].data[samples.cell[p]]) / render::kUnitLevel;
      };
      of_fringe[2 * p] = static_cast<float>((2.0 * e(0) - e(1) - e(2)) / 3.0);
      of_fringe[2 * p + 1] = static_cast<float>((e(2) - e(1)) / std::sqrt(3.0));
    }
  }
}

}  // namespace

std::shared_ptr<const UnitSums> render_unit_sums(render::Renderer& renderer, Twin view,
                                                 const GridSamples& samples, int points) {
  for (Camera& camera : view.cameras) camera.exposure_factors.clear(), camera.timing.reset();
  for (Object& object : view.objects) object.motion = {};
  const std::size_t per_fringe =
      3 * static_cast<std::size_t>(samples.grid.width) * static_cast<std::size_t>(samples.grid.height);
  UnitSums sums;
  for (std::vector<DirectionFringes>& part :
       parts_of(view.fringes.directions, std::max<std::size_t>(1, kMostRendered / per_fringe))) {
    view.fringes.directions = std::move(part);
    add_unit_sums(render_grid(renderer, view, samples.camera, samples.grid, points), samples, sums);
  }
  return std::make_shared<const UnitSums>(std::move(sums));
}

void add_sums(const GridSamples& samples, const std::vector<float>& sums, std::size_t k, double cosine,
              double sine, std::vector<float>& irradiance) {
  const std::size_t n = samples.images.size();
  const auto c = static_cast<float>(cosine), s = static_cast<float>(sine);
#pragma omp parallel for schedule(static)
  for (std::size_t p = 0; p < samples.n_pixels(); ++p)
    irradiance[p * n + k] += c * sums[2 * p] + s * sums[2 * p + 1];
}

}  // namespace fringetwin::compare
