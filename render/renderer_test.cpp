// SPDX-License-Identifier: Apache-2.0
// The Vulkan renderer on small scenes against closed forms, its determinism, limits and errors.
// (tests/accuracy compares it with the double-precision reference.)
// | tolerance | unit      | origin                                                              |
// |-----------|-----------|---------------------------------------------------------------------|
// | 1e-3      | relative  | area of a disk of 71 px radius by 16x16 samples a pixel              |
// | 5e-5      | rad       | single precision, 3 sigma of 1.5e-5                                 |
// | 1e-5      | relative  | irradiance, some tens of single-precision roundings                 |
// | 0         | bits      | determinism: seed, chunks of samples, memory path, geometry path    |
#include "render/renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"
#include "tests/support/render/loop_limit.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render::renderer_test {
namespace {

using testing::only_camera;
using testing::paper_rig;
using testing::with_object;

class RendererTest : public ::testing::Test {
 protected:
  static bool required() { return std::getenv("CI") || std::getenv("FRINGETWIN_REQUIRE_DEVICE"); }
  void SetUp() override {
    if (!list_devices().empty()) return;
    if (required()) FAIL() << "no Vulkan device found";
    GTEST_SKIP() << "no Vulkan device found";
  }
  static Renderer& renderer() {
    static Renderer shared;
    return shared;
  }
};

class Environment {
 public:
  Environment(const char* name, const char* value) : name_(name) { setenv(name, value, 1); }
  ~Environment() { unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
};

// Pinhole camera and projector side by side, axes parallel; everything has a closed form.
Twin simple_rig() {
  Twin twin = only_camera(paper_rig(), 0);
  twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {1000, 1000, 100, 90}, {201, 181}, "camera");
  twin.projector->lens = Lens("LENSMODEL_PINHOLE", {1700, 1700, 640, 360}, {1280, 720}, "projector");
  twin.projector->T_proj_world.rotation.setIdentity();
  twin.projector->T_proj_world.translation_mm = {-40.0, 0.0, 0.0};
  return twin;
}

Twin on_sphere() { return with_object(simple_rig(), "ball", SphereShape{{0, 0, 280}, 20.0}); }

Mesh icosphere(int subdivisions, double radius_mm) {
  return testing::make_bumpy_icosphere(subdivisions, radius_mm, {});
}

MeshShape mesh_at(const std::shared_ptr<const Mesh>& mesh, const Eigen::Vector3d& where_mm,
                  bool smooth = false) {
  return {{}, "mm", {Eigen::Matrix3d::Identity(), where_mm}, smooth, mesh};
}

bool same_bits(const ImageF& a, const ImageF& b) { return a.data == b.data; }

bool same_bits(const Transport& a, const Transport& b) {
  bool same = same_bits(a.mean, b.mean) && same_bits(a.ambient, b.ambient) && a.object.data == b.object.data;
  for (std::size_t d = 0; d < a.cosine.size(); ++d)
    for (std::size_t p = 0; p < a.cosine[d].size(); ++p)
      same = same && same_bits(a.cosine[d][p], b.cosine[d][p]) && same_bits(a.sine[d][p], b.sine[d][p]);
  for (std::size_t i = 0; i < a.direct.size(); ++i) same = same && same_bits(a.direct[i], b.direct[i]);
  return same;
}

TEST_F(RendererTest, ListsItsDevice) {
  const auto devices = list_devices();
  const std::string name = renderer().device().name;
  EXPECT_TRUE(
      std::any_of(devices.begin(), devices.end(), [&](const DeviceInfo& d) { return d.name == name; }));
  EXPECT_FALSE(renderer().device().driver.empty());
  // A part of the name in any case selects it.
  EXPECT_EQ(Renderer(name.substr(0, 4)).device().name, name);
}

TEST_F(RendererTest, SilhouetteOfASphere) {
  Twin twin = on_sphere();
  twin.projector->ambient = 1.0;
  const Transport t = renderer().trace(twin, 0, {Sampler::gauss, 256});
  double area_px = 0.0;
  for (const float hit : t.ambient.data) area_px += hit;
  const double radius_px = 1000.0 * 20.0 / std::sqrt(280.0 * 280.0 - 400.0);
  EXPECT_NEAR(area_px, std::numbers::pi * radius_px * radius_px, 1e-3 * area_px);
  EXPECT_EQ(t.object(100, 90), 0);
  EXPECT_EQ(t.object(100 + 71, 90), 0);
  EXPECT_EQ(t.object(100 + 72, 90), -1);
}

TEST_F(RendererTest, PhaseAtTheNearestPointOfASphere) {
  Twin twin = on_sphere();
  twin.render.pixel_fill = 0.0;  // the pixel's centre only
  const Transport t = renderer().trace(twin, 0, {Sampler::gauss, 1});
  // (0, 0, 260): x_proj = 640 - 1700 * 40/260.
  const double x_px = 640.0 - 1700.0 * 40.0 / 260.0;
  for (std::size_t p = 0; p < 3; ++p) {
    const double expected = 2.0 * std::numbers::pi * x_px / twin.fringes.directions[0].pitches_px[p];
    const double got = std::atan2(t.sine[0][p](100, 90), t.cosine[0][p](100, 90));
    EXPECT_NEAR(std::remainder(got - expected, 2.0 * std::numbers::pi), 0.0, 5e-5) << p;
  }
}

TEST_F(RendererTest, FrontalPlaneHasAClosedForm) {
  Twin twin = with_object(simple_rig(), "wall", PlaneShape{{0, 0, 300}, {0, 0, -1}, {}, {1, 0, 0}});
  twin.objects[0].material.diffuse = 0.7;
  twin.projector->intensity = 3.0;
  const Transport t = renderer().trace(twin, 0, {Sampler::gauss, 1});
  for (const auto& [x, y] : {std::pair(100, 90), std::pair(3, 5), std::pair(190, 20)}) {
    const Eigen::Vector3d p((x - 100) * 0.3, (y - 90) * 0.3, 300.0);
    const Eigen::Vector3d l = Eigen::Vector3d(40, 0, 0) - p;
    const double expected = 3.0 * 0.7 / std::numbers::pi * 300.0 / l.norm();
    EXPECT_NEAR(t.mean(x, y), expected, 1e-5 * expected);
    const double x_px = 640.0 + 1700.0 * (p.x() - 40.0) / 300.0;
    const double phase = 2.0 * std::numbers::pi * x_px / 13.0;
    const double got = std::atan2(t.sine[0][0](x, y), t.cosine[0][0](x, y));
    EXPECT_NEAR(std::remainder(got - phase, 2.0 * std::numbers::pi), 0.0, 5e-5);
  }
}

TEST_F(RendererTest, ObjectIndicesAreTheTwins) {
  Twin twin = with_object(simple_rig(), "wall", PlaneShape{{0, 0, 320}, {0, 0, -1}, {}, {1, 0, 0}});
  const auto mesh = std::make_shared<Mesh>(icosphere(2, 5.0));
  twin = with_object(twin, "part", mesh_at(mesh, {-15, 0, 280}));
  twin = with_object(twin, "ball", SphereShape{{15, 0, 280}, 5.0});
  const RenderedCamera r = renderer().render(twin, 0, {Sampler::gauss, 1});
  EXPECT_EQ(r.object(100, 20), 0);
  EXPECT_EQ(r.object(100 - 54, 90), 1);
  EXPECT_EQ(r.object(100 + 54, 90), 2);
}

TEST_F(RendererTest, NothingInViewIsDark) {
  const Twin twin = with_object(simple_rig(), "ball", SphereShape{{0, 0, -200}, 20.0});
  const RenderedCamera r = renderer().render(twin, 0, {Sampler::gauss, 4});
  ASSERT_EQ(r.irradiance.size(), 12u);
  for (const ImageF& image : r.irradiance)
    EXPECT_TRUE(std::all_of(image.data.begin(), image.data.end(), [](float e) { return e == 0.0F; }));
  EXPECT_EQ(r.rays, 0u);
  const RenderedCamera empty = renderer().render(simple_rig(), 0, {Sampler::gauss, 4});
  EXPECT_EQ(empty.object(0, 0), -1);
}

// A sphere far smaller than a block of pixels, at every place of the image: culling must keep it.
TEST_F(RendererTest, SmallSpheresAreNotCulled) {
  for (const double x : {-26.0, -9.6, 0.1, 12.8, 27.0})
    for (const double y : {-24.0, 2.4, 24.0}) {
      Twin twin = with_object(simple_rig(), "grain", SphereShape{{x, y, 280}, 0.3});
      twin.projector->ambient = 1.0;
      const Transport t = renderer().trace(twin, 0, {Sampler::gauss, 256});
      double area_px = 0.0;
      for (const float hit : t.ambient.data) area_px += hit;
      const double radius_px = 1000.0 * 0.3 / 280.0, slant = std::hypot(x, y) / 280.0;
      EXPECT_NEAR(area_px, std::numbers::pi * radius_px * radius_px * std::pow(1 + slant * slant, 1.5),
                  0.02 * area_px);
    }
}

TEST_F(RendererTest, SameSeedSameBits) {
  const Twin twin = on_sphere();
  for (const Sampler sampler : {Sampler::gauss, Sampler::multi_jittered, Sampler::sobol}) {
    const Transport a = renderer().trace(twin, 0, {sampler, 16}, 5);
    Renderer other;
    const Transport b = other.trace(twin, 0, {sampler, 16}, 5);
    EXPECT_TRUE(same_bits(a, b));
    const Transport c = renderer().trace(twin, 0, {sampler, 16}, 6);
    EXPECT_EQ(same_bits(a, c), sampler == Sampler::gauss);
  }
}

class RendererPrecisionTest : public RendererTest, public ::testing::WithParamInterface<bool> {};

TEST_P(RendererPrecisionTest, SameBitsHoweverTheWorkIsCut) {
  const auto mesh = std::make_shared<Mesh>(icosphere(4, 20.0));
  Twin twin = with_object(simple_rig(), "part", mesh_at(mesh, {0, 0, 280}));
  const Sampling sampling{Sampler::multi_jittered, 25, GetParam()};
  const Transport whole = renderer().trace(twin, 0, sampling, 1);
  Renderer cut;
  cut.set_tuning({.samples_per_dispatch = 7});
  EXPECT_TRUE(same_bits(whole, cut.trace(twin, 0, sampling, 1)));
  EXPECT_EQ(whole.rays, cut.trace(twin, 0, sampling, 1).rays);
  {
    const Environment staging("FRINGETWIN_STAGING", "1");
    Renderer staged;
    EXPECT_TRUE(same_bits(whole, staged.trace(twin, 0, sampling, 1)));
  }
  {
    const Environment geometry("FRINGETWIN_GEOMETRY", "storage");
    Renderer storage;
    EXPECT_TRUE(same_bits(whole, storage.trace(twin, 0, sampling, 1)));
  }
}

INSTANTIATE_TEST_SUITE_P(SingleAndDouble, RendererPrecisionTest, ::testing::Bool());

// lavapipe 22.3 cuts an invocation's loops at 65,535 iterations without a word. 4096 samples of a
// mesh in one dispatch exceed that: the renderer must notice, repeat, and get the same bits.
// Every image of a moving ball is that of a ball at rest where it then is, and all else that of the middle.
TEST_F(RendererTest, EachImageOfAMovingBallIsThatOfABallAtItsPlace) {
  Twin twin = on_sphere();
  const Eigen::Vector3d way_mm(0.8, -0.4, 2.0);
  twin.objects[0].motion = {way_mm.x(), way_mm.y(), way_mm.z()};
  const RenderedCamera moving = renderer().render(twin, 0, {Sampler::gauss, 4}, 0, true);
  const std::size_t n = moving.irradiance.size();
  const auto at_rest = [&](const Eigen::Vector3d& center_mm) {
    return renderer().render(with_object(simple_rig(), "ball", SphereShape{center_mm, 20.0}), 0,
                             {Sampler::gauss, 4}, 0, true);
  };
  const RenderedCamera middle = at_rest({0, 0, 280});
  for (const std::size_t k : {std::size_t{0}, n / 3, n - 1}) {
    const Eigen::Vector3d place_mm =
        Eigen::Vector3d(0, 0, 280) + (static_cast<double>(k) / static_cast<double>(n - 1) - 0.5) * way_mm;
    EXPECT_TRUE(same_bits(moving.irradiance[k], at_rest(place_mm).irradiance[k])) << k;
    EXPECT_FALSE(same_bits(moving.irradiance[k], middle.irradiance[k])) << k;
  }
  EXPECT_TRUE(same_bits(*moving.white, *middle.white) && moving.object.data == middle.object.data);
  twin.objects[0].motion = {0.0, 0.0, 0.0};
  EXPECT_TRUE(same_bits(renderer().render(twin, 0, {Sampler::gauss, 4}).irradiance[1], middle.irradiance[1]));
}

TEST_F(RendererTest, LoopLimitIsNoticed) {
  VulkanDevice device("");
  EXPECT_EQ(testing::count_loop_iterations(device, 1000), 1000u);
  const std::uint32_t limit = testing::count_loop_iterations(device, 200000);
  const auto mesh = std::make_shared<Mesh>(icosphere(5, 20.0));
  Twin twin = with_object(simple_rig(), "part", mesh_at(mesh, {0, 0, 280}));
  twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {1000, 1000, 15, 7}, {32, 16}, "camera");
  const Transport careful = renderer().trace(twin, 0, {Sampler::multi_jittered, 4096}, 1);
  Renderer greedy;
  greedy.set_tuning({.samples_per_dispatch = 4096});
  const Transport repeated = greedy.trace(twin, 0, {Sampler::multi_jittered, 4096}, 1);
  EXPECT_TRUE(same_bits(careful, repeated));
  if (limit < 200000) {
    EXPECT_GT(repeated.repeated_dispatches, 0);
  } else {
    EXPECT_EQ(repeated.repeated_dispatches, 0);
  }
}

