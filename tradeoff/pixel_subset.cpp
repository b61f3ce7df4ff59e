// SPDX-License-Identifier: Apache-2.0
#include "tradeoff/pixel_subset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <random>
#include <utility>

#include "twin/base/errors.hpp"

namespace fringetwin::tradeoff {
namespace {

/// Returns what each pixel shows: -1 nothing, else twice the object plus one where it is lit.
Image<int> pixel_keys(const render::RenderedCamera& rendered) {
  const auto& object = rendered.object;
  ImageF swing(object.width, object.height);
  float largest = 0.0F;
  for (std::size_t i = 0; i < swing.size(); ++i) {
    float low = rendered.irradiance.front().data[i], high = low;
    for (const ImageF& image : rendered.irradiance) {
      low = std::min(low, image.data[i]);
      high = std::max(high, image.data[i]);
    }
    swing.data[i] = high - low;
    largest = std::max(largest, high - low);
  }
  Image<int> keys(object.width, object.height, -1);
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (object.data[i] >= 0)
      keys.data[i] = 2 * object.data[i] + (largest > 0.0F && swing.data[i] > 1e-3F * largest ? 1 : 0);
  return keys;
}

template <class Visit>
void visit_neighbours(const Image<int>& keys, int x, int y, Visit visit) {
  for (int v = std::max(0, y - 1); v <= std::min(keys.height - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(keys.width - 1, x + 1); ++u) visit(keys(u, v));
}

Image<PixelClass> classes_of(const Image<int>& keys) {
  Image<PixelClass> out(keys.width, keys.height, PixelClass::background);
  for (int y = 0; y < keys.height; ++y)
    for (int x = 0; x < keys.width; ++x) {
      const int own = keys(x, y);
      bool differs = false;
      visit_neighbours(keys, x, y, [&](int key) { differs = differs || key != own; });
      if (differs)
        out(x, y) = PixelClass::edge;
      else if (own >= 0)
        out(x, y) = PixelClass::interior;
    }
  return out;
}

enum class Stratum { inside, silhouette, light_border };
using Strata = std::map<std::pair<int, Stratum>, std::vector<SubsetWindow>>;

/// Files a tile under the strata it belongs to; one that is all inside of a lit object belongs to nothing
/// else.
void file_tile(const Image<int>& keys, const Image<PixelClass>& classes, const SubsetWindow& tile,
               Strata& strata) {
  std::map<std::pair<int, Stratum>, int> found;
  int n_lit_interior = 0;
  for (int y = tile.y0; y < tile.y0 + tile.height; ++y)
    for (int x = tile.x0; x < tile.x0 + tile.width; ++x) {
      const int own = keys(x, y);
      if (classes(x, y) == PixelClass::interior && own % 2 == 1) ++n_lit_interior;
      if (classes(x, y) != PixelClass::edge || own < 0) continue;
      bool silhouette = false;
      visit_neighbours(keys, x, y,
                       [&](int key) { silhouette = silhouette || key < 0 || key / 2 != own / 2; });
      ++found[{own / 2, silhouette ? Stratum::silhouette : Stratum::light_border}];
    }
  if (n_lit_interior == tile.width * tile.height) {
    strata[{keys(tile.x0, tile.y0) / 2, Stratum::inside}].push_back(tile);
    return;
  }
  for (const auto& [stratum, count] : found) strata[stratum].push_back(tile);
}

bool same(const SubsetWindow& a, const SubsetWindow& b) { return a.x0 == b.x0 && a.y0 == b.y0; }

/// Draws one tile from each stratum in turn until there are enough or none is left.
std::vector<SubsetWindow> draw_windows(Strata strata, const SubsetOptions& options) {
  std::mt19937_64 random(options.seed);
  for (auto& [stratum, tiles] : strata)
    for (std::size_t i = tiles.size(); i > 1; --i) std::swap(tiles[i - 1], tiles[random() % i]);
  std::vector<SubsetWindow> out;
  const auto wanted = static_cast<std::size_t>(options.windows_per_camera);
  for (bool any = true; any && out.size() < wanted;) {
    any = false;
    for (auto& [stratum, tiles] : strata) {
      while (!tiles.empty()) {
        const SubsetWindow tile = tiles.back();
        tiles.pop_back();
        if (std::ranges::any_of(out, [&](const SubsetWindow& w) { return same(w, tile); })) continue;
        out.push_back(tile);
        any = true;
        break;
      }
      if (out.size() == wanted) break;
    }
  }
  return out;
}

}  // namespace

Image<PixelClass> classify_pixels(const render::RenderedCamera& rendered) {
  return classes_of(pixel_keys(rendered));
}

CameraSubset choose_subset(const render::RenderedCamera& rendered, const SubsetOptions& options) {
  FT_CHECK(options.window_px > 0 && options.windows_per_camera > 0, "a subset has pixels");
  const Image<int> keys = pixel_keys(rendered);
  const Image<PixelClass> classes = classes_of(keys);
  CameraSubset subset;
  for (const PixelClass c : classes.data) {
    subset.n_interior_image += c == PixelClass::interior;
    subset.n_edge_image += c == PixelClass::edge;
  }
  Strata strata;
  const int side = options.window_px;
  for (int y = 0; y < keys.height; y += side)
    for (int x = 0; x < keys.width; x += side)
      file_tile(keys, classes, {x, y, std::min(side, keys.width - x), std::min(side, keys.height - y)},
                strata);
  subset.windows = draw_windows(std::move(strata), options);
  std::size_t n_edge = 0;
  for (const SubsetWindow& w : subset.windows)
    for (int y = w.y0; y < w.y0 + w.height; ++y)
      for (int x = w.x0; x < w.x0 + w.width; ++x) {
        if (classes(x, y) == PixelClass::background) continue;
        const bool edge = classes(x, y) == PixelClass::edge;
        n_edge += edge;
        subset.pixels.push_back({x, y, edge, 1.0});
      }
  const std::size_t n_interior = subset.pixels.size() - n_edge;
  for (SubsetPixel& p : subset.pixels)
    p.weight = p.edge ? static_cast<double>(subset.n_edge_image) / static_cast<double>(n_edge)
                      : static_cast<double>(subset.n_interior_image) / static_cast<double>(n_interior);
  return subset;
}

std::size_t PixelSubset::n_pixels() const {
  std::size_t n = 0;
  for (const CameraSubset& c : cameras) n += c.pixels.size();
  return n;
}

std::string PixelSubset::text() const {
  std::size_t n_windows = 0, n_edge = 0, n_image = 0;
  for (const CameraSubset& c : cameras) {
    n_windows += c.windows.size();
    n_image += c.n_interior_image + c.n_edge_image;
    for (const SubsetPixel& p : c.pixels) n_edge += p.edge;
  }
  return fmt::format(
      "{} of {} object pixels ({} of them on silhouettes and borders of light) in {} windows of {} x {} px "
      "over {} camera(s), drawn with seed {}; each class weighted by its share in the whole image",
      n_pixels(), n_image, n_edge, n_windows, options.window_px, options.window_px, cameras.size(),
      options.seed);
}

PixelSubset choose_subset(const Twin& twin, render::Renderer& renderer, const SubsetOptions& options) {
  PixelSubset out;
  out.options = options;
  for (std::size_t i = 0; i < twin.cameras.size(); ++i) {
    SubsetOptions own = options;
    own.seed = options.seed + i;
    out.cameras.push_back(choose_subset(renderer.render(twin, i, {Sampler::gauss, 1}), own));
  }
  if (out.n_pixels() == 0)
    throw UserError(
        ExitCode::usage, twin.file.string(), "no camera sees any object",
        "check the objects' positions (mm, world = first camera unless rt_cam_world says otherwise)");
  return out;
}

bool can_crop(const Twin& twin) {
  return std::ranges::all_of(twin.cameras, [](const Camera& c) { return c.lens.is_perspective(); });
}

Twin window_twin(const Twin& twin, const PixelSubset& subset) {
  FT_CHECK(can_crop(twin), "only perspective lenses have a principal point to shift");
  Twin out = twin;
  out.cameras.clear();
  for (std::size_t i = 0; i < twin.cameras.size(); ++i)
    for (const SubsetWindow& w : subset.cameras[i].windows) {
      Camera camera = twin.cameras[i];
      std::vector<double> intrinsics = camera.lens.intrinsics();
      intrinsics[2] -= w.x0;
      intrinsics[3] -= w.y0;
      if (camera.timing) camera.timing->rows = camera.row_heights().part(w.y0, 1.0);
      camera.lens = Lens(camera.lens.model(), intrinsics, {w.width, w.height}, camera.name + " cropped");
      if (camera.channel) camera.channel->sensor_px = {2 * w.width, 2 * w.height};
      out.cameras.push_back(std::move(camera));
    }
  return out;
}

}  // namespace fringetwin::tradeoff
