// SPDX-License-Identifier: Apache-2.0
// Light that comes over any number of surfaces ([render] bounces = N and "all").
// | tolerance     | of                | origin                                                           |
// |---------------|-------------------|------------------------------------------------------------------|
// | 0.3 %, 1 %    | the indirect light| mean and rms over pixels, closed radiosity of a groove            |
// | 0.5 %         | the same          | a cavity: its facets and the cells' directions                   |
// | 1e-3 rad rms  | phase             | a groove under fringes against paths at random, issue 25          |
// | 0.1 %         | full scale rms    | its gray values                                                  |
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <complex>
#include <iostream>
#include <map>
#include <memory>
#include <numbers>

#include "render/base/quadrature.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/mesh/mesh.hpp"

namespace fringetwin::testing::bounces_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double pi = std::numbers::pi;
constexpr double kApexMm = 330.0, kWallMm = 40.0;

/// A camera of 160 x 120 px at the origin and a projector beside it that looks at the same point.
Twin rig_before(double distance_mm) {
  Twin twin = only_camera(paper_rig(), 0);
  twin.cameras[0].T_cam_world = Pose{};
  twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {640, 640, 79.5, 59.5}, {160, 120}, "small");
  const Vector3d at(60.0, 5.0, 0.0), to(0.0, 0.0, distance_mm);
  Pose& T = twin.projector->T_proj_world;
  T.rotation.row(2) = (to - at).normalized().transpose();
  T.rotation.row(0) = Vector3d(0, 1, 0).cross(to - at).normalized().transpose();
  T.rotation.row(1) = T.rotation.row(2).cross(T.rotation.row(0));
  T.translation_mm = -T.rotation * at;
  twin.projector->lens = Lens("LENSMODEL_PINHOLE", {900, 900, 320, 240}, {640, 480}, "small");
  twin.projector->inverse_square = false;
  twin.fringes.directions = {{Axis::x, {12.0, 60.0}, {0.0, 0.0}, {}}};
  twin.fringes.steps = 4;
  twin.objects.clear();
  return twin;
}

/// Two walls at right angles that meet along y at z = 330, open towards the camera.
Twin groove(double diffuse, double length_mm = 60.0) {
  Twin twin = rig_before(kApexMm - 15.0);
  for (const double side : {-1.0, 1.0}) {
    const Vector3d up = Vector3d(side, 0, -1).normalized();
    PlaneShape wall{.point_mm = Vector3d(0, 0, kApexMm) + 0.5 * kWallMm * up,
                    .normal = Vector3d(-side, 0, -1).normalized(),
                    .size_mm = Vector2d(length_mm, kWallMm),
                    .u_axis = {0, 1, 0}};
    twin = with_object(twin, side < 0 ? "left_wall" : "right_wall", wall, {diffuse, 0.0, 10.0});
  }
  return twin;
}

/// What a twin shows besides its direct light: mean over all patterns, per pixel.
ImageF indirect_mean(Twin twin, const render::Sampling& sampling) {
  const auto all = shared_renderer()->trace(twin, 0, sampling);
  twin.render.bounces = 0;
  const auto direct = shared_renderer()->trace(twin, 0, sampling);
  ImageF out = all.mean;
  for (std::size_t i = 0; i < out.size(); ++i) out.data[i] -= direct.mean.data[i];
  return out;
}

/// Errors of values relative to their truths, in their mean and rms.
struct Errors {
  double sum = 0.0, sum_sq = 0.0;
  int n = 0;
  void add(double error) {
    sum += error;
    sum_sq += error * error;
    ++n;
  }
  double mean() const { return sum / n; }
  double rms() const { return std::sqrt(sum_sq / n); }
};

/// Radiosity of the two walls of an endless groove by their light `direct(side, distance from the apex)`:
/// B_i(x) = D_i(x) + rho int K(x, y) B_k(y) dy, K = x y/2 (x^2 + y^2)^(-3/2), by Gauss's rule on panels that
/// become smaller towards the apex (Nystrom's method).
class GrooveRadiosity {
 public:
  template <class Direct>
  GrooveRadiosity(double rho, int bounces, const Direct& direct) : rho_(rho) {
    const auto& rule = render::gauss_rule(8);
    double end = kWallMm;
    for (int panel = 0; panel < 14; ++panel) {
      const double begin = panel < 13 ? 0.5 * end : 0.0;
      for (std::size_t k = 0; k < 8; ++k) {
        x_.push_back(0.5 * (begin + end) + 0.5 * (end - begin) * rule.nodes[k]);
        weight_.push_back(0.5 * (end - begin) * rule.weights[k]);
      }
      end = begin;
    }
    const auto n = static_cast<Eigen::Index>(x_.size());
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    Eigen::VectorXd b(2 * n);
    for (Eigen::Index i = 0; i < n; ++i) {
      b[i] = direct(0, x_[i]);
      b[n + i] = direct(1, x_[i]);
      for (Eigen::Index k = 0; k < n; ++k)
        K(i, n + k) = K(n + i, k) = rho * kernel(x_[i], x_[k]) * weight_[k];
    }
    light_ = b;
    for (int k = 1; k < std::min(bounces, 200); ++k) light_ = b + K * light_;
  }
  /// Returns what reaches a place over other surfaces, as radiosity.
  double indirect(int side, double x) const {
    const auto n = static_cast<Eigen::Index>(x_.size());
    double sum = 0.0;
    for (Eigen::Index k = 0; k < n; ++k) sum += kernel(x, x_[k]) * weight_[k] * light_[(1 - side) * n + k];
    return rho_ * sum;
  }