TEST_F(RendererTest, ValidationLayersAreSilent) {
  const Environment validation("FRINGETWIN_VALIDATION", "1");
  std::unique_ptr<Renderer> validated;
  try {
    validated = std::make_unique<Renderer>();
  } catch (const UserError& e) {
    if (required()) FAIL() << e.what();
    GTEST_SKIP() << e.what();
  }
  Twin twin = with_object(on_sphere(), "wall", PlaneShape{{0, 0, 320}, {0, 0, -1}, {}, {1, 0, 0}});
  const auto mesh = std::make_shared<Mesh>(icosphere(3, 5.0));
  twin = with_object(twin, "part", mesh_at(mesh, {20, 0, 280}, true));
  twin.cameras[0].optics = Optics{8.0, 10.0, 280.0};
  validated->trace(twin, 0, {Sampler::gauss, 4});
  validated->trace(twin, 0, {Sampler::sobol, 16});
  validated->trace(twin, 0, {Sampler::gauss, 4, true});
  validated->trace(paper_rig(), 1, {Sampler::gauss, 4});
  twin.cameras[0].optics.reset();
  for (const bool precise : {false, true}) validated->trace(twin, 0, {Sampler::adaptive, 4, precise});
  EXPECT_EQ(validated->validation_messages(), 0);
  VulkanDevice device("");
  testing::count_loop_iterations(device, 10);
  EXPECT_EQ(device.instance().validation_messages(), 0);
}

