// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/light_lattice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace fringetwin::render {
namespace {

/// A frontal plane, 0.5 mm per pixel, seen where `seen` says so; `depth` in mm.
SeenImage plane(int width, int height, const std::function<bool(int, int)>& seen,
                const std::function<float(int, int)>& depth) {
  SeenImage image{.width = width, .height = height};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      image.at.push_back(seen(x, y) ? static_cast<std::int32_t>(image.places.size()) : -1);
      if (!seen(x, y)) continue;
      const Eigen::Vector3f n(0, 0, -1);
      image.places.push_back(
          {.p_mm = {0.5F * static_cast<float>(x), 0.5F * static_cast<float>(y), depth(x, y)},
           .number = 1.0F,
           .n = n,
           .reflectivity = 1.0F,
           .n_geometric = n,
           .primitive = 0.0F});
    }
  return image;
}

struct Lattice {
  SeenImage seen;
  std::function<float(int, int)> light;
  float sigma = 0.0F;
  int asked = 0;
  LightLattice make(float tolerance) {
    RoughnessAtSteps roughness(seen);
    return LightLattice(seen, roughness, 2, 2, tolerance, [this](const std::vector<std::uint32_t>& pixels) {
      LightOfPixels out;
      for (const std::uint32_t pixel : pixels) {
        const float value = light(static_cast<int>(pixel) % seen.width, static_cast<int>(pixel) / seen.width);
        out.values.insert(out.values.end(), {value, -2.0F * value});
        out.sigma.push_back(sigma);
        ++asked;
      }
      return out;
    });
  }
};

const auto kEverywhere = [](int, int) { return true; };
const auto kFlat = [](int, int) { return 300.0F; };

TEST(LightLattice, GathersAtFewPixelsOfASmoothSurface) {
  Lattice l{plane(161, 97, kEverywhere, kFlat),
            [](int x, int y) { return 5.0F + 0.01F * float(x) - 0.02F * float(y); }};
  const LightLattice lattice = l.make(1e-4F);
  EXPECT_EQ(l.asked, 21 * 13 + 20 * 12);  // corners and middles of squares of 8 px
  const ImageF mean = lattice.interpolated(lattice.values(), 2, 0),
               other = lattice.interpolated(lattice.values(), 2, 1);
  for (int y = 0; y < 97; ++y)
    for (int x = 0; x < 161; ++x) {
      EXPECT_NEAR(mean(x, y), l.light(x, y), 1e-5) << x << ' ' << y;
      EXPECT_NEAR(other(x, y), -2.0F * l.light(x, y), 2e-5);
    }
}

TEST(LightLattice, TakesMorePixelsWhereLightBends) {
  Lattice l{plane(100, 70, kEverywhere, kFlat), [](int x, int y) {
              return 1.0F + std::exp(-0.01F * float((x - 50) * (x - 50) + (y - 30) * (y - 30)));
            }};
  const LightLattice lattice = l.make(0.005F);
  EXPECT_LT(l.asked, 100 * 70 / 4);
  const ImageF mean = lattice.interpolated(lattice.values(), 2, 0);
  double worst = 0.0;
  for (int y = 0; y < 70; ++y)
    for (int x = 0; x < 100; ++x)
      worst = std::max(worst, std::abs(static_cast<double>(mean(x, y) / l.light(x, y)) - 1.0));
  EXPECT_LE(worst, 0.01);  // a middle tells 0.005; beside it a square may be off by somewhat more
  // noise that hides the bend: nothing is quartered
  l.sigma = 10.0F;
  l.asked = 0;
  l.make(0.005F);
  EXPECT_EQ(l.asked, 14 * 10 + 13 * 9);
}

TEST(LightLattice, TakesRoughnessForNoise) {
  const auto rough = [](int x, int y) {
    return 1.0F + 0.05F * std::sin(12.9898F * static_cast<float>(x) + 78.233F * static_cast<float>(y * y));
  };
  Lattice l{plane(401, 301, kEverywhere, kFlat), rough};
  const LightLattice lattice = l.make(0.004F);
  EXPECT_LT(l.asked, 401 * 301 / 7);  // corners and middles of squares of 4 px
  const ImageF mean = lattice.interpolated(lattice.values(), 2, 0);
  double sum = 0.0;
  for (const float v : mean.data) sum += static_cast<double>(v);
  EXPECT_NEAR(sum / static_cast<double>(mean.size()), 1.0, 0.002);
}

float noise(int x, int y, float k) {
  return std::sin(12.9898F * k * static_cast<float>(x) + 78.233F * static_cast<float>(y * y + x));
}

