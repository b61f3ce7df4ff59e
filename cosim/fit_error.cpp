// SPDX-License-Identifier: Apache-2.0
#include "cosim/fit_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "compare/geometry/fit_rows.hpp"
#include "compare/result/fit_keys.hpp"
#include "measure/fit/object_fits.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::cosim {
namespace {

using measure::ObjectFit;

double size_or_zero(const std::map<std::string, double>& map, const std::string& key) {
  return std::abs(compare::value_or(map, key, 0.0));
}

/// The difference in place and size, without that of the residuals.
double geometry_distance_mm(const compare::FitRow& row) {
  const double d =
      std::max({size_or_zero(row.difference, "radius_mm"), size_or_zero(row.difference, "offset_mm"),
                size_or_zero(row.difference, "axis_distance_mm")});
  const Eigen::Vector3d* center_mm = compare::find_value(row.difference_vectors, "center_mm");
  return center_mm ? std::max(d, center_mm->norm()) : d;
}

}  // namespace

bool can_fit(const Twin& twin) { return !twin.measure.fits.empty() && measure::can_triangulate(twin); }

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
  return std::max({geometry_distance_mm(row), size_or_zero(row.difference, "rms_mm"),
                   size_or_zero(row.difference, "mean_mm"), size_or_zero(row.difference, "p95_mm")});
}

double fit_error_mm(const Twin& twin, const ObjectFit& fit) {
  if (!fit.usable) return kNaN;
  const Object* object = twin.find_object(fit.object);
  FT_CHECK(object != nullptr, "a fit names an object of the twin");
  const auto nominal = measure::nominal_fit(*object);
  if (!nominal) return fit.numbers.at("rms_mm");
  return geometry_distance_mm(compare::make_fit_row(fit, *nominal));
}

}  // namespace fringetwin::cosim
