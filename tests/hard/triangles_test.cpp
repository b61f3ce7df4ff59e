// SPDX-License-Identifier: Apache-2.0
// Bad triangles: slivers and needles, duplicates, inverted ones, zero areas, numbers that are none; and
// surfaces in one plane.
// | tolerance | unit           | origin                                                              |
// |-----------|----------------|---------------------------------------------------------------------|
// | 4e-5      | rad rms        | required of a plane; a fan of slivers is one                         |
// | 5e-5      | full scale rms | required                                                             |
// | 1e-6      | full scale     | the same surface by other triangles: single-precision rounding        |
// | 0         |                | surfaces in one plane: the same one everywhere                        |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/freeform.hpp"
#include "tests/support/hard_support.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::triangles_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// A square of 200 x 200 mm cut into a fan of n slivers from one corner.
Mesh fan(int n) {
  Mesh mesh;
  mesh.vertices_mm.emplace_back(-100.0F, -100.0F, 0.0F);
  for (int i = 0; i <= n; ++i) {
    const double s = 2.0 * i / n;  // along the two far sides
    const Vector3d p(s <= 1.0 ? 100.0 : 300.0 - 200.0 * s, s <= 1.0 ? 200.0 * s - 100.0 : 100.0, 0.0);
    mesh.vertices_mm.push_back(p.cast<float>());
  }
  for (int i = 1; i <= n; ++i) mesh.triangles.push_back({0, i, i + 1});
  return mesh;
}

/// Needles of 200 mm length side by side, `width_mm` each, corners shifted along by turns.
Mesh needles(int n, double width_mm) {
  Mesh mesh;
  for (int i = 0; i <= n; ++i) {
    const double y = (i - 0.5 * n) * width_mm;
    mesh.vertices_mm.push_back(Vector3d(-100.0 + i % 7, y, 0.0).cast<float>());
    mesh.vertices_mm.push_back(Vector3d(100.0 + i % 5, y, 0.0).cast<float>());
    if (i == 0) continue;
    const int k = 2 * i;
    mesh.triangles.push_back({k - 2, k - 1, k});
    mesh.triangles.push_back({k, k - 1, k + 1});
  }
  return mesh;
}

/// The schoolbook normal of each triangle, from the edges at its first vertex in single precision, against
/// that in double.
double schoolbook_tilt_rad(const Mesh& mesh) {
  double worst = 0.0;
  for (const auto& t : mesh.triangles) {
    const auto v = [&](std::size_t k) -> Vector3f {
      return mesh.vertices_mm[static_cast<std::size_t>(t[k])];
    };
    const Vector3f e1 = v(1) - v(0), e2 = v(2) - v(0);
    const Vector3d n = e1.cross(e2).cast<double>(), truth = e1.cast<double>().cross(e2.cast<double>());
    worst = std::max(worst, std::atan2(n.cross(truth).norm(), n.dot(truth)));
  }
  return worst;
}

/// The mesh lies in z = 0 of its frame, turned: truth is the analytic plane.
void expect_plane(const std::string& what, const Mesh& mesh, const Twin& rig, const PixelBlock& block) {
  const Pose T = {rotation_from_vector({0.25, -0.2, 0.4}), {0.0, 0.0, 290.0}};
  PlaneShape plane;
  plane.point_mm = T.translation_mm;
  plane.normal = T.rotation * Vector3d(0, 0, -1);
  plane.u_axis = T.rotation * Vector3d(1, 0, 0);
  const Twin twin = with_object(rig, "slivers", as_shape(mesh, T)), flat = with_object(rig, "plane", plane);
  const auto rendered = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  const auto truth = reference_block(render::Reference(flat), 0, block, {.gauss_n = 8});
  const Agreement a = compare(twin, 0, rendered.irradiance, truth, Pixels::interior);
  report(what, fmt::format("normal off by up to {:.1e} rad", schoolbook_tilt_rad(mesh)), a.text());
  EXPECT_GT(a.n, 500);
  EXPECT_LE(a.worst_phase_rms_rad(), 4e-5);
  EXPECT_LE(a.gray_rms, 5e-5);
  EXPECT_LE(a.gray_max, 1e-3);  // no lost ray, no wild normal
}

