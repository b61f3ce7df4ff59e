// SPDX-License-Identifier: Apache-2.0
// [[measure.fit]]: gate the cloud to each object, fit its shape robustly, name the numbers.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "measure/closest_point.hpp"
#include "measure/fits.hpp"
#include "twin/errors.hpp"

namespace fringetwin::measure {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<std::size_t> gate(const Object& object, double gate_mm, const PointCloud& cloud) {
  std::vector<unsigned char> inside(cloud.size(), 0);
  std::shared_ptr<const MeshDistance> surface;
  Pose T_object_world;
  if (const auto* mesh = std::get_if<MeshShape>(&object.shape)) {
    surface = mesh_distance_for(mesh->mesh);
    T_object_world = mesh->T_world_object.inverse();
  }
  const auto n = static_cast<std::ptrdiff_t>(cloud.size());
#pragma omp parallel for schedule(dynamic, 512)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const Eigen::Vector3d& p = cloud.p_world_mm[i];
    inside[i] = surface ? surface->query(T_object_world * p, gate_mm).triangle >= 0
                        : std::abs(surface_distance_mm(object, p)) <= gate_mm;
  }
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (inside[i]) index.push_back(i);
  return index;
}

void take_summary(const FitSummary& fit, ObjectFit& row) {
  row.usable = fit.usable;
  row.warning = fit.message;
  row.n = fit.n;
  row.numbers["n_gated"] = static_cast<double>(fit.n_gated);
  row.numbers["rms_mm"] = fit.usable ? fit.rms_mm : kNaN;
}

Eigen::Vector3d towards(const Eigen::Vector3d& normal, const Eigen::Vector3d& from,
                        const Eigen::Vector3d& viewer) {
  return normal.dot(viewer - from) < 0.0 ? Eigen::Vector3d(-normal) : normal;
}

FitOptions robust_options() {
  FitOptions options;
  options.loss = RobustLoss::tukey;
  return options;
}

void fit_shape(const SphereShape& shape, double, const std::vector<Eigen::Vector3d>& p,
               const Eigen::Vector3d&, ObjectFit& row) {
  const SphereFit fit = fit_sphere(p, shape, robust_options());
  take_summary(fit, row);
  const Eigen::Vector4d sigma = fit.covariance.diagonal().cwiseSqrt();
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  row.vectors["center_mm"] = fit.usable ? fit.center_mm : none;
  row.vectors["center_sigma_mm"] = fit.usable ? Eigen::Vector3d(sigma.head<3>()) : none;
  row.numbers["radius_mm"] = fit.usable ? fit.radius_mm : kNaN;
  row.numbers["radius_sigma_mm"] = fit.usable ? sigma[3] : kNaN;
}

void fit_shape(const PlaneShape&, double, const std::vector<Eigen::Vector3d>& p,
               const Eigen::Vector3d& viewer, ObjectFit& row) {
  const PlaneFit fit = fit_plane(p, robust_options());
  take_summary(fit, row);
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  row.vectors["point_mm"] = fit.usable ? fit.point_mm : none;
  row.vectors["normal"] = fit.usable ? towards(fit.normal, fit.point_mm, viewer) : none;
  row.numbers["offset_sigma_mm"] = fit.usable ? fit.offset_sigma_mm : kNaN;
  row.numbers["tilt_sigma_rad_0"] = fit.usable ? fit.tilt_sigma_rad[0] : kNaN;
  row.numbers["tilt_sigma_rad_1"] = fit.usable ? fit.tilt_sigma_rad[1] : kNaN;
}

void fit_shape(const CylinderShape& shape, double, const std::vector<Eigen::Vector3d>& p,
               const Eigen::Vector3d&, ObjectFit& row) {
  const CylinderFit fit = fit_cylinder(p, shape, robust_options());
  take_summary(fit, row);
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  row.vectors["point_mm"] = fit.usable ? fit.point_mm : none;
  row.vectors["axis"] = fit.usable ? fit.axis : none;
  row.numbers["radius_mm"] = fit.usable ? fit.radius_mm : kNaN;
  row.numbers["radius_sigma_mm"] = fit.usable ? fit.radius_sigma_mm : kNaN;
  row.numbers["axis_sigma_rad_0"] = fit.usable ? fit.axis_sigma_rad[0] : kNaN;
  row.numbers["axis_sigma_rad_1"] = fit.usable ? fit.axis_sigma_rad[1] : kNaN;
}

