// SPDX-License-Identifier: Apache-2.0
#include "measure/fit/object_fits.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "measure/fit/block_covariance.hpp"
#include "measure/fit/closest_point.hpp"
#include "measure/fit/shape_fits.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

double surface_distance_mm(const Shape& shape, const Eigen::Vector3d& p_world_mm) {
  return std::visit([&](const auto& s) { return distance_mm(s, p_world_mm); }, shape);
}

std::vector<std::size_t> gate(const Object& object, double gate_mm, const PointCloud& cloud) {
  std::vector<unsigned char> inside(cloud.size(), 0);
  const SurfaceGate surface(object, gate_mm);
  const auto n = static_cast<std::ptrdiff_t>(cloud.size());
#pragma omp parallel for schedule(dynamic, 512)
  for (std::ptrdiff_t i = 0; i < n; ++i) inside[i] = std::isfinite(surface.distance_mm(cloud.p_world_mm[i]));
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (inside[i]) index.push_back(i);
  return index;
}

/// Signed distances of the gated points to the fitted surface, and which of them count as inliers.
void add_deviations(const Shape& fitted, const std::vector<Eigen::Vector3d>& p, std::size_t n_used,
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

Gated take_points(const PointCloud& cloud, const std::vector<std::size_t>& index,
                  const Eigen::Vector3d& viewer_mm, double gate_mm) {
  Gated points{.viewer_mm = viewer_mm, .gate_mm = gate_mm};
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

bool has_nominal_surface(const Object& object) {
  const auto* mesh = std::get_if<MeshShape>(&object.shape);
  return mesh ? mesh->mesh != nullptr : !std::holds_alternative<MeasuredShape>(object.shape);
}

SurfaceGate::SurfaceGate(const Object& object, double gate_mm) : object_(object), gate_mm_(gate_mm) {
  if (const auto* mesh = std::get_if<MeshShape>(&object.shape)) {
    mesh_ = mesh_distance_for(mesh->mesh);
    T_object_world_ = mesh->T_world_object.inverse();
  }
}

double SurfaceGate::distance_mm(const Eigen::Vector3d& p_world_mm) const {
  constexpr double kBeyond = std::numeric_limits<double>::infinity();
  if (mesh_) {
    const Eigen::Vector3d p_mm = T_object_world_ * p_world_mm;
    const ClosestPoint nearest = mesh_->query(p_mm, gate_mm_);
    return nearest.triangle >= 0 ? (nearest.point_mm - p_mm).norm() : kBeyond;
  }
  const double distance = std::abs(surface_distance_mm(object_.shape, p_world_mm));
  return distance <= gate_mm_ ? distance : kBeyond;
}

void take_summary(const FitSummary& fit, ObjectFit& row) {
  row.usable = fit.usable;
  row.warning = fit.message;
  row.n = fit.n;
  row.numbers["n_gated"] = static_cast<double>(fit.n_gated);
  row.numbers["rms_mm"] = fit.usable ? fit.rms_mm : kNaN;
}

void put(ObjectFit& row, const std::string& key, double value) {
  row.numbers[key] = row.usable ? value : kNaN;
}

void put(ObjectFit& row, const std::string& key, const Eigen::Vector3d& value) {
  row.vectors[key] = row.usable ? value : Eigen::Vector3d::Constant(kNaN);
}

void put_tilt_directions(ObjectFit& row, const Eigen::Vector3d& normal_or_axis,
                         const Eigen::Vector3d& first) {
  const Eigen::Vector3d second = normal_or_axis.cross(first).normalized();
  put(row, "tilt_direction_0", second.cross(normal_or_axis));
  put(row, "tilt_direction_1", second);
}

void put_across(ObjectFit& row, const std::string& key, const Eigen::Matrix3d& covariance) {
  for (const char* end : {"_0", "_1"}) {
    const Eigen::Vector3d& way = row.vectors.at(std::string("tilt_direction") + end);
    put(row, key + end, std::sqrt(way.dot(covariance * way)));
  }
}

FitOptions robust_options(const Gated& points) {
  FitOptions options{.loss = RobustLoss::tukey, .block = points.block};
  return options;
}

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
    ObjectFit row{.object = request.object, .kind = shape_kind(object->shape)};
    const std::vector<std::size_t> gated = gate(*object, request.gate_mm, cloud);
    const Gated points = take_points(cloud, gated, viewer, request.gate_mm);
    std::visit(
        [&](const auto& shape) {
          fit_shape(shape, points, row);
          if (!row.usable) return;
          if (const std::optional<Shape> fitted = fitted_shape(shape, row))
            add_deviations(*fitted, points.p_mm, row.n, row);
        },
        object->shape);
    for (std::size_t& i : row.index) i = gated[i];
    rows.push_back(std::move(row));
  }
  return rows;
}

std::optional<ObjectFit> nominal_fit(const Object& object) {
  ObjectFit fit{.object = object.name, .kind = shape_kind(object.shape), .usable = true};
  if (!std::visit([&](const auto& shape) { return name_numbers(shape, fit); }, object.shape))
    return std::nullopt;
  return fit;
}

double surface_distance_mm(const Object& object, const Eigen::Vector3d& p_world_mm) {
  return surface_distance_mm(object.shape, p_world_mm);
}

}  // namespace fringetwin::measure
