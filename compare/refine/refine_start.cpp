// SPDX-License-Identifier: Apache-2.0
#include "compare/refine/refine_start.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "measure/fit/object_fits.hpp"
#include "measure/fit/shape_fits.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kPoints = 20'000;  ///< a start needs no more
constexpr double kWideGateMm = 10.0, kGateDistances = 5.0;
constexpr int kNewtonSteps = 6;

std::vector<std::size_t> motions_among(const std::vector<Parameter>& parameters, const Object& object) {
  std::vector<std::size_t> at;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (parameters[k].group == "pose" && parameters[k].name.starts_with(object.name + ".")) at.push_back(k);
  return at;
}

/// The points of one object, and their distances to its surface.
struct OwnPoints {
  measure::PointCloud cloud;
  std::vector<double> distance_mm;
};

/// Gives every point, of some evenly drawn, to the object whose surface is nearest.
std::vector<OwnPoints> own_points(const Twin& twin, const measure::PointCloud& cloud) {
  std::vector<measure::SurfaceGate> surfaces;
  for (const Object& object : twin.objects)
    surfaces.emplace_back(object, std::numeric_limits<double>::infinity());
  std::vector<OwnPoints> own(twin.objects.size());
  for (std::size_t i = 0; i < cloud.size(); i += cloud.size() / kPoints + 1) {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < surfaces.size(); ++k)
      if (const double distance = surfaces[k].distance_mm(cloud.p_world_mm[i]); distance < least) {
        least = distance;
        nearest = k;
      }
    if (!std::isfinite(least)) continue;
    own[nearest].cloud.p_world_mm.push_back(cloud.p_world_mm[i]);
    own[nearest].distance_mm.push_back(least);
  }
  return own;
}

std::optional<Shape> fitted_shape(const Object& object, const measure::ObjectFit& fit) {
  if (!fit.usable) return std::nullopt;
  if (const auto* mesh = std::get_if<MeshShape>(&object.shape)) {
    RotTrans rt_object_measured;
    rt_object_measured << fit.vectors.at("T_object_measured_r_rad"), fit.vectors.at("T_object_measured_t_mm");
    MeshShape moved = *mesh;
    moved.T_world_object = pose_from_rt(rt_object_measured).inverse() * mesh->T_world_object;
    return moved;
  }
  std::optional<Shape> shape =
      std::visit([&](const auto& s) { return measure::fitted_shape(s, fit); }, object.shape);
  if (const auto* nominal = std::get_if<PlaneShape>(&object.shape)) {
    auto& plane = std::get<PlaneShape>(*shape);  // its normal looks at the camera, the twin's where it likes
    if (plane.normal.dot(nominal->normal) < 0.0) plane.normal = -plane.normal;
  }
  return shape;
}

}  // namespace

std::vector<FittedPlace> fitted_places(const Twin& twin, const std::vector<Parameter>& parameters,
                                       const measure::PointCloud& cloud) {
  std::vector<FittedPlace> places;
  const auto moves = [&](const Object& object) { return !motions_among(parameters, object).empty(); };
  if (std::ranges::none_of(twin.objects, moves)) return places;  // distances to a measured mesh cost seconds
  std::vector<OwnPoints> own = own_points(twin, cloud);
  for (std::size_t k = 0; k < twin.objects.size(); ++k) {
    const Object& object = twin.objects[k];
    if (own[k].distance_mm.empty() || !moves(object)) continue;
    std::set<double> gates_mm{kWideGateMm};
    for (const FitRequest& asked : twin.measure.fits)
      if (asked.object == object.name) gates_mm.insert(asked.gate_mm);
    gates_mm.insert(std::max(kWideGateMm, kGateDistances * upper_median(own[k].distance_mm)));
    Twin fitted = twin;
    for (const double gate_mm : gates_mm) {
      throw_if_cancelled();
      fitted.measure.fits = {{object.name, gate_mm}};
      if (auto shape = fitted_shape(object, measure::fit_objects(fitted, own[k].cloud).front()))
        places.push_back({k, std::move(*shape)});
    }
  }
  return places;
}

Eigen::VectorXd values_at(const Twin& twin, const std::vector<Parameter>& parameters, Eigen::VectorXd values,
                          const FittedPlace& place) {
  const std::vector<std::size_t> at = motions_among(parameters, twin.objects[place.object]);
  const Vector3d near_mm =
      std::visit([](const auto& s) { return place_mm(s); }, place.shape).value_or(Vector3d::Zero());
  const auto marks_of = [&](const Shape& shape) {
    const measure::Marks m = std::visit([&](const auto& s) { return measure::marks_mm(s, near_mm); }, shape);
    return Eigen::VectorXd(m.reshaped());
  };
  const auto marks_with = [&](const Eigen::VectorXd& v) {
    return marks_of(with_values(twin, parameters, v).objects[place.object].shape);
  };
  const Eigen::VectorXd wanted = marks_of(place.shape);
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Eigen::VectorXd here = marks_with(values);
    Eigen::MatrixXd slope(here.size(), static_cast<Eigen::Index>(at.size()));
    for (std::size_t j = 0; j < at.size(); ++j) {
      Eigen::VectorXd next = values;
      next[at[j]] += parameters[at[j]].step;
      slope.col(static_cast<Eigen::Index>(j)) = (marks_with(next) - here) / parameters[at[j]].step;
    }
    const Eigen::VectorXd change = slope.colPivHouseholderQr().solve(wanted - here);
    for (std::size_t j = 0; j < at.size(); ++j) values[at[j]] += change[static_cast<Eigen::Index>(j)];
  }
  return values;
}

std::vector<std::size_t> alike_in_all_images(const Twin& twin, const std::vector<Parameter>& parameters) {
  std::size_t n_pitches = 0;
  for (const DirectionFringes& d : twin.fringes.directions) n_pitches += d.pitches_px.size();
  std::vector<std::size_t> same;
  for (std::size_t k = 0; n_pitches == 1 && twin.fringes.steps > 0 && k < parameters.size(); ++k)
    if (const int order = parameters[k].harmonic; order > 0 && order % twin.fringes.steps == 0)
      same.push_back(k);
  return same;
}

void start_at_fitted_places(GroupFit& fit, const Twin& twin, const measure::PointCloud& cloud) {
  for (const FittedPlace& place : fitted_places(twin, fit.parameters(), cloud))
    if (fit.start_at(values_at(twin, fit.parameters(), fit.values(), place)))
      say(fmt::format("refine: {} begins where its fit to the real points puts it, chi2 {:.5g}",
                      twin.objects[place.object].name, fit.chi2()));
}

void start_late_or_early(GroupFit& fit) {
  constexpr double kTried = 0.05;  // periods
  const std::vector<Parameter>& parameters = fit.parameters();
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const Parameter& p = parameters[k];
    if (p.group != "timing" || !p.name.ends_with(".late")) continue;
    const auto at = static_cast<Eigen::Index>(k);
    const double now = fit.values()[at];
    for (const double to : {now + kTried, now - kTried}) {
      throw_if_cancelled();
      Eigen::VectorXd tried = fit.values();
      tried[at] = std::clamp(to, p.smallest, p.largest);
      fit.start_at(tried);
    }
  }
}

}  // namespace fringetwin::compare
