// SPDX-License-Identifier: Apache-2.0
// What a later exposure does to gray values, against the mixing itself on made-up light; what is asked for by
// which name, refused, and written.
//
// | check                 | tolerance | origin |
// |-----------------------|-----------|----------------------------------------------------------------------|
// | slope of the light    | 1e-4      | light below 10 in single precision, 5e-7 each, over steps of 0.04; |
// |                       |           | the mixing is straight in the begin: no curvature | | slope at a
// border     | 5e-6      | differences of light below 10 in single precision, 5e-7 each         |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "compare/parameters/closed_columns.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/refine/asked_parameters.hpp"
#include "compare/refine/refine.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare::timing_columns_test {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 64, kHeight = 48, kImages = 12;

Twin two_cameras() {
  Twin twin;
  const Lens lens("LENSMODEL_PINHOLE", {900, 905, 31.5, 23.5}, {kWidth, kHeight}, "test");
  twin.cameras.push_back({"left", lens, Pose{}, Sensor{}, std::nullopt});
  twin.cameras.push_back({"right", lens, Pose{}, Sensor{}, std::nullopt});
  twin.projector = Projector{.lens = lens, .T_proj_world = Pose{}, .response = {}};
  twin.fringes.directions = {{Axis::x, {13, 14, 15}, {0, 0, 0}, {}}};
  twin.fringes.steps = 4;
  twin.fringes.unwrap = Unwrap::heterodyne;
  return twin;
}

/// Every third pixel of the second camera, images in another order than projected.
GridSamples samples() {
  GridSamples s;
  s.camera = 1;
  s.grid = {3, 1, 1, 21, 15};
  s.images = {3, 0, 1, 2, 4, 6, 7, 8, 11, 9, 10, 5};
  for (std::size_t i = 0; i < 21 * 15; i += 5) s.cell.push_back(i);
  s.real_dn.resize(s.cell.size() * s.images.size());
  return s;
}

/// What a pattern alone gives a pixel of a row.
double light_of(int image, double x, double y) {
  return 4.0 + 0.02 * x + (2.0 + 0.01 * y) * std::cos(1.7 * image + 0.4 * x + 0.1 * y);
}

/// What the exposure of an image sees, by the time that it has in each pattern.
double seen(const Camera& camera, int image, double x, double y) {
  const ExposureTiming timing = camera.timing.value_or(ExposureTiming{});
  const double begin =
      timing.late_of(static_cast<std::size_t>(image)) + timing.read_out * ((y + 0.5) / kHeight - 0.5);
  double sum = 0.0;
  for (int other = -1; other <= 1; ++other) {
    const double time =
        std::max(0.0, std::min(begin + timing.exposure, other + 1.0) - std::max<double>(begin, other));
    sum += time * light_of(std::clamp(image + other, 0, kImages - 1), x, y);
  }
  return factor_of(camera.exposure_factors, static_cast<std::size_t>(image)) * sum / timing.exposure;
}

std::vector<float> all_seen(const Twin& twin, const GridSamples& s) {
  std::vector<float> values;
  for (std::size_t p = 0; p < s.n_pixels(); ++p)
    for (const int image : s.images)
      values.push_back(
          static_cast<float>(seen(twin.cameras[1], image, 1.0 + 3.0 * static_cast<double>(s.cell[p] % 21),
                                  1.0 + 3.0 * static_cast<double>(s.cell[p] / 21))));
  return values;
}

Twin timed() {
  Twin twin = two_cameras();
  ExposureTiming timing{.exposure = 0.9, .read_out = 0.02};
  for (int k = 0; k < kImages; ++k) timing.late.push_back(k % 3 == 0 ? 0.25 : k % 3 == 1 ? -0.15 : 0.3);
  twin.cameras[1].timing = timing;
  for (int k = 0; k < kImages; ++k) twin.cameras[1].exposure_factors.push_back(1.0 + 0.05 * std::sin(k));
  return twin;
}

Parameter named(const Twin& twin, const std::string& name) {
  for (Parameter& p : parameters_of(twin, "timing"))
    if (p.name == name) return p;
  ADD_FAILURE() << "no parameter " << name;
  return {};
}

Twin moved(const Twin& twin, const Parameter& p, double by) {
  return with_values(twin, {p}, Eigen::VectorXd::Constant(1, p.start + by));
}

// The light of the patterns is found from what the exposures saw, which reach far into their neighbours.
TEST(TimingColumns, SlopesAreThoseOfTheMixing) {
  const Twin twin = timed();
  const GridSamples s = samples();
  const std::vector<float> before = all_seen(twin, s);
  for (const char* name : {"right.image_0.late", "right.image_4.late", "right.image_5.late",
                           "right.image_10.late", "right.timing.read_out"}) {
    SCOPED_TRACE(name);
    const Parameter p = named(twin, name);
    ASSERT_TRUE(p.effect && p.change);
    EXPECT_EQ(p.camera, 1u);
    EXPECT_FALSE(p.is_closed);
    constexpr double kStep = 0.02;
    std::vector<float> slope = before;
    p.effect({twin, twin, s, before, p.start, p.start + 1.0}, slope);
    const std::vector<float> more = all_seen(moved(twin, p, kStep), s),
                             less = all_seen(moved(twin, p, -kStep), s);
    double largest = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      const double difference = (static_cast<double>(more[i]) - static_cast<double>(less[i])) / (2.0 * kStep);
      ASSERT_NEAR(static_cast<double>(slope[i]) - static_cast<double>(before[i]), difference, 1e-4) << i;
      largest = std::max(largest, std::abs(difference));
    }
    EXPECT_GT(largest, 0.5);
  }
}

