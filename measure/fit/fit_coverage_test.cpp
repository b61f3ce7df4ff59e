// SPDX-License-Identifier: Apache-2.0
// Do the printed standard errors of fits tell the scatter when neighbouring points share their errors?
// clang-format off
// | check                           | tolerance            | origin                                                      |
// |---------------------------------|----------------------|-------------------------------------------------------------|
// | rms of (estimate - truth)/sigma | 0.75 ... 1.35        | 100 draws: 7 %; correlation across block borders: 10 to 15 %; |
// |                                 |                      | t distribution of some 20 blocks: 5 %                       |
// | 95 % intervals hold the truth   | >= 0.86              | the same                                                    |
// | against the truth, both sides   | 0.61 ... 0.75,       | 400 draws: 3 sigma of 2.3 % and of 1.1 %                    |
// |                                 | 0.92 ... 0.98        |                                                             |
// clang-format on
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <random>
#include <tuple>
#include <utility>

#include "measure/fit/block_covariance.hpp"
#include "measure/fit/fits.hpp"
#include "measure/measurement.hpp"
#include "tests/support/measure/measure_rig.hpp"

namespace fringetwin::measure::fit_coverage_test {
namespace {

using namespace testing;

/// Scores of many draws: (estimate - truth) / sigma.
struct Scores {
  double sum_sq = 0.0;
  int n = 0, inside = 0, inside_1 = 0;
  void add(double error, double sigma) {
    const double z = error / sigma;
    sum_sq += z * z;
    ++n;
    inside += std::abs(z) <= 1.96;
    inside_1 += std::abs(z) <= 1.0;
  }
  double rms() const { return std::sqrt(sum_sq / n); }
  double coverage() const { return static_cast<double>(inside) / n; }
  double within_1() const { return static_cast<double>(inside_1) / n; }
};

/// White noise averaged over (2 half + 1)^2 px, unit variance: correlated over that many pixels.
ImageD correlated_noise(int side, int half, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  ImageD white(side + 2 * half, side + 2 * half), out(side, side);
  for (double& v : white.data) v = normal(random);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      double sum = 0.0;
      for (int v = 0; v <= 2 * half; ++v)
        for (int u = 0; u <= 2 * half; ++u) sum += white(x + u, y + v);
      out(x, y) = sum / (2 * half + 1);
    }
  return out;
}

struct Sample {
  std::vector<Eigen::Vector3d> p_mm;
  std::vector<Eigen::Vector2f> q_px;
};

/// The cap of a sphere that a camera sees, one point per pixel of a disc of the given diameter.
Sample cap(const SphereShape& s, int diameter_px, double noise_mm, int half, std::mt19937_64& random) {
  const ImageD noise = correlated_noise(diameter_px, half, random);
  Sample out;
  const double r_px = 0.5 * diameter_px;
  for (int y = 0; y < diameter_px; ++y)
    for (int x = 0; x < diameter_px; ++x) {
      const double u = 0.95 * (x + 0.5 - r_px) / r_px, v = 0.95 * (y + 0.5 - r_px) / r_px;
      if (u * u + v * v > 0.9) continue;
      const Eigen::Vector3d d(u, v, -std::sqrt(1.0 - u * u - v * v));
      out.p_mm.push_back(s.center_mm + (s.radius_mm + noise_mm * noise(x, y)) * d);
      out.q_px.emplace_back(static_cast<float>(x + 300), static_cast<float>(y + 200));
    }
  return out;
}

TEST(FitCoverage, SphereWithErrorsSharedByNeighbours) {
  const SphereShape truth{{0.3, -0.2, 250}, 5.0};
  for (const auto& [diameter_px, half] : {std::pair{80, 1}, std::pair{80, 2}, std::pair{160, 3}}) {
    std::mt19937_64 random(11);
    Scores blocks, independent;
    for (int draw = 0; draw < (diameter_px > 100 ? 40 : 100); ++draw) {
      const Sample s = cap(truth, diameter_px, 0.001, half, random);
      FitOptions o;
      o.loss = RobustLoss::tukey;
      const SphereFit plain = fit_sphere(s.p_mm, truth, o);
      o.block = image_blocks(s.q_px);
      const SphereFit fit = fit_sphere(s.p_mm, truth, o);
      ASSERT_TRUE(fit.usable && plain.usable);
      ASSERT_EQ(fit.radius_mm, plain.radius_mm);  // only the covariance differs
      for (int k = 0; k < 4; ++k) {
        const double error = k < 3 ? fit.center_mm[k] - truth.center_mm[k] : fit.radius_mm - truth.radius_mm;
        blocks.add(error, std::sqrt(fit.covariance(k, k)));
        independent.add(error, std::sqrt(plain.covariance(k, k)));
      }
    }
    std::printf("%d px, correlated over %d px: rms z %.2f (independent %.2f), 95 %% hold %.3f (%.3f)\n",
                diameter_px, 2 * half + 1, blocks.rms(), independent.rms(), blocks.coverage(),
                independent.coverage());
    EXPECT_GT(blocks.rms(), 0.75);
    EXPECT_LT(blocks.rms(), 1.35);
    EXPECT_GE(blocks.coverage(), 0.86);
    EXPECT_GT(independent.rms(), 0.8 * (2 * half + 1));  // what the blocks mend
  }
}

TEST(FitCoverage, PlaneWithErrorsSharedByNeighbours) {
  std::mt19937_64 random(12);
  Scores offset, tilt;
  for (int draw = 0; draw < 100; ++draw) {
    const ImageD noise = correlated_noise(120, 2, random);
    std::vector<Eigen::Vector3d> p;
    std::vector<Eigen::Vector2f> q;
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 120; ++x) {
        p.push_back({0.1 * (x - 59.5), 0.15 * (y - 59.5), 300 + 0.002 * noise(x, y)});
        q.emplace_back(static_cast<float>(x), static_cast<float>(y));
      }
    FitOptions o;
    o.block = image_blocks(q);
    const PlaneFit fit = fit_plane(p, o);
    ASSERT_TRUE(fit.usable);
    offset.add(fit.point_mm.z() - 300.0, fit.offset_sigma_mm);
    for (int j = 0; j < 2; ++j)
      tilt.add(fit.normal[j] / fit.normal.z(), std::sqrt(fit.tilt_covariance(j, j)));
  }
  std::printf("plane: offset rms z %.2f, tilt %.2f\n", offset.rms(), tilt.rms());
  for (const Scores& s : {offset, tilt}) {
    EXPECT_GT(s.rms(), 0.75);
    EXPECT_LT(s.rms(), 1.35);
    EXPECT_GE(s.coverage(), 0.86);
  }
}

