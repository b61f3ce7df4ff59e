// SPDX-License-Identifier: Apache-2.0
// A ball is built from some of its phase steps, of images whose light drifts and whose fringes have harmonics
// that the twin does not know. The images are the double-precision reference's, with noise; the truth is the
// ball.
//
// | check                | tolerance      | origin                                                    |
// |----------------------|----------------|-----------------------------------------------------------|
// | rms of the shape     | 1.1 x of plain | plain: the same noise without drift and harmonics; what   |
// |                      |                | 20 common numbers are not known by is 1 % of the noise    |
// | the same as recorded | > 10 x         | planted: 0.015 rad of the fringes, 0.001 left of the      |
// |                      |                | phases' noise over the windows: 16 to 24 are seen         |
#include "cosim/shape/measured_shapes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <tuple>

#include "compare/held_out/held_out.hpp"
#include "cosim/simulate.hpp"
#include "measure/measurement.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "tests/support/reference_captures.hpp"

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
  return testing::reference_captures(testing::with_object(of, "ball", testing::physical_sphere()), 3);
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
      EXPECT_GT(before, 10.0 * plain);
      EXPECT_LT(after, 1.1 * plain);
      EXPECT_LT(known, 1.1 * plain);
    }
}

/// Returns the images with other gray values in these steps, some of them clipped.
std::vector<CameraImages> disturbed(std::vector<CameraImages> real, const std::vector<int>& steps) {
  const std::vector<PatternSpec> sequence = expand_sequence(rig().fringes);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> any(0.6F, 1.1F);
  for (std::size_t k = 0; k < sequence.size(); ++k)
    if (std::ranges::find(steps, sequence[k].step) != steps.end()) {
      for (float& v : real[0].images[k].as_floats()) v = std::round(v * any(random));
      real[0].images[k].writable(40, 30) = 4095.0F;
    }
  return real;
}

// Whatever the images that are held out show: no bit of the shape is another.
TEST(MeasuredShapes, OfAFoldHoldNothingOfTheImagesHeldOut) {
  const std::vector<CameraImages> real = recorded(uneven_rig());
  const compare::Fold fold = compare::folds_of(kSteps, 3)[1];
  const std::vector<CameraImages> others = disturbed(real, fold.held_out);
  for (const bool is_known : {false, true}) {
    Twin a = measured_twin(is_known ? uneven_rig() : rig()), b = a, whole = a, whole_b = a;
    build_measured_shapes(a, real, fold.fitted);
    build_measured_shapes(b, others, fold.fitted);
    EXPECT_EQ(mesh_of(a).vertices_mm, mesh_of(b).vertices_mm);
    EXPECT_EQ(mesh_of(a).triangles, mesh_of(b).triangles);
    // they are in the shape where none is held out, though the even steps alone make it: images that move
    // nothing would prove nothing
    std::vector<CameraImages> odd = disturbed(real, {1, 7});
    build_measured_shapes(whole, real);
    build_measured_shapes(whole_b, odd);
    EXPECT_NE(mesh_of(whole).vertices_mm, mesh_of(whole_b).vertices_mm);
  }
}

/// Returns what the images of a fold are predicted to, as `cosim --hold-out` does it.
std::vector<compare::HeldOutRow> predicted(const std::vector<CameraImages>& real, const compare::Fold& fold,
                                           const std::vector<std::string>& asked) {
  Twin twin = measured_twin(rig());
  const auto noise = build_measured_shapes(twin, real, fold.fitted);
  Simulated simulated = simulate(twin, {}, *testing::shared_renderer());
  compare::Side side;
  side.images = std::move(simulated.captures);
  side.irradiance = std::move(simulated.irradiance);
  side.measurement = measure::measure(twin, side.images, fold.fitted);
  compare::CompareOptions options;
  options.renderer = testing::shared_renderer();
  return compare::predict_held_out({.twin = twin,
                                    .real = real,
                                    .simulated = side,
                                    .options = options,
                                    .asked = asked,
                                    .fold = fold,
                                    .shape_leverage = noise->leverage})
      .rows;
}

// One image of a fold is disturbed in all pitches: no bit of what the others are predicted to is another, and
// their own light is theirs alone. Its own prediction is the same where no light is asked for.
TEST(MeasuredShapes, OfAFoldPredictImagesThatHaveNoPartInThem) {
  REQUIRE_RENDERER();
  const std::vector<CameraImages> real = recorded(uneven_rig());
  const compare::Fold fold = compare::folds_of(kSteps, 3)[1];
  std::vector<CameraImages> brighter = real;
  const std::vector<PatternSpec> sequence = expand_sequence(rig().fringes);
  const auto step_of = [&](const compare::HeldOutRow& row) {
    return std::ranges::find_if(sequence,
                                [&](const PatternSpec& p) { return p.label(rig().fringes) == row.pattern; })
        ->step;
  };
  for (std::size_t k = 0; k < sequence.size(); ++k)
    if (sequence[k].step == 4)
      for (float& v : brighter[0].images[k].as_floats()) v += 8.0F;
  for (const std::vector<std::string>& asked :
       {std::vector<std::string>{"harmonics", "texture"}, std::vector<std::string>{"light", "texture"}}) {
    const auto a = predicted(real, fold, asked), b = predicted(brighter, fold, asked);
    ASSERT_EQ(a.size(), b.size());
    std::size_t n_brighter = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      ASSERT_EQ(a[k].pattern, b[k].pattern);
      if (step_of(a[k]) != 4) {
        EXPECT_EQ(std::tie(a[k].n, a[k].mean_dn, a[k].rms_dn, a[k].noise_dn, a[k].fitted_dn, a[k].ratio),
                  std::tie(b[k].n, b[k].mean_dn, b[k].rms_dn, b[k].noise_dn, b[k].fitted_dn, b[k].ratio));
        if (asked[0] == "light") {
          EXPECT_EQ(a[k].light_factor, b[k].light_factor);
        }
        continue;
      }
      ++n_brighter;
      EXPECT_EQ(a[k].n, b[k].n);
      if (asked[0] == "light") {
        EXPECT_GT(b[k].light_factor, a[k].light_factor);
        continue;
      }
      EXPECT_NEAR(b[k].mean_dn, a[k].mean_dn - 8.0, 1e-3);  // 1000 DN in single precision: 6e-5
      EXPECT_EQ(b[k].predicted_dn, a[k].predicted_dn);
    }
    EXPECT_EQ(n_brighter, 3u);
  }
}

// Three steps leave nothing over that would tell light: the shape is that of the images as they are, and one
// warning of all folds says so.
TEST(MeasuredShapes, OfTooFewStepsAreMeasuredAsRecordedAndSaySoOnce) {
  const std::vector<CameraImages> real = recorded(uneven_rig());
  std::set<std::string> told;
  ::testing::internal::CaptureStderr();
  for (const std::vector<int>& steps : {std::vector<int>{0, 4, 8}, std::vector<int>{1, 5, 9}}) {
    Twin corrected = measured_twin(rig()), plain = measured_twin(rig(), false);
    build_measured_shapes(corrected, real, steps, &told);
    build_measured_shapes(plain, real, steps, &told);
    EXPECT_EQ(mesh_of(corrected).vertices_mm, mesh_of(plain).vertices_mm);
  }
  const std::string shown = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(told.size(), 1u);
  EXPECT_THAT(shown, ::testing::HasSubstr("left where some are held out do not tell light and waveform"));
  EXPECT_EQ(std::ranges::count(shown, '\n'), 1);
}

}  // namespace
}  // namespace fringetwin::cosim::measured_shapes_test
