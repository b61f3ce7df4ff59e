// SPDX-License-Identifier: Apache-2.0
// The committed datasets/paper-freeform/freeform.ply is what make_freeform writes.
//
// | tolerance          | value   | origin                                                              |
// | vertex coordinate  | 4e-6 mm | one float spacing at 35-64 mm: libm's exp differs between processors |
#include "tests/support/freeform.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace fringetwin::testing::freeform_test {
namespace {

TEST(Freeform, CommittedFileIsWhatTheGeneratorMakes) {
  const std::filesystem::path file =
      std::filesystem::path(std::getenv("FRINGETWIN_SOURCE")) / "datasets/paper-freeform/freeform.ply";
  const auto committed = load_mesh(file, "mm");
  const Mesh made = make_bumpy_icosphere(6, 35.0, default_bumps());
  ASSERT_EQ(made.triangles.size(), 81920U);
  EXPECT_EQ(committed->triangles, made.triangles);
  ASSERT_EQ(committed->vertices_mm.size(), made.vertices_mm.size());
  for (std::size_t i = 0; i < made.vertices_mm.size(); ++i)
    EXPECT_LE((committed->vertices_mm[i] - made.vertices_mm[i]).cwiseAbs().maxCoeff(), 4e-6F)
        << "vertex " << i;
}

}  // namespace
}  // namespace fringetwin::testing::freeform_test
