// SPDX-License-Identifier: Apache-2.0
#include "study/noise/noise_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include "measure/decode/mixed_pixels.hpp"
#include "render/reference/reference_shapes.hpp"
#include "study/noise/theory_scope.hpp"
#include "twin/base/errors.hpp"
#include "twin/number/sinc.hpp"

namespace fringetwin::study {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

const Object& checked(const Twin& twin, const std::string& name) {
  if (const std::string outside = outside_noise_theory(twin, name); !outside.empty())
    throw UserError(ExitCode::usage, twin.file.string(), "the theory of the noise does not know " + outside,
                    "record the fits alone");
  return *twin.find_object(name);
}

/// Sets the sides of a pixel as they lie on the tangent plane.
void set_footprint(const Camera& camera, const Vector2d& q_px, SurfacePoint* s) {
  const Eigen::Matrix3d R_world_cam = camera.T_cam_world.rotation.transpose();
  for (int k = 0; k < 2; ++k) {
    Vector3d rays[2];
    for (int side = 0; side < 2; ++side) {
      const auto ray = camera.lens.unproject(q_px + (side == 0 ? -0.5 : 0.5) * Vector2d::Unit(k));
      rays[side] = ray ? Vector3d(R_world_cam * *ray) : s->d;
    }
    const Vector3d turn = rays[1] - rays[0];
    s->edge_mm[k] = s->range_mm * (turn - s->d * s->n.dot(turn) / s->n.dot(s->d));
  }
}

}  // namespace

NoiseScene::NoiseScene(const Twin& twin, const std::string& object)
    : twin_(twin),
      object_(checked(twin, object)),
      axis_(twin.fringes.directions[0].axis == Axis::x ? 0 : 1) {}

std::optional<SurfacePoint> NoiseScene::meet(const Camera& camera, const Vector2d& q_px) const {
  const auto ray = camera.lens.unproject(q_px);
  if (!ray) return std::nullopt;
  const Pose T_world_cam = camera.T_cam_world.inverse();
  const render::Ray r{T_world_cam.translation_mm, T_world_cam.rotation * *ray};
  const auto* sphere = std::get_if<SphereShape>(&object_.shape);
  const auto hit = sphere != nullptr
                       ? render::intersect(*sphere, r, 0.0, HUGE_VAL)
                       : render::intersect(std::get<PlaneShape>(object_.shape), r, 0.0, HUGE_VAL);
  if (!hit) return std::nullopt;
  SurfacePoint s;
  s.d = r.direction;
  s.range_mm = hit->t_mm;
  s.p_mm = r.origin_mm + s.range_mm * s.d;
  s.n = hit->normal;
  if (s.n.dot(s.d) > 0.0) {
    if (sphere != nullptr) return std::nullopt;  // from inside
    s.n = -s.n;
  }
  return s;
}

std::optional<SurfacePoint> NoiseScene::see(const Camera& camera, const Vector2d& q_px) const {
  std::optional<SurfacePoint> s = meet(camera, q_px);
  if (!s || !locate(&*s)) return std::nullopt;
  set_footprint(camera, q_px, &*s);
  if (!set_noise(camera, &*s)) return std::nullopt;
  return s;
}

bool NoiseScene::is_used(const Camera& camera, int x, int y) const {
  const auto inside = [&](int i, int j) {
    return i >= 0 && j >= 0 && i < camera.lens.width() && j < camera.lens.height();
  };
  const auto at = [&](int i, int j) { return see(camera, Vector2d(i, j)); };
  const auto own = inside(x, y) ? at(x, y) : std::nullopt;
  if (!own) return false;
  if (sees_all(camera, x - 1, y - 1, 2)) return true;
  // three quarters of what gives light to a pixel, where the outline cuts it
  const double cut = 1.0 - 0.25 * std::min(1.0, twin_.sampled_side_px(camera));
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      if ((dx == 0 && dy == 0) || !inside(x - dx, y - dy) || !inside(x + 2 * dx, y + 2 * dy)) continue;
      if (at(x - dx, y - dy)) continue;
      const auto first = at(x + dx, y + dy), second = at(x + 2 * dx, y + 2 * dy);
      if (!first || !second) continue;
      const double filled = meet(camera, Vector2d(x - dx, y - dy)) ? 1.0 : cut;
      const double shift_px =
          measure::centroid_shift_px(filled * own->amplitude_dn, first->amplitude_dn, second->amplitude_dn);
      const double slope = std::abs(first->coordinate_px - second->coordinate_px);
      if (shift_px * slope > std::sqrt(own->variance_px2)) return false;
    }
  return true;
}

