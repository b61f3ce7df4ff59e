// SPDX-License-Identifier: Apache-2.0
// The adaptive trace, edges included, against the double-precision reference: its error, and that its own
// estimate of that error bounds it, on scenes it was not tuned on.
// | tolerance  | unit            | origin                                                       |
// |------------|-----------------|--------------------------------------------------------------|
// | 4e-5       | rad rms         | the bound on interior pixels in single precision             |
// | gray_error | full scale, rms | what was asked for, over all pixels                          |
// | + 2e-5     | full scale, rms | on the estimate: sums in single precision, and what 160^2    |
// |            |                 | nodes leave at an edge (2e-4) times the share of edge pixels |
// | 6, 10, 100 | rays per pixel  | 1/170, 1/100 of the published 1024; 1/10 where a pixel sees a fringe |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "tests/support/agreement.hpp"
#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::adaptive_test {
namespace {

Object plane_object(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& normal) {
  Object wall;
  wall.name = "wall";
  PlaneShape plane;
  plane.point_mm = point_mm;
  plane.normal = normal.normalized();
  wall.shape = plane;
  return wall;
}

enum class Content { one_facet, one_surface, edge };

// What 64 rays along each side of the pixel and 12 x 12 in it see. An edge that none of them tells cuts off
// less than 1/64 of two sides, 1e-4 of the pixel.
Content content(const render::Reference& reference, int x, int y) {
  constexpr int n_side = 64, n_inside = 12;
  std::vector<Eigen::Vector2d> at;
  for (int i = 0; i < n_side; ++i) {
    const double s = (i + 0.5) / n_side - 0.5;
    at.insert(at.end(), {{s, -0.5}, {0.5, s}, {s, 0.5}, {-0.5, s}});
  }
  for (int i = 0; i < n_inside * n_inside; ++i)
    at.emplace_back((i % n_inside + 0.5) / n_inside - 0.5, (i / n_inside + 0.5) / n_inside - 0.5);
  const render::PixelSample first = reference.sample(0, {x, y});
  Content found = Content::one_facet;
  double nearest = first.t_mm, farthest = first.t_mm;
  for (const Eigen::Vector2d& p : at) {
    const render::PixelSample s = reference.sample(0, {x + p.x(), y + p.y()});
    if (s.lit != first.lit || s.object != first.object) return Content::edge;
    if (s.triangle != first.triangle) found = Content::one_surface;
    nearest = std::min(nearest, s.t_mm);
    farthest = std::max(farthest, s.t_mm);
  }
  // A fold of one surface hides a part of it.
  return found == Content::one_surface && farthest - nearest > 0.5 ? Content::edge : found;
}

bool all_lit_around(const Twin& twin, const render::Reference& reference, int x, int y) {
  const Lens& lens = twin.cameras[0].lens;
  if (x == 0 || y == 0 || x + 1 == lens.width() || y + 1 == lens.height()) return false;
  for (int k = 0; k < 9; ++k)
    if (!reference.sample(0, {x + k % 3 - 1, y + k / 3 - 1}).lit) return false;
  return true;
}

// Gauss nodes: 12 x 12 on one facet; 48 x 48 on several, where creases bend what is averaged; 160 x 160 at
// edges. Pixels of several facets, with no edge in them or beside them, count as interior, too.
std::vector<ReferenceBlockPixel> careful_truth(const Twin& twin, const PixelBlock& block) {
  const render::Reference reference(twin);
  auto truth = reference_block(reference, 0, block, {.gauss_n = 12});
#pragma omp parallel for schedule(dynamic)
  for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(truth.size()); ++i) {
    auto& p = truth[static_cast<std::size_t>(i)];
    const Content what = content(reference, p.x, p.y);
    if (what != Content::one_facet)
      p.pixel = reference.pixel(0, p.x, p.y, {.gauss_n = what == Content::edge ? 160 : 48});
    if (what == Content::one_surface) p.interior = all_lit_around(twin, reference, p.x, p.y);
  }
  return truth;
}

