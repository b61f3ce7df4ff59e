// SPDX-License-Identifier: Apache-2.0
#include "study/noise/noise_theory.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "measure/fit/robust.hpp"
#include "study/noise/interpolation_noise.hpp"
#include "study/noise/noise_scene.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::study {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

/// Along the surface's normal: of one point, and of what counts in sums over many.
struct PointNoise {
  double single_mm2 = 0.0, summed_mm2 = 0.0;
};

PointNoise with_projector(const SurfacePoint& s) {
  const double normal_per_px = s.n.dot(s.d) / s.gradient.dot(s.d);
  const double v = s.variance_px2 * normal_per_px * normal_per_px;
  return {v, v};
}

/// Image point and how it moves with the point in space, px/mm.
struct Projection {
  Vector2d q_px;
  Eigen::Matrix<double, 2, 3> dq_dp;
};

std::optional<Projection> projection(const Camera& camera, const Vector3d& p_mm) {
  Eigen::Matrix<double, 2, 3> dq_dp_cam;
  const auto q = camera.lens.project(camera.T_cam_world * p_mm, &dq_dp_cam);
  if (!q) return std::nullopt;
  return Projection{*q, dq_dp_cam * camera.T_cam_world.rotation};
}

/// Left and right see the same coordinate; the right one's lies between pixels. Neighbouring points share the
/// right pixels between which they lie: one point has less of their noise than their sum.
/// `step_px`: how far its pixel's sides are apart in the right image.
PointNoise with_second_camera(const SurfacePoint& left, const SurfacePoint& right,
                              const Eigen::Matrix2d& step_px) {
  // p + t d, seen by the second camera along e, takes the coordinate of the surface there
  const Vector3d move = left.d - right.d * (left.n.dot(left.d) / left.n.dot(right.d));
  const double slope = left.gradient.dot(move);
  const double scale = left.n.dot(left.d) / slope;
  const double one = interpolation_covariance(0.0);
  return {scale * scale * (left.variance_px2 + one * one * right.variance_px2),
          scale * scale * (left.variance_px2 + lattice_variance(step_px) * right.variance_px2)};
}

/// A point that takes part in the fit.
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

std::optional<FitPoint> point_at(const NoiseScene& scene, const Twin& twin, int x, int y) {
  const auto seen = scene.see(twin.cameras[0], Vector2d(x, y));
  if (!seen || !scene.is_used(twin.cameras[0], x, y)) return std::nullopt;
  if (twin.triangulate() != Triangulate::stereo) return FitPoint{seen->n, with_projector(*seen)};
  const Camera& second = twin.cameras[1];
  const auto there = projection(second, seen->p_mm);
  const auto other = there ? scene.see(second, there->q_px) : std::nullopt;
  // or the second camera sees another side of the object there
  if (!other || (other->p_mm - seen->p_mm).norm() > 1e-6 * seen->range_mm) return std::nullopt;
  if (!scene.is_readable(second, there->q_px)) return std::nullopt;
  Eigen::Matrix2d step_px;
  step_px << there->dq_dp * seen->edge_mm[0], there->dq_dp * seen->edge_mm[1];
  return FitPoint{seen->n, with_second_camera(*seen, *other, step_px)};
}

std::vector<FitPoint> points_of(const NoiseScene& scene, const Twin& twin, int stride) {
  const Lens& lens = twin.cameras[0].lens;
  std::vector<FitPoint> points;
  for (int y = stride / 2; y < lens.height(); y += stride)
    for (int x = stride / 2; x < lens.width(); x += stride)
      if (const auto point = point_at(scene, twin, x, y)) points.push_back(*point);
  return points;
}

}  // namespace

NoiseTheory noise_theory(const Twin& twin, const std::string& object, std::size_t most_pixels) {
  const NoiseScene scene(twin, object);
  const Lens& lens = twin.cameras[0].lens;
  const double pixels = static_cast<double>(lens.width()) * lens.height();
  const int stride =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / static_cast<double>(most_pixels)))));
  const std::vector<FitPoint> points = points_of(scene, twin, stride);
  const double pixels_each = static_cast<double>(stride) * stride;
  NoiseTheory out;
  if (points.size() < 4) return out;
  // the fit leaves out what is farther than that (docs/metrics/geometry.md, "Fits")
  const double limit_mm = measure::kInlierSigmas * kMadToSigma * median_distance(points);
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
