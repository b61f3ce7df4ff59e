// SPDX-License-Identifier: Apache-2.0
#include "render/scene/visible_range.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace fringetwin::render {
namespace {

using Eigen::Vector3d;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kUnboundedMm = 0.5 * std::numeric_limits<float>::max();  // half sizes beyond: no end
constexpr int kRaysAlong = 33;

struct Interval {
  double low = kInfinity, high = -kInfinity;
  void add(double v) { low = std::min(low, v), high = std::max(high, v); }
  bool empty() const { return !(low <= high); }
  Interval operator&(const Interval& o) const { return {std::max(low, o.low), std::min(high, o.high)}; }
};

struct View {
  std::vector<Vector3d> directions;  // unit
  Vector3d middle = Vector3d::UnitZ();
  double angle = 0.0;    // from the middle to the farthest
  double spacing = 0.0;  // angle between neighbours, at most
};

double angle_between(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

View view_of(const Lens& lens) {
  View view;
  const auto at = [&](double i, double j) {
    return lens.unproject(
        {-0.5 + lens.width() * i / (kRaysAlong - 1), -0.5 + lens.height() * j / (kRaysAlong - 1)});
  };
  view.middle = at(0.5 * (kRaysAlong - 1), 0.5 * (kRaysAlong - 1)).value_or(Vector3d::UnitZ());
  for (int j = 0; j < kRaysAlong; ++j)
    for (int i = 0; i < kRaysAlong; ++i) {
      const auto d = at(i, j);
      if (!d) continue;
      view.directions.push_back(*d);
      view.angle = std::max(view.angle, angle_between(view.middle, *d));
    }
  view.spacing = 4.0 * view.angle / (kRaysAlong - 1);
  return view;
}

Vector3d head(const Double4& v) { return {v[0], v[1], v[2]}; }

class Range {
 public:
  explicit Range(const View& view) : view_(view) {}

  void add_sphere(const Vector3d& center, double radius) {
    const double distance = center.norm();
    const double reach = radius >= distance ? 4.0 : std::asin(radius / distance);
    if (angle_between(view_.middle, center) > view_.angle + reach) return;
    add({center.z() - radius, center.z() + radius}, distance + radius);
  }

  // Adds a plane, whose layout shaders/shapes.glsl gives.
  void add_plane(const std::array<Double4, 4>& g) {
    const Vector3d n = head(g[0]), p = head(g[3]);
    Interval depth;
    double far = 0.0;
    bool beyond = false;
    for (const Vector3d& d : view_.directions) {
      const double t = g[0][3] / n.dot(d);
      if (!(t > 0.0)) {
        beyond = true;
        continue;
      }
      depth.add(t * d.z());
      far = std::max(far, t);
    }
    if (depth.empty()) return;
    if (g[1][3] > kUnboundedMm) {
      if (beyond) depth.high = far = kInfinity;  // the horizon is in view
      add(depth, far);
      return;
    }
    const double half = std::abs(g[1][3] * g[1][2]) + std::abs(g[2][3] * g[2][2]);
    const double size = std::hypot(g[1][3], g[2][3]);
    add(depth & Interval{p.z() - half, p.z() + half}, std::min(far, p.norm() + size));
  }

  // Adds a cylinder: the infinite surface's points on every ray that passes the axis at less than the radius
  // plus the space between two rays.
  void add_cylinder(const std::array<Double4, 4>& g) {
    const Vector3d foot = head(g[0]), axis = head(g[1]);
    const double radius = g[0][3];
    Interval depth;
    double far = 0.0;
    for (const Vector3d& d : view_.directions) {
      const Vector3d d_perp = d - d.dot(axis) * axis;
      const double a = d_perp.squaredNorm();
      if (!(a > 0.0)) continue;
      const double t = foot.dot(d_perp) / a;
      if (!(t > 0.0)) continue;
      const double line = (foot - t * d_perp).norm();
      if (line > radius + view_.spacing * t) continue;
      const double half = std::sqrt(std::max(radius * radius - line * line, 0.0) / a);
      depth.add((t - half) * d.z());
      depth.add((t + half) * d.z());
      far = std::max(far, t + half);
    }
    if (depth.empty()) return;
    if (g[1][3] > kUnboundedMm) {
      add(depth, far);
      return;
    }
    const Vector3d p = foot + g[2][0] * axis;
    const double half =
        std::abs(g[1][3] * axis.z()) + radius * std::sqrt(std::max(1.0 - axis.z() * axis.z(), 0.0));
    add(depth & Interval{p.z() - half, p.z() + half}, std::min(far, p.norm() + std::hypot(g[1][3], radius)));
  }

  VisibleRange result() const { return {depth_.low, depth_.high, far_}; }

 private:
  void add(const Interval& depth, double far) {
    if (depth.empty() || !(depth.high > 0.0)) return;
    depth_.add(std::max(depth.low, std::numeric_limits<double>::min()));
    depth_.add(depth.high);
    far_ = std::max(far_, far);
  }

  const View& view_;
  Interval depth_;
  double far_ = 0.0;
};

}  // namespace

VisibleRange visible_range(const Camera& camera, const PackedScene& scene) {
  const View view = view_of(camera.lens);
  Range range(view);
  for (const auto& g : scene.of_kind(KIND_PLANES)) range.add_plane(g);
  for (const auto& g : scene.of_kind(KIND_CYLINDERS)) range.add_cylinder(g);
  for (const BoundingSphere& b : scene.finite)
    if (b.tells_depth) range.add_sphere(b.center_mm, b.radius_mm);
  return range.result();
}

}  // namespace fringetwin::render