// ---- what a user can get wrong

template <class F>
void expect_error(ExitCode code, const std::string& part, F f) {
  try {
    f();
    ADD_FAILURE() << "no error about " << part;
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), code) << e.what();
    EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
  }
}

TEST_F(RendererTest, UnknownDevice) {
  expect_error(ExitCode::device, "no-such-device", [] { Renderer r("no-such-device"); });
  const Environment device("FRINGETWIN_DEVICE", "also-missing");
  expect_error(ExitCode::device, "also-missing", [] { Renderer r; });
}

TEST_F(RendererTest, NoDriver) {
  const Environment icd("VK_ICD_FILENAMES", "/nonexistent.json"),
      driver("VK_DRIVER_FILES", "/nonexistent.json");
  EXPECT_TRUE(list_devices().empty());
  expect_error(ExitCode::device, "driver", [] { Renderer r; });
}

TEST_F(RendererTest, CameraInsideAnObject) {
  const auto trace = [](const Shape& shape) {
    renderer().trace(with_object(simple_rig(), "it", shape), 0, {Sampler::gauss, 4});
  };
  expect_error(ExitCode::usage, "inside the sphere \"it\"", [&] { trace(SphereShape{{0, 0, 5}, 20}); });
  expect_error(ExitCode::usage, "inside the cylinder", [&] {
    trace(CylinderShape{{1, 0, 0}, {0, 1, 0}, 20, {}});
  });
  expect_error(ExitCode::usage, "inside the cylinder", [&] {
    trace(CylinderShape{{0, 0, 0}, {0, 0, 1}, 20, 9.0});
  });
  const auto mesh = std::make_shared<Mesh>(icosphere(3, 20.0));
  expect_error(ExitCode::usage, "inside the mesh", [&] { trace(mesh_at(mesh, {0, 0, 5})); });
  // Beyond the end of a cylinder, or in front of an open mesh, one may look in.
  trace(CylinderShape{{0, 0, 100}, {0, 0, 1}, 20, 50.0});
  auto bowl = std::make_shared<Mesh>(*mesh);
  std::erase_if(bowl->triangles,
                [&](const auto& t) { return bowl->vertices_mm[static_cast<std::size_t>(t[0])].z() < 2.0F; });
  trace(mesh_at(bowl, {0, 0, -8}));
}

