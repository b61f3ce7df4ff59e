// SPDX-License-Identifier: Apache-2.0
// Every effect of the renderer: it agrees with the reference, it changes what it should change, and
// switched off it changes no bit. The table of effects tells each of them on and off.
// | tolerance | unit           | origin                                                               |
// |-----------|----------------|----------------------------------------------------------------------|
// | 4e-5      | rad rms        | as for the shapes (shapes_test.cpp)                                  |
// | 5e-5      | full scale rms | as for the shapes; pow of a shininess n may err by 2 n ulp of a lobe |
// | 1e-5      | relative       | fp32 sums against a closed form at the pixel centre, 2nd-order term  |
// | 0         |                | off = bitwise the same image                                         |
#include "twin/effects.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <iostream>
#include <numbers>
#include <set>

#include "tests/support/expect_agreement.hpp"
#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::effects_test {
namespace {

using Eigen::Vector3d;

/// The ideal sphere in a window of 160x120 px of the left camera.
Twin sphere_window() { return with_object(left_window({0, 0, 250}, 160, 120), "sphere", ideal_sphere()); }
Twin plane_window(int width = 160, int height = 120) {
  return with_object(left_window({0, 0, 300}, width, height), "plane", frontal_plane());
}

double change(const Twin& a, const Twin& b) { return relative_change(render_fixed(a), render_fixed(b)); }

TEST(Effects, PhongLobe) {
  REQUIRE_RENDERER();
  Twin twin = sphere_window();
  const Twin lambert = twin;
  twin.objects[0].material.shininess = 35.0;
  expect_same_bits(lambert, twin);  // specular 0: the exponent is nobody's business
  twin.objects[0].material.specular = 0.4;
  expect_agreement(twin, "Phong", 300);
  EXPECT_GT(change(lambert, twin), 0.1);
  expect_linear_in_the_light(twin);
}

// A sharp highlight, turned so that the projector is mirrored into the middle of the view.
TEST(Effects, SharpPhongLobe) {
  REQUIRE_RENDERER();
  Twin twin = plane_window();
  const Vector3d p(0, 0, 300), to_light = (twin.projector->center_world_mm() - p).normalized();
  PlaneShape& plane = std::get<PlaneShape>(twin.objects[0].shape);
  plane.normal = (to_light - Vector3d::UnitZ()).normalized();
  plane.u_axis = plane.normal.unitOrthogonal();
  const Twin lambert = twin;
  twin.objects[0].material.specular = 0.2;
  twin.objects[0].material.shininess = 1000.0;
  expect_agreement(twin, "Phong, shininess 1000", 1500);
  EXPECT_GT(change(lambert, twin), 0.3);
}

TEST(Effects, InverseSquareFalloff) {
  REQUIRE_RENDERER();
  Twin twin = plane_window();
  const Twin flat = twin;
  twin.projector->reference_distance_mm = 123.0;  // falloff still "none"
  expect_same_bits(flat, twin);
  twin.projector->inverse_square = true;
  expect_agreement(twin, "falloff", 1500);
  const auto with = render_fixed(twin), without = render_fixed(flat);
  const render::Reference reference(flat);
  for (int x = 10; x < 150; x += 30) {
    const auto s = reference.sample(0, {static_cast<double>(x), 60.0});
    const double d2 = (flat.projector->center_world_mm() - s.point_world_mm).squaredNorm();
    const auto light = [&](const render::RenderedCamera& r) {
      return r.irradiance[0](x, 60) + r.irradiance[2](x, 60);
    };
    EXPECT_NEAR(light(with) / light(without), 123.0 * 123.0 / d2, 1e-5 * 123 * 123 / d2);
  }
}

TEST(Effects, AmbientIsAddedToWhatIsHit) {
  REQUIRE_RENDERER();
  Twin twin = sphere_window();
  const Twin dark = twin;
  twin.projector->ambient = 0.75;
  expect_agreement(twin, "ambient", 300);
  const auto with = render_fixed(twin), without = render_fixed(dark);
  int hits = 0, misses = 0;
  const render::Reference reference(dark);
  for (int y = 0; y < 120; y += 4)
    for (int x = 0; x < 160; x += 4) {
      const double more = with.irradiance[5](x, y) - without.irradiance[5](x, y);
      const auto pixel = reference.pixel(0, x, y, {.gauss_n = 4});
      if (pixel.interior) {
        EXPECT_NEAR(more, 0.75, 2e-6);
        ++hits;
      } else if (with.irradiance[5](x, y) == 0.0F) {
        ++misses;
        EXPECT_EQ(pixel.object, -1);
      }
    }
  EXPECT_GT(hits, 100);
  EXPECT_GT(misses, 300);
}

TEST(Effects, ProjectorBlur) {
  REQUIRE_RENDERER();
  Twin twin = plane_window();
  const auto sharp = render_fixed(twin);
  twin.projector->blur_px = 1.6;
  expect_agreement(twin, "blur", 1500);
  const auto soft = render_fixed(twin);
  const double pi = std::numbers::pi;
  const auto contrast = [&](const render::RenderedCamera& r, std::size_t pitch) {
    const auto& i = r.irradiance;
    return std::hypot(i[4 * pitch](80, 60) - i[4 * pitch + 2](80, 60),
                      i[4 * pitch + 1](80, 60) - i[4 * pitch + 3](80, 60));
  };
  for (std::size_t pitch = 0; pitch < 3; ++pitch) {
    const double u = pi * 1.6 / (13.0 + static_cast<double>(pitch));
    EXPECT_NEAR(contrast(soft, pitch) / contrast(sharp, pitch), std::exp(-2 * u * u), 1e-6);
  }
}

TEST(Effects, GammaResponse) {
  REQUIRE_RENDERER();
  Twin twin = sphere_window();
  const Twin linear = twin;
  twin.projector->response.kind = ProjectorResponse::Kind::gamma;
  expect_same_bits(linear, twin);  // exponent 1
  twin.projector->response.gamma = 2.2;
  expect_agreement(twin, "gamma 2.2", 300);
  EXPECT_GT(change(linear, twin), 0.1);
  twin.projector->blur_px = 0.8;
  expect_agreement(twin, "gamma 2.2 and blur", 300);
}

TEST(Effects, TableResponse) {
  REQUIRE_RENDERER();
  Twin twin = plane_window();
  twin.projector->response.kind = ProjectorResponse::Kind::table;
  twin.projector->response.table = {0.0, 1.0};
  const Twin identity = twin;
  // A table of two levels is the linear response: the reference knows no difference.
  const Agreement a = expect_agreement(identity, "identity table", 1500);
  EXPECT_GT(a.n, 0);
  twin.projector->response.table = {0.02, 0.1, 0.35, 0.8, 0.97};
  twin.projector->blur_px = 0.6;
  expect_agreement(twin, "table and blur", 1500);
}

TEST(Effects, PixelFill) {
  REQUIRE_RENDERER();
  Twin twin = sphere_window();
  const Twin full = twin;
  twin.render.pixel_fill = 0.5;
  expect_agreement(twin, "half-size pixels", 300);
  EXPECT_GT(change(full, twin), 1e-4);
}

// The sphere shades the plane. Fully lit and fully shaded pixels are told apart without error.
TEST(Effects, CastShadow) {
  REQUIRE_RENDERER();
  const Twin rig = paper_rig();
  const Vector3d light = rig.projector->center_world_mm(), along = Vector3d(0, 0, 250) - light;
  const Vector3d shadow = light + along * ((300 - light.z()) / along.z());
  Twin twin = with_object(crop_around(only_camera(rig, 0), shadow, 160, 120), "plane", frontal_plane());
  const Twin alone = twin;
  twin.objects.push_back({"sphere", ideal_sphere(), {}});
  expect_agreement(twin, "shadow", 1000, 3);
  const auto with = render_fixed(twin), without = render_fixed(alone);
  const render::Reference reference(twin);
  int lit = 0, dark = 0, wrong = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const render::ReferencePixel p = reference.pixel(0, x, y, {.gauss_n = 4});
      if (p.object != 0) continue;
      if (p.interior) {
        ++lit;
        wrong += std::abs(with.irradiance[3](x, y) / without.irradiance[3](x, y) - 1.0F) > 1e-6F;
      } else if (p.mean == 0.0) {
        ++dark;
        // the 4x4 points may miss a sliver of light at the shadow's edge
        wrong += with.irradiance[3](x, y) > 0.0F && reference.pixel(0, x, y, {.gauss_n = 32}).mean == 0.0;
      }
    }
  std::cout << "shadow: " << lit << " lit, " << dark << " dark pixels\n";
  EXPECT_GT(lit, 5000);
  EXPECT_GT(dark, 1000);
  EXPECT_EQ(wrong, 0);
  // switched off, the plane is lit as if it were alone, and the reference says the same
  twin.render.shadow = false;
  const auto unshaded = render_fixed(twin);
  const render::Reference unshaded_reference(twin);
  int compared = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x)
      if (unshaded.object(x, y) == 0 && unshaded_reference.is_whole(0, x, y)) {
        ++compared;
        wrong += std::abs(unshaded.irradiance[3](x, y) / without.irradiance[3](x, y) - 1.0F) > 1e-6F;
      }
  EXPECT_GT(compared, lit + dark / 2);
  EXPECT_EQ(wrong, 0);
  expect_agreement(twin, "shadow switched off", 1000, 3);
}