// Of exposures that begin and end with their patterns a later one sees the next pattern, an earlier one the
// one before: the slope is the mean of both.
TEST(TimingColumns, AtABorderTheSlopeIsTheMeanOfBothSides) {
  const Twin twin = two_cameras();
  const GridSamples s = samples();
  const std::vector<float> before = all_seen(twin, s);
  const Parameter p = named(twin, "right.image_6.late");
  std::vector<float> slope = before;
  p.effect({twin, twin, s, before, 0.0, 1.0}, slope);
  for (std::size_t pixel = 0; pixel < s.n_pixels(); ++pixel)
    for (std::size_t k = 0; k < s.images.size(); ++k) {
      const double x = 1.0 + 3.0 * static_cast<double>(s.cell[pixel] % 21),
                   y = 1.0 + 3.0 * static_cast<double>(s.cell[pixel] / 21);
      const std::size_t i = pixel * s.images.size() + k;
      const double expected = s.images[k] == 6 ? 0.5 * (light_of(7, x, y) - light_of(5, x, y)) : 0.0;
      ASSERT_NEAR(static_cast<double>(slope[i]) - static_cast<double>(before[i]), expected, 5e-6);
    }
}

TEST(TimingColumns, ANumberPerImageAndTheReadOutOfEachCamera) {
  Twin twin = two_cameras();
  EXPECT_EQ(parameters_of(twin, "timing").size(), 2u * (kImages + 1));
  // beside images that are not compared what a pattern gives is not known: those are rendered
  for (const Parameter& p : parameters_of(twin, "timing", {0, 1, 2}))
    EXPECT_EQ(static_cast<bool>(p.effect), p.name.ends_with("image_1.late") || p.name.ends_with("_0.late") ||
                                               p.name.ends_with("_5.late") || p.name.ends_with("_9.late"))
        << p.name;
  const Parameter late = named(twin, "left.image_3.late"), read_out = named(twin, "left.timing.read_out");
  EXPECT_EQ(late.smallest, -0.5);  // with a read-out of 1, the most
  EXPECT_EQ(late.largest, 0.5);
  EXPECT_EQ(read_out.smallest, 0.0);
  EXPECT_EQ(read_out.largest, 1.0);
  twin.projector.reset();
  EXPECT_TRUE(parameters_of(twin, "timing").empty());
}

std::string refusal(const Twin& twin, const std::vector<std::string>& asked) {
  try {
    check_refine(twin, asked);
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(TimingColumns, OfThreeStepsItIsNotTold) {
  Twin twin = two_cameras();
  EXPECT_EQ(refusal(twin, {"timing"}), "");
  EXPECT_EQ(refusal(twin, {"left.timing"}), "");
  for (const Parameter& p : refinable_parameters(twin, {"left"})) EXPECT_NE(p.group, "timing");
  EXPECT_EQ(refinable_parameters(twin, {"left.timing"}).size(), 1u);
  twin.fringes.steps = 3;
  EXPECT_THAT(refusal(twin, {"timing"}),
              HasSubstr("timing is told by 4 phase steps or more, the twin has 3"));
}

// Without a rendering the light of an image would stay its own, and late exposures see that of the next.
TEST(TimingColumns, TheLightOfImagesIsRenderedBesideIt) {
  const Twin twin = two_cameras();
  const auto is_rendered = [](const Parameter& p) { return p.group != "light" || !p.is_closed; };
  EXPECT_TRUE(std::ranges::all_of(refinable_parameters(twin, {"light", "timing"}), is_rendered));
  EXPECT_FALSE(std::ranges::all_of(refinable_parameters(twin, {"light"}), is_rendered));
  EXPECT_TRUE(std::ranges::all_of(parameters_of(timed(), "light"), is_rendered));
}

TEST(TimingColumns, IsWrittenAsItIsRead) {
  const Twin before = two_cameras();
  Twin after = before;
  after.cameras[1].timing = ExposureTiming{.exposure = 1.0, .read_out = 0.25, .late = {}};
  EXPECT_THAT(refined_toml({}, before, after),
              HasSubstr("[camera.timing]  # \"right\"\nread_out = 0.25\n\n"));
  after = moved(before, named(before, "left.image_2.late"), 0.125);
  EXPECT_THAT(refined_toml({}, before, after),
              HasSubstr("[camera.timing]  # \"left\"\nlate = [0, 0, 0.125, 0, 0, 0, 0, 0, 0, 0, 0, 0]\n\n"));
  Twin all_late = before;
  all_late.cameras[0].timing = ExposureTiming{.exposure = 1.0, .read_out = 0.0, .late = {0.125}};
  EXPECT_THAT(refined_toml({}, before, all_late), HasSubstr("late = 0.125\n"));
  EXPECT_EQ(moved(all_late, named(all_late, "left.image_2.late"), 0.25).cameras[0].timing->late_of(2), 0.375);
  EXPECT_THAT(refined_toml({}, all_late, all_late), ::testing::Not(HasSubstr("timing")));
}

}  // namespace
}  // namespace fringetwin::compare::timing_columns_test