bool NoiseScene::is_readable(const Camera& camera, const Vector2d& q_px) const {
  const int x = static_cast<int>(std::floor(q_px.x())), y = static_cast<int>(std::floor(q_px.y()));
  if (sees_all(camera, x - 1, y - 1, 3)) return true;
  return is_used(camera, x, y) && is_used(camera, x + 1, y) && is_used(camera, x, y + 1) &&
         is_used(camera, x + 1, y + 1);
}

bool NoiseScene::sees_all(const Camera& camera, int x, int y, int width) const {
  if (x < 0 || y < 0 || x + width >= camera.lens.width() || y + width >= camera.lens.height()) return false;
  for (const int dy : {0, width})
    for (const int dx : {0, width})
      if (!see(camera, Vector2d(x + dx, y + dy))) return false;
  return true;
}

bool NoiseScene::locate(SurfacePoint* s) const {
  const Projector& projector = *twin_.projector;
  Eigen::Matrix<double, 2, 3> dq_dp;
  const auto q = projector.lens.project(projector.T_proj_world * s->p_mm, &dq_dp);
  if (!q || q->x() < -0.5 || q->y() < -0.5 || q->x() > projector.lens.width() - 0.5 ||
      q->y() > projector.lens.height() - 0.5)
    return false;
  s->coordinate_px = (*q)[axis_];
  s->gradient = (dq_dp * projector.T_proj_world.rotation).row(axis_).transpose();
  return true;
}

/// The noise of the mean over the pitches, inverse-variance weighted with heterodyne fringes; false where the
/// fringes are too weak or saturate.
bool NoiseScene::set_noise(const Camera& camera, SurfacePoint* s) const {
  const Projector& projector = *twin_.projector;
  const Sensor& sensor = camera.sensor;
  const Vector3d to_light = projector.center_world_mm() - s->p_mm;
  const double cosine = s->n.dot(to_light.normalized());
  if (cosine <= 0.0) return false;
  double w = projector.intensity * object_.material.diffuse / std::numbers::pi * cosine;
  if (projector.inverse_square)
    w *= projector.reference_distance_mm * projector.reference_distance_mm / to_light.squaredNorm();
  const Fringes& fringes = twin_.fringes;
  const double signal_dn = sensor.gain_dn * (fringes.mean * w + projector.ambient);
  const double read = sensor.read_noise_dn.value_or(0.0);
  const double sigma2_dn2 =
      1.0 / 12.0 + read * read + (sensor.electrons_per_dn ? signal_dn / *sensor.electrons_per_dn : 0.0);
  const DirectionFringes& direction = fringes.directions[0];
  double information = 0.0;
  for (std::size_t k = 0; k < direction.pitches_px.size(); ++k) {
    const double wave = 2.0 * std::numbers::pi / direction.pitches_px[k];
    double amplitude = sensor.gain_dn * fringes.amplitude * w *
                       std::exp(-0.5 * wave * wave * projector.blur_px * projector.blur_px);
    for (const Vector3d& edge : s->edge_mm)
      amplitude *= sinc(0.5 * twin_.sampled_side_px(camera) * wave * s->gradient.dot(edge));
    amplitude = std::abs(amplitude);
    if (amplitude < twin_.measure.min_modulation_dn) return false;
    if (sensor.black_level_dn + signal_dn + amplitude >= sensor.max_dn()) return false;
    const bool finest = static_cast<int>(k) == direction.finest();
    if (finest) s->amplitude_dn = amplitude;
    const double one = 2.0 / fringes.steps * sigma2_dn2 / (amplitude * amplitude) / (wave * wave);
    if (fringes.unwrap == Unwrap::heterodyne)
      information += 1.0 / one;
    else if (finest)
      information = 1.0 / one;
  }
  s->variance_px2 = 1.0 / information;
  return true;
}

}  // namespace fringetwin::study