// A second object far aside (out of view, shading nothing) leaves every pixel as it was.
TEST(Effects, AnObjectThatShadesNothingChangesNothing) {
  REQUIRE_RENDERER();
  Twin twin = plane_window();
  const auto alone = render_fixed(twin);
  twin.objects.push_back({"aside", SphereShape{{0, 900, 300}, 5.0}, {}});
  // another shader variant may round differently: 2 ulp of 10
  EXPECT_LE(largest_difference(alone, render_fixed(twin)), 2e-6);
}

// Each border of the projector's image across the view.
TEST(Effects, ProjectorBorder) {
  REQUIRE_RENDERER();
  struct Border {
    Axis axis;
    double at_px;
  };
  for (const Border& border : {Border{Axis::x, -0.5}, {Axis::x, 1279.5}, {Axis::y, -0.5}, {Axis::y, 719.5}}) {
    const bool along_x = border.axis == Axis::x;
    Twin twin = plane_window(along_x ? 240 : 120, along_x ? 120 : 240);
    const Eigen::Vector2d middle_px = along_x ? Eigen::Vector2d(120, 60) : Eigen::Vector2d(60, 120);
    twin.projector->lens = Lens("LENSMODEL_PINHOLE", {1700, 1700, 640, 360}, {1280, 720}, "pinhole");
    const Eigen::Vector2d middle = render::Reference(twin).sample(0, middle_px).projector_px;
    // move the principal point so that the border passes the middle of the view
    const double cx = along_x ? 640 + border.at_px - middle.x() : 640;
    const double cy = along_x ? 360 : 360 + border.at_px - middle.y();
    twin.projector->lens = Lens("LENSMODEL_PINHOLE", {1700, 1700, cx, cy}, {1280, 720}, "pinhole");
    expect_agreement(twin, "projector border", 500);
    const auto rendered = render_fixed(twin);
    const render::Reference reference(twin);
    int dark = 0, lit = 0;
    for (int i = 0; i < 240; ++i) {
      const int x = along_x ? i : 30, y = along_x ? 30 : i;
      const auto p = reference.pixel(0, x, y, {.gauss_n = 16});
      const float light = rendered.irradiance[0](x, y) + rendered.irradiance[2](x, y);
      if (p.interior) {
        ++lit;
        EXPECT_GT(light, 1.0F) << i;
      } else if (p.mean == 0.0) {
        ++dark;
        EXPECT_EQ(light, 0.0F) << i;
      }
    }
    EXPECT_GT(dark, 50);
    EXPECT_GT(lit, 50);
  }
}

