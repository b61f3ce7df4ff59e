// SPDX-License-Identifier: Apache-2.0
// No tolerances: sentences.
#include "cosim/notes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/paper_rig.hpp"

namespace fringetwin::cosim::notes_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

Twin with_measured_shape() {
  return testing::with_object(testing::with_object(testing::paper_rig(), "wall", testing::frontal_plane()),
                              "part", MeasuredShape{.steps = "odd", .smoothing_px = 2.5});
}

TEST(MeasuredShapeNote, SaysWhatTheObjectIsBuiltFromAndWhatIsCompared) {
  const std::string note = measured_shape_note(with_measured_shape(), {0, 2, 6});
  EXPECT_THAT(note, HasSubstr("The object \"part\" was built from the odd phase steps of this same capture "
                              "(smoothed over 2.5 px) and is compared with the other steps (0, 2, 6)."));
  EXPECT_THAT(note, Not(HasSubstr("by construction")));
}

TEST(MeasuredShapeNote, SaysHowFarWindowsGrow) {
  Twin twin = with_measured_shape();
  std::get<MeasuredShape>(twin.objects.back().shape).most_smoothing_px = 16.0;
  EXPECT_THAT(measured_shape_note(twin, {0}), HasSubstr("(smoothed over 2.5 to 16 px)"));
  std::get<MeasuredShape>(twin.objects.back().shape).most_smoothing_px = 2.0;
  EXPECT_THAT(measured_shape_note(twin, {0}), HasSubstr("(smoothed over 2.5 px)"));
}

TEST(MeasuredShapeNote, SaysThatItsPhaseAgreesWhereNoStepIsLeft) {
  const std::string note = measured_shape_note(with_measured_shape(), {});
  EXPECT_THAT(note, AllOf(HasSubstr("The object \"part\" was built from all phase steps"),
                          HasSubstr("agrees with its phase by construction"), Not(HasSubstr("other steps"))));
}

TEST(MeasuredShapeNote, IsEmptyWithoutSuchAnObject) {
  const Twin twin = testing::with_object(testing::paper_rig(), "wall", testing::frontal_plane());
  EXPECT_EQ(measured_shape_note(twin, {0, 2}), "");
  EXPECT_EQ(measured_shape_note(twin, {}), "");
}

constexpr const char* kIsPublished = "\"ball\" IS the published result";

/// Returns a twin whose "ball" is a sphere, and published numbers of it with these; no number stands twice.
Twin with_published(const PublishedFit& published) {
  Twin twin =
      testing::with_object(testing::with_object(testing::paper_rig(), "wall", testing::frontal_plane()),
                           "ball", SphereShape{.center_mm = {6.5, -5.25, 270.75}, .radius_mm = 19.0});
  twin.real.results = {published};
  return twin;
}
PublishedFit published_ball() {
  return {.object = "ball",
          .numbers = {{"radius_mm", 19.0}, {"rms_mm", 0.013}},
          .vectors = {{"center_mm", {6.5, -5.25, 270.75}}}};
}

TEST(PublishedResultsNote, SaysSoWhereTheObjectIsThePublishedResult) {
  const std::string note = published_results_note(with_published(published_ball()));
  EXPECT_THAT(note, HasSubstr("No images of the physical measurement are at hand"));
  EXPECT_THAT(note, HasSubstr(kIsPublished));
}

// One published number that the object was not given makes its difference one of twin and rig.
TEST(PublishedResultsNote, SaysNoSuchThingWhereAnyNumberDiffers) {
  for (int i = 0; i < 3; ++i) {
    PublishedFit fit = published_ball();
    fit.vectors["center_mm"][i] += 0.001;
    EXPECT_THAT(published_results_note(with_published(fit)),
                AllOf(HasSubstr("only its published numbers"), Not(HasSubstr("IS the published"))))
        << "center_mm " << i;
  }
  PublishedFit radius = published_ball();
  radius.numbers["radius_mm"] = 19.001;
  EXPECT_THAT(published_results_note(with_published(radius)), Not(HasSubstr("IS the published")));
}

TEST(PublishedResultsNote, SaysNoSuchThingOfNumbersThatWereNotPublished) {
  PublishedFit fit = published_ball();
  fit.numbers.erase("radius_mm");
  EXPECT_THAT(published_results_note(with_published(fit)), Not(HasSubstr("IS the published")));
  fit = published_ball();
  fit.vectors.clear();
  EXPECT_THAT(published_results_note(with_published(fit)), Not(HasSubstr("IS the published")));
}

TEST(PublishedResultsNote, SaysNoSuchThingOfOtherObjects) {
  for (const char* other : {"wall", "not in the twin"}) {
    PublishedFit fit = published_ball();
    fit.object = other;
    EXPECT_THAT(published_results_note(with_published(fit)),
                AllOf(HasSubstr("only its published numbers"), Not(HasSubstr("IS the published"))))
        << other;
  }
}

TEST(PublishedResultsNote, IsEmptyWithoutPublishedNumbers) {
  Twin twin = with_published(published_ball());
  twin.real.results.clear();
  EXPECT_EQ(published_results_note(twin), "");
}

}  // namespace
}  // namespace fringetwin::cosim::notes_test
