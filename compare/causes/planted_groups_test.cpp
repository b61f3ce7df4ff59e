// SPDX-License-Identifier: Apache-2.0
// Every group that is no pose and no lens, planted into gray values with noise, is found by one linear step.
// Light, response, field and shift change gray values by 0.8 DN at most. Ten times more, and Huber's weights,
// which take off more from residuals that noise enlarges, or what two factors do together (the field), move
// the step of a linear model by more than 4 sigma.
//
// | check                 | tolerance      | origin                                                |
// |-----------------------|----------------|-------------------------------------------------------|
// | planted value         | 4 sigma        | 30 numbers, normal: one seed in 500                   |
// | light and shifts      | 3.5 sigma      | required; 47 numbers, normal: one seed in 45          |
// | sigma                 | 0.1 planted    | 0.3 DN of 200: planted are 17 sigma and more          |
// | light refined back    | 3 sigma        | required; 11 numbers: one seed in 34                  |
// | field, lamp           | 3 sigma        | required; 5 numbers: one seed in 74                   |
// | field and rendering   | 2e-4           | 0.1 px of 640, 0.08 per half image, of 12: 1.5e-4     |
// | motion refined back   | 3 sigma        | required; 3 numbers: one seed in 120                  |
// | effect and rendering  | 2e-5           | irradiance of 12 in single precision, 7e-7 each, added|
// | projector's pixel     | 0.1 px         | phase in single precision: 5e-5 rad of 5120 px: 0.04  |
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "compare/causes/group_fit.hpp"
#include "compare/causes/sensitivity.hpp"
#include "compare/parameters/closed_columns.hpp"
#include "compare/parameters/parameters.hpp"
#include "render/pattern/camera_effects.hpp"
#include "render/reference/reference.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/compare/planted_samples.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::planted_groups_test {
namespace {

using namespace planted_samples;

Twin window_on_the_sphere() { return testing::window_on_the_sphere(kWidth, kHeight); }

render::Renderer& renderer() { return testing::needed_renderer(); }

struct Planted {
  std::string name;
  double change;
};

/// Finds these parameters, gain and black level in one step.
void expect_found(const Twin& twin, const std::string& group, const std::vector<Planted>& planted,
                  const Images& truth, const Error& error) {
  std::vector<Parameter> parameters;
  for (const Planted& wanted : planted)
    for (Parameter& p : parameters_of(twin, group))
      if (p.name == wanted.name) parameters.push_back(std::move(p));
  ASSERT_EQ(parameters.size(), planted.size());
  const std::vector<CameraImages> frames = frames_of(rendered(twin));
  std::vector<GridSamples> samples = samples_of(truth, error, frames);
  find_projector_places(renderer(), twin, samples);
  Sensitivity sensitivity(renderer(), std::move(samples));
  const std::vector<Parameter> pose = parameters_of(twin, "pose");
  std::vector<std::size_t> places(pose.size());
  std::iota(places.begin(), places.end(), 0);
  sensitivity.take_pose_slopes(sensitivity.columns(twin, pose, start_values(pose)), places);
  const NormalEquations e = sensitivity.equations(twin, parameters, start_values(parameters));
  std::vector<std::size_t> unknowns;
  for (std::size_t k = 0; k < parameters.size() + 4; ++k) unknowns.push_back(k);
  const Step step = solve_step(e, unknowns);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    EXPECT_NEAR(step.change[at], planted[k].change, 4.0 * step.sigma[at]) << planted[k].name;
    EXPECT_LT(step.sigma[at], 0.1 * std::abs(planted[k].change)) << planted[k].name;
  }
  EXPECT_LT(step.chi2, 1.05 * static_cast<double>(e.n));
}

TEST(PlantedGroups, SizeIntrinsicsGlossAndContrast) {
  const Twin twin = window_on_the_sphere();
  const std::pair<std::string, Planted> cases[] = {{"size", {"ball.radius_mm", 0.02}},
                                                   {"intrinsics", {"projector.principal_point_px.x", 0.05}},
                                                   {"intrinsics", {"right.principal_point_px.x", -0.05}},
                                                   {"intrinsics", {"projector.focal_px", 0.5}},
                                                   {"specular", {"ball.specular", 0.02}},
                                                   {"fringe_contrast", {"projector.fringe_contrast", -0.02}}};
  for (const auto& [group, planted] : cases)
    for (const Parameter& p : parameters_of(twin, group))
      if (p.name == planted.name) {
        const Twin truth = with_values(twin, {p}, Eigen::VectorXd::Constant(1, p.start + planted.change));
        expect_found(twin, group, {planted}, rendered(truth), same);
      }
}