// Barrel distortion x (1 - 0.6 r^2) turns back at r = 0.745: what lies at r = 1.2 would seem to be in
// the middle of the projector's image, where r = 0.15 is.
TEST(Effects, NoLightBeyondTheProjectorsInvertibleRadius) {
  REQUIRE_RENDERER();
  for (const double radius : {0.2, 1.2}) {
    Twin twin = plane_window(240, 120);
    const Vector3d p =
        twin.projector->T_proj_world * render::Reference(twin).sample(0, {120, 60}).point_world_mm;
    const double turn = std::atan(radius) - std::atan2(p.x(), p.z());
    twin.projector->T_proj_world =
        Pose{rotation_from_vector({0, turn, 0}), Vector3d::Zero()} * twin.projector->T_proj_world;
    twin.projector->lens =
        Lens("LENSMODEL_OPENCV4", {600, 600, 199.5, 139.5, -0.6, 0, 0, 0}, {400, 280}, "barrel");
    if (radius < 0.7) {
      expect_agreement(twin, "barrel projector", 1500);
      continue;
    }
    const auto rendered = render_fixed(twin);
    for (const ImageF& image : rendered.irradiance)
      for (float e : image.data) ASSERT_EQ(e, 0.0F);
  }
}

TEST(Effects, BoundedPlaneAndCylinder) {
  REQUIRE_RENDERER();
  Twin twin = left_window({0, 0, 290}, 200, 160);
  PlaneShape tile = tilted_plane();
  tile.size_mm = Eigen::Vector2d(14.0, 9.0);
  tile.point_mm = {-2.0, 0.0, 290.0};
  CylinderShape tube = upright_cylinder();
  tube.point_mm = {4.0, 0.0, 270.0};
  tube.radius_mm = 2.0;
  tube.length_mm = 6.0;
  twin = with_object(with_object(twin, "tile", tile), "tube", tube);
  expect_agreement(twin, "bounded shapes", 300);
}