 private:
  static double kernel(double x, double y) { return 0.5 * x * y / std::pow(x * x + y * y, 1.5); }
  double rho_;
  std::vector<double> x_, weight_;
  Eigen::VectorXd light_;
};

TEST(AllBounces, OfAnEndlessGrooveAreItsRadiosity) {
  REQUIRE_RENDERER();
  constexpr double kRho = 0.8;
  Twin twin = groove(kRho, 4000.0);
  // from so far away that the light is the same along the groove and on each wall
  const Vector3d from = Vector3d(0.25, 0.0, -1.0).normalized() * 1e5;
  Pose& T = twin.projector->T_proj_world;
  T.rotation.row(2) = -from.normalized().transpose();
  T.rotation.row(0) = Vector3d(0, 1, 0).cross(-from).normalized().transpose();
  T.rotation.row(1) = T.rotation.row(2).cross(T.rotation.row(0));
  T.translation_mm = -T.rotation * (Vector3d(0, 0, kApexMm) + from);
  twin.projector->lens = Lens("LENSMODEL_PINHOLE", {1.2e4, 1.2e4, 320, 240}, {640, 480}, "from afar");
  twin.fringes.directions = {{Axis::x, {640.0}, {0.0}, {}}};
  const render::Reference reference(twin);
  const auto on_wall = [&](int side) {
    return twin.projector->intensity * kRho / pi *
           Vector3d(side == 0 ? 1 : -1, 0, -1).normalized().dot(from.normalized());
  };
  for (const int bounces : {1, 2, 3, kAllBounces}) {
    twin.render.bounces = bounces;
    twin.render.bounce_samples = 256;
    const ImageF found = indirect_mean(twin, {Sampler::gauss, 4});
    const GrooveRadiosity truth(kRho, bounces, [&](int side, double) { return on_wall(side); });
    Errors errors;
    std::map<int, Errors> at;
    double share = 0.0;
    for (int y = 30; y < 90; y += 3)
      for (int x = 20; x < 140; x += 2) {
        const auto s = reference.sample(0, {static_cast<double>(x), static_cast<double>(y)});
        if (!s.lit || !reference.is_whole(0, x, y)) continue;
        const double distance = (s.point_world_mm - Vector3d(0, s.point_world_mm.y(), kApexMm)).norm();
        if (distance > kWallMm - 1.0) continue;
        const double expected = truth.indirect(s.object, distance);
        share = std::max(share, expected / on_wall(s.object));
        errors.add(static_cast<double>(found(x, y)) / expected - 1.0);
        at[(s.object == 0 ? -1 : 1) * (1 + static_cast<int>(distance / 4))].add(
            static_cast<double>(found(x, y)) / expected - 1.0);
      }
    for (auto& [k, e] : at) std::cout << k << ": " << e.mean() << " " << e.rms() << "\n";
    std::cout << "endless groove, bounces " << bounces << ": " << errors.n << " pixels, mean error "
              << errors.mean() << ", rms " << errors.rms() << ", up to " << share << " of the direct light\n";
    EXPECT_GT(errors.n, 300);
    EXPECT_GT(share, bounces == 1 ? 0.3 : 0.5);
    EXPECT_LE(std::abs(errors.mean()), 0.003);
    EXPECT_LE(errors.rms(), 0.01);
  }
}

TEST(AllBounces, UnderFringesAgreeWithPathsAtRandom) {
  REQUIRE_RENDERER();
  for (const int bounces : {1, 2, kAllBounces}) {
    Twin twin = groove(0.8);
    Twin dark = twin;
    const render::Sampling sampling{Sampler::gauss, 16};
    const auto direct = shared_renderer()->trace(dark, 0, sampling);
    twin.render.bounces = bounces;
    const double full_scale = twin.cameras[0].sensor.max_dn() / twin.cameras[0].sensor.gain_dn;
    const auto truth =
        reference_block(render::Reference(twin), 0, {20, 20, 120, 80, 17}, {.gauss_n = 2, .bounce_n = 160});
    for (const int directions : {256, 4096, 16384}) {
      twin.render.bounce_samples = directions;
      const auto rendered = shared_renderer()->trace(twin, 0, sampling);
      Errors phase, gray, moved, share;
      for (const auto& p : truth) {
        if (!p.interior) continue;
        const auto difference = [&](const render::Transport& t) {
          const double c = t.cosine[0][0](p.x, p.y), s = t.sine[0][0](p.x, p.y);
          return std::arg(std::complex<double>(c, s) *
                          std::conj(std::complex<double>(p.pixel.cosine[0][0], p.pixel.sine[0][0])));
        };
        phase.add(difference(rendered));
        moved.add(difference(direct));
        gray.add((static_cast<double>(rendered.mean(p.x, p.y)) - p.pixel.mean) / full_scale);
        share.add(p.pixel.mean / static_cast<double>(direct.mean(p.x, p.y)) - 1.0);
      }
      std::cout << "groove, bounces " << bounces << ", " << directions << " directions: " << phase.n
                << " pixels, phase " << phase.rms() << " rad rms (moved by " << moved.rms() << "), gray "
                << gray.rms() << " of full scale, mean " << gray.mean() << "; indirect over direct "
                << share.mean() << '\n';
    }
  }
}

}  // namespace
}  // namespace fringetwin::testing::bounces_test
