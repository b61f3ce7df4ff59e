// SPDX-License-Identifier: Apache-2.0
#include "cosim/chain.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>

#include "compare/geometry/fit_rows.hpp"
#include "render/sensor/sensor.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

using measure::ObjectFit;

double wall_now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double cpu_now_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void scale_images(CameraImages& images, double factor) {
  const auto scale = [factor](ImageF& image) {
    for (float& v : image.data) v = static_cast<float>(factor * static_cast<double>(v));
  };
  for (ImageF& image : images.images) scale(image);
  if (images.white) scale(*images.white);
  if (images.black) scale(*images.black);
}

double number_or(const std::map<std::string, double>& map, const std::string& key) {
  const auto at = map.find(key);
  return at == map.end() ? 0.0 : std::abs(at->second);
}

// Place and size; residuals apart.
double geometry_distance_mm(const compare::FitRow& row) {
  double d = std::max({number_or(row.difference, "radius_mm"), number_or(row.difference, "offset_mm"),
                       number_or(row.difference, "axis_distance_mm")});
  if (const auto at = row.difference_vectors.find("center_mm"); at != row.difference_vectors.end())
    d = std::max(d, at->second.norm());
  return d;
}

}  // namespace

Stopwatch::Stopwatch() : wall_start_s_(wall_now_s()), cpu_start_s_(cpu_now_s()) {}
Elapsed Stopwatch::elapsed() const { return {wall_now_s() - wall_start_s_, cpu_now_s() - cpu_start_s_}; }

RenderedTwin render_all(render::Renderer& renderer, const Twin& twin, const render::Sampling& sampling,
                        std::uint64_t seed) {
  const Stopwatch watch;
  RenderedTwin out;
  for (std::size_t i = 0; i < twin.cameras.size(); ++i) {
    throw_if_cancelled();
    out.cameras.push_back(renderer.render(twin, i, sampling, seed));
  }
  out.time = watch.elapsed();
  return out;
}

RenderedTwin render_all(render::Renderer& renderer, const Twin& twin, std::uint64_t seed) {
  return render_all(renderer, twin, render::choose_sampling(twin), seed);
}

std::vector<CameraImages> expose_all(const std::vector<render::RenderedCamera>& rendered, const Twin& sensors,
                                     const Twin& units, std::uint64_t seed) {
  std::vector<CameraImages> out;
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    CameraImages images = render::expose(rendered[i], sensors.cameras[i], i, seed);
    const double factor = units.cameras[i].sensor.gain_dn / sensors.cameras[i].sensor.gain_dn;
    if (factor != 1.0) scale_images(images, factor);
    images.bit_depth = units.cameras[i].sensor.bit_depth;
    out.push_back(std::move(images));
  }
  return out;
}

bool can_fit(const Twin& twin) {
  if (twin.measure.fits.empty() || twin.fringes.unwrap == Unwrap::none) return false;
  return twin.triangulate() == Triangulate::stereo ? twin.cameras.size() >= 2 : twin.projector.has_value();
}

std::vector<ObjectFit> fits_in_order(const Twin& twin, const measure::Measurement& measurement) {
  std::vector<ObjectFit> out;
  for (const FitRequest& request : twin.measure.fits)
    for (const ObjectFit& fit : measurement.fits)
      if (fit.object == request.object) {
        out.push_back(fit);
        break;
      }
  return out;
}

double fit_distance_mm(const ObjectFit& a, const ObjectFit& b) {
  if (!a.usable || !b.usable) return std::numeric_limits<double>::infinity();
  const compare::FitRow row = compare::make_fit_row(a, b);
  return std::max({geometry_distance_mm(row), number_or(row.difference, "rms_mm"),
                   number_or(row.difference, "mean_mm"), number_or(row.difference, "p95_mm")});
}

double fit_error_mm(const Twin& twin, const ObjectFit& fit) {
  if (!fit.usable) return std::numeric_limits<double>::quiet_NaN();
  const Object* object = twin.find_object(fit.object);
  FT_CHECK(object != nullptr, "a fit names an object of the twin");
  const auto nominal = measure::nominal_fit(*object);
  if (!nominal) return fit.numbers.at("rms_mm");
  return geometry_distance_mm(compare::make_fit_row(fit, *nominal));
}

}  // namespace fringetwin::study
