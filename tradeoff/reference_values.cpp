// SPDX-License-Identifier: Apache-2.0
#include "tradeoff/reference_values.hpp"

#include <cmath>

#include "render/reference/reference.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::tradeoff {
namespace {

std::vector<double> to_dn(const std::vector<double>& irradiance, const Sensor& sensor) {
  std::vector<double> dn(irradiance.size());
  for (std::size_t i = 0; i < dn.size(); ++i) dn[i] = sensor.gain_dn * irradiance[i] + sensor.black_level_dn;
  return dn;
}

/// True for an interior pixel (docs/CONVENTIONS.md): the pixel and its eight neighbours are whole.
bool is_interior(const render::Reference& reference, std::size_t camera, int x, int y) {
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (!reference.is_whole(camera, x + dx, y + dy)) return false;
  return true;
}

int samples_for(const SubsetPixel& pixel, bool interior, bool with_lens, const ReferenceOptions& options) {
  if (interior) return options.gauss_interior;
  return pixel.edge && !with_lens ? options.gauss_edge : options.gauss_facet;
}

/// Sums squared differences over n edge pixels.
struct EdgeCheck {
  double sum = 0.0;
  std::size_t n = 0;
};

/// Samples every eighth edge pixel again with gauss_n points per side, and sums how much the values change.
EdgeCheck check_edges(const render::Reference& reference, std::size_t camera,
                      const std::vector<SubsetPixel>& pixels, const PixelValues& dn, int gauss_n) {
  const Sensor& sensor = reference.twin().cameras[camera].sensor;
  std::vector<std::size_t> chosen;
  for (std::size_t p = 0, k = 0; p < pixels.size(); ++p)
    if (pixels[p].edge && k++ % 8 == 0) chosen.push_back(p);
  std::vector<double> sums(chosen.size(), 0.0);
  const auto n = static_cast<std::ptrdiff_t>(chosen.size());
#pragma omp parallel for schedule(dynamic, 4)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const std::size_t p = chosen[i];
    const auto other =
        to_dn(reference.pixel(camera, pixels[p].x, pixels[p].y, {.gauss_n = gauss_n}).irradiance, sensor);
    for (std::size_t k = 0; k < other.size(); ++k)
      sums[i] += std::pow(other[k] - dn[p][k], 2) / static_cast<double>(other.size());
  }
  EdgeCheck out;
  for (const double s : sums) out.sum += s, ++out.n;
  return out;
}

}  // namespace

ReferenceValues reference_values(const Twin& twin, const PixelSubset& subset,
                                 const ReferenceOptions& options) {
  const render::Reference reference(twin);
  Progress progress("double-precision reference", subset.n_pixels());
  ReferenceValues out;
  EdgeCheck check;
  for (std::size_t camera = 0; camera < twin.cameras.size(); ++camera) {
    const auto& pixels = subset.cameras[camera].pixels;
    const bool with_lens = twin.cameras[camera].optics.has_value();
    PixelValues dn(pixels.size());
    std::vector<unsigned char> interior(pixels.size(), 0);
    const auto n = static_cast<std::ptrdiff_t>(pixels.size());
#pragma omp parallel for schedule(dynamic, 16)
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      if (cancelled()) continue;
      const SubsetPixel& p = pixels[i];
      interior[i] = is_interior(reference, camera, p.x, p.y);
      const int gauss_n = samples_for(p, interior[i] != 0, with_lens, options);
      dn[i] = to_dn(reference.pixel(camera, p.x, p.y, {.gauss_n = gauss_n}).irradiance,
                    twin.cameras[camera].sensor);
      progress.tick();
    }
    throw_if_cancelled();
    const int edge_n = with_lens ? options.gauss_facet : options.gauss_edge;
    const EdgeCheck own = check_edges(reference, camera, pixels, dn, 3 * edge_n / 4);
    check.sum += own.sum;
    check.n += own.n;
    out.dn.push_back(std::move(dn));
    out.interior.emplace_back(interior.begin(), interior.end());
  }
  out.edge_uncertainty_dn = check.n > 0 ? std::sqrt(check.sum / static_cast<double>(check.n)) : kNaN;
  return out;
}

ImageChange error_against(const ReferenceValues& reference, const Twin& twin, const PixelSubset& subset,
                          const std::vector<PixelValues>& rendered_dn) {
  ChangeSum sum(twin.fringes, twin.measure.min_modulation_dn);
  for (std::size_t i = 0; i < subset.cameras.size(); ++i)
    sum.add(subset.cameras[i].pixels, rendered_dn[i], reference.dn[i], &reference.interior[i]);
  return sum.result();
}

std::vector<PixelValues> dn_from_images(const Twin& twin, const PixelSubset& subset,
                                        const std::vector<render::RenderedCamera>& whole) {
  std::vector<PixelValues> out;
  for (std::size_t i = 0; i < subset.cameras.size(); ++i) {
    const Sensor& sensor = twin.cameras[i].sensor;
    out.push_back(
        take_pixels(whole[i].irradiance, subset.cameras[i].pixels, sensor.gain_dn, sensor.black_level_dn));
  }
  return out;
}

std::vector<PixelValues> dn_from_windows(const Twin& twin, const PixelSubset& subset,
                                         const std::vector<render::RenderedCamera>& windows) {
  std::vector<PixelValues> out;
  std::size_t next = 0;
  for (std::size_t i = 0; i < subset.cameras.size(); ++i) {
    const Sensor& sensor = twin.cameras[i].sensor;
    PixelValues values;
    auto pixel = subset.cameras[i].pixels.begin();
    const auto end = subset.cameras[i].pixels.end();
    for (const SubsetWindow& w : subset.cameras[i].windows) {
      std::vector<SubsetPixel> local;
      const auto holds = [&w](const SubsetPixel& p) {
        return p.x >= w.x0 && p.y >= w.y0 && p.x < w.x0 + w.width && p.y < w.y0 + w.height;
      };
      for (; pixel != end && holds(*pixel); ++pixel)
        local.push_back({pixel->x - w.x0, pixel->y - w.y0, pixel->edge, pixel->weight});
      const PixelValues own =
          take_pixels(windows[next++].irradiance, local, sensor.gain_dn, sensor.black_level_dn);
      values.insert(values.end(), own.begin(), own.end());
    }
    FT_CHECK(pixel == end, "every pixel of the subset lies in its window");
    out.push_back(std::move(values));
  }
  return out;
}

}  // namespace fringetwin::tradeoff