constexpr double kMeshPhaseLimit_rad = 1e-4;  ///< required on triangle meshes (shapes_test.cpp)

MeshShape small_part(const std::shared_ptr<const Mesh>& mesh, const Vector3d& at_mm,
                     const Vector3d& turn_rad) {
  return {{}, "mm", {rotation_from_vector(turn_rad), at_mm}, false, mesh};
}

TEST(Effects, InstancesOfOneMesh) {
  REQUIRE_RENDERER();
  const auto mesh = std::make_shared<Mesh>(make_bumpy_icosphere(2, 6.0, default_bumps()));
  Twin twin = left_window({0, 0, 260}, 200, 120);
  twin = with_object(twin, "plane", frontal_plane());
  twin = with_object(twin, "a", small_part(mesh, {-6.5, 1, 255}, {0, 0, 0}));
  twin = with_object(twin, "b", small_part(mesh, {6.5, -1, 262}, {0.4, -1.1, 0.9}), {0.5, 0.0, 10.0});
  expect_agreement(twin, "instances", 501, 3, kMeshPhaseLimit_rad);
  Twin copies = twin;
  std::get<MeshShape>(copies.objects[2].shape).mesh = std::make_shared<Mesh>(*mesh);
  expect_same_bits(twin, copies);
}

TEST(Effects, VertexNormals) {
  REQUIRE_RENDERER();
  const auto mesh = std::make_shared<Mesh>(make_bumpy_icosphere(2, 6.0, default_bumps()));
  const Twin window = left_window({0, 0, 260}, 140, 120);
  MeshShape part = small_part(mesh, {0, 0, 260}, {0.1, 0.2, 0.3});
  const Twin facets = with_object(window, "part", part);
  part.smooth = true;
  const Twin smooth = with_object(window, "part", part);
  expect_agreement(smooth, "vertex normals", 201, 3, kMeshPhaseLimit_rad);
  EXPECT_GT(change(facets, smooth), 0.02);
}

// A facet wound the other way round looks no different under smooth shading: the vertex normals decide,
// turned to the side that is seen.
TEST(Effects, VertexNormalsOfReversedFacets) {
  REQUIRE_RENDERER();
  auto mesh = std::make_shared<Mesh>(make_bumpy_icosphere(2, 6.0, default_bumps()));
  mesh->vertex_normals = compute_vertex_normals(*mesh);
  auto mended = std::make_shared<Mesh>(*mesh);
  int reversed = 0;
  for (std::size_t i = 0; i < mended->triangles.size(); i += 3, ++reversed)
    std::swap(mended->triangles[i][0], mended->triangles[i][1]);
  const Twin window = left_window({0, 0, 260}, 140, 120);
  MeshShape part = small_part(mesh, {0, 0, 260}, {0.1, 0.2, 0.3});
  part.smooth = true;
  const Twin straight = with_object(window, "part", part);
  part.mesh = mended;
  const Twin twin = with_object(window, "part", part);
  EXPECT_GT(reversed, 100);
  expect_agreement(twin, "reversed facets", 201, 3, kMeshPhaseLimit_rad);
  EXPECT_LT(change(straight, twin), 1e-5);
}