/// A measured surface: normals 15 degrees off, places by a sixth of a pixel, from pixel to pixel; behind
/// column `step` 40 mm farther away.
SeenImage measured(int width, int height, int step) {
  SeenImage image = plane(width, height, kEverywhere, [step](int x, int y) {
    return (x < step ? 300.0F : 340.0F) + 0.12F * noise(x, y, 1.7F);
  });
  for (std::size_t i = 0; i < image.places.size(); ++i) {
    const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
    image.places[i].n =
        Eigen::Vector3f(0.25F * noise(x, y, 1.1F), 0.25F * noise(x, y, 2.3F), -1.0F).normalized();
  }
  return image;
}

// Noise that quartering does not make less does not hide a place where light bends.
TEST(LightLattice, FollowsLightThatBendsInAFewPlacesBesideNoise) {
  const auto light = [](int x, int y) {
    const float away = static_cast<float>(std::abs(x - 200));
    return 1.0F + 4.0F * std::exp(-0.5F * away) +
           0.02F * std::sin(12.9898F * static_cast<float>(x) + 78.233F * static_cast<float>(y * y));
  };
  Lattice l{plane(401, 301, kEverywhere, kFlat), light};
  const LightLattice lattice = l.make(0.004F);
  EXPECT_LT(l.asked, 401 * 301 / 3);
  const ImageF mean = lattice.interpolated(lattice.values(), 2, 0);
  for (int y = 0; y < 301; ++y)
    for (int x = 190; x <= 210; ++x) ASSERT_NEAR(mean(x, y), light(x, y), 0.25) << x << ' ' << y;
}

TEST(LightLattice, InterpolatesOnARoughSurfaceButNotAcrossItsEdge) {
  Lattice l{measured(401, 301, 203), [](int x, int) { return x < 203 ? 1.0F : 9.0F; }};
  const LightLattice lattice = l.make(0.004F);
  EXPECT_LT(l.asked, 401 * 301 / 7);
  EXPECT_EQ(lattice.noise(), 0.0);
  const ImageF mean = lattice.interpolated(lattice.values(), 2, 0);
  for (int y = 0; y < 301; ++y)
    for (int x = 0; x < 401; ++x) ASSERT_NEAR(mean(x, y), l.light(x, y), 1e-5) << x << ' ' << y;
}

TEST(LightLattice, FollowsLightThatBendsOnARoughSurface) {
  Lattice l{measured(401, 301, 401), [](int x, int) { return 1.0F + 0.2F * std::sin(0.25F * float(x)); }};
  const LightLattice lattice = l.make(0.004F);
  const ImageF mean = lattice.interpolated(lattice.values(), 2, 0);
  double worst = 0.0;
  for (int y = 0; y < 301; ++y)
    for (int x = 0; x < 401; ++x)
      worst = std::max(worst, std::abs(static_cast<double>(mean(x, y) / l.light(x, y)) - 1.0));
  EXPECT_LE(worst, 0.03);  // 8 px are a third of a period: 0.1 without quartering; 2 px: 0.02
}

TEST(LightLattice, SaysWhatRoughnessIsOff) {
  Lattice l{measured(401, 301, 401), [](int x, int y) { return 1.0F + 0.05F * noise(x, y, 3.1F); }};
  const LightLattice lattice = l.make(0.004F);
  EXPECT_LT(l.asked, 401 * 301 / 7);
  EXPECT_NEAR(lattice.noise(), 0.07,
              0.02);  // of the second channel, the larger one: 2 x 0.05/sqrt(2) and of four others
}

// Ribs of 8 px that face left and right: smooth, though a square's corners and middle face both.
TEST(LightLattice, DoesNotTakeAStructureForRoughness) {
  const auto faces_left = [](int x, int) { return (x + 2) % 8 < 4; };
  Lattice l{plane(161, 97, kEverywhere, kFlat), [&](int x, int y) { return faces_left(x, y) ? 1.0F : 2.0F; }};
  for (std::size_t i = 0; i < l.seen.places.size(); ++i)
    l.seen.places[i].n =
        Eigen::Vector3f(faces_left(static_cast<int>(i) % 161, 0) ? -0.6F : 0.6F, 0.0F, -0.8F);
  const LightLattice lattice = l.make(0.004F);
  const ImageF mean = lattice.interpolated(lattice.values(), 2, 0);
  for (int y = 0; y < 97; ++y)
    for (int x = 0; x < 161; ++x) ASSERT_NEAR(mean(x, y), l.light(x, y), 1e-5) << x << ' ' << y;
}

