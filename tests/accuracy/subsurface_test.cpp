// SPDX-License-Identifier: Apache-2.0
// Light that goes below surfaces ([object.material] mean_free_path_mm): photons at random, and the reference.
// | tolerance  | of                 | origin                                                           |
// |------------|--------------------|------------------------------------------------------------------|
// | 1 %        | complex contrast   | the formula on a plane, by the test's own perspective             |
// | 0.05       | complex contrast   | photons at random: what the formula leaves out (docs/PHYSICS.md)   |
// | 4e-5, 5e-5 | rad, of full scale | as for the shapes (shapes_test.cpp)                               |
// | 2 %        | full scale rms     | a code: the profile instead of the formula, 0.8 % here             |
// | 3e-3, 1e-3 | rad, of full scale | over a wall, 4,096 directions (16,384: 1e-3, bounces_test.cpp)     |
// | 0          |                    | beside other objects                                              |
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <complex>
#include <iostream>
#include <numbers>
#include <random>

#include "tests/support/expect_agreement.hpp"
#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::subsurface_test {
namespace {

using Eigen::Vector3d;
using Complex = std::complex<double>;
constexpr double pi = std::numbers::pi;
constexpr double kRefraction = 1.4;

Twin with_path(Twin twin, double mean_free_path_mm) {
  for (Object& object : twin.objects) object.material.mean_free_path_mm = mean_free_path_mm;
  return twin;
}

/// A device that looks at the origin from an angle beside the axis -z, in the plane of x and z, far away.
Pose seen_from(double angle_rad, double distance_mm) {
  const Vector3d at = distance_mm * Vector3d(std::sin(angle_rad), 0.0, -std::cos(angle_rad));
  Pose T;
  T.rotation.row(2) = -at.normalized().transpose();
  T.rotation.row(1) = Vector3d(0, 1, 0).transpose();
  T.rotation.row(0) = Vector3d(0, 1, 0).cross(-at.normalized()).transpose();
  T.translation_mm = -T.rotation * at;
  return T;
}

/// A plane that faces -z, a projector and a camera so far away that all of it is seen and lit from one side.
/// Fringes along x whose pitches on the plane are these.
struct PlaneRig {
  double light_rad, viewer_rad, albedo = 0.8;
  std::vector<double> pitches_mm = {0.5, 1.0, 2.0, 4.0, 8.0, 20.0};
  static constexpr double kFarMm = 4000.0, kFocalPx = 2e5;
  Twin twin() const {
    Twin twin = only_camera(paper_rig(), 0);
    twin.cameras[0].T_cam_world = seen_from(viewer_rad, kFarMm);
    twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {kFocalPx, kFocalPx, 8, 8}, {17, 17}, "far");
    twin.projector->T_proj_world = seen_from(light_rad, kFarMm);
    twin.projector->lens = Lens("LENSMODEL_PINHOLE", {kFocalPx, kFocalPx, 960, 540}, {1920, 1080}, "far");
    twin.projector->inverse_square = false;
    DirectionFringes x{Axis::x, {}, {}, {}};
    for (const double pitch_mm : pitches_mm) {
      x.pitches_px.push_back(pitch_mm * std::cos(light_rad) * kFocalPx / kFarMm);
      x.phase_origin_px.push_back(0.0);
    }
    twin.fringes.directions = {x};
    twin.fringes.steps = 4;
    twin.objects.clear();
    return with_object(
        twin, "plane",
        PlaneShape{.point_mm = {0, 0, 0}, .normal = {0, 0, -1}, .size_mm = {}, .u_axis = {1, 0, 0}},
        {.diffuse = albedo});
  }
  /// Returns what each pitch becomes of itself in the middle of the image, by the renderer.
  std::vector<Complex> rendered(double mean_free_path_mm) const {
    std::vector<Complex> out;
    const render::Sampling sampling{Sampler::gauss, 9, true};
    const auto below = shared_renderer()->trace(with_path(twin(), mean_free_path_mm), 0, sampling),
               beside = shared_renderer()->trace(twin(), 0, sampling);
    const auto sum = [](const render::Transport& found, std::size_t p) {
      return Complex(static_cast<double>(found.cosine[0][p](8, 8)),
                     static_cast<double>(found.sine[0][p](8, 8)));
    };
    for (std::size_t p = 0; p < pitches_mm.size(); ++p) out.push_back(sum(below, p) / sum(beside, p));
    return out;
  }
};