TEST_F(RendererTest, UnfinishedTwins) {
  Twin dark = on_sphere();
  dark.projector.reset();
  expect_error(ExitCode::usage, "projector", [&] { renderer().trace(dark, 0, {Sampler::gauss, 4}); });
  expect_error(ExitCode::usage, "not loaded", [&] {
    renderer().trace(with_object(simple_rig(), "part", MeshShape{"part.stl", "mm", {}, false, nullptr}), 0,
                     {Sampler::gauss, 4});
  });
  expect_error(ExitCode::usage, "measured", [&] {
    renderer().trace(with_object(simple_rig(), "part", MeasuredShape{}), 0, {Sampler::gauss, 4});
  });
  expect_error(ExitCode::usage, "n x n", [&] { renderer().trace(on_sphere(), 0, {Sampler::gauss, 5}); });
}

// A camera ray that walks to its triangle meets the same one as through the BVH, and shadow rays are left out
// only where nothing is in the way.
TEST_F(RendererTest, WalksAndSearchesAgree) {
  Twin twin = only_camera(paper_rig(), 0);
  twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {1000, 1000, 200, 180}, {401, 361}, "camera");
  const auto big = std::make_shared<Mesh>(testing::make_bumpy_icosphere(5, 35.0, testing::default_bumps()));
  const auto small = std::make_shared<Mesh>(testing::make_bumpy_icosphere(4, 8.0, testing::default_bumps()));
  twin = with_object(twin, "part",
                     MeshShape{{}, "mm", {rotation_from_vector({0.1, -0.2, 0.4}), {0, 0, 275}}, false, big});
  for (const auto& [p, seed] :
       {std::pair(Eigen::Vector3d(-25, 10, 235), 0.3), std::pair(Eigen::Vector3d(30, -20, 260), 1.1)})
    twin.objects.push_back(
        {"knob", MeshShape{{}, "mm", {rotation_from_vector({seed, 0.2, 0}), p}, true, small}, {}});
  twin.objects.push_back({"wall", testing::frontal_plane(310.0), {}});
  for (const std::size_t n_objects : {std::size_t{1}, std::size_t{4}}) {
    Twin scene = twin;
    scene.objects.resize(n_objects);
    Transport by[2];
    for (const bool search : {false, true}) {
      renderer().set_tuning({.search_always = search});
      by[search] = renderer().trace(scene, 0, {Sampler::gauss, 4});
    }
    renderer().set_tuning({});
    EXPECT_LT(by[0].rays, by[1].rays + 1);
    EXPECT_EQ(by[0].object.data, by[1].object.data);
    std::size_t differ = 0;
    for (std::size_t i = 0; i < by[0].mean.size(); ++i)
      differ += by[0].mean.data[i] != by[1].mean.data[i] ||
                by[0].cosine[0][0].data[i] != by[1].cosine[0][0].data[i];
    EXPECT_EQ(differ, 0U);
  }
}

