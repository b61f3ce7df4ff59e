// SPDX-License-Identifier: Apache-2.0
// Light that is not the same everywhere: the field of the projector's light, and a lamp in the room. Against
// the reference, against formulas, and off: no bit changes.
// | tolerance | unit           | origin                                                                  |
// |-----------|----------------|-------------------------------------------------------------------------|
// | 4e-5      | rad rms        | as for the shapes (shapes_test.cpp); 1e-4 required on triangle meshes   |
// | 5e-5      | full scale rms | as for the shapes                                                       |
// | 3e-6      | relative       | single precision: exp to 4 ulp (5e-7), 14 terms of up to 0.5, 6e-8 each |
// | 6e-4      | of 12.75       | lamp: the limit of 5e-5 of full scale, at each pixel                    |
// | 4e-6      | of 8           | sums of light of 8 in single precision, 5e-7 each, 9 points in a pixel  |
// | 0         |                | off = bitwise the same image                                            |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "tests/support/expect_agreement.hpp"
#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::uneven_light_test {
namespace {

using Eigen::Vector3d;
constexpr double kMeshPhaseLimit_rad = 1e-4, kLampLimit = 6e-4;

/// A hot spot of 35 % beside the middle, all orders.
const std::vector<double> kField{0.12, -0.08, -0.3, 0.05,  -0.2, 0.04, -0.03,
                                 0.06, 0.02,  0.05, -0.02, 0.03, 0.04, -0.05};

/// ln of that field by the polynomials written out; u and v from -1 to 1.
double ln_field(double u, double v) {
  const double p2u = (3 * u * u - 1) / 2, p2v = (3 * v * v - 1) / 2;
  const double p3u = (5 * u * u * u - 3 * u) / 2, p3v = (5 * v * v * v - 3 * v) / 2;
  const double p4u = (35 * std::pow(u, 4) - 30 * u * u + 3) / 8,
               p4v = (35 * std::pow(v, 4) - 30 * v * v + 3) / 8;
  const std::vector<double>& c = kField;
  return c[0] * u + c[1] * v + c[2] * p2u + c[3] * u * v + c[4] * p2v + c[5] * p3u + c[6] * p2u * v +
         c[7] * u * p2v + c[8] * p3v + c[9] * p4u + c[10] * p3u * v + c[11] * p2u * p2v + c[12] * u * p3v +
         c[13] * p4v;
}

Twin window(const Vector3d& at_mm = {0, 0, 290}) {
  return with_object(left_window(at_mm, 80, 60), "plane", tilted_plane());
}
MeshShape small_part(const Vector3d& turn_rad) {
  const auto mesh = std::make_shared<const Mesh>(make_bumpy_icosphere(2, 6.0, default_bumps()));
  return {{}, "mm", {rotation_from_vector(turn_rad), {0, 0, 260}}, false, mesh};
}
Twin with_field(Twin twin) {
  twin.projector->light_field = kField;
  return twin;
}

TEST(LightField, OffChangesNoBit) {
  REQUIRE_RENDERER();
  Twin twin = window();
  const auto before = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  twin.projector->light_field.assign(14, 0.0);
  const auto after = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  EXPECT_EQ(after.sampling.sampler, Sampler::adaptive);
  expect_same_bits(before, after);
}

// In the middle of the projector's image and towards its corners.
TEST(LightField, IsAFactorOfWhatIsProjected) {
  REQUIRE_RENDERER();
  const render::Sampling one_ray{Sampler::gauss, 1};
  double lowest = 1e9, highest = 0.0;
  for (const Vector3d& at_mm : {Vector3d(0, 0, 290), {-60, -45, 290}, {60, 35, 290}}) {
    const Twin even = window(at_mm);
    const auto s = render::Reference(even).sample(0, {40.0, 30.0});
    ASSERT_TRUE(s.lit);
    const double factor = std::exp(
        ln_field((s.projector_px.x() + 0.5) / 640.0 - 1.0, (s.projector_px.y() + 0.5) / 360.0 - 1.0));
    const auto a = shared_renderer()->trace(even, 0, one_ray),
               b = shared_renderer()->trace(with_field(even), 0, one_ray);
    EXPECT_NEAR(static_cast<double>(b.mean(40, 30)) / static_cast<double>(a.mean(40, 30)), factor,
                3e-6 * factor);
    for (std::size_t p = 0; p < 3; ++p)
      EXPECT_NEAR(static_cast<double>(b.cosine[0][p](40, 30)),
                  factor * static_cast<double>(a.cosine[0][p](40, 30)), 3e-6 * factor * a.mean(40, 30));
    EXPECT_NEAR(render::Reference(with_field(even)).sample(0, {40.0, 30.0}).weight, factor * s.weight,
                1e-12 * factor * s.weight);
    lowest = std::min(lowest, factor), highest = std::max(highest, factor);
  }
  EXPECT_GT(highest / lowest, 1.2);
}

TEST(LightField, HasTheGeometricMeanOne) {
  double sum = 0.0;
  for (int j = 0; j < 100; ++j)
    for (int i = 0; i < 100; ++i) sum += ln_field((i + 0.5) / 50.0 - 1.0, (j + 0.5) / 50.0 - 1.0) / 1e4;
  EXPECT_NEAR(sum, 0.0, 1e-4);  // midpoints: 1/24 of the second differences, 1e-4 of terms of 0.3
}

TEST(LightField, AgreesWithTheReference) {
  REQUIRE_RENDERER();
  for (const Vector3d& at_mm : {Vector3d(0, 0, 290), {-60, -45, 290}, {60, 35, 290}})
    expect_agreement(with_field(window(at_mm)), "light field, plane", 50, 7);
  const Twin ball = with_object(left_window({0, 0, 250}, 160, 120), "sphere", ideal_sphere());
  expect_agreement(with_field(ball), "light field, sphere", 300);
  expect_linear_in_the_light(with_field(ball));
  EXPECT_GT(relative_change(render_fixed(ball), render_fixed(with_field(ball))), 0.02);
  Twin gamma = with_field(ball);
  gamma.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  expect_agreement(gamma, "light field, gamma", 300);
  const Twin part = with_object(left_window({0, 0, 260}, 140, 120), "part", small_part({0.1, 0.2, 0.3}));
  expect_agreement(with_field(part), "light field, mesh", 201, 3, kMeshPhaseLimit_rad);
}

/// A lamp from the upper right, behind the cameras.
Twin with_lamp(Twin twin, const Vector3d& lamp_world = {2.5, -1.5, -3.0}) {
  twin.room.lamp_world = lamp_world;
  return twin;
}

/// Returns the lamp's light of a pixel by 3 x 3 Gauss points of the reference; nothing where its border sees
/// another surface than its middle, or is lit there and not here.
std::optional<double> lamp_of_pixel(const render::Reference& reference, int x, int y) {
  constexpr double kNode = 0.3872983346207417, kWeight[] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  const auto middle = reference.sample(0, {static_cast<double>(x), static_cast<double>(y)});
  const auto at = [&](double dx, double dy) { return reference.sample(0, {x + dx, y + dy}); };
  const auto is_alike = [&](const render::PixelSample& s) {
    return s.object == middle.object && s.triangle == middle.triangle && s.lit == middle.lit &&
           (s.lamp > 0.0) == (middle.lamp > 0.0);
  };
  for (const double dx : {-0.5, 0.0, 0.5})
    for (const double dy : {-0.5, 0.0, 0.5})
      if (middle.object < 0 || !is_alike(at(dx, dy))) return std::nullopt;
  double sum = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) sum += kWeight[i] * kWeight[k] * at((i - 1) * kNode, (k - 1) * kNode).lamp;
  return sum;
}

