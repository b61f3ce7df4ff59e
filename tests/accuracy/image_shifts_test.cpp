// SPDX-License-Identifier: Apache-2.0
// Patterns that lie further in some images: each is the image of a rig whose patterns all lie there.
// | tolerance | unit           | origin                                                               |
// |-----------|----------------|----------------------------------------------------------------------|
// | 2e-6      | of the mean    | phases of some turns in single precision, 6e-8 each; sums of 36 rays |
// | 4e-5      | rad rms        | as for the shapes (shapes_test.cpp)                                  |
// | 5e-5      | full scale rms | as for the shapes                                                    |
// | 0         |                | off = bitwise the same image                                         |
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::image_shifts_test {
namespace {

Twin window() {
  Twin twin = with_object(left_window({0, 0, 250}, 120, 90), "sphere", ideal_sphere());
  twin.projector->ambient = 0.3;
  return twin;
}
/// Every third image as it should be.
Twin with_shifts(Twin twin) {
  const std::size_t n = expand_sequence(twin.fringes).size();
  for (std::size_t i = 0; i < n; ++i)
    twin.projector->image_shifts_px.push_back(i % 3 == 2 ? 0.0
                                                         : 1.7 * std::sin(1.0 + static_cast<double>(i)));
  return twin;
}
/// The rig whose patterns all lie so much further.
Twin moved(Twin twin, double shift_px) {
  twin.projector->image_shifts_px.clear();
  for (DirectionFringes& d : twin.fringes.directions)
    for (double& origin_px : d.phase_origin_px) origin_px += shift_px;
  return twin;
}

/// Holds each image against that of the rig whose patterns lie there.
void expect_each_moved(const Twin& twin) {
  const Twin shifted = with_shifts(twin);
  const render::RenderedCamera all = render_fixed(shifted), unmoved = render_fixed(twin);
  double changed = 0.0;
  for (std::size_t i = 0; i < all.irradiance.size(); ++i) {
    const double shift_px = shifted.projector->image_shifts_px[i];
    const ImageF expected = render_fixed(moved(twin, shift_px)).irradiance[i];
    for (std::size_t k = 0; k < expected.size(); ++k) {
      const auto e = static_cast<double>(expected.data[k]),
                 e0 = static_cast<double>(unmoved.irradiance[i].data[k]);
      ASSERT_NEAR(static_cast<double>(all.irradiance[i].data[k]), e, 2e-6 * (e + e0 + 40.0)) << i << ' ' << k;
      changed = std::max(changed, std::abs(e - e0));
    }
    if (shift_px == 0.0) {
      EXPECT_EQ(all.irradiance[i].data, unmoved.irradiance[i].data);
    }
  }
  EXPECT_GT(changed, 1.0);
}

TEST(ImageShifts, OffChangesNoBit) {
  REQUIRE_RENDERER();
  Twin twin = window();
  const auto before = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  twin.projector->image_shifts_px.assign(12, 0.0);
  expect_same_bits(before, shared_renderer()->render(twin, 0, render::choose_sampling(twin)));
}

TEST(ImageShifts, PlainFringes) {
  REQUIRE_RENDERER();
  expect_each_moved(window());
}

TEST(ImageShifts, HarmonicsMoveAlong) {
  REQUIRE_RENDERER();
  Twin twin = window();
  for (DirectionFringes& d : twin.fringes.directions) d.harmonics.assign(3, {{0.02, -0.03}, {0.0, 0.02}});
  expect_each_moved(twin);
}

TEST(ImageShifts, StepsEvaluatedOneByOne) {
  REQUIRE_RENDERER();
  Twin twin = window();
  twin.projector->response = {ProjectorResponse::Kind::table, 1.0, {0.0, 0.3, 0.4, 1.0}};
  expect_each_moved(twin);
}

TEST(ImageShifts, GrayCodeSharpAndBlurred) {
  REQUIRE_RENDERER();
  Twin twin = window();
  twin.fringes.unwrap = Unwrap::gray;
  DirectionFringes& x = twin.fringes.directions[0];
  x.pitches_px = {16.0};
  x.phase_origin_px = {0.0};
  x.gray = GrayCode{.bits = 7, .complementary = true};
  for (const double blur_px : {0.0, 0.8, 6.0}) {  // edges that stand alone, and that overlap
    twin.projector->blur_px = blur_px;
    expect_each_moved(twin);
  }
}

TEST(ImageShifts, AgreeWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = with_shifts(window());
  expect_agreement(twin, "shift per image", 200);
  twin.projector->blur_px = 1.5;
  twin.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  expect_agreement(twin, "shift per image, gamma and blur", 200);
}

}  // namespace
}  // namespace fringetwin::testing::image_shifts_test
