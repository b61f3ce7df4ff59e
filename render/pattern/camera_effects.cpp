// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/camera_effects.hpp"

#include <algorithm>
#include <cmath>

#include "render/pattern/pixel_texture.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr double kNarrowPx = 0.75;

// Returns output pixel i of a row or column of n, from pixels i - reach ... i + reach with stride `step`.
float weighted(const float* row, int i, int n, std::ptrdiff_t step, const std::vector<double>& kernel) {
  const int reach = static_cast<int>(kernel.size()) - 1;
  double sum = 0.0, weights = 0.0;
  for (int k = std::max(0, i - reach); k <= std::min(n - 1, i + reach); ++k) {
    const double w = kernel[std::abs(k - i)];
    sum += w * static_cast<double>(row[k * step]);
    weights += w;
  }
  return static_cast<float>(sum / weights);
}

// The images of the sequence, then the white and black ones where there are such.
std::vector<ImageF*> all_images(RenderedCamera* rendered) {
  std::vector<ImageF*> images;
  for (ImageF& image : rendered->irradiance) images.push_back(&image);
  for (auto* image : {&rendered->white, &rendered->black})
    if (*image) images.push_back(&**image);
  return images;
}

}  // namespace

std::vector<double> psf_kernel(double sigma_px) {
  FT_CHECK(sigma_px > 0.0, "width of a point spread function");
  const int reach = std::max(8, static_cast<int>(std::ceil(5.5 * sigma_px)));
  std::vector<double> kernel;
  double sum = 0.0;
  for (int n = 0; n <= reach; ++n) {
    const double s = sigma_px * sigma_px;
    kernel.push_back(sigma_px >= kNarrowPx ? std::exp(-0.5 * n * n / s)
                                           : std::exp(-s) * std::cyl_bessel_i(static_cast<double>(n), s));
    sum += (n == 0 ? 1.0 : 2.0) * kernel.back();
  }
  for (double& w : kernel) w /= sum;
  return kernel;
}

ImageF convolve_separable(const ImageF& image, const std::vector<double>& kernel) {
  ImageF across(image.width, image.height), out(image.width, image.height);
#pragma omp parallel for
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      across(x, y) = weighted(&image.data[image.index(0, y)], x, image.width, 1, kernel);
#pragma omp parallel for
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      out(x, y) = weighted(&across.data[image.index(x, 0)], y, image.height, image.width, kernel);
  return out;
}

double vignetting_factor(const Camera& camera, double x_px, double y_px) {
  if (camera.vignetting.kind == Vignetting::Kind::cos4) {
    const auto d = camera.lens.unproject({x_px, y_px});
    return std::pow(std::max(0.0, d ? d->z() / d->norm() : 0.0), 4);
  }
  if (camera.vignetting.kind == Vignetting::Kind::none) return 1.0;
  // the lens darkens the sensor, whichever of its pixels are the image
  const Eigen::Vector2d size_px = camera.sensor_px().cast<double>(),
                        at_px = camera.on_sensor_px({x_px, y_px});
  const double corner = 0.5 * size_px.norm();
  const double u = (at_px.x() - 0.5 * (size_px.x() - 1.0)) / corner,
               v = (at_px.y() - 0.5 * (size_px.y() - 1.0)) / corner;
  const double s = u * u + v * v;
  const auto& a = camera.vignetting.a;
  const auto& tilt = camera.vignetting.tilt;
  return 1.0 + tilt[0] * u + tilt[1] * v + s * (a[0] + s * (a[1] + s * a[2]));
}

ImageF vignetting_map(const Camera& camera) {
  ImageF map(camera.lens.width(), camera.lens.height(), 1.0F);
#pragma omp parallel for
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) map(x, y) = static_cast<float>(vignetting_factor(camera, x, y));
  return map;
}

void apply_lens_effects(const Camera& camera, RenderedCamera* rendered) {
  FT_CHECK(!camera.spreads_over_sensor(), "a point spread reaches over pixels of other colours");
  const bool vignetting = camera.vignetting.kind != Vignetting::Kind::none;
  if (!vignetting && camera.psf_px == 0.0) return;
  const ImageF map = vignetting ? vignetting_map(camera) : ImageF();
  const std::vector<double> kernel = camera.psf_px > 0.0 ? psf_kernel(camera.psf_px) : std::vector<double>();
  for (ImageF* image : all_images(rendered)) {
    if (vignetting)
      for (std::size_t i = 0; i < image->size(); ++i) image->data[i] *= map.data[i];
    if (!kernel.empty()) *image = convolve_separable(*image, kernel);
  }
}

void apply_camera_effects(const Camera& camera, RenderedCamera* rendered, std::size_t first_image) {
  apply_lens_effects(camera, rendered);
  apply_textures(camera, rendered, first_image);
}

void apply_textures(const Camera& camera, RenderedCamera* rendered, std::size_t first_image) {
  if (!camera.texture) return;
  const std::vector<ImageF*> images = all_images(rendered);
  for (std::size_t k = 0; k < images.size(); ++k) {
    const bool is_of_sequence = k < rendered->irradiance.size();  // references have no exposure of their own
    const double exposure = is_of_sequence ? factor_of(camera.exposure_factors, first_image + k) : 1.0;
    apply_pixel_texture(*camera.texture, camera.texture_spread_px, exposure, *images[k]);
  }
}

}  // namespace fringetwin::render
