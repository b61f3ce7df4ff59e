// SPDX-License-Identifier: Apache-2.0
// A ball is built from some of its phase steps, of images whose light drifts and whose fringes have harmonics
// that the twin does not know. The images are the double-precision reference's, with noise; the truth is the
// ball.
//
// | check                    | tolerance       | origin |
// |--------------------------|-----------------|-------------------------------------------------------------|
// | rms error of the shape   | 1.1 x of plain  | plain: the same noise without drift and harmonics; what 20 |
// |                          |                 | common numbers are not known by is 1 % of 7680 phases' noise
// | | as recorded              | > 2 x of plain  | planted: 0.01 rad of drift and of harmonics, noise 0.003 |
#include "cosim/shape/measured_shapes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "compare/held_out/held_out.hpp"
#include "render/reference/reference.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::cosim::measured_shapes_test {
namespace {

constexpr int kWidth = 96, kHeight = 80, kSteps = 12;
constexpr double kNoiseDn = 3.0;

/// A ball that fills the window of one camera.
Twin rig() {
  Twin twin = testing::left_window(testing::physical_sphere().center_mm, kWidth, kHeight);
  twin.measure.triangulate = Triangulate::projector;
  twin.fringes.steps = kSteps;
  twin.cameras[0].sensor.bit_depth = 12;
  twin.cameras[0].sensor.gain_dn = 200.0;
  twin.cameras[0].sensor.read_noise_dn = kNoiseDn;
  return twin;
}

/// The rig with a lamp that drifts by 2 % to either side over the steps of each pitch, and fringes with a
/// second and a fifth harmonic of 3 and 1.5 % of their amplitude.
Twin uneven_rig() {
  Twin twin = rig();
  for (const PatternSpec& spec : expand_sequence(twin.fringes))
    twin.projector->light_factors.push_back(1.0 + 0.02 * (2.0 * spec.step / (kSteps - 1.0) - 1.0));
  const double a = twin.fringes.amplitude;
  twin.fringes.directions[0].harmonics.assign(3, {{0.03 * a, 0.0}, {}, {}, {0.0, 0.015 * a}});
  return twin;
}

/// What the reference says this rig records of the ball.
std::vector<CameraImages> recorded(const Twin& of) {
  const render::Reference reference(testing::with_object(of, "ball", testing::physical_sphere()));
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, 1.0);
  CameraImages out;
  out.camera = of.cameras[0].name;
  out.bit_depth = 12;
  out.images.assign(expand_sequence(of.fringes).size(), ImageF(kWidth, kHeight, 0.0F));
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const auto pixel = reference.pixel(0, i % kWidth, i / kWidth, {.gauss_n = 3});
    for (std::size_t k = 0; k < out.images.size(); ++k)
      out.images[k].as_floats()[static_cast<std::size_t>(i)] = static_cast<float>(
          std::round(of.cameras[0].sensor.gain_dn * pixel.irradiance[k] + kNoiseDn * normal(random)));
  }
  return {out};
}

/// The twin whose ball is measured.
Twin measured_twin(Twin of, bool correct_fringes = true) {
  return testing::with_object(
      std::move(of), "ball",
      MeasuredShape{.steps = "even", .smoothing_px = 4.0, .correct_fringes = correct_fringes});
}

const Mesh& mesh_of(const Twin& built) { return *std::get<MeshShape>(built.objects[0].shape).mesh; }

/// Returns the rms of what the surface is wrong by where its windows are whole, mm.
double wrong_by_mm(const Twin& built) {
  const SphereShape truth = testing::physical_sphere();
  const Camera& camera = built.cameras[0];
  double sum = 0.0, n = 0.0;
  for (const Eigen::Vector3f& vertex_mm : mesh_of(built).vertices_mm) {
    const Eigen::Vector3d p_world_mm = vertex_mm.cast<double>();
    const auto q_px = camera.lens.project(camera.T_cam_world * p_world_mm);
    if (!q_px || q_px->x() < 6.0 || q_px->y() < 6.0 || q_px->x() > kWidth - 7.0 || q_px->y() > kHeight - 7.0)
      continue;
    sum += std::pow((p_world_mm - truth.center_mm).norm() - truth.radius_mm, 2);
    n += 1.0;
  }
  EXPECT_GT(n, 4000.0);
  return std::sqrt(sum / n);
}

double wrong_by_mm(Twin twin, const std::vector<CameraImages>& real, const std::vector<int>& steps) {
  build_measured_shapes(twin, real, steps);
  return wrong_by_mm(twin);
}

TEST(MeasuredShapes, OfAFoldHaveNoRippleOfItsLightAndItsFringes) {
  const std::vector<CameraImages> uneven = recorded(uneven_rig()), even = recorded(rig());
  for (const int n_folds : {3, 4})  // steps that take orders 5, and 2, for the phase
    for (const compare::Fold& fold : compare::folds_of(kSteps, n_folds)) {
      SCOPED_TRACE(::testing::Message() << n_folds << " folds, without " << fold.held_out.front());
      const double plain = wrong_by_mm(measured_twin(rig(), false), even, fold.fitted),
                   before = wrong_by_mm(measured_twin(rig(), false), uneven, fold.fitted),
                   after = wrong_by_mm(measured_twin(rig()), uneven, fold.fitted),
                   known = wrong_by_mm(measured_twin(uneven_rig()), uneven, fold.fitted);
      EXPECT_GT(before, 2.0 * plain);
      EXPECT_LT(after, 1.1 * plain);
      EXPECT_LT(known, 1.1 * plain);
      printf("folds %d: plain %.5f before %.5f after %.5f known %.5f mm\n", n_folds, plain, before, after,
             known);
    }
}

}  // namespace
}  // namespace fringetwin::cosim::measured_shapes_test