TEST(SurfaceRoughness, LeavesSmoothSurfacesTheirLimits) {
  SeenImage image = plane(161, 97, kEverywhere, kFlat);
  for (std::size_t i = 0; i < image.places.size(); ++i) {  // a sphere of 60 mm
    SurfacePlace& place = image.places[i];
    const Eigen::Vector2f at(place.p_mm.x() - 40.0F, place.p_mm.y() - 24.0F);
    place.p_mm.z() = 360.0F - std::sqrt(3600.0F - at.squaredNorm());
    place.n = (place.p_mm - Eigen::Vector3f(40.0F, 24.0F, 360.0F)).normalized();
  }
  for (const int step : {1, 2, 4}) {
    const SurfaceRoughness smooth(image, step), rough(measured(161, 97, 161), step);
    for (const auto& [x, y] : {std::pair{3, 3}, std::pair{80, 50}, std::pair{160, 96}}) {
      EXPECT_FALSE(is_rough(smooth.widened(kSmooth, x, y), kSmooth));
      EXPECT_EQ(smooth.widened(kSmooth, x, y).least_cosine, kSmooth.least_cosine);
      EXPECT_TRUE(is_rough(rough.widened(kSmooth, x, y), kSmooth));
    }
  }
  // a few pixels tell nothing
  EXPECT_FALSE(is_rough(SurfaceRoughness(measured(9, 9, 9), 1).widened(kSmooth, 4, 4), kSmooth));
}

TEST(SurfaceRoughness, KeepsObjectsApart) {
  SeenImage image = measured(161, 97, 161);
  for (std::size_t i = 0; i < image.places.size(); ++i)
    image.places[i].primitive = i % 161 < 80 ? 0.0F : 1.0F;
  const SurfaceLimits limits = SurfaceRoughness(image, 1).widened(kRough, 79, 40);
  EXPECT_TRUE(limits.of_one_primitive);
  EXPECT_TRUE(on_one_surface(image.place(40 * 161 + 79), image.place(40 * 161 + 74), {-1.0F, 1.0F, true}));
  EXPECT_FALSE(on_one_surface(image.place(40 * 161 + 79), image.place(40 * 161 + 80), {-1.0F, 1.0F, true}));
}

TEST(LightLattice, InterpolatesNothingAcrossAnEdge) {
  // a step of 40 mm with other light behind it, and a hole
  const auto hole = [](int x, int y) { return (x - 20) * (x - 20) + (y - 20) * (y - 20) > 30; };
  Lattice l{plane(64, 48, hole, [](int x, int) { return x < 37 ? 300.0F : 340.0F; }),
            [](int x, int) { return x < 37 ? 1.0F : 9.0F; }};
  const LightLattice lattice = l.make(1e-3F);
  const ImageF mean = lattice.interpolated(lattice.values(), 2, 0);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      if (hole(x, y)) {
        EXPECT_NEAR(mean(x, y), l.light(x, y), 1e-6) << x << ' ' << y;
      }
}

TEST(LightLattice, SeesThingsBetweenItsCorners) {
  const auto bar = [](int x, int) { return x >= 17 && x <= 19; };  // corners at 16 and 24, the middle at 20
  Lattice l{plane(64, 48, kEverywhere, [&](int x, int y) { return bar(x, y) ? 250.0F : 300.0F; }),
            [&](int x, int y) { return bar(x, y) ? 5.0F : 1.0F; }};
  const LightLattice lattice = l.make(1e-3F);
  const ImageF mean = lattice.interpolated(lattice.values(), 2, 0);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) EXPECT_NEAR(mean(x, y), l.light(x, y), 1e-6) << x << ' ' << y;
}

TEST(LightLattice, TakesImagesOfAnySize) {
  for (const auto& [width, height] :
       {std::pair{1, 1}, std::pair{1, 20}, std::pair{17, 1}, std::pair{2, 3}, std::pair{9, 8}}) {
    Lattice l{plane(width, height, kEverywhere, kFlat), [](int x, int y) { return float(1 + x + 3 * y); }};
    const LightLattice lattice = l.make(1e-4F);
    const ImageF mean = lattice.interpolated(lattice.values(), 2, 0);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) EXPECT_NEAR(mean(x, y), l.light(x, y), 1e-4) << width << ' ' << height;
  }
  Lattice nothing{plane(
                      30, 20, [](int, int) { return false; }, kFlat),
                  [](int, int) { return 1.0F; }};
  EXPECT_TRUE(nothing.make(0.01F).pixels().empty());
}

}  // namespace
}  // namespace fringetwin::render