// Rays of the projector's pixels along x on the plane: x of its image grows with x of the world.
Complex by_formula(const PlaneRig& rig, double mean_free_path_mm, double pitch_mm) {
  const double k = 2.0 * pi / pitch_mm * mean_free_path_mm, s = [&] {
    // (1 - s)(1 - 0.139 s) = A (1 + 1.17 s), by bisection
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 60; ++i) {
      const double m = 0.5 * (low + high);
      ((1 - m) * (1 - 0.139 * m) > rig.albedo * (1 + 1.17 * m) ? low : high) = m;
    }
    return low;
  }();
  const double in = std::asin(std::sin(rig.light_rad) / kRefraction),
               out = std::asin(std::sin(rig.viewer_rad) / kRefraction);
  const auto z = [&](double q) {
    const Complex a(1.0 / std::cos(in), -q * std::tan(in)), b(1.0 / std::cos(out), q * std::tan(out));
    const double all = std::sqrt(q * q + 3.0), left = std::sqrt(q * q + 3.0 * s * s);
    return (a + all) * (b + all) / ((a + left) * (b + left) * (a + b));
  };
  return z(k) / z(0.0);
}

TEST(Subsurface, ContrastAndShiftOnAPlaneAreThoseOfTheFormula) {
  REQUIRE_RENDERER();
  for (const auto& [light_deg, viewer_deg] :
       {std::pair{0.0, 0.0}, std::pair{45.0, 0.0}, std::pair{-45.0, 20.0}, std::pair{30.0, -60.0}})
    for (const double albedo : {0.3, 0.8, 1.0})
      for (const double path_mm : {0.3, 1.0, 3.0}) {
        const PlaneRig rig{light_deg * pi / 180.0, viewer_deg * pi / 180.0, albedo};
        const std::vector<Complex> found = rig.rendered(path_mm);
        for (std::size_t p = 0; p < found.size(); ++p) {
          const Complex expected = by_formula(rig, path_mm, rig.pitches_mm[p]);
          EXPECT_LE(std::abs(found[p] - expected), 0.01 * std::abs(expected))
              << light_deg << ' ' << viewer_deg << ' ' << albedo << ' ' << path_mm << ' ' << rig.pitches_mm[p]
              << ' ' << found[p] << ' ' << expected;
        }
      }
}

/// Photons in a half space of isotropic scattering events: the light that leaves in one direction, by the
/// Fourier transform of where it does relative to where it came in. Lengths in mean free paths; from every
/// event the share that leaves without another is counted.
std::vector<Complex> photons(double share, double in_rad, double out_rad, const std::vector<double>& k) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform;
  std::vector<Complex> sums(k.size(), 0.0);
  double all = 0.0;
  for (int photon = 0; photon < 100000; ++photon) {
    // comes from the side of the light, so it goes towards -x where the light is at +x
    Vector3d at(0, 0, 0), d(-std::sin(in_rad), 0.0, std::cos(in_rad));  // z: depth
    double left = 1.0;
    for (int event = 0; event < 1000 && left > 1e-4; ++event) {
      at -= std::log(1.0 - uniform(random)) * d;
      if (at.z() < 0.0) break;
      left *= share;
      const double leaves = left * std::exp(-at.z() / std::cos(out_rad)) / std::cos(out_rad),
                   x = at.x() + at.z() * std::tan(out_rad);
      all += leaves;
      // a pattern exp(ikx) that came in at 0 is seen at x: relative to the pattern at x
      for (std::size_t i = 0; i < k.size(); ++i) sums[i] += leaves * std::polar(1.0, -k[i] * x);
      const double z = 2.0 * uniform(random) - 1.0, angle = 2.0 * pi * uniform(random);
      d = {std::sqrt(1.0 - z * z) * std::cos(angle), std::sqrt(1.0 - z * z) * std::sin(angle), z};
    }
  }
  for (Complex& sum : sums) sum /= all;
  return sums;
}

