// SPDX-License-Identifier: Apache-2.0
#include "compare/parameters/grid_view.hpp"

#include <algorithm>
#include <cmath>

#include "render/pattern/camera_effects.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {
namespace {

/// Returns whether the rays of a camera can be had without those between or around them.
bool can_be_thinned(const Camera& camera) {
  return camera.lens.is_perspective() && camera.psf_px == 0.0 &&
         !(camera.texture && camera.texture_spread_px > 0.0);
}

bool is_whole(const GridView& grid, const Camera& camera) {
  return grid.width == camera.lens.width() && grid.height == camera.lens.height();
}

/// Returns the camera of a grid: pixel (i, j) of the result looks where pixel (first_x + k i, first_y + k j)
/// of the camera does.
Camera thinned(const Camera& camera, const GridView& grid) {
  if (is_whole(grid, camera)) return camera;
  Camera out = camera;
  out.vignetting = {};  // these follow the whole image: applied afterwards
  out.texture = nullptr;
  // rows are exposed when those of the whole image are
  if (out.timing) out.timing->rows = camera.row_heights().part(grid.first_y, grid.stride);
  std::vector<double> intrinsics = camera.lens.intrinsics();
  const double k = grid.stride;
  intrinsics[0] /= k;
  intrinsics[1] /= k;
  intrinsics[2] = (intrinsics[2] - grid.first_x) / k;
  intrinsics[3] = (intrinsics[3] - grid.first_y) / k;
  out.lens =
      Lens(camera.lens.model(), intrinsics, {grid.width, grid.height}, "the thinned camera " + camera.name);
  return out;
}

constexpr std::size_t kScatterPixels = 2'500;
constexpr int kScatterPoints = 1;  // direct light is the same for both seeds

}  // namespace

std::map<std::pair<int, int>, std::vector<StepImage>> steps_of_pitches(const GridSamples& s,
                                                                       const Fringes& fringes) {
  const std::vector<PatternSpec> sequence = expand_sequence(fringes);
  std::map<std::pair<int, int>, std::vector<StepImage>> pitches;
  for (std::size_t k = 0; k < s.images.size(); ++k) {
    const PatternSpec& p = sequence.at(static_cast<std::size_t>(s.images[k]));
    if (p.kind == PatternSpec::Kind::phase_step)
      pitches[{p.direction, p.pitch}].push_back({k, kTwoPi * p.step / fringes.steps});
  }
  return pitches;
}

GridView choose_grid(const Camera& camera, std::size_t n_valid, std::size_t most) {
  GridView grid{1, 0, 0, camera.lens.width(), camera.lens.height()};
  if (n_valid <= most) return grid;
  const int k =
      static_cast<int>(std::ceil(std::sqrt(static_cast<double>(n_valid) / static_cast<double>(most))));
  if (!can_be_thinned(camera)) {
    grid.keep = k;
    return grid;
  }
  grid.stride = std::min({k, camera.lens.width(), camera.lens.height()});
  grid.first_x = grid.first_y = grid.stride / 2;
  grid.width = (camera.lens.width() - 1 - grid.first_x) / grid.stride + 1;
  grid.height = (camera.lens.height() - 1 - grid.first_y) / grid.stride + 1;
  return grid;
}

GridView cut_to(const GridView& grid, const Camera& camera, const ImageU8& mask) {
  int x0 = grid.width, y0 = grid.height, x1 = 0, y1 = 0;
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x)
      if (mask.data[grid.pixel_of(x, y, mask.width)] != 0) {
        x0 = std::min(x0, x), x1 = std::max(x1, x + 1);
        y0 = std::min(y0, y), y1 = y + 1;
      }
  if (x1 == 0 || !can_be_thinned(camera)) return grid;
  GridView part = grid;
  part.first_x += grid.stride * x0;
  part.first_y += grid.stride * y0;
  part.width = x1 - x0;
  part.height = y1 - y0;
  return part;
}

std::vector<ImageF> render_grid(render::Renderer& renderer, const Twin& twin, std::size_t index,
                                const GridView& grid, int samples, std::uint64_t seed) {
  Twin view = twin;
  view.cameras = {thinned(twin.cameras.at(index), grid)};
  view.render.pixel_fill /= grid.stride;
  std::vector<ImageF> images = renderer.render(view, 0, {Sampler::gauss, samples}, seed).irradiance;
  const Camera& camera = twin.cameras[index];
  const bool vignetting = camera.vignetting.kind != Vignetting::Kind::none;
  if (is_whole(grid, camera) || (!vignetting && !camera.texture)) return images;
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      const auto factor = static_cast<float>(
          render::vignetting_factor(camera, grid.first_x + grid.stride * x, grid.first_y + grid.stride * y));
      const std::size_t pixel = grid.pixel_of(x, y, camera.lens.width());
      for (std::size_t k = 0; k < images.size(); ++k) {
        float& e = images[k](x, y);
        if (vignetting) e *= factor;
        if (camera.texture) e = camera.texture->of(e, pixel, factor_of(camera.exposure_factors, k));
      }
    }
  return images;
}

Eigen::MatrixXd bounce_scatter(render::Renderer& renderer, const Twin& twin, std::size_t index) {
  if (twin.render.bounces == 0) return {};
  const Lens& lens = twin.cameras.at(index).lens;
  const std::size_t n_all = static_cast<std::size_t>(lens.width()) * static_cast<std::size_t>(lens.height());
  const GridView grid = choose_grid(twin.cameras[index], n_all, kScatterPixels);
  const std::vector<ImageF> one = render_grid(renderer, twin, index, grid, kScatterPoints, 1),
                            other = render_grid(renderer, twin, index, grid, kScatterPoints, 2);
  const auto n_images = static_cast<Eigen::Index>(one.size());
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(n_images, n_images);
  Eigen::VectorXd apart(n_images);
  double n = 0.0;
  for (std::size_t i = 0; i < one[0].size(); ++i) {
    for (Eigen::Index k = 0; k < n_images; ++k)
      apart[k] = static_cast<double>(one[k].data[i]) - static_cast<double>(other[k].data[i]);
    if (apart.isZero(0.0)) continue;
    products += apart * apart.transpose();
    n += 1.0;
  }
  return products * (0.5 / std::max(n, 1.0));
}

}  // namespace fringetwin::compare
