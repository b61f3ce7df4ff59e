// SPDX-License-Identifier: Apache-2.0
// What the theory of the noise says that it does not know, and the list of it in the documentation.
// tolerance: none, sentences are compared as they are.
#include "study/noise/theory_scope.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/effects.hpp"

namespace fringetwin::testing::theory_scope_test {
namespace {

using study::outside_noise_theory;
using ::testing::HasSubstr;

/// Returns what is outside of the theory of the small twin with this change.
std::string outside(const std::function<void(Twin&)>& change) {
  const auto file = scratch_folder("theory_scope") / "twin.toml";
  write_file(file, small_twin());
  Twin twin = load_twin(file);
  change(twin);
  return outside_noise_theory(twin, "ball");
}

TEST(TheoryScope, TheKeyIsNamedWithItsValue) {
  EXPECT_EQ(outside([](Twin&) {}), "");
  EXPECT_EQ(outside([](Twin& t) { t.cameras[0].psf_px = 2.0; }), "camera.left.psf_px = 2");
  EXPECT_EQ(outside([](Twin& t) {
              t.cameras[0].optics = Optics{8.0, 25.0, 300.0};
            }),
            "camera.left.optics.f_number = 8");
  EXPECT_EQ(outside([](Twin& t) { t.cameras[0].vignetting.kind = Vignetting::Kind::cos4; }),
            "camera.left.vignetting");
  EXPECT_EQ(outside([](Twin& t) {
              t.projector->optics = Optics{2.0, 12.0, 300.0};
            }),
            "projector.optics.f_number = 2");
  EXPECT_EQ(outside([](Twin& t) { t.projector->pixel_structure = true; }),
            "projector.pixel_structure = true");
  EXPECT_EQ(outside([](Twin& t) { t.fringes.steps = 3; }), "fringes.steps = 3");
  EXPECT_EQ(outside([](Twin& t) { t.render.bounces = 2; }), "render.bounces = 2");
  EXPECT_EQ(outside([](Twin& t) { t.render.bounces = kAllBounces; }), "render.bounces = \"all\"");
  EXPECT_EQ(outside([](Twin& t) { t.measure.smoothing_px = 1.5; }), "measure.smoothing_px = 1.5");
  EXPECT_EQ(outside([](Twin& t) { t.objects[0].material.specular = 0.25; }),
            "object.ball.material.specular = 0.25");
}

TEST(TheoryScope, AnEffectWithoutAWordOfItsOwnIsNamedWithItsKeys) {
  EXPECT_EQ(outside([](Twin& t) { t.projector->quantise_bits = 8; }),
            "pattern rounding ([projector] quantise_bits = 8)");
}

// A new effect that the theory does not count with belongs into the list, too.
TEST(TheoryScope, TheDocumentationListsEveryEffectThatIsOutside) {
  const char* source = std::getenv("FRINGETWIN_SOURCE");
  if (!source) GTEST_SKIP() << "FRINGETWIN_SOURCE is not set";
  const std::string text = read_file(std::filesystem::path(source) / "docs/metrics/study.md");
  const std::size_t begin = text.find("#### Outside of the theory");
  ASSERT_NE(begin, std::string::npos);
  const std::string list = text.substr(begin, text.find("\n## ", begin) - begin);
  for (const Effect& effect : effects())
    EXPECT_EQ(list.find("| " + effect.name + " |") != std::string::npos, !effect.in_noise_theory)
        << effect.name;
}

}  // namespace
}  // namespace fringetwin::testing::theory_scope_test