/// The diffuse reflectance of that half space for light that comes straight in.
double albedo_of(double share) {
  const double s = std::sqrt(1.0 - share);
  return (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s);
}

TEST(Subsurface, ContrastAndShiftAreThoseOfPhotons) {
  REQUIRE_RENDERER();
  double worst = 0.0;
  for (const double share : {0.7, 0.9, 0.99})
    for (const auto& [light_deg, viewer_deg] :
         {std::pair{0.0, 0.0}, std::pair{45.0, 0.0}, std::pair{45.0, 45.0}, std::pair{-45.0, 45.0}}) {
      const PlaneRig rig{
          light_deg * pi / 180.0, viewer_deg * pi / 180.0, albedo_of(share), {0.5, 2.0, 6.0, 20.0}};
      std::vector<double> k;
      for (const double pitch_mm : rig.pitches_mm) k.push_back(2.0 * pi / pitch_mm);
      const std::vector<Complex> found = rig.rendered(1.0),
                                 expected = photons(share, std::asin(std::sin(rig.light_rad) / kRefraction),
                                                    std::asin(std::sin(rig.viewer_rad) / kRefraction), k);
      for (std::size_t p = 0; p < found.size(); ++p) {
        worst = std::max(worst, std::abs(found[p] - expected[p]));
        EXPECT_LE(std::abs(found[p] - expected[p]), 0.05)
            << share << ' ' << light_deg << ' ' << viewer_deg << ' ' << rig.pitches_mm[p]
            << " mm: " << found[p] << ", photons " << expected[p];
      }
    }
  std::cout << "photons: at most " << worst << " off\n";
}

Twin window(const Shape& shape, const Vector3d& at = {0, 0, 290}, int width = 120, int height = 90) {
  return with_object(left_window(at, width, height), "surface", shape);
}

TEST(Subsurface, AgreesWithTheReference) {
  REQUIRE_RENDERER();
  for (const double path_mm : {0.3, 1.5}) {
    expect_agreement(with_path(window(tilted_plane()), path_mm), "below a plane", 200, 7);
    expect_agreement(with_path(window(physical_sphere(), physical_sphere().center_mm, 240, 200), path_mm),
                     "below a sphere", 300, 9);
    expect_agreement(with_path(window(upright_cylinder(), upright_cylinder().point_mm), path_mm),
                     "below a cylinder", 100, 9);
  }
}

TEST(Subsurface, BesideALobeAndBesideAnObjectOfAnotherKind) {
  REQUIRE_RENDERER();
  Twin twin = with_path(window(tilted_plane()), 0.8);
  twin.objects[0].material.specular = 0.3;
  twin.objects.push_back({"sphere", SphereShape{{0, 0, 270}, 4.0}, {}});
  twin.objects.push_back({"other", SphereShape{{5, 3, 270}, 3.0}, {.mean_free_path_mm = 0.2}});
  expect_agreement(twin, "a lobe beside", 200, 5);
  expect_linear_in_the_light(twin);
}

