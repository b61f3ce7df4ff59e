// SPDX-License-Identifier: Apache-2.0
// [[measure.fit]]: gate the cloud to each object, fit its shape robustly, name the numbers.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "measure/fit/block_covariance.hpp"
#include "measure/fit/closest_point.hpp"
#include "measure/fit/fits.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

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

/// The points of one fit and where they come from.
struct Gated {
  std::vector<Eigen::Vector3d> p_mm;
  std::vector<int> block;  ///< image block of each point's source pixel; empty when unknown
  Eigen::Vector3d viewer_mm = Eigen::Vector3d::Zero();
  double gate_mm = 0.0;
};

FitOptions robust_options(const Gated& points) {
  FitOptions options;
  options.loss = RobustLoss::tukey;
  options.block = points.block;
  return options;
}

void fit_shape(const SphereShape& shape, const Gated& points, ObjectFit& row) {
  const SphereFit fit = fit_sphere(points.p_mm, shape, robust_options(points));
  take_summary(fit, row);
  const Eigen::Vector4d sigma = fit.covariance.diagonal().cwiseSqrt();
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  row.vectors["center_mm"] = fit.usable ? fit.center_mm : none;
  row.vectors["center_sigma_mm"] = fit.usable ? Eigen::Vector3d(sigma.head<3>()) : none;
  row.numbers["radius_mm"] = fit.usable ? fit.radius_mm : kNaN;
  row.numbers["radius_sigma_mm"] = fit.usable ? sigma[3] : kNaN;
}

void fit_shape(const PlaneShape&, const Gated& points, ObjectFit& row) {
  const PlaneFit fit = fit_plane(points.p_mm, robust_options(points));
  take_summary(fit, row);
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  row.vectors["point_mm"] = fit.usable ? fit.point_mm : none;
  row.vectors["normal"] = fit.usable ? towards(fit.normal, fit.point_mm, points.viewer_mm) : none;
  row.numbers["offset_sigma_mm"] = fit.usable ? fit.offset_sigma_mm : kNaN;
  row.numbers["tilt_sigma_rad_0"] = fit.usable ? fit.tilt_sigma_rad[0] : kNaN;
  row.numbers["tilt_sigma_rad_1"] = fit.usable ? fit.tilt_sigma_rad[1] : kNaN;
}

void fit_shape(const CylinderShape& shape, const Gated& points, ObjectFit& row) {
  const CylinderFit fit = fit_cylinder(points.p_mm, shape, robust_options(points));
  take_summary(fit, row);
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  row.vectors["point_mm"] = fit.usable ? fit.point_mm : none;
  row.vectors["axis"] = fit.usable ? fit.axis : none;
  row.numbers["radius_mm"] = fit.usable ? fit.radius_mm : kNaN;
  row.numbers["radius_sigma_mm"] = fit.usable ? fit.radius_sigma_mm : kNaN;
  row.numbers["axis_sigma_rad_0"] = fit.usable ? fit.axis_sigma_rad[0] : kNaN;
  row.numbers["axis_sigma_rad_1"] = fit.usable ? fit.axis_sigma_rad[1] : kNaN;
}

void fit_shape(const MeshShape& shape, const Gated& points, ObjectFit& row) {
  const MeshFit fit = register_mesh(points.p_mm, shape, points.gate_mm);
  take_summary(fit, row);
  std::vector<double> absolute;
  double sum = 0.0;
  for (const float d : fit.deviation_mm) {
    sum += static_cast<double>(d);
    absolute.push_back(std::abs(static_cast<double>(d)));
  }
  const bool some = fit.usable && !absolute.empty();
  row.numbers["rms_all_mm"] = some ? fit.rms_mm : kNaN;  // nothing within the gate is left out
  row.numbers["mean_mm"] = some ? sum / static_cast<double>(absolute.size()) : kNaN;
  row.numbers["p95_mm"] = some ? lower_quantile(absolute, 0.95) : kNaN;
  row.numbers["within_10um"] = some ? fit.within_10um : kNaN;
  const RotTrans rt = rt_from_pose(fit.T_object_measured);
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  row.vectors["T_object_measured_r_rad"] = some ? Eigen::Vector3d(rt.head<3>()) : none;
  row.vectors["T_object_measured_t_mm"] = some ? Eigen::Vector3d(rt.tail<3>()) : none;
  row.index = fit.index;
  row.deviation_mm = fit.deviation_mm;
}

void fit_shape(const MeasuredShape&, const Gated& points, ObjectFit& row) {
  row.n = points.p_mm.size();
  row.warning = "the object is built from a measurement: it has no nominal surface to fit";
}

/// Signed distances of the gated points to the fitted surface, and which of them count as inliers.
void add_deviations(const Object& fitted, const std::vector<Eigen::Vector3d>& p, std::size_t n_used,
                    ObjectFit& row) {
  std::vector<double> distance(p.size());
  double sum_sq = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    distance[i] = surface_distance_mm(fitted, p[i]);
    sum_sq += distance[i] * distance[i];
  }
  row.numbers["rms_all_mm"] = std::sqrt(sum_sq / static_cast<double>(p.size()));
  double limit = std::numeric_limits<double>::infinity();
  if (n_used < p.size()) {
    std::vector<double> absolute;
    for (const double d : distance) absolute.push_back(std::abs(d));
    limit = nth_smallest(absolute, n_used - 1);  // the inliers are the nearest points
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

Gated take_points(const PointCloud& cloud, const std::vector<std::size_t>& index,
                  const Eigen::Vector3d& viewer_mm, double gate_mm) {
  Gated points;
  points.viewer_mm = viewer_mm;
  points.gate_mm = gate_mm;
  points.p_mm.reserve(index.size());
  for (const std::size_t i : index) points.p_mm.push_back(cloud.p_world_mm[i]);
  if (cloud.q_cam_px.size() != cloud.size()) return points;
  std::vector<Eigen::Vector2f> pixels;
  pixels.reserve(index.size());
  for (const std::size_t i : index) pixels.push_back(cloud.q_cam_px[i]);
  points.block = image_blocks(pixels);
  return points;
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
    const Gated points = take_points(cloud, gated, viewer, request.gate_mm);
    std::visit([&](const auto& shape) { fit_shape(shape, points, row); }, object->shape);
    if (row.usable) add_shape_deviations(points.p_mm, row);
    for (std::size_t& i : row.index) i = gated[i];
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace fringetwin::measure
