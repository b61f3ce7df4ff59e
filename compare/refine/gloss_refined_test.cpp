// SPDX-License-Identifier: Apache-2.0
// Shiny surfaces as the reference in double precision sees them: the width of their lobe is named and found
// back, and light that they mirror to one another is named for what it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "compare/causes/causes.hpp"
#include "compare/causes/group_fit.hpp"
#include "compare/parameters/parameters.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/compare/planted_samples.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::gloss_refined_test {
namespace {

using ::testing::ElementsAre;

using namespace planted_samples;

constexpr double kSeenNoiseDn = 0.5, kCornerNoiseDn = 1.0;

void make_shiny(Material& material, double specular, double roughness) {
  material.specular = specular;
  material.specular_model = Material::Specular::ggx;
  material.roughness = roughness;
}

/// A window around the sphere's highlight.
Twin shiny_ball(double roughness) {
  Twin twin = testing::window_on_the_sphere(2 * kWidth, 2 * kHeight);
  make_shiny(twin.objects[0].material, 0.05, roughness);
  return twin;
}

TEST(GlossRefined, RoughnessIsNamedAndFoundBack) {
  REQUIRE_RENDERER();
  for (const auto& [truth, start] : {std::pair{0.3, 0.4}, std::pair{0.45, 0.35}, std::pair{0.6, 0.5}}) {
    const Images recorded = traced_by_reference(shiny_ball(truth));
    const std::vector<CameraImages> frames = frames_of(recorded);
    Sensitivity sensitivity{testing::needed_renderer(), samples_of(recorded, same, frames, kSeenNoiseDn)};
    const Twin twin = shiny_ball(start);
    const Causes causes = find_causes(sensitivity, twin);
    EXPECT_THAT(causes.together, ElementsAre("roughness")) << truth;
    GroupFit fit(sensitivity, twin, parameters_of(twin, "roughness"), {.exact = true});
    fit.run();
    EXPECT_TRUE(fit.converged());
    ASSERT_EQ(fit.known().size(), 1u);
    EXPECT_NEAR(fit.known()[0].value, truth, 3.0 * fit.known()[0].sigma) << truth;
    EXPECT_LT(fit.known()[0].sigma, 0.02 * truth);
    EXPECT_EQ(fit.twin().objects[0].material.roughness, fit.known()[0].value);
  }
}

/// A corner of two walls that shine.
Twin shiny_corner(double roughness) {
  Twin twin = testing::window_on_a_corner(0.5, 120, 90);
  for (Object& wall : twin.objects) make_shiny(wall.material, 0.1, roughness);
  return twin;
}

/// What the camera sees of a corner whose walls mirror light to one another, around its edge.
GridSamples seen_of_corner(double roughness) {
  Twin truth = shiny_corner(roughness);
  truth.render.bounces = kAllBounces;
  truth.render.glossy_bounces = true;
  const render::Reference reference(truth);
  GridSamples s;
  s.camera = 0;
  s.grid = {1, 0, 0, 120, 90};
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, kCornerNoiseDn);
  for (const auto& p : testing::reference_block(reference, 0, {40, 29, 40, 32, 1},
                                                {.gauss_n = 2, .bounce_n = 32, .paths = 1}, true)) {
    s.cell.push_back(static_cast<std::size_t>(p.y * 120 + p.x));
    for (const double light : p.pixel.irradiance) {
      s.real_dn.push_back(static_cast<float>(kGain * light + kBlack + noise(random)));
      s.weight.push_back(static_cast<float>(1.0 / kCornerNoiseDn));
    }
  }
  for (int k = 0; k < 12; ++k) s.images.push_back(k);
  s.gain_dn = kGain;
  s.black_level_dn = kBlack;
  return s;
}

TEST(GlossRefined, LightThatSurfacesMirrorIsNamed) {
  REQUIRE_RENDERER();
  for (const double roughness : {0.3, 0.6}) {
    Sensitivity sensitivity(testing::needed_renderer(), {seen_of_corner(roughness)});
    Twin twin = shiny_corner(roughness);
    twin.render.bounce_samples = 1024;
    const Causes causes = find_causes(sensitivity, twin);
    EXPECT_THAT(causes.together, ElementsAre("gloss")) << roughness;
  }
}

}  // namespace
}  // namespace fringetwin::compare::gloss_refined_test
