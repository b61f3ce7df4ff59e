// SPDX-License-Identifier: Apache-2.0
#include "compare/geometry/deviation_cloud.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "measure/points/points_ply.hpp"
#include "report/color_scale.hpp"
#include "report/map.hpp"

namespace fringetwin::compare {
namespace {

void write_deviation_cloud(const std::filesystem::path& file, const measure::PointCloud& cloud,
                           const measure::ObjectFit& fit, double span_mm) {
  measure::PlyVertices ply = measure::ply_of_points(cloud, fit.index);
  ply.add_float(measure::kScalarField + std::string("deviation_mm"),
                [&fit](std::size_t k) { return fit.deviation_mm[k]; });
  std::vector<report::Rgb> colours;
  for (const float deviation_mm : fit.deviation_mm) {
    const double t = 0.5 + 0.5 * static_cast<double>(deviation_mm) / span_mm;
    colours.push_back(report::scale_color(report::Scale::diverging, t));
  }
  ply.add_byte("red", [&colours](std::size_t k) { return colours[k].r; });
  ply.add_byte("green", [&colours](std::size_t k) { return colours[k].g; });
  ply.add_byte("blue", [&colours](std::size_t k) { return colours[k].b; });
  ply.write(file, fmt::format("unit mm, world frame; deviation from the fitted {}: blue {:.6g} mm, white 0, "
                              "red {:.6g} mm",
                              fit.kind, -span_mm, span_mm));
}

}  // namespace

const measure::ObjectFit* fit_with_deviations(const measure::Measurement& measurement,
                                              const std::string& object) {
  const measure::ObjectFit* found = nullptr;
  for (const measure::ObjectFit& fit : measurement.fits)
    if (fit.object == object && fit.usable && !fit.deviation_mm.empty() &&
        fit.deviation_mm.size() == fit.index.size())
      found = &fit;
  return found;
}

double deviation_span_um(const std::vector<const measure::ObjectFit*>& fits, double percent) {
  double largest = 1e-6;
  for (const measure::ObjectFit* fit : fits) {
    ImageF um(static_cast<int>(fit->deviation_mm.size()), 1);
    std::ranges::transform(fit->deviation_mm, um.data.begin(), [](float mm) { return 1000.0f * mm; });
    largest = std::max(largest, report::symmetric_limits(um, percent).high);
  }
  return largest;
}

std::string deviation_cloud_name(const std::string& object) { return "deviation_" + object + ".ply"; }

void write_deviation_clouds(const std::filesystem::path& dir, const measure::Measurement& measurement,
                            const std::vector<const measure::Measurement*>& sides) {
  for (const measure::ObjectFit& listed : measurement.fits) {
    const measure::ObjectFit* fit = fit_with_deviations(measurement, listed.object);
    if (!fit) continue;
    std::vector<const measure::ObjectFit*> shown;
    for (const measure::Measurement* side : sides)
      if (const measure::ObjectFit* other = fit_with_deviations(*side, listed.object)) shown.push_back(other);
    write_deviation_cloud(dir / deviation_cloud_name(listed.object), measurement.cloud, *fit,
                          1e-3 * deviation_span_um(shown, kDeviationPercent));
  }
}

}  // namespace fringetwin::compare