TEST(HardTriangles, SliversInAPlane) {
  REQUIRE_RENDERER();
  const Twin rig = only_camera(paper_rig(), 0);
  // Boxes of slivers askew overlap, so that a ray meets thousands: few pixels.
  expect_plane("fan of 1000 slivers of 200 ... 280 mm", fan(1000), crop_around(rig, {0, 0, 290}, 150, 120),
               {4, 4, 142, 112, 5});
  const Twin macro = zoomed(rig, {0, 0, 290}, 40.0, 80, 64);
  expect_plane("needles of 200 mm x 1 um", needles(4000, 1e-3), macro, {4, 4, 72, 56, 2});
}

// A tilted sheet whose slivers' float vertices do not lie in one plane: the reference takes the same.
TEST(HardTriangles, NeedlesInGeneralPosition) {
  REQUIRE_RENDERER();
  Mesh mesh = needles(1000, 0.16);
  const Eigen::Matrix3d R = rotation_from_vector({0.4, 0.3, -0.2});
  for (Vector3f& v : mesh.vertices_mm)
    v = (R * v.cast<double>() + Vector3d(310.0, -140.0, 77.0)).cast<float>();
  const Pose T = {Eigen::Matrix3d(rotation_from_vector({-0.2, -0.3, 0.1})), Vector3d(3, -4, 290)};
  const Pose T_world_object = {T.rotation, T.translation_mm - T.rotation * Vector3d(310.0, -140.0, 77.0)};
  const Twin twin =
      with_object(left_window(T.translation_mm, 96, 80), "needles", as_shape(mesh, T_world_object));
  const Agreement a =
      agreement(twin, 0, {Sampler::gauss, 16}, {2, 2, 92, 76, 5}, Pixels::hit, {.gauss_n = 4});
  report("2,000 needles of 200 x 0.16 mm askew, rounded vertices",
         fmt::format("normal off by up to {:.1e} rad", schoolbook_tilt_rad(mesh)), a.text());
  EXPECT_GT(a.n, 200);
  EXPECT_LE(a.worst_phase_rms_rad(), 4e-5);
  EXPECT_LE(a.gray_rms, 5e-4);
}

// ---------------------------------------------------------------- the same surface by other triangles

const Vector3d part_place(2.0, -3.0, 275.0);

Twin part(const Mesh& mesh, bool smooth) {
  const Pose T = {rotation_from_vector({0.11, -0.23, 0.37}), part_place};
  return with_object(left_window({0, 0, 245}, 320, 240), "part", as_shape(mesh, T, smooth));
}

/// Largest gray difference (of full scale), and the count of pixels that differ by more than 1e-3.
struct Difference {
  double worst = 0.0;
  int far = 0, nan = 0;
};
Difference difference(const Twin& a, const Twin& b) {
  const render::Sampling sampling{Sampler::gauss, 4};
  const auto ra = shared_renderer()->render(a, 0, sampling), rb = shared_renderer()->render(b, 0, sampling);
  const double full = a.cameras[0].sensor.max_dn() / a.cameras[0].sensor.gain_dn;
  Difference out;
  for (std::size_t i = 0; i < ra.irradiance.size(); ++i)
    for (std::size_t p = 0; p < ra.irradiance[i].size(); ++p) {
      const double d = std::abs(ra.irradiance[i].data[p] - rb.irradiance[i].data[p]) / full;
      out.nan += std::isnan(d);
      out.far += d > 1e-3;
      out.worst = std::max(out.worst, std::isnan(d) ? 0.0 : d);
    }
  return out;
}

Mesh base_mesh() {
  Mesh mesh = make_bumpy_icosphere(4, 35.0, default_bumps());
  mesh.vertex_normals = compute_vertex_normals(mesh);  // as if the file had them: the variants keep them
  return mesh;
}

void invert_every_third(Mesh* mesh) {
  for (std::size_t i = 0; i < mesh->triangles.size(); i += 3)
    std::swap(mesh->triangles[i][1], mesh->triangles[i][2]);
}