struct Counts {
  int lit = 0, dark = 0;
};
/// Holds what the lamp adds to an image against the reference; returns how many pixels are lit and dark.
Counts expect_lamp(const Twin& twin) {
  Twin without = twin;
  without.room = {};
  const ImageF with_lamp = render_fixed(twin).irradiance[5], alone = render_fixed(without).irradiance[5];
  const render::Reference reference(twin);
  Counts counts;
  int wrong = 0;
  for (int y = 1; y < alone.height - 1; y += 2)
    for (int x = 1; x < alone.width - 1; x += 2)
      if (const auto expected = lamp_of_pixel(reference, x, y)) {
        (*expected > 0.0 ? counts.lit : counts.dark) += 1;
        wrong += !(std::abs(with_lamp(x, y) - alone(x, y) - *expected) <= kLampLimit);
      }
  EXPECT_EQ(wrong, 0);
  std::cout << "lamp: " << counts.lit << " lit, " << counts.dark << " dark pixels\n";
  return counts;
}

TEST(Lamp, LightsBySteepnessAlone) {
  REQUIRE_RENDERER();
  const Twin ball = with_object(left_window({0, 0, 250}, 160, 120), "sphere", ideal_sphere());
  const Twin twin = with_lamp(ball, {2.5, -1.5, -1.0});
  const Counts counts = expect_lamp(twin);
  EXPECT_GT(counts.lit, 500);
  EXPECT_GT(counts.dark, 100);
  expect_agreement(twin, "lamp, sphere", 300);
  Twin ambient = twin;
  ambient.projector->ambient = 0.75;
  expect_agreement(ambient, "lamp and ambient light, sphere", 300);
  // the reference by hand
  const render::Reference reference(twin);
  for (int x = 40; x < 120; x += 10) {
    const auto s = reference.sample(0, {static_cast<double>(x), 60.0});
    ASSERT_EQ(s.object, 0);
    const Vector3d n = (s.point_world_mm - ideal_sphere().center_mm).normalized();
    EXPECT_NEAR(s.lamp, 0.8 * std::max(0.0, n.dot(twin.room.lamp_world)), 1e-12);
  }
}