TEST(FitCoverage, FewBlocksKeepTheIndependentSigma) {
  std::mt19937_64 random(13);
  const SphereShape truth{{0, 0, 250}, 5.0};
  Sample s = cap(truth, 60, 0.001, 0, random);
  FitOptions o;
  const SphereFit plain = fit_sphere(s.p_mm, truth, o);
  o.block.assign(s.p_mm.size(), 0);
  for (std::size_t i = 0; i < o.block.size(); ++i) o.block[i] = static_cast<int>(i % 5);
  EXPECT_EQ(fit_sphere(s.p_mm, truth, o).covariance, plain.covariance);
}

/// A ball beside a wall, both where a camera sees them, lit by the projector: the truth of the tests below.
struct Scene {
  SphereShape ball{{-18.0, 1.0, 262.0}, 17.0};
  PlaneShape wall{{24.0, -2.0, 270.0},
                  Eigen::Vector3d(-0.15, 0.1, -1).normalized(),
                  Eigen::Vector2d(34.0, 44.0),
                  Eigen::Vector3d::UnitX()};

  Scene() { wall.u_axis = (Eigen::Vector3d::UnitX() - wall.normal.x() * wall.normal).normalized(); }

  /// Returns the way along the ray to what it hits first, and the normal there.
  std::optional<std::pair<double, Eigen::Vector3d>> hit(const Eigen::Vector3d& o,
                                                        const Eigen::Vector3d& d) const {
    std::optional<std::pair<double, Eigen::Vector3d>> best;
    if (const auto s = sphere_surface(ball.center_mm, ball.radius_mm)(o, d))
      best = {*s, (o + *s * d - ball.center_mm).normalized()};
    const auto s = plane_surface(wall.point_mm, wall.normal)(o, d);
    if (!s || (best && best->first < *s)) return best;
    const Eigen::Vector3d at = o + *s * d - wall.point_mm;
    if (std::abs(at.dot(wall.u_axis)) <= 0.5 * wall.size_mm->x() &&
        std::abs(at.dot(wall.normal.cross(wall.u_axis))) <= 0.5 * wall.size_mm->y())
      best = {*s, wall.normal};
    return best;
  }
};

/// The lit pixels of a camera and their irradiance in each image, 1 = full scale.
struct Exposure {
  std::vector<std::size_t> pixel;
  std::vector<std::vector<float>> values;  ///< [image][lit pixel]
};