render::Sampling adaptive(const Twin& twin) {
  RenderOptions options;
  options.sampler = Sampler::adaptive;
  return render::choose_sampling(twin, options);
}

void expect_kept_promise(const Twin& twin, const PixelBlock& block, double most_rays) {
  const render::Sampling sampling = adaptive(twin);
  const auto rendered = shared_renderer()->render(twin, 0, sampling);
  ASSERT_TRUE(rendered.estimate);
  const auto truth = careful_truth(twin, block);
  const Agreement interior = compare(twin, 0, rendered.irradiance, truth);
  const Agreement all = compare(twin, 0, rendered.irradiance, truth, Pixels::all);
  const double n_pixels = static_cast<double>(rendered.object.size());
  fmt::print(
      "interior {}\nall {}\nestimate {:.2e} rad, gray {:.2e}; mixed {:.4f}, facets {:.4f}, smooth {:.4f}; "
      "{:.2f} rays per pixel\n",
      interior.text(), all.text(), rendered.estimate->phase_rad, rendered.estimate->gray,
      rendered.estimate->mixed_share, rendered.estimate->facets_share, rendered.estimate->smooth_share,
      static_cast<double>(rendered.rays) / n_pixels);
  if (interior.n > 0) {
    EXPECT_LE(interior.worst_phase_rms_rad(), 4e-5);
    EXPECT_LE(interior.worst_phase_rms_rad(), rendered.estimate->phase_rad);
  }
  EXPECT_LE(rendered.estimate->gray, sampling.gray_error);
  EXPECT_LE(rendered.estimate->phase_rad, sampling.phase_error_rad);
  // The block lies on the edges: its rms is that of the image times the share it has of all mixed pixels.
  EXPECT_LE(all.gray_rms, sampling.gray_error);
  EXPECT_LE(static_cast<double>(rendered.rays), most_rays * n_pixels);
}

/// A free-form part of 20 * 4^subdivisions flat facets.
Object bumpy_part(int subdivisions) {
  const auto mesh = std::make_shared<Mesh>(make_bumpy_icosphere(subdivisions, 35.0, default_bumps()));
  const Pose pose{rotation_from_vector({0.11, -0.23, 0.37}), {0.0, 0.0, 275.0}};
  return {"part", MeshShape{{}, "mm", pose, false, mesh}, {}};
}

TEST(Adaptive, SphereBeforeAWall) {
  REQUIRE_RENDERER();
  Twin twin = paper_rig();
  twin.objects = {Object{"ball", SphereShape{{0, 0, 250}, 5.0}, {}}, plane_object({0, 0, 300}, {0, 0, -1})};
  expect_kept_promise(twin, block_around(twin, 0, {0, 0, 250}, 116, 3), 6.0);
}

TEST(Adaptive, CylinderAndTiltedWallAtLowResolution) {
  REQUIRE_RENDERER();
  // Phase swings of more than a radian per pixel at the finest pitch: a fixed 2 x 2 rule leaves 1e-2 rad.
  Twin twin = paper_rig();
  const Lens lens = twin.cameras[0].lens;
  twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {400, 400, 119.5, 89.5}, {240, 180}, "coarse camera");
  CylinderShape cylinder;
  cylinder.point_mm = {5, 0, 260};
  cylinder.axis = Eigen::Vector3d(0.2, 1.0, 0.1).normalized();
  cylinder.radius_mm = 12.0;
  twin.objects = {Object{"rod", cylinder, {}}, plane_object({0, 0, 310}, {0.2, 0.1, -1})};
  expect_kept_promise(twin, {0, 0, 240, 180, 5}, 100.0);
}