TEST(Lamp, OffChangesNoBit) {
  REQUIRE_RENDERER();
  Twin twin = window();
  twin.projector->ambient = 0.5;
  expect_same_bits(twin, with_lamp(twin, Vector3d::Zero()));
}

TEST(Lamp, HasTheFactorsOfTheRoomsLight) {
  REQUIRE_RENDERER();
  Twin plain = with_lamp(window()), twin = plain;
  plain.projector->ambient = twin.projector->ambient = 0.5;
  for (int i = 0; i < 12; ++i) twin.projector->ambient_factors.push_back(1.0 + 0.05 * i);
  expect_agreement(twin, "lamp that grows brighter", 50, 7);
  const auto steady = render_fixed(plain), growing = render_fixed(twin);
  const double room = 0.5 + render::Reference(plain).sample(0, {40.0, 30.0}).lamp;
  for (int i = 0; i < 12; ++i)
    EXPECT_NEAR(growing.irradiance[i](40, 30) - steady.irradiance[i](40, 30), 0.05 * i * room, 4e-6);
}

// A ball before a wall: its shadow is where the reference says, and gone where shadows are off.
TEST(Lamp, CastsShadows) {
  REQUIRE_RENDERER();
  Twin twin = with_object(left_window({-8, 5, 300}, 160, 120), "plane", frontal_plane());
  twin.objects.push_back({"sphere", ideal_sphere(), {}});
  twin = with_lamp(twin, {1.0, -0.6, -6.0});
  const Counts shaded = expect_lamp(twin);
  twin.render.shadow = false;
  const Counts open = expect_lamp(twin);
  EXPECT_GT(shaded.lit, 1000);
  EXPECT_GT(shaded.dark, open.dark + 100);
}

// Links between triangles know what hides from the projector, not what hides from the lamp.
TEST(Lamp, OfMeshes) {
  REQUIRE_RENDERER();
  for (const bool smooth : {false, true}) {
    MeshShape part = small_part({0.4, -0.3, 0.0});
    part.smooth = smooth;
    const Counts counts = expect_lamp(
        with_lamp(with_object(left_window({0, 0, 260}, 140, 120), "part", part), {6.0, -2.0, -2.0}));
    EXPECT_GT(counts.lit, 100);
    EXPECT_GT(counts.dark, 100);
  }
}

}  // namespace
}  // namespace fringetwin::testing::uneven_light_test