/// Mean over 3 x 3 rays of each pixel: Lambert's cosine times the pattern's value.
Exposure average_over_pixels(const Twin& twin, std::size_t camera, const Scene& scene) {
  const Camera& cam = twin.cameras[camera];
  const Pose T_world_cam = cam.T_cam_world.inverse();
  const Eigen::Vector3d light = twin.projector->center_world_mm();
  const std::vector<PatternSpec> patterns = expand_sequence(twin.fringes);
  Exposure out;
  out.values.resize(patterns.size());
  std::vector<double> sum(patterns.size());
  for (int y = 0; y < cam.lens.height(); ++y)
    for (int x = 0; x < cam.lens.width(); ++x) {
      std::ranges::fill(sum, 0.0);
      for (int k = 0; k < 9; ++k) {
        const auto ray = cam.lens.unproject({x + (k % 3 - 1) / 3.0, y + (k / 3 - 1) / 3.0});
        const Eigen::Vector3d d = T_world_cam.rotation * *ray;
        const auto seen = scene.hit(T_world_cam.translation_mm, d);
        if (!seen) continue;
        const Eigen::Vector3d p = T_world_cam.translation_mm + seen->first * d, to_light = light - p;
        const double cosine = seen->second.dot(to_light.normalized());
        const auto shadow = scene.hit(light, -to_light.normalized());
        if (cosine <= 0.0 || !shadow || shadow->first < to_light.norm() - 1e-6) continue;
        const auto q = twin.projector->lens.project(twin.projector->T_proj_world * p);
        for (std::size_t i = 0; i < patterns.size(); ++i)
          sum[i] += cosine / 9.0 * pattern_value(twin.fringes, patterns[i], q->x());
      }
      if (*std::ranges::max_element(sum) <= 0.0) continue;
      out.pixel.push_back(static_cast<std::size_t>(y) * cam.lens.width() + x);
      for (std::size_t i = 0; i < sum.size(); ++i) out.values[i].push_back(static_cast<float>(sum[i]));
    }
  return out;
}

/// The gray values of a camera; without `random` neither noise nor rounding.
CameraImages expose(const Camera& camera, const Exposure& lit, std::mt19937_64* random) {
  const Sensor& sensor = camera.sensor;
  std::normal_distribution<float> normal;
  CameraImages images{.camera = camera.name, .bit_depth = sensor.bit_depth};
  const auto black = static_cast<float>(sensor.black_level_dn), gain = static_cast<float>(sensor.gain_dn),
             read = static_cast<float>(sensor.read_noise_dn.value()),
             per_dn = 1.0f / static_cast<float>(sensor.electrons_per_dn.value());
  for (const std::vector<float>& values : lit.values) {
    ImageF image(camera.lens.width(), camera.lens.height(), black);
    for (std::size_t k = 0; k < values.size(); ++k) {
      float v = gain * values[k];
      if (random) v = std::round(black + v + std::sqrt(read * read + v * per_dn) * normal(*random)) - black;
      image.data[lit.pixel[k]] = black + v;
    }
    images.images.push_back(std::move(image));
  }
  return images;
}

struct Rig {
  const char* name;
  std::size_t n_cameras;
  int steps;
  Sensor sensor;
};

/// Returns the camera with the part of its image alone that the scene fills, and a margin.
Camera cropped(const Camera& camera, const Scene& scene) {
  const Pose T_world_cam = camera.T_cam_world.inverse();
  Eigen::AlignedBox2i filled;
  for (int y = 0; y < camera.lens.height(); ++y)
    for (int x = 0; x < camera.lens.width(); ++x)
      if (scene.hit(T_world_cam.translation_mm,
                    T_world_cam.rotation *
                        *camera.lens.unproject({static_cast<double>(x), static_cast<double>(y)})))
        filled.extend(Eigen::Vector2i(x, y));
  const Eigen::Vector2i first = filled.min().array() - 3;
  std::vector<double> intrinsics = camera.lens.intrinsics();
  intrinsics[2] -= first.x();
  intrinsics[3] -= first.y();
  Camera out = camera;
  out.lens = Lens("LENSMODEL_OPENCV4", intrinsics, filled.sizes().array() + 7, "cropped");
  return out;
}

Twin twin_of(const Rig& rig, const Scene& scene) {
  Twin twin = scaled_paper_rig(0.2);
  twin.cameras.erase(twin.cameras.begin() + static_cast<std::ptrdiff_t>(rig.n_cameras), twin.cameras.end());
  for (Camera& camera : twin.cameras) {
    camera = cropped(camera, scene);
    camera.sensor = rig.sensor;
  }
  twin.fringes.steps = rig.steps;
  twin.objects = {{"ball", scene.ball, {}}, {"wall", scene.wall, {}}};
  twin.measure.fits = {{"ball", 2.0}, {"wall", 2.0}};
  return twin;
}

