// SPDX-License-Identifier: Apache-2.0
// How much of their light surfaces send to others is found beside a gain that is not known: two walls that
// meet, as the reference in double precision sees them.
//
// | check             | tolerance | origin                                                         |
// |-------------------|-----------|----------------------------------------------------------------|
// | the reflectivity  | 1 %       | directions: 4,096 of the twin, 2,048 of the truth               |
// | the gain          | 0.2 %     | what that leaves of it: a fifth of the light is indirect         |
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "compare/causes/group_fit.hpp"
#include "compare/parameters/parameters.hpp"
#include "render/reference/reference.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::bounce_albedo_refined_test {
namespace {

constexpr int kWidth = 120, kHeight = 90;
constexpr double kGain = 20.0, kBlack = 7.0, kNoiseDn = 0.5;

Twin corner(double diffuse) {
  Twin twin = testing::window_on_a_corner(diffuse, kWidth, kHeight);
  twin.render.bounces = 1;
  twin.render.bounce_samples = 4096;
  return twin;
}

TEST(BounceAlbedoRefined, IsFoundBesideTheGain) {
  REQUIRE_RENDERER();
  const render::Reference reference(corner(0.8));
  GridSamples s;
  s.camera = 0;
  s.grid = {1, 0, 0, kWidth, kHeight};
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, kNoiseDn);
  for (const auto& p : testing::reference_block(reference, 0, {8, 8, kWidth - 16, kHeight - 16, 6},
                                                {.gauss_n = 2, .bounce_n = 32}, true)) {
    s.cell.push_back(static_cast<std::size_t>(p.y * kWidth + p.x));
    for (const double light : p.pixel.irradiance) {
      s.real_dn.push_back(static_cast<float>(kGain * light + kBlack + noise(random)));
      s.weight.push_back(static_cast<float>(1.0 / kNoiseDn));
    }
  }
  for (int k = 0; k < 12; ++k) s.images.push_back(k);
  // the twin's walls are too dark, and its light by as much too strong: the gain is the true one
  Twin twin = corner(0.5);
  twin.projector->intensity *= 0.8 / 0.5;
  s.gain_dn = kGain;
  s.black_level_dn = kBlack;
  Sensitivity sensitivity(testing::needed_renderer(), {std::move(s)});
  GroupFit fit(sensitivity, twin, parameters_of(twin, "bounce_albedo"), {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  ASSERT_EQ(fit.known().size(), 1u);
  EXPECT_NEAR(std::exp(fit.known()[0].value) * 0.5, 0.8, 0.008);
  EXPECT_NEAR(fit.twin().objects[1].material.diffuse, 0.8, 0.008);
  EXPECT_NEAR(fit.twin().projector->intensity * fit.twin().objects[0].material.diffuse,
              twin.projector->intensity * 0.5, 1e-6);
  EXPECT_NEAR(sensitivity.samples()[0].gain_dn / kGain, 1.0, 0.002);
}

TEST(BounceAlbedoRefined, IsNoneOfOneBallAlone) {
  EXPECT_TRUE(parameters_of(testing::window_on_the_sphere(40, 30), "bounce_albedo").empty());
}

}  // namespace
}  // namespace fringetwin::compare::bounce_albedo_refined_test
