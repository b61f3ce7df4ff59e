// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/grid_view.hpp"

#include <algorithm>
#include <cmath>

#include "render/pattern/camera_effects.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {
namespace {

/// Returns the camera of a grid: pixel (i, j) of the result looks where pixel (first + k i, first + k j) of
/// the camera does.
Camera thinned(const Camera& camera, const GridView& grid) {
  if (grid.stride == 1) return camera;
  Camera out = camera;
  out.vignetting = {};  // follows the whole image: applied afterwards
  std::vector<double> intrinsics = camera.lens.intrinsics();
  const double k = grid.stride;
  intrinsics[0] /= k;
  intrinsics[1] /= k;
  intrinsics[2] = (intrinsics[2] - grid.first) / k;
  intrinsics[3] = (intrinsics[3] - grid.first) / k;
  out.lens =
      Lens(camera.lens.model(), intrinsics, {grid.width, grid.height}, "the thinned camera " + camera.name);
  return out;
}

constexpr std::size_t kScatterPixels = 2'500;
constexpr int kScatterPoints = 4;

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
  GridView grid{1, 0, camera.lens.width(), camera.lens.height()};
  if (n_valid <= most) return grid;
  const int k =
      static_cast<int>(std::ceil(std::sqrt(static_cast<double>(n_valid) / static_cast<double>(most))));
  if (!camera.lens.is_perspective() || camera.psf_px > 0.0) {
    grid.keep = k;
    return grid;
  }
  grid.stride = std::min({k, camera.lens.width(), camera.lens.height()});
  grid.first = grid.stride / 2;
  grid.width = (camera.lens.width() - 1 - grid.first) / grid.stride + 1;
  grid.height = (camera.lens.height() - 1 - grid.first) / grid.stride + 1;
  return grid;
}

std::vector<ImageF> render_grid(render::Renderer& renderer, const Twin& twin, std::size_t index,
                                const GridView& grid, int samples, std::uint64_t seed) {
  Twin view = twin;
  view.cameras = {thinned(twin.cameras.at(index), grid)};
  view.render.pixel_fill /= grid.stride;
  std::vector<ImageF> images = renderer.render(view, 0, {Sampler::gauss, samples}, seed).irradiance;
  const Camera& camera = twin.cameras[index];
  if (grid.stride == 1 || camera.vignetting.kind == Vignetting::Kind::none) return images;
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      const auto factor = static_cast<float>(
          render::vignetting_factor(camera, grid.first + grid.stride * x, grid.first + grid.stride * y));
      for (ImageF& image : images) image(x, y) *= factor;
    }
  return images;
}

Eigen::MatrixXd bounce_scatter(render::Renderer& renderer, const Twin& twin, std::size_t index, int samples) {
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
  return products * (0.5 * kScatterPoints / (samples * std::max(n, 1.0)));
}

}  // namespace fringetwin::compare