TEST(HardTriangles, DuplicatesInversionsAndZeroAreas) {
  REQUIRE_RENDERER();
  for (const bool smooth : {false, true}) {
    const Mesh mesh = base_mesh();
    Mesh twice = mesh, inverted = mesh, zero = mesh;
    twice.triangles.insert(twice.triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
    invert_every_third(&inverted);
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 2) {
      const auto& t = mesh.triangles[i];
      zero.triangles.push_back({t[0], t[1], t[1]});
      zero.triangles.push_back({t[2], t[2], t[2]});
    }
    const Twin truth = part(mesh, smooth);
    for (const auto& [name, changed] : {std::pair<const char*, const Mesh*>{"every triangle twice", &twice},
                                        {"every third triangle inverted", &inverted},
                                        {"zero-area triangles among them", &zero}}) {
      const Difference d = difference(truth, part(*changed, smooth));
      report(fmt::format("{}{}", name, smooth ? ", smooth" : ""), "",
             fmt::format("gray differs by {:.1e} at most, {} values by more than 1e-3, {} NaN", d.worst,
                         d.far, d.nan));
      EXPECT_EQ(d.nan, 0) << name;
      EXPECT_EQ(d.far, 0) << name;
      EXPECT_LE(d.worst, 1e-6) << name;
    }
  }
}

// Inverted triangles in a mesh without normals of its own: smooth shading averages normals of both
// signs, down to zero where a triangle lies on its inverted copy. Same rule as the reference: a vertex
// normal that says nothing gives way to the facet's.
TEST(HardTriangles, SmoothShadingWithCancelledNormals) {
  REQUIRE_RENDERER();
  Mesh both = make_bumpy_icosphere(3, 35.0, default_bumps());
  const std::size_t n = both.triangles.size();
  for (std::size_t i = 0; i < n; ++i) {
    const auto t = both.triangles[i];
    both.triangles.push_back({t[0], t[2], t[1]});
  }
  both.vertex_normals.assign(both.vertices_mm.size(), Vector3f::Zero());
  const Agreement a =
      agreement(part(both, true), 0, {Sampler::gauss, 16}, {0, 0, 320, 240, 5}, Pixels::hit, {.gauss_n = 4});
  report("every triangle on its inverted copy, smooth", "", a.text());
  EXPECT_GT(a.n, 1500);
  EXPECT_LE(a.worst_phase_rms_rad(), 4e-5);
  EXPECT_LE(a.gray_rms, 5e-4);
}

// ---------------------------------------------------------------- numbers that are none

template <class Change>
void expect_refused(const std::string& part_of_message, Change change) {
  Twin twin = part(make_bumpy_icosphere(1, 35.0, {}), false);
  Mesh mesh = *std::get<MeshShape>(twin.objects[0].shape).mesh;
  change(&mesh);
  std::get<MeshShape>(twin.objects[0].shape).mesh = std::make_shared<Mesh>(mesh);
  try {
    shared_renderer()->trace(twin, 0, {Sampler::gauss, 4});
    ADD_FAILURE() << "no error about " << part_of_message;
  } catch (const UserError& e) {
    EXPECT_NE(std::string(e.what()).find(part_of_message), std::string::npos) << e.what();
  }
}

TEST(HardTriangles, NotANumber) {
  REQUIRE_RENDERER();
  expect_refused("finite", [](Mesh* m) { m->vertices_mm[7].y() = std::numeric_limits<float>::quiet_NaN(); });
  expect_refused("finite", [](Mesh* m) { m->vertices_mm[0].x() = std::numeric_limits<float>::infinity(); });
  expect_refused("no triangle", [](Mesh* m) {
    for (auto& t : m->triangles) t = {t[0], t[1], t[0]};  // nothing has an area
  });
}

TEST(HardTriangles, DenormalCoordinates) {
  REQUIRE_RENDERER();
  // A sheet in the plane z = 0 whose zeros are the smallest positive floats, and the true zeros.
  const auto sheet = [](double z) {
    Mesh m = height_field(-60, -60, 2, 2, 60, 60, [](double, double) { return 0.0; });
    for (std::size_t i = 0; i < m.vertices_mm.size(); ++i)
      m.vertices_mm[i].z() = i % 2 ? static_cast<float>(z) : -static_cast<float>(z);
    m.vertices_mm[31].x() = static_cast<float>(z);
    return m;
  };
  Twin a = part(sheet(0.0), false), b = part(sheet(1e-44), false);
  const Difference d = difference(a, b);
  report("denormal coordinates", "", fmt::format("gray differs by {:.1e} at most, {} NaN", d.worst, d.nan));
  EXPECT_EQ(d.nan, 0);
  EXPECT_LE(d.worst, 1e-6);
}

