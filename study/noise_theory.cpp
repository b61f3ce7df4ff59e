// SPDX-License-Identifier: Apache-2.0
#include "study/noise_theory.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "measure/robust.hpp"
#include "twin/errors.hpp"

namespace fringetwin::study {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

/// A point of the object as one camera sees it.
struct SurfacePoint {
  Vector3d p_mm, n, d;  ///< world frame; n towards the camera, d the ray, both unit
  double range_mm = 0.0;
  double coordinate_px = 0.0;  ///< of the projector
  Vector3d gradient;           ///< of the coordinate in space, px/mm
  double variance_px2 = 0.0;   ///< of the decoded coordinate
  double area_mm2 = 0.0;       ///< of the surface in one pixel
};

double sinc(double x) { return std::abs(x) < 1e-9 ? 1.0 : std::sin(x) / x; }

/// What interpolation between pixels leaves of the variance of independent noise, per axis: the mean over the
/// place in a pixel of the sum of squared Catmull-Rom weights.
constexpr double kInterpolated = 57.0 / 70.0;

class Scene {
 public:
  Scene(const Twin& twin, const std::string& object)
      : twin_(twin),
        object_(checked(twin, object)),
        axis_(twin.fringes.directions[0].axis == Axis::x ? 0 : 1) {}

  /// Nothing where the pixel's centre sees no point of the object with a usable fringe.
  std::optional<SurfacePoint> see(const Camera& camera, const Vector2d& q_px) const {
    const auto ray = camera.lens.unproject(q_px);
    if (!ray) return std::nullopt;
    SurfacePoint s;
    const Pose T_world_cam = camera.T_cam_world.inverse();
    s.d = T_world_cam.rotation * *ray;
    if (!hit(T_world_cam.translation_mm, &s) || !locate(&s)) return std::nullopt;
    const Footprint f = footprint(camera, q_px, s);
    s.area_mm2 = f.area_mm2;
    const auto variance = coordinate_variance(camera, s, f);
    if (!variance) return std::nullopt;
    s.variance_px2 = *variance;
    return s;
  }

  bool is_sphere() const { return std::holds_alternative<SphereShape>(object_.shape); }

 private:
  struct Footprint {
    double step_px[2];  ///< change of the projector's coordinate per pixel, along x and y
    double area_mm2;
  };

  static const Object& checked(const Twin& twin, const std::string& name) {
    const auto refuse = [&](const std::string& why) {
      throw UserError(ExitCode::usage, twin.file.string(), "the theory of the noise does not know " + why,
                      "record the fits alone");
    };
    const Object* object = twin.find_object(name);
    if (object == nullptr) refuse("the object \"" + name + "\"");
    if (!std::holds_alternative<SphereShape>(object->shape) &&
        !std::holds_alternative<PlaneShape>(object->shape))
      refuse(std::string("objects of shape ") + shape_kind(object->shape));
    if (twin.objects.size() != 1) refuse("several objects");
    if (!twin.projector) refuse("a rig without projector");
    const Fringes& f = twin.fringes;
    if (f.directions.size() != 1 || f.steps < 4 || f.directions[0].gray)
      refuse("other fringes than four or more phase steps in one direction");
    if (twin.projector->response.kind != ProjectorResponse::Kind::linear)
      refuse("a response that is not linear");
    if (twin.projector->optics || twin.projector->pixel_structure)
      refuse("the projector's optics and pixels");
    if (twin.render.bounces > 0) refuse("light between surfaces");
    if (twin.measure.smoothing_px > 0.0) refuse("smoothed coordinates");
    if (object->material.specular > 0.0) refuse("specular surfaces");
    for (const Camera& camera : twin.cameras)
      if (camera.optics || camera.psf_px > 0.0 || camera.vignetting.kind != Vignetting::Kind::none)
        refuse("camera optics");
    if (const auto* plane = std::get_if<PlaneShape>(&object->shape); plane && !plane->albedo_file.empty())
      refuse("texture");
    return *object;
  }

  bool hit(const Vector3d& origin, SurfacePoint* s) const {
    if (const auto* sphere = std::get_if<SphereShape>(&object_.shape)) {
      const Vector3d c = sphere->center_mm - origin;
      const double along = c.dot(s->d);
      const double rest = sphere->radius_mm * sphere->radius_mm - (c.squaredNorm() - along * along);
      if (rest <= 0.0) return false;
      s->range_mm = along - std::sqrt(rest);
      s->p_mm = origin + s->range_mm * s->d;
      s->n = (s->p_mm - sphere->center_mm) / sphere->radius_mm;
      return s->range_mm > 0.0;
    }
    const auto& plane = std::get<PlaneShape>(object_.shape);
    const double slope = plane.normal.dot(s->d);
    if (slope == 0.0) return false;
    s->range_mm = plane.normal.dot(plane.point_mm - origin) / slope;
    s->p_mm = origin + s->range_mm * s->d;
    s->n = slope < 0.0 ? plane.normal : Vector3d(-plane.normal);
    if (plane.size_mm) {
      const Vector3d off = s->p_mm - plane.point_mm;
      const Vector3d v_axis = plane.normal.cross(plane.u_axis);
      if (std::abs(off.dot(plane.u_axis)) > 0.5 * plane.size_mm->x() ||
          std::abs(off.dot(v_axis)) > 0.5 * plane.size_mm->y())
        return false;
    }
    return s->range_mm > 0.0;
  }