// Objects into which no light goes have the same bits beside one into which it does: off, an effect is off.
TEST(Subsurface, ChangesNoBitOfOtherObjects) {
  REQUIRE_RENDERER();
  Twin twin = window(tilted_plane());
  twin.objects.push_back({"ball", SphereShape{{0, 0, 270}, 4.0}, {}});
  const render::RenderedCamera without = render_fixed(twin);
  twin.objects[1].material.mean_free_path_mm = 0.5;
  const render::RenderedCamera beside = render_fixed(twin);
  int plane = 0, changed = 0;
  for (std::size_t p = 0; p < without.object.size(); ++p) {
    const int x = static_cast<int>(p) % without.object.width, y = static_cast<int>(p) / without.object.width;
    bool alone = true;
    for (int v = std::max(0, y - 1); v <= std::min(without.object.height - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(without.object.width - 1, x + 1); ++u)
        alone = alone && without.object(u, v) == without.object.data[p];
    if (!alone) continue;
    for (std::size_t i = 0; i < without.irradiance.size(); ++i) {
      const bool same = without.irradiance[i].data[p] == beside.irradiance[i].data[p];
      if (without.object.data[p] == 0) {
        EXPECT_TRUE(same) << x << ' ' << y;
        ++plane;
      } else {
        changed += same ? 0 : 1;
      }
    }
  }
  EXPECT_GT(plane, 1000);
  EXPECT_GT(changed, 1000);
}

// Light over a translucent wall has been below it, too. Paths: as in bounces_test.cpp.
TEST(Subsurface, LightOverATranslucentSurfaceHasBeenBelowIt) {
  REQUIRE_RENDERER();
  Twin twin = window_on_a_corner(0.8, 120, 90);
  twin.render.bounces = 1;
  twin.render.bounce_samples = 4096;
  const auto truth = reference_block(render::Reference(with_path(twin, 1.0)), 0, {10, 20, 100, 50, 16},
                                     {.gauss_n = 2, .bounce_n = 64});
  const auto compared = [&](double path_mm) {
    const Twin below = with_path(twin, path_mm);
    return compare(below, 0, shared_renderer()->render(below, 0, {Sampler::gauss, 16}).irradiance, truth);
  };
  const Agreement with = compared(1.0), without = compared(0.0);
  std::cout << "corner: " << with.text() << "; without " << without.text() << '\n';
  EXPECT_GE(with.n, 15);
  EXPECT_LE(with.worst_phase_rms_rad(), 3e-3);
  EXPECT_LE(with.gray_rms, 1e-3);
  EXPECT_GE(without.gray_rms, 0.01);
}

TEST(Subsurface, BelowAMeshAgreesWithTheReference) {
  REQUIRE_RENDERER();
  MeshShape mesh;
  mesh.mesh = std::make_shared<const Mesh>(make_bumpy_icosphere(5, 35.0, {}));
  mesh.T_world_object.translation_mm = {0, 0, 270};
  expect_agreement(with_path(window(mesh, {0, 0, 240}, 160, 120), 0.5), "below a mesh", 50, 5);
}

TEST(Subsurface, EdgesOfACodeAreBlurredAndBeside) {
  REQUIRE_RENDERER();
  Twin twin = with_path(window(tilted_plane()), 0.4);
  twin.fringes.directions = {{Axis::x, {16.0}, {0.0}, GrayCode{.bits = 6, .complementary = true}}};
  twin.fringes.unwrap = Unwrap::gray;
  const auto truth = reference_block(render::Reference(twin), 0, whole_image(twin, 0, 13), {.gauss_n = 4});
  const Agreement blurred = compare(twin, 0, render_fixed(twin).irradiance, truth),
                  sharp = compare(twin, 0, render_fixed(with_path(twin, 0.0)).irradiance, truth);
  std::cout << "a code: " << blurred.text() << "; without " << sharp.text() << '\n';
  EXPECT_LE(blurred.gray_rms, 0.02);
  EXPECT_GE(sharp.gray_rms, 2.0 * blurred.gray_rms);
}

TEST(Subsurface, WithTheProjectorsPixelsOrDefocusIsRefused) {
  REQUIRE_RENDERER();
  Twin twin = with_path(window(tilted_plane()), 0.4);
  twin.projector->optics = Optics{.f_number = 2.8, .focal_length_mm = 12.0, .focus_distance_mm = 300.0};
  EXPECT_THROW(render_fixed(twin), UserError);
  twin.projector->optics.reset();
  twin.projector->pixel_structure = true;
  EXPECT_THROW(render_fixed(twin), UserError);
  twin.projector->pixel_structure = false;
  EXPECT_NO_THROW(render_fixed(twin));
}

}  // namespace
}  // namespace fringetwin::testing::subsurface_test
