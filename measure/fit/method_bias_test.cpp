// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   2e-6 mm, 1e-7 rad   one linear step over displacements of 5e-3 mm on radii of 10 mm: their square over
//   the
//                       radius
//   5 %                 a standard error from 3600 residuals: 1.2 %, four times that
#include "measure/fit/method_bias.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "measure/fit/object_fits.hpp"
#include "tests/support/measure/measure_rig.hpp"

namespace fringetwin::measure::method_bias_test {
namespace {

using namespace testing;
using Eigen::Vector3d;

constexpr int kSide = 60;  ///< pixels of an object along each direction

/// Adds a point for each pixel of a square: `at(u, v)`, u and v from -1 to 1.
template <class At>
void add_square(PointCloud& cloud, int first_column, const At& at) {
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      cloud.p_world_mm.push_back(at((2.0 * x + 1.0) / kSide - 1.0, (2.0 * y + 1.0) / kSide - 1.0));
      cloud.q_cam_px.emplace_back(static_cast<float>(first_column + x), static_cast<float>(y));
    }
}

Vector3d on_sphere(const Vector3d& center, double radius, double u, double v) {
  return center + radius * Vector3d(0.6 * u, 0.6 * v, -std::sqrt(1.0 - 0.36 * (u * u + v * v)));
}

Twin twin_of_three() {
  Twin twin = scaled_paper_rig(0.25);
  PlaneShape wall;
  wall.point_mm = {0, 0, 300};
  wall.normal = {0, 0, 1};  // away from the viewer
  wall.size_mm = Vector3d(20, 20, 0).head<2>();
  CylinderShape pipe;
  pipe.point_mm = {40, 0, 280};
  pipe.axis = {0, 1, 0};
  pipe.radius_mm = 10;
  twin.objects = {{"ball", SphereShape{{-40, 0, 280}, 10}, {}}, {"wall", wall, {}}, {"pipe", pipe, {}}};
  twin.measure.fits = {{"ball", 1.0}, {"wall", 1.0}, {"pipe", 1.0}};
  return twin;
}

// The method moves every surface by a known amount and the real objects stand beside the twin's: the stated
// bias is that amount, and without it the fits are where the objects are.
TEST(MethodBias, IsWhatMovedTheNoiseFreePoints) {
  const Vector3d shift(1e-3, -2e-3, 3e-3);
  const auto cloud_at = [&](const Vector3d& beside, double wider, double turned) {
    PointCloud cloud;
    add_square(cloud, 0, [&](double u, double v) {
      return on_sphere(Vector3d(-40, 0, 280) + beside, 10 + wider, u, v);
    });
    add_square(cloud, kSide, [&](double u, double v) {
      return Vector3d(10 * u, 10 * v,
                      300 + beside.z() - turned * 10 * u);  // rises towards the viewer along x
    });
    add_square(cloud, 2 * kSide, [&](double u, double v) {
      const Vector3d axis = Vector3d(turned, 1, 0).normalized();
      return Vector3d(Vector3d(40, 0, 280) + beside + 10 * v * axis +
                      (10 + wider) * Vector3d(0.8 * u, -0.8 * u * turned, -std::sqrt(1 - 0.64 * u * u)));
    });
    return cloud;
  };
  Twin twin = twin_of_three();
  const Vector3d real(0.02, 0.01, -0.03);
  const PointCloud noise_free = cloud_at(shift, 4e-3, 2e-4), cloud = cloud_at(real + shift, 4e-3, 2e-4);
  for (const bool correct : {false, true}) {
    twin.measure.correct_pixel_area = correct;
    std::vector<ObjectFit> fits = fit_objects(twin, cloud);
    state_method_bias(twin, noise_free, cloud, fits);
    const ObjectFit &ball = fits[0], &wall = fits[1], &pipe = fits[2];
    const double left = correct ? 0.0 : 1.0;
    EXPECT_LT((ball.bias_vectors.at("center_mm") - shift).norm(), 2e-6);
    EXPECT_NEAR(ball.bias.at("radius_mm"), 4e-3, 2e-6);
    EXPECT_LT((ball.vectors.at("center_mm") - Vector3d(-40, 0, 280) - real - left * shift).norm(), 3e-6);
    EXPECT_NEAR(ball.numbers.at("radius_mm"), 10 + left * 4e-3, 3e-6);
    EXPECT_NEAR(wall.bias.at("offset_mm"), -3e-3, 2e-6);  // the normal points towards the viewer
    EXPECT_NEAR(wall.bias.at("tilt_rad_0"), 2e-4, 1e-7);
    EXPECT_NEAR(wall.bias.at("tilt_rad_1"), 0.0, 1e-7);
    EXPECT_NEAR(wall.vectors.at("point_mm").z(), 300 + real.z() + left * shift.z(), 3e-6);
    EXPECT_NEAR(wall.vectors.at("normal").x(), -left * 2e-4, 2e-7);
    for (const std::string way : {"0", "1"}) {
      const Vector3d& d = pipe.vectors.at("tilt_direction_" + way);
      EXPECT_NEAR(pipe.bias.at("axis_shift_mm_" + way), d.dot(shift), 4e-6);
      EXPECT_NEAR(pipe.bias.at("axis_rad_" + way), d.dot(Vector3d(2e-4, 0, 0)), 4e-7);
    }
    EXPECT_NEAR(pipe.bias.at("radius_mm"), 4e-3, 4e-6);
    EXPECT_NEAR(pipe.vectors.at("axis").x(), left * 2e-4, 4e-7);
    EXPECT_NEAR(pipe.numbers.at("radius_mm"), 10 + left * 4e-3, 5e-6);
  }
}

// White noise on a wall with a bump that the noise-free points have, too.
TEST(MethodBias, NoiseAndFormAreStatedApart) {
  const double noise_mm = 2e-3;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, noise_mm);
  const auto bump = [](double u, double v) {
    return 0.01 * std::exp(-4.0 * ((u - 0.3) * (u - 0.3) + v * v));
  };
  PointCloud noise_free, cloud;
  add_square(noise_free, 0, [&](double u, double v) { return Vector3d(10 * u, 10 * v, 300 + bump(u, v)); });
  add_square(cloud, 0,
             [&](double u, double v) { return Vector3d(10 * u, 10 * v, 300 + bump(u, v) + normal(random)); });
  Twin twin = twin_of_three();
  twin.objects.erase(twin.objects.begin());
  twin.measure.triangulate = Triangulate::projector;
  twin.measure.fits = {{"wall", 1.0}};
  std::vector<ObjectFit> fits = fit_objects(twin, cloud);
  state_method_bias(twin, noise_free, cloud, fits);
  const ObjectFit& wall = fits[0];
  const double n = kSide * kSide, of_offset = noise_mm / std::sqrt(n);
  EXPECT_NEAR(wall.numbers.at("offset_noise_sigma_mm"), of_offset, 0.05 * of_offset);
  const double of_tilt = of_offset / (10 / std::sqrt(3.0));
  EXPECT_NEAR(wall.numbers.at("tilt_noise_sigma_rad_0"), of_tilt, 0.05 * of_tilt);
  EXPECT_GT(wall.numbers.at("offset_form_sigma_mm"), 2.0 * of_offset);
  EXPECT_NEAR(std::hypot(wall.numbers.at("offset_form_sigma_mm"), wall.numbers.at("offset_noise_sigma_mm")),
              wall.numbers.at("offset_sigma_mm"), 1e-12);
}

TEST(MethodBias, IsNotStatedWhereTheTwinHasNoPoints) {
  PointCloud cloud, half;
  add_square(cloud, 0, [](double u, double v) { return on_sphere({-40, 0, 280}, 10, u, v); });
  for (std::size_t i = 0; i < cloud.size(); i += 2) {
    half.p_world_mm.push_back(cloud.p_world_mm[i]);
    half.q_cam_px.push_back(cloud.q_cam_px[i]);
  }
  Twin twin = twin_of_three();
  twin.measure.fits = {{"ball", 1.0}};
  std::vector<ObjectFit> fits = fit_objects(twin, cloud);
  state_method_bias(twin, half, cloud, fits);
  EXPECT_TRUE(fits[0].bias.empty() && !fits[0].numbers.contains("radius_noise_sigma_mm"));
}

}  // namespace
}  // namespace fringetwin::measure::method_bias_test
