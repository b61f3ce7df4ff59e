// SPDX-License-Identifier: Apache-2.0
#include "compare/geometry/moved_fits.hpp"

#include <cmath>
#include <optional>
#include <utility>

#include "compare/geometry/fit_rows.hpp"
#include "measure/fit/object_fits.hpp"

namespace fringetwin::compare {
namespace {

using Eigen::Vector3d;
using measure::ObjectFit;

/// Returns the point of a fitted plane (`is_plane`) or axis that is nearest to p_mm.
Vector3d nearest_mm(const ObjectFit& surface, bool is_plane, const Vector3d& p_mm) {
  const Vector3d& point_mm = surface.vectors.at("point_mm");
  const Vector3d way = surface.vectors.at(is_plane ? "normal" : "axis").normalized();
  const Vector3d along_mm = way.dot(p_mm - point_mm) * way;
  return is_plane ? Vector3d(p_mm - along_mm) : Vector3d(point_mm + along_mm);
}

/// Returns the fit changed by what `to` differs from `from`, both nominal. A normal or an axis may point
/// either way.
ObjectFit moved(const ObjectFit& fit, const ObjectFit& from, const ObjectFit& to) {
  ObjectFit out = fit;
  if (to.numbers.contains("radius_mm"))
    out.numbers["radius_mm"] += to.numbers.at("radius_mm") - from.numbers.at("radius_mm");
  if (to.vectors.contains("center_mm"))
    out.vectors["center_mm"] += to.vectors.at("center_mm") - from.vectors.at("center_mm");
  for (const char* key : {"normal", "axis"}) {
    if (!to.vectors.contains(key)) continue;
    const bool is_plane = std::string(key) == "normal";
    Vector3d &way = out.vectors[key], &point_mm = out.vectors["point_mm"];
    point_mm += nearest_mm(to, is_plane, point_mm) - nearest_mm(from, is_plane, point_mm);
    const Vector3d was = from.vectors.at(key).normalized(), is = to.vectors.at(key).normalized();
    way = (way + std::copysign(1.0, was.dot(way)) * (is - was)).normalized();
    for (const char* across : {"tilt_direction_0", "tilt_direction_1"})
      if (const auto at = out.vectors.find(across); at != out.vectors.end())
        at->second = (at->second - way.dot(at->second) * way).normalized();
  }
  return out;
}

}  // namespace

std::vector<FitRow> moved_fits(const std::vector<FitRow>& rows, const Twin& twin, const Twin& changed) {
  std::vector<FitRow> out;
  for (const FitRow& row : rows) {
    const Object *from = twin.find_object(row.object), *to = changed.find_object(row.object);
    if (!from || !to || !row.simulated || !row.real || !row.simulated->usable || !row.real->usable) continue;
    const std::optional<ObjectFit> nominal_from = measure::nominal_fit(*from),
                                   nominal_to = measure::nominal_fit(*to);
    if (nominal_from && nominal_to)
      out.push_back(make_fit_row(moved(*row.simulated, *nominal_from, *nominal_to), row.real));
  }
  return out;
}

std::map<std::string, double> z_by_name(const std::vector<FitRow>& rows) {
  std::map<std::string, double> out;
  for (const FitRow& row : rows) {
    for (const auto& [key, z] : row.z) out[row.object + "." + key] = z;
    for (const auto& [key, z] : row.z_vectors)
      for (int i = 0; i < 3; ++i)
        if (std::isfinite(z[i])) out[row.object + "." + key + "." + "xyz"[i]] = z[i];
  }
  return out;
}

Eigen::VectorXd with_uncertain_values(const Eigen::VectorXd& z, const Eigen::MatrixXd& slopes,
                                      const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd more = (slopes * covariance).cwiseProduct(slopes).rowwise().sum();
  return z.array() / (1.0 + more.array().max(0.0)).sqrt();
}

}  // namespace fringetwin::compare
