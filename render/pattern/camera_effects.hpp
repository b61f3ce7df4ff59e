// SPDX-License-Identifier: Apache-2.0
// Applies to finished irradiance images what the camera does to them: vignetting, then point spread, then the
// texture of its pixels.
#pragma once
#include <vector>

#include "render/base/rendered_camera.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Returns the weights at 0, 1, 2 ... px of a symmetric kernel of unit sum and variance sigma^2: samples of
/// the Gaussian from 0.75 px on (its contrast at 0.1 cycles/px is exact to 1.1e-4), below that Lindeberg's
/// discrete Gaussian exp(-s) I_n(s), s = sigma^2 ("Scale-Space for Discrete Signals", PAMI 12(3), 1990),
/// because samples of a narrow Gaussian have another variance.
std::vector<double> psf_kernel(double sigma_px);

/// Convolves an image with such a kernel, rows, then columns. Beyond the border nothing is known: the
/// kernel's part inside the image is scaled to unit sum.
ImageF convolve_separable(const ImageF& image, const std::vector<double>& kernel);

/// Returns the factor of the irradiance at a point of the image: cos^4 of the angle between its ray and the
/// axis, or the polynomial.
double vignetting_factor(const Camera& camera, double x_px, double y_px);
/// Returns the vignetting_factor() at each pixel's centre.
ImageF vignetting_map(const Camera& camera);

/// Applies what the camera asks for to all images, the white and black ones included; nothing otherwise. The
/// images are those of the sequence from `first_image` on: an exposure factor makes a texture's offset
/// larger, too.
/// A point spread goes over all pixels of a sensor: a camera with a channel has none here
/// (Renderer::render()).
void apply_camera_effects(const Camera& camera, RenderedCamera* rendered, std::size_t first_image = 0);
/// Applies vignetting and point spread alone, which come first.
void apply_lens_effects(const Camera& camera, RenderedCamera* rendered);
/// Applies the texture of the camera's pixels alone, which comes last.
void apply_textures(const Camera& camera, RenderedCamera* rendered, std::size_t first_image = 0);

}  // namespace fringetwin::render
