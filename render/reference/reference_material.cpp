// SPDX-License-Identifier: Apache-2.0
#include "render/reference/reference_material.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace fringetwin::render {
namespace {

double smith_g1(double cosine, double alpha) {
  const double tangent = std::tan(std::acos(std::min(1.0, cosine)));
  return 2.0 / (1.0 + std::sqrt(1.0 + alpha * alpha * tangent * tangent));
}

}  // namespace

double reference_ggx(const Eigen::Vector3d& N, const Eigen::Vector3d& L, const Eigen::Vector3d& V,
                     double reflectance, double roughness) {
  const double cos_l = N.dot(L), cos_v = N.dot(V), alpha = roughness * roughness;
  if (cos_l <= 0.0 || cos_v <= 0.0) return 0.0;
  const Eigen::Vector3d H = (L + V).normalized();
  const double cos_m = std::min(1.0, N.dot(H)), theta_m = std::atan2((N - cos_m * H).norm(), cos_m);
  const double spread = alpha * alpha + std::pow(std::tan(theta_m), 2);
  const double D = alpha * alpha / (std::numbers::pi * std::pow(std::cos(theta_m), 4) * spread * spread);
  const double F = reflectance + (1.0 - reflectance) * std::pow(1.0 - H.dot(L), 5);
  return F * D * smith_g1(cos_l, alpha) * smith_g1(cos_v, alpha) / (4.0 * cos_l * cos_v);
}

double reference_reflected(const Material& material, double albedo, const Eigen::Vector3d& N,
                           const Eigen::Vector3d& L, const Eigen::Vector3d& V, bool lobe) {
  const double cosine = N.dot(L), diffuse = material.diffuse * albedo / std::numbers::pi * cosine;
  if (!lobe || material.specular == 0.0) return diffuse;
  if (material.specular_model == Material::Specular::ggx)
    return diffuse + reference_ggx(N, L, V, material.specular, material.roughness) * cosine;
  const double mirrored = (2.0 * cosine * N - L).dot(V);
  return diffuse + material.specular * std::pow(std::max(0.0, mirrored), material.shininess);
}

double reference_vignetting(const Camera& camera, const Eigen::Vector2d& q_px) {
  switch (camera.vignetting.kind) {
    case Vignetting::Kind::none:
      return 1.0;
    case Vignetting::Kind::cos4: {
      const auto d = camera.lens.unproject(q_px);
      return d ? std::pow(std::cos(std::atan2(d->head<2>().norm(), d->z())), 4) : 0.0;
    }
    case Vignetting::Kind::polynomial: {
      const Eigen::Vector2d size = camera.sensor_px().cast<double>();
      const Eigen::Vector2d from_middle =
          (camera.on_sensor_px(q_px) - 0.5 * (size - Eigen::Vector2d::Ones())) / (0.5 * size.norm());
      const double r = from_middle.norm();
      double factor = 1.0 + from_middle.dot(Eigen::Vector2d(camera.vignetting.tilt.data()));
      for (int i = 0; i < 3; ++i) factor += camera.vignetting.a[i] * std::pow(r, 2 * i + 2);
      return factor;
    }
  }
  return 1.0;
}

double reference_map_albedo(const PlaneShape& plane, const Eigen::Vector3d& point_world_mm) {
  if (!plane.albedo_map) return 1.0;
  const ImageF& map = *plane.albedo_map;
  const Eigen::Vector3d r = point_world_mm - plane.point_mm;
  const Eigen::Vector3d across = plane.normal.cross(plane.u_axis);
  // from the corner, in pixels of the map; pixel i has its centre at i + 1/2
  const double x = (r.dot(plane.u_axis) / plane.size_mm->x() + 0.5) * map.width;
  const double y = (r.dot(across) / plane.size_mm->y() + 0.5) * map.height;
  double sum = 0.0, weights = 0.0;
  for (int j = -1; j <= map.height; ++j) {
    const double wy = std::max(0.0, 1.0 - std::abs(y - (j + 0.5)));
    if (wy == 0.0) continue;
    for (int i = -1; i <= map.width; ++i) {
      const double w = wy * std::max(0.0, 1.0 - std::abs(x - (i + 0.5)));
      if (w == 0.0) continue;
      sum += w * map(std::clamp(i, 0, map.width - 1), std::clamp(j, 0, map.height - 1));
      weights += w;
    }
  }
  return sum / weights;
}

}  // namespace fringetwin::render