TEST(Adaptive, FacetedPartBeforeAWall) {
  REQUIRE_RENDERER();
  Twin twin = paper_rig();
  twin.objects = {bumpy_part(5), plane_object({0, 0, 320}, {0, 0, -1})};
  expect_kept_promise(twin, block_around(twin, 0, {-30, 0, 275}, 96, 8), 6.0);
}

// Every pixel of a small view, so that the renderer's estimate and the truth speak of the same pixels.
/// Returns the rays per pixel.
double expect_bounded(const std::string& what, const Twin& twin, int stride,
                      Pixels phase_where = Pixels::interior) {
  SCOPED_TRACE(what);
  const render::Sampling sampling = render::choose_sampling(twin);
  const auto rendered = shared_renderer()->render(twin, 0, sampling);
  EXPECT_EQ(rendered.sampling.sampler, Sampler::adaptive);
  if (!rendered.estimate) throw std::logic_error("no estimate");
  const auto truth = careful_truth(twin, whole_image(twin, 0, stride));
  const Agreement interior = compare(twin, 0, rendered.irradiance, truth, phase_where);
  const Agreement all = compare(twin, 0, rendered.irradiance, truth, Pixels::hit);
  const double rays_per_pixel =
      static_cast<double>(rendered.rays) / static_cast<double>(rendered.object.size());
  fmt::print("{}: {:.1e} rad of {:.1e} inside, {:.1e} of {:.1e} of full scale; {:.1f} rays per pixel\n", what,
             interior.worst_phase_rms_rad(), rendered.estimate->phase_rad, all.gray_rms,
             rendered.estimate->gray, rays_per_pixel);
  EXPECT_GT(interior.n, 0);
  EXPECT_LE(interior.pitches[0].phase_rms_rad, rendered.estimate->phase_rad);
  EXPECT_LE(all.gray_rms, rendered.estimate->gray + 2e-5);
  if (phase_where == Pixels::interior) {
    EXPECT_LE(interior.gray_rms, rendered.estimate->gray_inside + 2e-5);
  }
  // Where the last refinement leaves more than was asked for, the estimate says so.
  EXPECT_LE(all.gray_rms, std::max(sampling.gray_error, rendered.estimate->gray) + 2e-5);
  return rays_per_pixel;
}

Twin ball_before_wall(int width = 140, int height = 100) {
  Twin twin = only_camera(paper_rig(), 0);
  twin.objects = {Object{"ball", SphereShape{{0, 0, 250}, 5.0}, {}}, plane_object({0, 0, 300}, {0.1, 0, -1})};
  return crop_around(std::move(twin), {-4, 0, 250}, width, height);
}

TEST(Adaptive, EstimateBoundsTheErrorWithEachEffect) {
  REQUIRE_RENDERER();
  Twin twin = ball_before_wall();
  twin.projector->ambient = 1.0;
  expect_bounded("ambient light", twin, 4);
  twin = ball_before_wall();
  twin.objects[0].material.specular = 0.3;
  twin.objects[0].material.shininess = 20.0;
  twin.projector->inverse_square = true;
  twin.projector->reference_distance_mm = 250.0;
  twin.projector->blur_px = 1.2;
  expect_bounded("Phong, falloff, blur", twin, 4);
  twin = ball_before_wall();
  twin.objects[0].material.specular = 0.1;
  twin.objects[0].material.specular_model = Material::Specular::ggx;
  twin.objects[0].material.roughness = 0.4;
  twin.cameras[0].vignetting.kind = Vignetting::Kind::cos4;
  expect_bounded("GGX, vignetting", twin, 4);
  twin = ball_before_wall();
  twin.fringes.directions.push_back(twin.fringes.directions[0]);
  twin.fringes.directions[1].axis = Axis::y;
  for (DirectionFringes& d : twin.fringes.directions) d.pitches_px = {13, 14, 15, 16, 18, 20, 24, 32, 48};
  for (DirectionFringes& d : twin.fringes.directions) d.phase_origin_px.assign(9, 0.0);
  expect_bounded("two directions, nine pitches", twin, 4);
  twin = ball_before_wall();
  for (DirectionFringes& d : twin.fringes.directions)
    d.harmonics.assign(3,
                       {{0.004, -0.011}, {-0.003, 0.008}, {0.001, 0.005}, {0.002, -0.003}, {-0.001, 0.002}});
  expect_bounded("harmonics", twin, 4);
  twin.fringes.directions[0].harmonics.assign(3, {{0.1, -0.1}, {0.05, 0.0}});
  expect_bounded("strong harmonics", twin, 4);
  twin = ball_before_wall();
  twin.render.phase_error_rad = 1e-5;
  expect_bounded("double precision", twin, 4);
}