TEST(Effects, VertexAlbedo) {
  REQUIRE_RENDERER();
  auto mesh = std::make_shared<Mesh>(make_bumpy_icosphere(2, 6.0, {}));
  Twin twin = left_window({0, 0, 260}, 140, 120);
  const Twin plain = with_object(twin, "part", small_part(mesh, {0, 0, 260}, {0, 0, 0}));
  auto painted = std::make_shared<Mesh>(*mesh);
  painted->vertex_albedo.assign(mesh->vertices_mm.size(), 1.0F);
  const Twin white = with_object(twin, "part", small_part(painted, {0, 0, 260}, {0, 0, 0}));
  EXPECT_LT(change(plain, white), 1e-6);
  auto checked = std::make_shared<Mesh>(*painted);
  for (std::size_t i = 0; i < checked->vertex_albedo.size(); i += 2) checked->vertex_albedo[i] = 0.4F;
  twin = with_object(twin, "part", small_part(checked, {0, 0, 260}, {0, 0, 0}));
  expect_agreement(twin, "vertex albedo", 201, 3, kMeshPhaseLimit_rad);
}

/// Sums of ten terms in single precision, of which the largest is at most ten times the sum.
constexpr double kAddedUp = 6e-6;

/// What each image of the twelve of the paper's rig has of lamp, room light and exposure.
void give_light_factors(Twin& twin) {
  for (int i = 0; i < 12; ++i) {
    twin.projector->light_factors.push_back(1.0 + 0.02 * std::cos(1.0 + 1.7 * i));
    twin.projector->ambient_factors.push_back(1.0 + 0.3 * std::sin(0.4 * i));
    twin.cameras[0].exposure_factors.push_back(1.0 + 0.05 * std::sin(2.0 + i));
  }
}

TEST(Effects, LightPerImage) {
  REQUIRE_RENDERER();
  Twin twin = sphere_window();
  twin.projector->ambient = 0.5;
  for (const double gamma : {1.0, 2.2}) {  // by transport sums, and evaluated image by image
    if (gamma != 1.0) twin.projector->response = {ProjectorResponse::Kind::gamma, gamma, {}};
    Twin steady = twin, changed = twin;
    steady.projector->light_factors = steady.projector->ambient_factors = steady.cameras[0].exposure_factors =
        std::vector<double>(12, 1.0);
    expect_same_bits(twin, steady);
    give_light_factors(changed);
    expect_agreement(changed, "light per image", 300);
    // what was asked for, and in these images: c (f E_projector + r E_ambient), at silhouettes, too
    Twin dark = twin;
    dark.projector->ambient = 0.0;
    const render::RenderedCamera projected = render_fixed(dark), before = render_fixed(twin),
                                 after = render_fixed(changed);
    const Projector& p = *changed.projector;
    for (std::size_t i = 0; i < 12; ++i)
      for (std::size_t k = 0; k < before.object.size(); k += 7) {
        const auto lamp = static_cast<double>(projected.irradiance[i].data[k]),
                   both = static_cast<double>(before.irradiance[i].data[k]);
        ASSERT_NEAR(static_cast<double>(after.irradiance[i].data[k]),
                    changed.cameras[0].exposure_factors[i] *
                        (p.light_factors[i] * lamp + p.ambient_factors[i] * (both - lamp)),
                    kAddedUp * both);
      }
  }
}