// Rays that run exactly inside the planes of facets and along edges: a box with axis-parallel sides
// before a camera on its axis; direction components of exactly 0.
TEST(HardTriangles, AxisParallelBox) {
  REQUIRE_RENDERER();
  Mesh box;
  for (int i = 0; i < 8; ++i)
    box.vertices_mm.emplace_back(i & 1 ? 20.0F : 0.0F, i & 2 ? 20.0F : 0.0F, i & 4 ? 40.0F : 0.0F);
  for (const auto& q :
       {std::array{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}) {
    box.triangles.push_back({q[0], q[1], q[2]});
    box.triangles.push_back({q[0], q[2], q[3]});
  }
  Twin twin = bench_rig();
  twin.projector->ambient = 1.0;
  twin.render.pixel_fill = 0.0;
  twin = with_object(twin, "box", as_shape(box, {Eigen::Matrix3d::Identity(), {0, 0, 250}}));
  const auto t = shared_renderer()->trace(twin, 0, {Sampler::gauss, 1});
  int wrong = 0, nan = 0;
  for (int y = 0; y < 181; ++y)
    for (int x = 0; x < 201; ++x) {
      const bool inside =
          x >= 100 && x <= 180 && y >= 90 && y <= 170;  // 20/250 * 1000 = 80 px, borders included
      const bool border = x == 100 || x == 180 || y == 90 || y == 170;  // of either opinion
      nan += std::isnan(t.mean(x, y)) || std::isnan(t.cosine[0][0](x, y));
      wrong += !border && (t.ambient(x, y) != (inside ? 1.0F : 0.0F));
    }
  report("rays inside the planes of a box's sides", "", fmt::format("{} wrong pixels, {} NaN", wrong, nan));
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(nan, 0);
}

// ---------------------------------------------------------------- surfaces in one plane

// A dark rectangle, a bright rectangle and a mesh in one tilted plane, each stated by its own point: the
// one that counts is seen everywhere, as in the reference, and not a speckle of all.
TEST(HardTriangles, SurfacesInOnePlane) {
  REQUIRE_RENDERER();
  const PlaneShape plane = tilted_plane();
  PlaneShape first = plane, second = plane;
  const Vector3d v = plane.normal.cross(plane.u_axis);
  first.size_mm = Eigen::Vector2d(60, 60);
  second.point_mm = plane.point_mm + 11.3 * plane.u_axis - 7.7 * v;
  second.size_mm = Eigen::Vector2d(70, 60);
  Eigen::Matrix3d R;
  R << plane.u_axis, v, plane.normal;
  const Mesh sheet = height_field(-40, -40, 4, 4, 20, 20, [](double, double) { return 0.0; });
  Twin twin = only_camera(paper_rig(), 0);
  twin = with_object(twin, "dark", first, {0.2, 0.0, 10.0});
  twin = with_object(twin, "bright", second, {0.8, 0.0, 10.0});
  twin = with_object(twin, "mesh", as_shape(sheet, {R, plane.point_mm + 3.3 * v}), {0.5, 0.0, 10.0});
  const auto t = shared_renderer()->trace(twin, 0, {Sampler::gauss, 1});
  const render::Reference reference(twin);
  int n = 0, wrong = 0, as_reference = 0, schoolbook = 0;
  for (int y = 200; y < 980; y += 3)
    for (int x = 300; x < 1200; x += 3) {
      const auto s = reference.sample(0, {x, y});
      if (s.object < 0) continue;
      const Vector3d in_plane = s.point_world_mm - plane.point_mm;
      if (std::abs(in_plane.dot(plane.u_axis)) > 29.9 || std::abs(in_plane.dot(v)) > 29.9) continue;
      ++n;
      wrong += t.object(x, y) != 0;
      as_reference += t.object(x, y) == s.object;
      // nearest of the three in single precision, as it comes
      const Vector3f d = only_camera(twin, 0).cameras[0].lens.unproject({x, y})->cast<float>();
      const auto root = [&](const PlaneShape& p) {
        return p.normal.cast<float>().dot(p.point_mm.cast<float>()) / p.normal.cast<float>().dot(d);
      };
      schoolbook += root(second) < root(first);
    }
  report(fmt::format("three surfaces in one plane, {} pixels", n),
         fmt::format("{:.0f} % of the pixels show the second", 100.0 * schoolbook / n),
         fmt::format("{} wrong", wrong));
  EXPECT_GT(n, 10'000);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(as_reference, n);
}

}  // namespace
}  // namespace fringetwin::testing::triangles_test