/// Returns the seven numbers that the fits of ball and wall state, less the truth, and their sigmas for
/// noise.
std::pair<std::vector<double>, std::vector<double>> errors_and_sigmas(const Scene& scene,
                                                                      const Measurement& m) {
  const ObjectFit &ball = m.fits.at(0), &wall = m.fits.at(1);
  const Eigen::Vector3d moved = ball.vectors.at("center_mm") - scene.ball.center_mm,
                        sigma = ball.vectors.at("center_noise_sigma_mm"), &normal = wall.vectors.at("normal");
  std::vector<double> errors(moved.begin(), moved.end()), sigmas(sigma.begin(), sigma.end());
  errors.push_back(ball.numbers.at("radius_mm") - scene.ball.radius_mm);
  sigmas.push_back(ball.numbers.at("radius_noise_sigma_mm"));
  errors.push_back(scene.wall.normal.dot(wall.vectors.at("point_mm") - scene.wall.point_mm));
  sigmas.push_back(wall.numbers.at("offset_noise_sigma_mm"));
  for (const std::string way : {"0", "1"}) {
    const Eigen::Vector3d& d = wall.vectors.at("tilt_direction_" + way);
    errors.push_back(scene.wall.normal.dot(d) / scene.wall.normal.dot(normal) - normal.dot(d));
    sigmas.push_back(wall.numbers.at("tilt_noise_sigma_rad_" + way));
  }
  return {errors, sigmas};
}

// The twin is right; its noise-free images are those that the draws start from. The bias is that of a curved
// surface under the pixel's average: without it no interval would hold the ball's depth.
TEST(FitCoverage, NoiseSigmaHoldsTheTruthOnceTheMethodBiasIsOff) {
  constexpr int kDraws = 400;
  const Scene scene;
  const char* const names[] = {"x", "y", "z", "radius", "offset", "tilt 0", "tilt 1"};
  for (const Rig& rig : {Rig{"projector, 12 bit, N = 4", 1, 4, {12, {}, 3000.0, 100.0, 10.0, 6.0}},
                         Rig{"two cameras, 8 bit, N = 3", 2, 3, {8, {}, 220.0, 4.0, 40.0, 0.6}}}) {
    Twin twin = twin_of(rig, scene);
    twin.measure.correct_pixel_area = true;
    std::vector<Exposure> lit;
    std::vector<CameraImages> noise_free;
    for (std::size_t c = 0; c < twin.cameras.size(); ++c) {
      lit.push_back(average_over_pixels(twin, c, scene));
      noise_free.push_back(expose(twin.cameras[c], lit.back(), nullptr));
    }
    struct Draw {
      std::vector<double> errors, sigmas;
      double biased_z_mm = 0.0;
    };
    std::vector<Draw> draws(kDraws);
#pragma omp parallel for schedule(dynamic, 4)
    for (int k = 0; k < kDraws; ++k) {
      std::mt19937_64 random(21 + k);
      std::vector<CameraImages> images;
      for (std::size_t c = 0; c < twin.cameras.size(); ++c)
        images.push_back(expose(twin.cameras[c], lit[c], &random));
      Measurement m = measure(twin, images);
      state_method_bias(twin, noise_free, m);
      if (m.fits[0].bias.empty() || m.fits[1].bias.empty()) continue;
      std::tie(draws[k].errors, draws[k].sigmas) = errors_and_sigmas(scene, m);
      draws[k].biased_z_mm = draws[k].errors[2] + m.fits[0].bias_vectors.at("center_mm").z();
    }
    Scores scores[7], biased_z;
    for (const Draw& draw : draws) {
      ASSERT_FALSE(draw.errors.empty()) << rig.name;
      for (std::size_t k = 0; k < 7; ++k) scores[k].add(draw.errors[k], draw.sigmas[k]);
      biased_z.add(draw.biased_z_mm, draw.sigmas[2]);
    }
    std::printf("%s: with its bias z holds %.2f\n", rig.name, biased_z.coverage());
    EXPECT_LT(biased_z.coverage(), 0.3) << rig.name;
    for (int k = 0; k < 7; ++k) {
      std::printf("%s: %-8s 68 %%: %.3f, 95 %%: %.3f, rms z %.2f\n", rig.name, names[k], scores[k].within_1(),
                  scores[k].coverage(), scores[k].rms());
      EXPECT_NEAR(scores[k].within_1(), 0.68, 0.07) << rig.name << ": " << names[k];
      EXPECT_NEAR(scores[k].coverage(), 0.95, 0.03) << rig.name << ": " << names[k];
    }
  }
}

}  // namespace
}  // namespace fringetwin::measure::fit_coverage_test