TEST(PlantedGroups, LightOfImages) {
  const Twin twin = window_on_the_sphere();
  const double factors[] = {0.999, 1.001, 1.002, 0.998, 1.0,   1.0,
                            1.0,   1.0,   1.0,   1.003, 0.997, 1.0};  // mean 1
  std::vector<Planted> planted;
  for (const int k : {1, 2, 3, 9, 10})
    planted.push_back({"image_" + std::to_string(k) + ".light", factors[k] - 1.0});
  expect_found(twin, "light", planted, rendered(twin),
               [&](double e, std::size_t, int image, int, int) { return factors[image] * e; });
}

// A lamp that drifts by 2 % and flickers, under steady room light, as the reference in double precision sees
// it: what `--refine light` does finds every image's factor, and the keys that it writes show these images.
TEST(PlantedGroups, LightIsRefinedBack) {
  Twin twin = window_on_the_sphere();
  twin.projector->ambient = 1.0;
  Twin truth = twin;
  for (int k = 0; k < 12; ++k)
    truth.projector->light_factors.push_back((1.0 - 0.02 + 0.04 * k / 11.0) * (k % 3 == 1 ? 1.01 : 1.0));
  const render::Reference reference(truth);
  Images recorded(2, std::vector<ImageF>(12, ImageF(kWidth, kHeight)));
  for (std::size_t c = 0; c < 2; ++c)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const render::ReferencePixel pixel = reference.pixel(c, x, y, {.gauss_n = 3});
        for (std::size_t k = 0; k < 12; ++k) recorded[c][k](x, y) = static_cast<float>(pixel.irradiance[k]);
      }
  const std::vector<CameraImages> frames = frames_of(recorded);
  Sensitivity sensitivity(renderer(), samples_of(recorded, same, frames));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "light"), {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_NEAR(fit.chi2(), 1.0, 0.02);  // 46,080 values: sqrt(2/n) = 0.0066
  const std::vector<double>& planted = truth.projector->light_factors;
  double mean = 0.0;
  for (const double factor : planted) mean += std::log(factor) / 12.0;
  for (std::size_t k = 0; k < 11; ++k) {
    const GroupFit::Known& known = fit.known()[k];
    EXPECT_NEAR(known.value, std::log(planted[k + 1]) - mean, 3.0 * known.sigma) << fit.parameters()[k].name;
    EXPECT_LT(known.sigma, 1e-3);
  }
  // without a rendering they were fitted, with the twin's own factors they are rendered
  const Sensitivity::Values rendered = sensitivity.irradiance(fit.twin(), Sensitivity::kResidualSamples);
  for (std::size_t c = 0; c < 2; ++c)
    for (std::size_t i = 0; i < rendered[c].size(); ++i)
      ASSERT_NEAR(fit.predicted()[c][i], rendered[c][i], 2e-5);
}

TEST(PlantedGroups, LightOfTheRoom) {
  const Twin twin = window_on_the_sphere();
  expect_found(twin, "room_light", {{"left.room_light.x", 1.0}, {"right.room_light.yy", -2.0}},
               rendered(twin), [](double e, std::size_t camera, int, int x, int y) {
                 const double u = 2.0 * x / kWidth - 1.0, v = (2.0 * y - kHeight) / kWidth;
                 return e + (camera == 0 ? u : -2.0 * v * v) / kGain;
               });
}

TEST(PlantedGroups, ResponseOfACamera) {
  const Twin twin = window_on_the_sphere();
  expect_found(twin, "camera_response", {{"left.response.gamma", -0.002}, {"right.response.square", 0.005}},
               rendered(twin), [](double e, std::size_t camera, int, int, int) {
                 const double r = e * kGain / 255.0;
                 return 255.0 / kGain * (camera == 0 ? std::pow(r, 0.998) : r + 0.005 * r * r);
               });
}

/// Returns the projector's pixel that lights a pixel of a camera, by the reference in double precision.
Eigen::Vector2d projector_px(const render::Reference& reference, std::size_t camera, int x, int y) {
  return reference.sample(camera, {x, y}).projector_px;
}

