// SPDX-License-Identifier: Apache-2.0
#include "compare/geometry/fit_rows.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "compare/geometry/published_sigma.hpp"
#include "compare/result/fit_keys.hpp"

namespace fringetwin::compare {
namespace {

using Eigen::Vector3d;
using measure::ObjectFit;

double z_score(double difference, const double* sigma_a, const double* sigma_b) {
  if (!sigma_a || !sigma_b) return kNaN;
  const double sigma = std::hypot(*sigma_a, *sigma_b);
  return sigma > 0.0 && std::isfinite(sigma) ? difference / sigma : kNaN;
}

void compare_numbers(const ObjectFit& s, const ObjectFit& r, FitRow& row) {
  for (const auto& [key, value] : s.numbers) {
    const double* other = find_value(r.numbers, key);
    if (!other || is_sigma_key(key) || is_count_key(key)) continue;
    row.difference[key] = value - *other;
    const double z =
        z_score(value - *other, find_value(s.numbers, sigma_key(key)), find_value(r.numbers, sigma_key(key)));
    if (std::isfinite(z)) row.z[key] = z;
  }
}

void compare_vectors(const ObjectFit& s, const ObjectFit& r, FitRow& row) {
  for (const auto& [key, value] : s.vectors) {
    const Vector3d* other = find_value(r.vectors, key);
    if (!other || is_sigma_key(key)) continue;
    const Vector3d difference = value - *other;
    row.difference_vectors[key] = difference;
    const Vector3d *sigma_s = find_value(s.vectors, sigma_key(key)),
                   *sigma_r = find_value(r.vectors, sigma_key(key));
    if (!sigma_s || !sigma_r) continue;
    Vector3d z;
    for (int i = 0; i < 3; ++i) z[i] = z_score(difference[i], &(*sigma_s)[i], &(*sigma_r)[i]);
    if (!z.array().isNaN().all()) row.z_vectors[key] = z;
  }
}

/// Returns the angle of two axes, sign-free; exact for small angles.
double axis_angle_rad(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

/// Returns the standard error of the simulated centroid's distance from the real plane: both offsets, and the
/// tilt of the real plane over the way between the centroids (its larger tilt sigma: the direction is not
/// kept). NaN when unknown.
double offset_sigma_mm(const ObjectFit& s, const ObjectFit& r, double between_mm) {
  const double *a = find_value(s.numbers, "offset_sigma_mm"), *b = find_value(r.numbers, "offset_sigma_mm");
  const double *t0 = find_value(r.numbers, "tilt_sigma_rad_0"),
               *t1 = find_value(r.numbers, "tilt_sigma_rad_1");
  if (!a || !b || !t0 || !t1) return kNaN;
  return std::sqrt(*a * *a + *b * *b + std::pow(between_mm * std::max(*t0, *t1), 2));
}

/// Compares distance and angle where the fits have a normal or an axis: the point of a plane or an axis is a
/// convention and cannot be compared.
void compare_placement(const ObjectFit& s, const ObjectFit& r, FitRow& row) {
  const bool plane = s.vectors.contains("normal");
  const char* axis_key = plane ? "normal" : "axis";
  const Vector3d *axis_s = find_value(s.vectors, axis_key), *axis_r = find_value(r.vectors, axis_key);
  const Vector3d *point_s = find_value(s.vectors, "point_mm"), *point_r = find_value(r.vectors, "point_mm");
  if (!axis_s || !axis_r || !point_s || !point_r) return;
  row.difference["angle_rad"] = axis_angle_rad(*axis_s, *axis_r);
  const Vector3d between = *point_s - *point_r;
  if (plane) {
    const double offset = axis_r->normalized().dot(between);
    row.difference["offset_mm"] = offset;
    const double sigma = offset_sigma_mm(s, r, (between - offset * axis_r->normalized()).norm());
    if (sigma > 0.0 && std::isfinite(sigma)) row.z["offset_mm"] = offset / sigma;
  } else
    row.difference["axis_distance_mm"] = axis_r->normalized().cross(between).norm();
}

std::optional<ObjectFit> find_fit(const std::optional<measure::Measurement>& m, const std::string& object) {
  if (!m) return std::nullopt;
  for (const ObjectFit& fit : m->fits)
    if (fit.object == object) return fit;
  return std::nullopt;
}

void add_name(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

std::vector<std::string> object_names(const Twin& twin, const Side& real, const Side& simulated) {
  std::vector<std::string> names;
  for (const FitRequest& fit : twin.measure.fits) add_name(names, fit.object);
  for (const Side* side : {&simulated, &real})
    if (side->measurement)
      for (const ObjectFit& fit : side->measurement->fits) add_name(names, fit.object);
  for (const PublishedFit& fit : twin.real.results) add_name(names, fit.object);
  return names;
}

void warn_unusable(const std::optional<ObjectFit>& fit, const char* side,
                   std::vector<std::string>& warnings) {
  if (fit && !fit->usable)
    warnings.push_back(fmt::format("{} fit of \"{}\" (n = {}): {}", side, fit->object, fit->n, fit->warning));
}

}  // namespace

ObjectFit published_fit(const Twin& twin, const PublishedFit& published) {
  ObjectFit fit;
  fit.object = published.object;
  const Object* object = twin.find_object(published.object);
  fit.kind = object ? shape_kind(object->shape) : "";
  fit.usable = true;
  fit.numbers = published.numbers;
  fit.vectors = published.vectors;
  return fit;
}

FitRow make_fit_row(const std::optional<ObjectFit>& simulated, const std::optional<ObjectFit>& real) {
  FitRow row;
  const ObjectFit& any = simulated ? *simulated : real.value();
  row.object = any.object;
  row.kind = any.kind;
  row.simulated = simulated;
  row.real = real;
  if (!simulated || !real || !simulated->usable || !real->usable) return row;
  compare_numbers(*simulated, *real, row);
  compare_vectors(*simulated, *real, row);
  compare_placement(*simulated, *real, row);
  return row;
}

std::vector<FitRow> fit_rows(const Twin& twin, const Side& real, const Side& simulated,
                             std::vector<std::string>& warnings) {
  std::vector<FitRow> rows;
  for (const std::string& name : object_names(twin, real, simulated)) {
    const std::optional<ObjectFit> s = find_fit(simulated.measurement, name);
    std::optional<ObjectFit> r = find_fit(real.measurement, name);
    for (const PublishedFit& published : twin.real.results)
      if (!r && published.object == name) r = published_fit(twin, published);
    if (!s && !r) continue;
    rows.push_back(make_fit_row(s, r));
    if (s && r && !find_fit(real.measurement, name))
      estimate_published_z(simulated.measurement->cloud, rows.back());
    warn_unusable(s, "simulated", warnings);
    warn_unusable(r, "real", warnings);
  }
  return rows;
}

}  // namespace fringetwin::compare