TEST(Adaptive, EstimateBoundsTheErrorOnFacets) {
  REQUIRE_RENDERER();
  Twin twin = only_camera(paper_rig(), 0);
  twin.objects = {bumpy_part(5)};
  expect_bounded("facets", crop_around(twin, {-20, 10, 260}, 120, 90), 4);
  std::get<MeshShape>(twin.objects[0].shape).smooth = true;
  expect_bounded("vertex normals", crop_around(twin, {-20, 10, 260}, 80, 60), 4);
  // The coarser mesh has facets of several pixels here, so that some see one alone.
  twin.objects = {bumpy_part(3)};
  twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {400, 400, 39.5, 29.5}, {80, 60}, "coarse camera");
  expect_bounded("facets, a radian per pixel", twin, 3);
}

// Where the driver cuts loops short, a scan line is shared by several invocations.
TEST(Adaptive, ScanLinesInStretches) {
  REQUIRE_RENDERER();
  const Twin twin = ball_before_wall();
  std::vector<double> rays_per_pixel;
  for (const std::uint32_t stretches : {1U, 4U}) {
    shared_renderer()->set_tuning({.line_stretches = stretches});
    rays_per_pixel.push_back(expect_bounded("scan lines in stretches", twin, 3));
  }
  shared_renderer()->set_tuning({});
  EXPECT_GT(rays_per_pixel[1], rays_per_pixel[0]) << "no line was cut";
}

// Facets of a few pixels, fringes of about a radian per pixel: no ray beyond the first is needed inside.
TEST(Adaptive, EstimateBoundsTheErrorOfHarmonicsOnFacets) {
  REQUIRE_RENDERER();
  Twin twin = only_camera(paper_rig(), 0);
  twin.objects = {bumpy_part(5)};
  twin.fringes.directions[0].harmonics.assign(3, {{0.02, -0.03}, {-0.01, 0.02}, {0.0, 0.01}});
  expect_bounded("facets, harmonics", crop_around(twin, {-20, 10, 260}, 80, 60), 4);
}

TEST(Adaptive, SmallFacetsAreIntegratedPieceByPiece) {
  REQUIRE_RENDERER();
  Twin twin = only_camera(paper_rig(), 0);
  twin.objects = {bumpy_part(5)};
  twin.cameras[0].lens =
      Lens("LENSMODEL_PINHOLE", {1180, 1180, 359.5, 269.5}, {720, 540}, "half-size camera");
  twin = crop_around(twin, {-5, 5, 245}, 120, 90);
  EXPECT_LE(expect_bounded("facets of five pixels", twin, 4, Pixels::hit), 10.0);
}

// Lit up to the camera's outline: there a pixel's square and what lies just beside it hold up to 32 facets
// seen edge-on, under fringes of several radian per pixel.
TEST(Adaptive, LitOutlineOfManyFacets) {
  REQUIRE_RENDERER();
  Twin twin = only_camera(paper_rig(), 1);
  twin.objects = {bumpy_part(6)};
  const Eigen::Vector3d middle(0, 0, 275), eye = twin.cameras[0].T_cam_world.inverse().translation_mm;
  const Eigen::Vector3d left = (middle - eye).normalized().cross(Eigen::Vector3d::UnitY());
  for (const double side : {-1.0, 1.0}) {
    SCOPED_TRACE(side);
    expect_bounded("lit outline", crop_around(twin, middle + side * 33.5 * left, 48, 64), 3);
  }
}