  bool locate(SurfacePoint* s) const {
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

  /// Of a pixel on the tangent plane.
  static Footprint footprint(const Camera& camera, const Vector2d& q_px, const SurfacePoint& s) {
    const Eigen::Matrix3d R_world_cam = camera.T_cam_world.rotation.transpose();
    Vector3d edge[2];
    Footprint f{};
    for (int k = 0; k < 2; ++k) {
      Vector3d rays[2];
      for (int side = 0; side < 2; ++side) {
        const auto ray = camera.lens.unproject(q_px + (side == 0 ? -0.5 : 0.5) * Vector2d::Unit(k));
        rays[side] = ray ? Vector3d(R_world_cam * *ray) : s.d;
      }
      const Vector3d turn = rays[1] - rays[0];
      edge[k] = s.range_mm * (turn - s.d * s.n.dot(turn) / s.n.dot(s.d));
      f.step_px[k] = s.gradient.dot(edge[k]);
    }
    f.area_mm2 = edge[0].cross(edge[1]).norm();
    return f;
  }

  /// sigma^2 of the mean over the pitches, inverse-variance weighted with heterodyne fringes; nothing where
  /// the fringes are too weak or saturate.
  std::optional<double> coordinate_variance(const Camera& camera, const SurfacePoint& s,
                                            const Footprint& f) const {
    const Projector& projector = *twin_.projector;
    const Sensor& sensor = camera.sensor;
    const Vector3d to_light = projector.center_world_mm() - s.p_mm;
    const double cosine = s.n.dot(to_light.normalized());
    if (cosine <= 0.0) return std::nullopt;
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
      for (const double step : f.step_px) amplitude *= sinc(0.5 * twin_.render.pixel_fill * wave * step);
      amplitude = std::abs(amplitude);
      if (amplitude < twin_.measure.min_modulation_dn) return std::nullopt;
      if (sensor.black_level_dn + signal_dn + amplitude >= sensor.max_dn()) return std::nullopt;
      const double one = 2.0 / fringes.steps * sigma2_dn2 / (amplitude * amplitude) / (wave * wave);
      if (fringes.unwrap == Unwrap::heterodyne)
        information += 1.0 / one;
      else if (static_cast<int>(k) == direction.finest())
        information = 1.0 / one;
    }
    return 1.0 / information;
  }

  const Twin& twin_;
  const Object& object_;
  int axis_;
};

/// Along the surface's normal: of one point, and of what counts in sums over many.
struct PointNoise {
  double single_mm2 = 0.0, summed_mm2 = 0.0;
};

PointNoise with_projector(const SurfacePoint& s) {
  const double normal_per_px = s.n.dot(s.d) / s.gradient.dot(s.d);
  const double v = s.variance_px2 * normal_per_px * normal_per_px;
  return {v, v};
}

/// Left and right see the same coordinate; the right one's lies between pixels. Neighbouring points share
/// the right pixels between which they lie: one point has less of their noise, a sum has all of it.
PointNoise with_second_camera(const SurfacePoint& left, const SurfacePoint& right) {
  // p + t d, seen by the second camera along e, takes the coordinate of the surface there
  const Vector3d move = left.d - right.d * (left.n.dot(left.d) / left.n.dot(right.d));
  const double slope = left.gradient.dot(move);
  const double scale = left.n.dot(left.d) / slope;
  const double points_per_pixel = right.area_mm2 / left.area_mm2;
  return {scale * scale * (left.variance_px2 + kInterpolated * kInterpolated * right.variance_px2),
          scale * scale * (left.variance_px2 + points_per_pixel * right.variance_px2)};
}

/// A point of the fit.
struct FitPoint {
  Vector3d n;
  PointNoise noise;
};

/// c with half of |normal(0, sigma_i)| below it, over all points.
double median_distance(const std::vector<FitPoint>& points) {
  double low = 0.0, high = 0.0;
  for (const FitPoint& p : points) high = std::max(high, std::sqrt(p.noise.single_mm2));
  for (int i = 0; i < 60; ++i) {
    const double c = 0.5 * (low + high);
    double below = 0.0;
    for (const FitPoint& p : points) below += std::erf(c / std::sqrt(2.0 * p.noise.single_mm2));
    (below < 0.5 * static_cast<double>(points.size()) ? low : high) = c;
  }
  return 0.5 * (low + high);
}

/// What a limit leaves of a normal distribution: its share, and its variance over that without a limit.
struct Kept {
  double share, variance;
};
Kept kept_within(double limit_mm, double sigma_mm) {
  const double u = limit_mm / sigma_mm;
  const double share = std::erf(u / std::numbers::sqrt2);
  const double density = std::exp(-0.5 * u * u) / std::sqrt(2.0 * std::numbers::pi);
  return {share, 1.0 - 2.0 * u * density / share};
}

/// Least squares of N parameters: normal matrix and the noise that goes through it.
template <int N>
class FitSum {
 public:
  using Row = Eigen::Matrix<double, N, 1>;
  /// `kept`: of the point's noise by the fit's limit. The fit is repeated until its set of points is stable,
  /// so that points near the limit come and go with it: they tell less of the surface than their share.
  void add(const Row& row, const Kept& kept, double variance) {
    normal_ += kept.share * kept.variance * row * row.transpose();
    noise_ += kept.share * kept.variance * variance * row * row.transpose();
  }
  Row sigma(double pixels_each) const {
    const Eigen::Matrix<double, N, N> inverse = normal_.inverse();
    return (inverse * noise_ * inverse / pixels_each).diagonal().cwiseSqrt();
  }

