// SPDX-License-Identifier: Apache-2.0
// Chooses the pixels at which renderings are compared closely: windows that cover every object's inside, its
// silhouette and the borders of its light, in every camera.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "render/renderer.hpp"
#include "twin/image/image.hpp"
#include "twin/twin.hpp"

namespace fringetwin::tradeoff {

enum class PixelClass : unsigned char {
  background,  ///< nothing is hit here nor in the eight neighbours
  interior,    ///< the eight neighbours hit the same object and agree on being lit
  edge         ///< silhouette, cast shadow, terminator, border of the projector's image
};
/// Classifies the pixels of one rendered camera (one ray a pixel is enough). A pixel is lit when its images
/// differ by more than 1e-3 of the largest such difference.
Image<PixelClass> classify_pixels(const render::RenderedCamera& rendered);

struct SubsetOptions {
  int window_px = 16;           ///< side; a multiple of 8 suits the renderer
  int windows_per_camera = 12;  ///< at most
  std::uint64_t seed = 0;
};

struct SubsetWindow {
  int x0 = 0, y0 = 0, width = 0, height = 0;
};
struct SubsetPixel {
  int x = 0, y = 0;
  bool edge = false;
  /// How many pixels of the whole image it stands for: pixels of its class in the image / in the subset,
  /// so that sums over the subset estimate those over all pixels that are not background.
  double weight = 1.0;
};
struct CameraSubset {
  std::vector<SubsetWindow> windows;
  std::vector<SubsetPixel> pixels;  ///< background left out; window after window, in rows
  std::size_t n_interior_image = 0, n_edge_image = 0;
};
/// Chooses tiles of the image, drawn in turn (without repetition, from the seed) from: the inside of each
/// object, its silhouette, the borders of light on it. Needs no renderer.
CameraSubset choose_subset(const render::RenderedCamera& rendered, const SubsetOptions& options);

struct PixelSubset {
  SubsetOptions options;
  std::vector<CameraSubset> cameras;  ///< order of twin.cameras
  std::size_t n_pixels() const;
  std::string text() const;  ///< one sentence that states the choice
};
/// Renders every camera with one ray a pixel and chooses. Throws UserError(usage) when no camera sees
/// any object.
PixelSubset choose_subset(const Twin& twin, render::Renderer& renderer, const SubsetOptions& options);

/// Returns the twin with one small camera per window, in the order of the windows (all cameras' windows one
/// after the other). Pixel (0, 0) of each is pixel (x0, y0) of its camera. Perspective lenses only.
Twin window_twin(const Twin& twin, const PixelSubset& subset);
/// True where window_twin() works: with perspective lenses.
bool can_crop(const Twin& twin);

}  // namespace fringetwin::tradeoff