void fit_shape(const MeshShape& shape, double gate_mm, const std::vector<Eigen::Vector3d>& p,
               const Eigen::Vector3d&, ObjectFit& row) {
  const MeshFit fit = register_mesh(p, shape, gate_mm);
  take_summary(fit, row);
  std::vector<double> absolute;
  double sum = 0.0;
  for (const float d : fit.deviation_mm) {
    sum += static_cast<double>(d);
    absolute.push_back(std::abs(static_cast<double>(d)));
  }
  const bool some = fit.usable && !absolute.empty();
  double p95 = kNaN;
  if (some) {
    const auto at =
        absolute.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(absolute.size() - 1));
    std::nth_element(absolute.begin(), at, absolute.end());
    p95 = *at;
  }
  row.numbers["mean_mm"] = some ? sum / static_cast<double>(absolute.size()) : kNaN;
  row.numbers["p95_mm"] = p95;
  row.numbers["within_10um"] = some ? fit.within_10um : kNaN;
  const RotTrans rt = rt_from_pose(fit.T_object_measured);
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  row.vectors["r_object_rad"] = some ? Eigen::Vector3d(rt.head<3>()) : none;
  row.vectors["t_object_mm"] = some ? Eigen::Vector3d(rt.tail<3>()) : none;
  row.index = fit.index;
  row.deviation_mm = fit.deviation_mm;
}

void fit_shape(const MeasuredShape&, double, const std::vector<Eigen::Vector3d>& p, const Eigen::Vector3d&,
               ObjectFit& row) {
  row.n = p.size();
  row.warning = "the object is built from a measurement: it has no nominal surface to fit";
}

/// Signed distances of the gated points to the fitted surface, and which of them count as inliers.
void add_deviations(const Object& fitted, const std::vector<Eigen::Vector3d>& p, std::size_t n_used,
                    ObjectFit& row) {
  std::vector<double> distance(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) distance[i] = surface_distance_mm(fitted, p[i]);
  double limit = std::numeric_limits<double>::infinity();
  if (n_used < p.size()) {
    std::vector<double> absolute;
    for (const double d : distance) absolute.push_back(std::abs(d));
    const auto at = absolute.begin() + static_cast<std::ptrdiff_t>(n_used - 1);
    std::nth_element(absolute.begin(), at, absolute.end());
    limit = *at;  // the inliers are the nearest points
  }
  for (std::size_t i = 0; i < p.size(); ++i)
    if (std::abs(distance[i]) <= limit) {
      row.index.push_back(i);
      row.deviation_mm.push_back(static_cast<float>(distance[i]));
    }
}

void add_shape_deviations(const std::vector<Eigen::Vector3d>& p, ObjectFit& row) {
  Object fitted;
  if (row.kind == "sphere")
    fitted.shape = SphereShape{row.vectors["center_mm"], row.numbers["radius_mm"]};
  else if (row.kind == "plane")
    fitted.shape = PlaneShape{
        row.vectors["point_mm"], row.vectors["normal"], {}, row.vectors["normal"].unitOrthogonal()};
  else if (row.kind == "cylinder")
    fitted.shape = CylinderShape{row.vectors["point_mm"], row.vectors["axis"], row.numbers["radius_mm"], {}};
  else
    return;
  add_deviations(fitted, p, row.n, row);
}

}  // namespace

std::vector<ObjectFit> fit_objects(const Twin& twin, const PointCloud& cloud) {
  std::vector<ObjectFit> rows;
  const Eigen::Vector3d viewer =
      twin.cameras.empty() ? Eigen::Vector3d::Zero() : twin.cameras.front().center_world_mm();
  for (const FitRequest& request : twin.measure.fits) {
    const Object* object = twin.find_object(request.object);
    if (!object)
      throw UserError(ExitCode::usage, twin.file.string(),
                      "measure.fit names the object \"" + request.object + "\", which is not there",
                      "use the name of an [[object]]");
    ObjectFit row;
    row.object = request.object;
    row.kind = shape_kind(object->shape);
    const std::vector<std::size_t> gated = gate(*object, request.gate_mm, cloud);
    std::vector<Eigen::Vector3d> p;
    p.reserve(gated.size());
    for (const std::size_t i : gated) p.push_back(cloud.p_world_mm[i]);
    std::visit([&](const auto& shape) { fit_shape(shape, request.gate_mm, p, viewer, row); }, object->shape);
    if (row.usable) add_shape_deviations(p, row);
    for (std::size_t& i : row.index) i = gated[i];
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace fringetwin::measure