// A mesh stays on the device from one trace to the next; another one, its other normals, another kind of
// buffer and another precision do not find it there.
TEST_F(RendererTest, WhatWasTracedBeforeChangesNothing) {
  const auto part = std::make_shared<Mesh>(testing::make_bumpy_icosphere(4, 20.0, testing::default_bumps()));
  const auto scene = [](const std::shared_ptr<const Mesh>& mesh, bool smooth, double z_mm) {
    return with_object(simple_rig(), "part", mesh_at(mesh, {0, 0, z_mm}, smooth));
  };
  Renderer used;
  const auto expect_as_new = [&](const Twin& twin, const char* what) {
    const Transport found = used.trace(twin, 0, {Sampler::gauss, 4});
    Renderer fresh;
    EXPECT_TRUE(same_bits(found, fresh.trace(twin, 0, {Sampler::gauss, 4}))) << what;
  };
  expect_as_new(scene(part, false, 280.0), "first");
  expect_as_new(scene(part, false, 280.0), "again");
  expect_as_new(scene(part, true, 280.0), "smooth");
  expect_as_new(scene(part, false, 700.0), "farther away");
  for (int i = 0; i < 4; ++i) {  // each may lie where the one before was
    const auto other = std::make_shared<Mesh>(icosphere(3, 12.0 + i));
    expect_as_new(scene(other, false, 280.0), "another mesh");
  }
  {
    const Environment storage("FRINGETWIN_GEOMETRY", "storage");
    expect_as_new(scene(part, true, 280.0), "in storage buffers");
  }
  expect_as_new(scene(part, true, 280.0), "in texel buffers");
  EXPECT_THROW(used.trace(scene(std::make_shared<Mesh>(), false, 280.0), 0, {Sampler::gauss, 4}), UserError);
  expect_as_new(scene(part, false, 280.0), "after an error");
}