// What the adaptive trace does not know is rendered by a fixed rule, and said so.
TEST(Adaptive, StandsBackWhereItDoesNotApply) {
  REQUIRE_RENDERER();
  const auto sampler = [](const Twin& twin) {
    return shared_renderer()->render(twin, 0, render::choose_sampling(twin)).sampling.sampler;
  };
  Twin twin = ball_before_wall(24, 16);
  EXPECT_EQ(sampler(twin), Sampler::adaptive);
  twin.projector->optics = Optics{4.0, 15.0, 250.0};
  EXPECT_EQ(sampler(twin), Sampler::gauss);
  twin = ball_before_wall(24, 16);
  twin.cameras[0].optics = Optics{4.0, 12.0, 250.0};
  EXPECT_EQ(sampler(twin), Sampler::gauss);
  twin = ball_before_wall(24, 16);
  twin.render.bounces = 1;  // apart from the direct light
  EXPECT_EQ(sampler(twin), Sampler::adaptive);
  twin = ball_before_wall(24, 16);
  twin.projector->response.kind = ProjectorResponse::Kind::gamma;
  twin.projector->response.gamma = 2.2;
  EXPECT_EQ(sampler(twin), Sampler::gauss);
  twin = ball_before_wall(24, 16);
  twin.fringes.directions[0].pitches_px = {20};
  twin.fringes.directions[0].phase_origin_px = {0};
  twin.fringes.directions[0].gray = GrayCode{};
  twin.fringes.directions[0].gray->bits = 6;
  twin.fringes.unwrap = Unwrap::gray;
  EXPECT_EQ(sampler(twin), Sampler::gauss);
  twin = ball_before_wall(24, 16);
  twin.fringes.waveform = {Waveform::Kind::levels, {1.0, 0.0, 0.0, 1.0}};
  twin.projector->blur_px = 1.5;
  EXPECT_EQ(sampler(twin), Sampler::gauss);
  twin = ball_before_wall(24, 16);
  twin.projector->blur_field_px2 = {0.0, 0.0, 1.0, 0.0, 0.0};
  EXPECT_EQ(sampler(twin), Sampler::gauss);
  twin = ball_before_wall(24, 16);
  twin.room.lamp_world = {0.0, 0.0, -1.0};
  EXPECT_EQ(sampler(twin), Sampler::gauss);
  twin = ball_before_wall(24, 16);
  twin.projector->light_field = {0.1, 0.0, -0.5, 0.0, -0.5};
  EXPECT_EQ(sampler(twin), Sampler::adaptive);
}

// Outline before nothing and terminator, both clipped: across the part from one to the other.
TEST(Adaptive, OutlineAndTerminatorOfAFacetedPart) {
  REQUIRE_RENDERER();
  Twin twin = only_camera(paper_rig(), 0);
  twin.objects = {bumpy_part(5)};
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(-34, 0, 275), Eigen::Vector3d(33, 0, 275)})
    expect_bounded("outline or terminator", crop_around(twin, p, 60, 48), 3);
}

TEST(Adaptive, SameBitsEveryTime) {
  REQUIRE_RENDERER();
  Twin twin = paper_rig();
  twin.objects = {Object{"ball", SphereShape{{0, 0, 250}, 5.0}, {}}};
  const auto a = shared_renderer()->render(twin, 0, adaptive(twin));
  const auto b = shared_renderer()->render(twin, 0, adaptive(twin));
  for (std::size_t i = 0; i < a.irradiance.size(); ++i) EXPECT_EQ(a.irradiance[i].data, b.irradiance[i].data);
}

}  // namespace
}  // namespace fringetwin::testing::adaptive_test
