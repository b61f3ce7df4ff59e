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

/// Enters a difference and, where both sides state a standard error, its z. `besides_sigma`: of what moves
/// the difference and stands in neither.
void enter(const std::string& key, double difference, double besides_sigma, const ObjectFit& s,
           const ObjectFit& r, FitRow& row) {
  row.difference[key] = difference;
  const double z = difference / std::hypot(value_or(s.numbers, sigma_key(key), kNaN),
                                           value_or(r.numbers, sigma_key(key), kNaN), besides_sigma);
  if (std::isfinite(z)) row.z[key] = z;
}

void compare_numbers(const ObjectFit& s, const ObjectFit& r, FitRow& row) {
  for (const auto& [key, value] : s.numbers) {
    const double* other = find_value(r.numbers, key);
    if (other && !is_sigma_key(key) && !is_count_key(key)) enter(key, value - *other, 0.0, s, r, row);
  }
}

void compare_vectors(const ObjectFit& s, const ObjectFit& r, FitRow& row) {
  for (const auto& [key, value] : s.vectors) {
    const Vector3d* other = find_value(r.vectors, key);
    if (!other || is_sigma_key(key) || is_direction_key(key)) continue;
    const Vector3d difference = value - *other;
    row.difference_vectors[key] = difference;
    const Vector3d *sigma_s = find_value(s.vectors, sigma_key(key)),
                   *sigma_r = find_value(r.vectors, sigma_key(key));
    if (!sigma_s || !sigma_r) continue;
    Vector3d z;
    for (int i = 0; i < 3; ++i) {
      z[i] = difference[i] / std::hypot((*sigma_s)[i], (*sigma_r)[i]);
      if (!std::isfinite(z[i])) z[i] = kNaN;
    }
    if (!z.array().isNaN().all()) row.z_vectors[key] = z;
  }
}

/// Returns the angle of two axes, sign-free; exact for small angles.
double axis_angle_rad(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

/// Compares the tilts of planes (sign 1: how a plane rises) or axes (-1: how it leans) along the simulated
/// fit's two directions, exactly for every angle; the senses of normals and axes mean nothing.
void compare_tilts(const std::string& key, double sign, const Vector3d& axis_r, const ObjectFit& s,
                   const ObjectFit& r, FitRow& row) {
  const Vector3d *way_0 = find_value(s.vectors, "tilt_direction_0"),
                 *way_1 = find_value(s.vectors, "tilt_direction_1");
  if (!way_0 || !way_1) return;
  const double along = way_0->cross(*way_1).dot(axis_r), sense = std::copysign(1.0, sign * along);
  enter(key + "_0", std::atan2(sense * axis_r.dot(*way_0), std::abs(along)), 0.0, s, r, row);
  enter(key + "_1", std::atan2(sense * axis_r.dot(*way_1), std::abs(along)), 0.0, s, r, row);
}

/// Compares distance along the real normal. Its standard error has, besides both offsets, the tilt of the
/// real plane over the way between the centroids: the larger one, whatever the way's direction.
void compare_planes(const Vector3d& normal_r, const Vector3d& between_mm, const ObjectFit& s,
                    const ObjectFit& r, FitRow& row) {
  const double offset = normal_r.dot(between_mm);
  const Eigen::Vector2d tilt_sigma(value_or(r.numbers, "tilt_sigma_rad_0", kNaN),
                                   value_or(r.numbers, "tilt_sigma_rad_1", kNaN));
  enter("offset_mm", offset,
        (between_mm - offset * normal_r).norm() * tilt_sigma.maxCoeff<Eigen::PropagateNaN>(), s, r, row);
  compare_tilts("tilt_rad", 1.0, normal_r, s, r, row);
}

/// Compares the places of axes across the simulated one, beside the real axis's point. Their standard error
/// has, besides both places, the tilt of the simulated axis over the way to there.
void compare_axes(const Vector3d& axis_s, const Vector3d& axis_r, const Vector3d& between_mm,
                  const ObjectFit& s, const ObjectFit& r, FitRow& row) {
  row.difference["axis_distance_mm"] = axis_r.cross(between_mm).norm();
  compare_tilts("axis_rad", -1.0, axis_r, s, r, row);
  for (const std::string end : {"_0", "_1"})
    if (const Vector3d* way = find_value(s.vectors, "tilt_direction" + end))
      enter("axis_shift_mm" + end, way->dot(between_mm),
            axis_s.dot(between_mm) * value_or(s.numbers, "axis_sigma_rad" + end, kNaN), s, r, row);
}

/// Compares place and direction where the fits have a normal or an axis: the point of a plane or an axis is a
/// convention and cannot be compared.
void compare_placement(const ObjectFit& s, const ObjectFit& r, FitRow& row) {
  const bool plane = s.vectors.contains("normal");
  const char* axis_key = plane ? "normal" : "axis";
  const Vector3d *axis_s = find_value(s.vectors, axis_key), *axis_r = find_value(r.vectors, axis_key);
  const Vector3d *point_s = find_value(s.vectors, "point_mm"), *point_r = find_value(r.vectors, "point_mm");
  if (!axis_s || !axis_r || !point_s || !point_r) return;
  row.difference["angle_rad"] = axis_angle_rad(*axis_s, *axis_r);
  const Vector3d between_mm = *point_s - *point_r;
  if (plane)
    compare_planes(axis_r->normalized(), between_mm, s, r, row);
  else
    compare_axes(axis_s->normalized(), axis_r->normalized(), between_mm, s, r, row);
}

std::optional<ObjectFit> find_fit(const std::optional<measure::Measurement>& m, const std::string& object) {
  if (!m) return std::nullopt;
  for (const ObjectFit& fit : m->fits)
    if (fit.object == object) return fit;
  return std::nullopt;
}

void add_name(std::vector<std::string>& names, const std::string& name) {
  if (std::ranges::find(names, name) == names.end()) names.push_back(name);
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
  ObjectFit fit{.object = published.object};
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