 private:
  Eigen::Matrix<double, N, N> normal_ = Eigen::Matrix<double, N, N>::Zero(), noise_ = normal_;
};

std::vector<FitPoint> points_of(const Scene& scene, const Twin& twin, int stride) {
  const Camera& camera = twin.cameras[0];
  const bool stereo = twin.triangulate() == Triangulate::stereo;
  std::vector<FitPoint> points;
  for (int y = stride / 2; y < camera.lens.height(); y += stride)
    for (int x = stride / 2; x < camera.lens.width(); x += stride) {
      const auto seen = scene.see(camera, Vector2d(x, y));
      if (!seen) continue;
      if (!stereo) {
        points.push_back({seen->n, with_projector(*seen)});
        continue;
      }
      const Camera& second = twin.cameras[1];
      const auto q = second.lens.project(second.T_cam_world * seen->p_mm);
      if (!q || q->x() < 0.0 || q->y() < 0.0 || q->x() > second.lens.width() - 1 ||
          q->y() > second.lens.height() - 1)
        continue;
      const auto other = scene.see(second, *q);
      // else the second camera sees another side of the object there
      if (other && (other->p_mm - seen->p_mm).norm() <= 1e-6 * seen->range_mm)
        points.push_back({seen->n, with_second_camera(*seen, *other)});
    }
  return points;
}

}  // namespace

NoiseTheory noise_theory(const Twin& twin, const std::string& object, std::size_t most_pixels) {
  const Scene scene(twin, object);
  const Lens& lens = twin.cameras[0].lens;
  const double pixels = static_cast<double>(lens.width()) * lens.height();
  const int stride =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / static_cast<double>(most_pixels)))));
  const std::vector<FitPoint> points = points_of(scene, twin, stride);
  const double pixels_each = static_cast<double>(stride) * stride;
  NoiseTheory out;
  if (points.size() < 4) return out;
  // the fit leaves out what is farther than that (docs/METRICS.md, "Fits")
  const double limit_mm = measure::kInlierSigmas * 1.4826 * median_distance(points);
  FitSum<4> sphere;
  FitSum<1> plane;
  double sum = 0.0, n = 0.0;
  for (const FitPoint& p : points) {
    const Kept kept = kept_within(limit_mm, std::sqrt(p.noise.single_mm2));
    n += kept.share;
    sum += kept.share * kept.variance * p.noise.single_mm2;
    sphere.add(Eigen::Vector4d(p.n.x(), p.n.y(), p.n.z(), 1.0), kept, p.noise.summed_mm2);
    plane.add(Eigen::Matrix<double, 1, 1>::Ones(), kept, p.noise.summed_mm2);
  }
  out.n = n * pixels_each;
  out.rms_mm = std::sqrt(sum / n);
  if (scene.is_sphere()) {
    const Eigen::Vector4d sigma = sphere.sigma(pixels_each);
    out.center_sigma_mm = sigma.head<3>();
    out.radius_sigma_mm = sigma[3];
  } else {
    out.offset_sigma_mm = plane.sigma(pixels_each)[0];
  }
  return out;
}

}  // namespace fringetwin::study