/// A twin with every effect of twin/effects.hpp on.
Twin everything() {
  Twin twin = with_object(paper_rig(), "ball", ideal_sphere());
  twin.objects.push_back({"wall", frontal_plane(), {}});
  twin.objects[0].material.specular = 0.2;
  twin.objects[0].material.mean_free_path_mm = 0.5;
  for (Camera& c : twin.cameras) {
    c.optics = Optics{8.0, 10.0, 270.0};
    c.sensor.electrons_per_dn = 40.0;
    c.sensor.read_noise_dn = 0.5;
    c.sensor.black_level_dn = 3.0;
    c.sensor.response = knee_response(120.0, 0.85);
    c.sensor.prnu.values = std::make_shared<const ImageF>(c.lens.width(), c.lens.height(), 1.01F);
    c.sensor.dsnu.values = std::make_shared<const ImageF>(c.lens.width(), c.lens.height(), 0.25F);
    c.psf_px = 0.4;
    c.texture_spread_px = 0.5;
    c.timing = ExposureTiming{.exposure = 0.9, .read_out = 0.2, .late = {0.05}};
    c.vignetting.kind = Vignetting::Kind::cos4;
    const auto texture = std::make_shared<PixelTexture>();
    texture->factor = ImageF(c.lens.width(), c.lens.height(), 0.9F);
    texture->offset = ImageF(c.lens.width(), c.lens.height(), 0.05F);
    c.texture = texture;
  }
  Projector& p = *twin.projector;
  p.ambient = 0.1;
  p.inverse_square = true;
  p.reference_distance_mm = 270.0;
  p.blur_px = 1.0;
  p.blur_field_px2 = {0.1, 0.0, 0.2, 0.0, 0.0};
  p.halo = {{.share = 0.1, .sigma_px = 3.0}};
  p.light_field = {0.1, 0.0};
  twin.room.lamp_world = {0.0, 0.1, -0.2};
  p.response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  p.optics = Optics{2.0, 15.0, 270.0};
  p.pixel_structure = true;
  p.quantise_bits = 8;
  for (DirectionFringes& d : twin.fringes.directions) {
    d.harmonics.assign(3, {{0.01, 0.02}});
    d.harmonics_field = {{{0.01, 0.0}}, {{0.0, 0.01}}};
    d.contrast = {1.0, 0.95, 0.9};
    d.raster = {1.0, 9, {{0.01, 0.0}}};
  }
  twin.fringes.waveform = {Waveform::Kind::levels, {1.0, 0.0, 0.0, 1.0}};
  twin.render.bounces = 1;
  twin.render.glossy_bounces = true;
  give_light_factors(twin);
  p.image_shifts_px.assign(12, 0.1);
  twin.fringes.image_harmonics.assign(12, {{0.01, 0.0}});
  std::get<PlaneShape>(twin.objects[1].shape).albedo_map = std::make_shared<ImageF>(2, 2, 0.5F);
  return twin;
}

TEST(Effects, EachSwitchActsOnItsOwnEffectOnly) {
  const Twin full = everything();
  std::set<std::string> names;
  for (const Effect& effect : effects()) {
    EXPECT_TRUE(names.insert(effect.name).second) << effect.name << " is there twice";
    EXPECT_FALSE(effect.switch_on.empty() || effect.without.empty()) << effect.name;
    if (!effect.is_on(full)) continue;
    Twin without = full;
    effect.switch_off(without);
    // a halo is what goes beyond the blur, and lobes send light from surface to surface only where both are
    const auto goes_with = [&](const Effect& other) {
      return other.name == effect.name || (effect.name == "projector blur" && other.name == "halo") ||
             ((effect.name == "interreflection" || effect.name == "specular lobe") &&
              other.name == "glossy interreflection");
    };
    for (const Effect& other : effects())
      EXPECT_EQ(other.is_on(without), other.is_on(full) && !goes_with(other))
          << "switching off " << effect.name << " changed " << other.name;
  }
}

// All effects are on in that twin and off in the plainest one.
TEST(Effects, OnAndOff) {
  for (const Effect& effect : effects()) EXPECT_TRUE(effect.is_on(everything())) << effect.name;
  Twin plain = with_object(paper_rig(), "ball", ideal_sphere());
  std::vector<std::string> on;
  for (const Effect& effect : effects())
    if (effect.is_on(plain)) on.push_back(effect.name);
  EXPECT_THAT(on, ::testing::ElementsAre("pixel area", "sensor rounding"));
}

// A finer converter of the same range: black, full scale and noise in DN of the first stay where they were.
TEST(Effects, WithoutRoundingTheSensorKeepsItsRange) {
  Twin twin = everything();
  const Sensor before = twin.cameras[0].sensor;
  for (const Effect& effect : effects())
    if (effect.name == "sensor rounding") effect.switch_off(twin);
  const Sensor& after = twin.cameras[0].sensor;
  const double scale = after.gain_dn / before.gain_dn;
  EXPECT_EQ(after.bit_depth, 16);
  EXPECT_EQ(scale, 256.0);
  EXPECT_EQ(after.black_level_dn / scale, before.black_level_dn);
  EXPECT_EQ(static_cast<double>(after.dsnu.values->data[0]) / scale, 0.25);
  EXPECT_EQ(before.dsnu.values->data[0], 0.25F) << "the twin before has its own";
  EXPECT_EQ(*after.read_noise_dn / scale, *before.read_noise_dn);
  // variance gain E / electrons_per_dn, in DN of the first
  EXPECT_EQ(after.gain_dn / *after.electrons_per_dn / (scale * scale),
            before.gain_dn / *before.electrons_per_dn);
}

}  // namespace
}  // namespace fringetwin::testing::effects_test
