// SPDX-License-Identifier: Apache-2.0
// The renderer with its default sampling against the double-precision reference (8x8 Gauss-Legendre)
// on the paper's rig at 1440x1080, interior pixels (docs/CONVENTIONS.md), every pitch.
// | tolerance | unit                 | origin                                                    |
// |-----------|----------------------|-----------------------------------------------------------|
// | 4e-5      | rad rms              | required; largest seen 3.7e-5 (tilted plane)                |
// | 5e-5      | full scale rms       | required                                                  |
// | 5e-4      | full scale rms       | 2x2 points on pixels that an edge between facets crosses    |
// | 1e-8      | rad rms              | 8x8 against 16x16 Gauss-Legendre inside the reference      |
#include <gtest/gtest.h>

#include <iostream>

#include "tests/support/agreement.hpp"
#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::shapes_test {
namespace {

void expect_agreement(const Twin& twin, const Eigen::Vector3d& center_mm, int side, int stride,
                      double phase_limit_rad, int at_least) {
  const render::Sampling sampling = render::choose_sampling(twin);
  for (std::size_t camera = 0; camera < twin.cameras.size(); ++camera) {
    const PixelBlock block =
        side > 0 ? block_around(twin, camera, center_mm, side, stride) : whole_image(twin, camera, stride);
    const Agreement a = agreement(twin, camera, sampling, block);
    std::cout << twin.objects[0].name << ", " << twin.cameras[camera].name << ", " << sampling.samples
              << " samples: " << a.text() << "\n";
    EXPECT_GE(a.n, at_least);
    ASSERT_EQ(a.pitches.size(), 3u);
    for (const PitchAgreement& p : a.pitches) EXPECT_LE(p.phase_rms_rad, phase_limit_rad);
    EXPECT_LE(a.gray_rms, 5e-5);
  }
}

TEST(Shapes, IdealSphere) {
  REQUIRE_RENDERER();
  expect_agreement(with_object(paper_rig(), "sphere R 5", ideal_sphere()), {0, 0, 250}, 120, 3, 4e-5, 500);
}

TEST(Shapes, PhysicalSphere) {
  REQUIRE_RENDERER();
  expect_agreement(with_object(paper_rig(), "sphere R 19", physical_sphere()), physical_sphere().center_mm,
                   400, 9, 4e-5, 500);
}

TEST(Shapes, FullFramePlane) {
  REQUIRE_RENDERER();
  expect_agreement(with_object(paper_rig(), "frontal plane", frontal_plane()), {}, 0, 29, 4e-5, 1000);
}

TEST(Shapes, TiltedPlane) {
  REQUIRE_RENDERER();
  expect_agreement(with_object(paper_rig(), "tilted plane", tilted_plane()), {}, 0, 29, 4e-5, 1000);
}

TEST(Shapes, Cylinder) {
  REQUIRE_RENDERER();
  expect_agreement(with_object(paper_rig(), "cylinder", upright_cylinder()), upright_cylinder().point_mm, 400,
                   9, 4e-5, 300);
}

/// Turned, so that no edge runs along the rows or columns of an image.
MeshShape freeform(int subdivisions, bool smooth) {
  const auto mesh = std::make_shared<Mesh>(make_bumpy_icosphere(subdivisions, 35.0, default_bumps()));
  return {{}, "mm", {rotation_from_vector({0.11, -0.23, 0.37}), {0.0, 0.0, 275.0}}, smooth, mesh};
}

// Facets of 5 px leave few pixels whose nine neighbours each lie inside a facet, nearly all of them in
// the left camera's middle.
TEST(Shapes, FreeformMesh) {
  REQUIRE_RENDERER();
  for (bool smooth : {false, true}) {
    const Twin twin = with_object(paper_rig(), "mesh", freeform(6, smooth));
    const Agreement a =
        agreement(twin, 0, render::choose_sampling(twin), block_around(twin, 0, {0, 0, 240}, 140, 1));
    std::cout << (smooth ? "smooth" : "facets") << " mesh of 81,920 triangles: " << a.text() << "\n";
    EXPECT_GE(a.n, 100);
    EXPECT_LE(a.worst_phase_rms_rad(), 4e-5);
    EXPECT_LE(a.gray_rms, 5e-5);
  }
}

// Facets of 40 px: the limits of the analytic shapes hold, too.
TEST(Shapes, CoarseMesh) {
  REQUIRE_RENDERER();
  expect_agreement(with_object(paper_rig(), "mesh of 1,280 facets", freeform(3, false)), {0, 0, 240}, 420, 6,
                   4e-5, 500);
}

// All lit pixels, not only those inside one facet: what a measurement of the mesh really sees.
TEST(Shapes, FreeformMeshAcrossFacets) {
  REQUIRE_RENDERER();
  const Twin twin = with_object(paper_rig(), "mesh", freeform(6, false));
  const Agreement a = agreement(twin, 0, render::choose_sampling(twin),
                                block_around(twin, 0, {0, 0, 240}, 300, 9), Pixels::hit, {.gauss_n = 32});
  std::cout << "mesh, all lit pixels: " << a.text() << "\n";
  EXPECT_GE(a.n, 1000);
  EXPECT_LE(a.worst_phase_rms_rad(), 4e-5);
  EXPECT_LE(a.gray_rms, 5e-4);
}

TEST(Shapes, TheReferenceItselfHasConverged) {
  for (const auto& [shape, center] : {std::pair<Shape, Eigen::Vector3d>{ideal_sphere(), {0, 0, 250}},
                                      {frontal_plane(), {0, 0, 300}},
                                      {upright_cylinder(), {4, 2, 275}}}) {
    const Twin twin = with_object(paper_rig(), "object", shape);
    const render::Reference reference(twin);
    const PixelBlock block = block_around(twin, 1, center, 80, 10);
    const auto coarse = reference_block(reference, 1, block, {.gauss_n = 8});
    const auto fine = reference_block(reference, 1, block, {.gauss_n = 16});
    int n = 0;
    for (std::size_t i = 0; i < fine.size(); ++i) {
      if (!fine[i].interior) continue;
      ++n;
      for (std::size_t p = 0; p < 3; ++p)
        EXPECT_NEAR(std::atan2(coarse[i].pixel.sine[0][p], coarse[i].pixel.cosine[0][p]),
                    std::atan2(fine[i].pixel.sine[0][p], fine[i].pixel.cosine[0][p]), 1e-8);
    }
    EXPECT_GT(n, 5);
  }
}

}  // namespace
}  // namespace fringetwin::testing::shapes_test