TEST(PlantedGroups, FieldOfTheProjector) {
  const Twin twin = window_on_the_sphere();
  const render::Reference reference(twin);
  const Images truth = rendered(twin);
  const std::vector<CameraImages> frames = frames_of(truth);
  std::vector<GridSamples> samples = samples_of(truth, same, frames);
  find_projector_places(renderer(), twin, samples);
  for (const GridSamples& s : samples)
    for (std::size_t p = 0; p < s.n_pixels(); p += 7)
      EXPECT_LE((s.projector_px[p].cast<double>() - projector_px(reference, s.camera,
                                                                 static_cast<int>(s.cell[p]) % kWidth,
                                                                 static_cast<int>(s.cell[p]) / kWidth))
                    .norm(),
                0.1);
  expect_found(
      twin, "projector_field", {{"projector.light_field.1_0", 0.02}, {"projector.light_field.0_1", -0.03}},
      truth, [&](double e, std::size_t camera, int, int x, int y) {
        const Eigen::Vector2d at = projector_px(reference, camera, x, y);
        return e * std::exp(0.02 * ((at.x() + 0.5) / 640.0 - 1.0) - 0.03 * ((at.y() + 0.5) / 360.0 - 1.0));
      });
}

// The reference sees a ball that a hot spot lights; what `--refine projector_field` does finds its terms
// beside each other and the gain, and the twin that it writes shows these images.
TEST(PlantedGroups, FieldOfTheProjectorIsRefinedBack) {
  const Twin twin = window_on_the_sphere();
  Twin truth = twin;
  truth.projector->light_field = {0.05, -0.08, -0.3, 0.0, -0.2};
  const Images recorded = traced_by_reference(truth);
  const std::vector<CameraImages> frames = frames_of(recorded);
  std::vector<GridSamples> samples = samples_of(recorded, same, frames);
  find_projector_places(renderer(), twin, samples);
  Sensitivity sensitivity(renderer(), std::move(samples));
  std::vector<Parameter> parameters = parameters_of(twin, "projector_field");
  parameters.resize(2);  // of the part that the ball fills a curve hardly differs from more light
  Twin known = twin;
  known.projector->light_field = truth.projector->light_field;
  known.projector->light_field[0] = known.projector->light_field[1] = 0.0;
  for (Parameter& p : parameters) EXPECT_EQ(p.start, 0.0);
  GroupFit fit(sensitivity, known, parameters, {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_NEAR(fit.chi2(), 1.0, 0.02);  // as for the light
  for (std::size_t k = 0; k < 2; ++k) {
    const GroupFit::Known& found = fit.known()[k];
    EXPECT_NEAR(found.value, truth.projector->light_field[k], 3.0 * found.sigma) << fit.parameters()[k].name;
    EXPECT_LT(found.sigma, 0.1 * std::abs(truth.projector->light_field[k]));
    EXPECT_EQ(fit.twin().projector->light_field[k], found.value);
  }
  const Sensitivity::Values rendered = sensitivity.irradiance(fit.twin(), Sensitivity::kResidualSamples);
  for (std::size_t c = 0; c < 2; ++c)
    for (std::size_t i = 0; i < rendered[c].size(); ++i)
      ASSERT_NEAR(fit.predicted()[c][i], rendered[c][i], 2e-4);
}

// The lamp is turned by 11 degrees and brighter by 20 % than the twin has it; both cast shadows.
TEST(PlantedGroups, LampIsRefinedBack) {
  Twin twin = window_on_the_sphere();
  twin.room.lamp_world = {0.5, -0.3, -1.0};
  Twin truth = twin;
  truth.room.lamp_world = {0.4, -0.5, -1.2};
  const Images recorded = traced_by_reference(truth);
  const std::vector<CameraImages> frames = frames_of(recorded);
  Sensitivity sensitivity(renderer(), samples_of(recorded, same, frames));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "lamp"), {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_NEAR(fit.chi2(), 1.0, 0.02);  // as for the light
  ASSERT_EQ(fit.parameters().size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const GroupFit::Known& found = fit.known()[k];
    EXPECT_NEAR(found.value, truth.room.lamp_world[static_cast<Eigen::Index>(k)], 3.0 * found.sigma)
        << fit.parameters()[k].name;
    EXPECT_EQ(fit.twin().room.lamp_world[static_cast<Eigen::Index>(k)], found.value);
  }
  EXPECT_TRUE(parameters_of(window_on_the_sphere(), "lamp").empty());
}

TEST(PlantedGroups, ShiftOfImages) {
  const Twin twin = window_on_the_sphere();
  Images truth = rendered(twin);
  std::vector<Planted> planted;
  for (const auto& [image, shift_px] : {std::pair{0, 0.004}, std::pair{6, -0.003}}) {
    Twin moved = twin;
    for (double& origin_px : moved.fringes.directions[0].phase_origin_px) origin_px += shift_px;
    const Images all = rendered(moved);
    for (std::size_t c = 0; c < truth.size(); ++c)
      truth[c][static_cast<std::size_t>(image)] = all[c][static_cast<std::size_t>(image)];
    planted.push_back({"image_" + std::to_string(image) + ".shift_px", shift_px});
  }
  expect_found(twin, "image_shift", planted, truth, same);
}

// Steps that are wrong by some hundredths of a radian, of fringes that have harmonics and light that differs
// from image to image, as the reference in double precision sees them: what `--refine image_shift,light` does
// finds each, though its derivatives take the harmonics as staying.
TEST(PlantedGroups, ShiftsAreRefinedBack) {
  Twin twin = window_on_the_sphere();
  for (DirectionFringes& d : twin.fringes.directions) d.harmonics.assign(3, {{0.01, -0.02}});
  Twin truth = twin;
  for (int k = 0; k < 12; ++k) {
    truth.projector->image_shifts_px.push_back(0.1 * std::sin(2.0 + 1.9 * k));
    truth.projector->light_factors.push_back(1.0 + 0.02 * std::cos(1.0 + 2.3 * k));
  }
  const render::Reference reference(truth);
  Images recorded(2, std::vector<ImageF>(12, ImageF(kWidth, kHeight)));
  for (std::size_t c = 0; c < 2; ++c)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const render::ReferencePixel pixel = reference.pixel(c, x, y, {.gauss_n = 3});
        for (std::size_t k = 0; k < 12; ++k) recorded[c][k](x, y) = static_cast<float>(pixel.irradiance[k]);
      }
  const std::vector<CameraImages> frames = frames_of(recorded);
  Sensitivity sensitivity(renderer(), samples_of(recorded, same, frames));
  std::vector<Parameter> parameters = parameters_of(twin, "image_shift");
  for (Parameter& p : parameters_of(twin, "light")) parameters.push_back(std::move(p));
  GroupFit fit(sensitivity, twin, parameters, {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_NEAR(fit.chi2(), 1.0, 0.02);  // as for the light
  for (std::size_t k = 0; k < 12; ++k) {
    const GroupFit::Known& found = fit.known()[k];
    EXPECT_NEAR(found.value, truth.projector->image_shifts_px[k], 3.5 * found.sigma)
        << fit.parameters()[k].name;  // the largest of 12 normal errors exceeds 3.5 once in 180 draws
    EXPECT_LT(found.sigma, 0.01);
    EXPECT_EQ(fit.twin().projector->image_shifts_px[k], found.value);
  }
}

// The ball is elsewhere in every image; each is rendered with its own twin.
TEST(PlantedGroups, MotionOfTheBall) {
  const Twin twin = window_on_the_sphere();
  Images truth = rendered(twin);
  const Eigen::Vector3d moved_mm(0.004, 0.02, -0.006);  // the fringes run along y
  const std::size_t n = truth[0].size();
  for (std::size_t k = 0; k < n; ++k) {
    Twin then = twin;
    std::get<SphereShape>(then.objects[0].shape).center_mm +=
        (static_cast<double>(k) / static_cast<double>(n - 1) - 0.5) * moved_mm;
    const Images all = rendered(then);
    for (std::size_t c = 0; c < truth.size(); ++c) truth[c][k] = all[c][k];
  }
  expect_found(twin, "motion",
               {{"ball.center_mm.x.motion", moved_mm.x()},
                {"ball.center_mm.y.motion", moved_mm.y()},
                {"ball.center_mm.z.motion", moved_mm.z()}},
               truth, same);
}

// The reference in double precision sees the ball at another place in every image, by half a radian of fringe
// in all: `--refine motion` finds the way, and the twin that it writes shows these images.
TEST(PlantedGroups, MotionIsRefinedBack) {
  const Twin twin = window_on_the_sphere();
  const Eigen::Vector3d moved_mm(0.04, 0.02, -0.05);
  const int n = 12;
  Images recorded(2, std::vector<ImageF>(n, ImageF(kWidth, kHeight)));
  for (int k = 0; k < n; ++k) {
    Twin then = twin;
    std::get<SphereShape>(then.objects[0].shape).center_mm += (k / (n - 1.0) - 0.5) * moved_mm;
    const render::Reference reference(then);
    for (std::size_t c = 0; c < 2; ++c)
#pragma omp parallel for schedule(dynamic)
      for (int i = 0; i < kWidth * kHeight; ++i)
        recorded[c][static_cast<std::size_t>(k)].data[static_cast<std::size_t>(i)] =
            static_cast<float>(reference.pixel(c, i % kWidth, i / kWidth, {.gauss_n = 3})
                                   .irradiance[static_cast<std::size_t>(k)]);
  }
  const std::vector<CameraImages> frames = frames_of(recorded);
  Sensitivity sensitivity(renderer(), samples_of(recorded, same, frames));
  GroupFit fit(sensitivity, twin, refinable_parameters_of(twin, "motion"), {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_NEAR(fit.chi2(), 1.0, 0.02);  // as for the light
  ASSERT_EQ(fit.parameters().size(), 3u);
  for (int i = 0; i < 3; ++i) {
    const GroupFit::Known& known = fit.known()[static_cast<std::size_t>(i)];
    EXPECT_NEAR(known.value, moved_mm[i], 3.0 * known.sigma)
        << fit.parameters()[static_cast<std::size_t>(i)].name;
    EXPECT_LT(known.sigma, 0.1 * std::abs(moved_mm[i]));
    EXPECT_EQ(fit.twin().objects[0].motion[static_cast<std::size_t>(i)], known.value);
  }
  EXPECT_EQ(fit.parameters()[2].name, "ball.center_mm.z.motion");

  // the phase of the finest pitch is wrong by what the motion does to it; the twin says so
  const Images at_rest = rendered(twin), predicted = rendered(fit.twin());
  const auto phase = [](const Images& images, std::size_t i) {
    return testing::stepped_phase(
        4, [&](int step) { return static_cast<double>(images[0][static_cast<std::size_t>(step)].data[i]); });
  };
  double squares = 0.0, off_squares = 0.0;
  for (std::size_t i = 0; i < at_rest[0][0].size(); ++i) {
    const double error_rad = testing::wrap(phase(recorded, i) - phase(at_rest, i));
    const double off_rad = testing::wrap(phase(predicted, i) - phase(recorded, i));
    squares += error_rad * error_rad;
    off_squares += off_rad * off_rad;
  }
  EXPECT_GT(std::sqrt(squares / (kWidth * kHeight)), 0.02);
  EXPECT_LT(off_squares, 0.05 * 0.05 * squares) << "asked: 20 %; the way is known to 2 %";
}

TEST(PlantedGroups, BlurOfACamera) {
  const Twin twin = window_on_the_sphere();
  Images truth = rendered(twin);
  const double variance = 0.05;
  for (ImageF& image : truth[1])
    image = render::convolve_separable(image, render::psf_kernel(std::sqrt(variance)));
  expect_found(twin, "camera_psf", {{"right.psf_px", variance}}, truth, same);
}

// Light and shifts of the images with a brightness and an offset of each pixel's own, which leave the two
// nearly the same: fitted in turn they crept.
TEST(PlantedGroups, LightAndShiftsOfPixelsOfTheirOwn) {
  Twin twin = window_on_the_sphere();
  twin.fringes.steps = 8;
  twin.projector->ambient = 1.0;
  Twin truth = twin;
  for (int k = 0; k < 24; ++k) {
    truth.projector->light_factors.push_back(1.0 + 0.02 * std::sin(2.0 * k));
    truth.projector->image_shifts_px.push_back(k % 8 == 3 ? 0.15 : k % 8 == 6 ? -0.1 : 0.0);
  }
  const Images images = traced_by_reference(truth);
  const std::vector<CameraImages> frames = frames_of(rendered(twin));
  std::vector<GridSamples> samples = samples_of(
      images, [](double e, std::size_t, int, int x, int y) { return (0.7 + 0.01 * ((x + y) % 40)) * e; },
      frames);
  Sensitivity sensitivity(renderer(), std::move(samples));
  sensitivity.free_in_all(FreePerPixel::factor_and_offset);
  std::vector<Parameter> parameters = parameters_of(twin, "image_shift");
  const std::size_t n_shifts = parameters.size();
  for (Parameter& light : parameters_of(twin, "light")) parameters.push_back(std::move(light));
  GroupFit fit(sensitivity, twin, parameters, {.hold_gain = true, .exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_LE(fit.steps(), 8);
  EXPECT_LT(fit.chi2(), 1.05);
  double mean = 0.0;
  for (const double factor : truth.projector->light_factors) mean += std::log(factor) / 24.0;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const double value = k < n_shifts ? truth.projector->image_shifts_px[k]
                                      : std::log(truth.projector->light_factors[k - n_shifts + 1]) - mean;
    EXPECT_NEAR(fit.known()[k].value, value, 3.5 * fit.known()[k].sigma) << parameters[k].name;
  }
}

}  // namespace
}  // namespace fringetwin::compare::planted_groups_test