// Where nothing was seen the adaptive trace must not find what stood there of an object before, in images of
// the same and of another size.
TEST_F(RendererTest, ASmallObjectFindsNothingOfALargeOne) {
  const auto seen_by = [](int width_px, int height_px, const Shape& shape) {
    Twin twin = with_object(simple_rig(), "object", shape);
    twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {1000, 1000, 100, 90}, {width_px, height_px}, "camera");
    return twin;
  };
  const Shape wall = PlaneShape{{0, 0, 320}, {0, 0, -1}, {}, {1, 0, 0}},
              ball = SphereShape{{3, -2, 280}, 4.0};
  const Sampling adaptive{Sampler::adaptive, 4};
  for (const char* staging : {"0", "1"}) {
    const Environment variable("FRINGETWIN_STAGING", staging);
    Renderer used;
    for (const auto& [width, height] : {std::pair{320, 240}, std::pair{250, 187}, std::pair{320, 240}}) {
      used.trace(seen_by(320, 240, wall), 0, adaptive);
      Renderer fresh;
      EXPECT_TRUE(same_bits(used.trace(seen_by(width, height, ball), 0, adaptive),
                            fresh.trace(seen_by(width, height, ball), 0, adaptive)))
          << width << ' ' << staging;
    }
  }
}

}  // namespace
}  // namespace fringetwin::render::renderer_test
