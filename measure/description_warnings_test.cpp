// SPDX-License-Identifier: Apache-2.0
// What measured images say of their own description, through the whole chain: right ones nothing, and
// exchanged cameras what they are. The images are made per pixel from rays and the projected pattern's
// definition.
#include "measure/description_warnings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "tests/support/measure/measure_rig.hpp"

namespace fringetwin::measure::description_warnings_test {
namespace {

using namespace testing;
using ::testing::AnyOf;
using ::testing::HasSubstr;

/// A tilted wall, which fills both images.
RaySurface wall() { return plane_surface({0, 0, 270}, Eigen::Vector3d(0.1, 0.2, -1).normalized()); }

/// 8-bit images of what was shown; `gamma` of the projector.
CameraImages shown_images(const Twin& twin, std::size_t camera, const Fringes& shown, double gamma) {
  const CameraDecode truth = ideal_decode(twin, camera, wall());
  CameraImages images;
  images.camera = twin.cameras[camera].name;
  for (const PatternSpec& pattern : expand_sequence(shown)) {
    ImageF image(truth.width(), truth.height(), 0.0f);
    for (std::size_t i = 0; i < image.size(); ++i)
      if (const double c = truth.directions[0].coordinate_px.data[i]; std::isfinite(c))
        image.data[i] =
            static_cast<float>(std::round(210.0 * std::pow(pattern_value(shown, pattern, c), gamma)));
    images.images.push_back(std::move(image));
  }
  return images;
}

struct Rig {
  Twin twin = scaled_paper_rig(0.5);
  Fringes shown = twin.fringes;
  double gamma = 1.0;
  bool exchanged = false;
  std::optional<std::size_t> repeats;  ///< the image of camera 0 that the next one repeats

  std::vector<std::string> doubts() const {
    std::vector<CameraImages> images;
    for (const std::size_t camera : {0u, 1u})
      images.push_back(shown_images(twin, exchanged ? 1 - camera : camera, shown, gamma));
    if (repeats) images[0].images.at(*repeats + 1) = images[0].images.at(*repeats);
    std::vector<std::string> out;
    for (const Doubt& doubt : description_warnings(twin, images, measure(twin, images), nullptr))
      out.push_back(doubt.sentence);
    return out;
  }
};

TEST(DescriptionWarnings, NothingOfARightTwin) {
  EXPECT_THAT(Rig().doubts(), ::testing::IsEmpty());
  Rig rig;
  rig.gamma = 2.2;  // which the phase steps contradict, but neither pitches nor cameras
  EXPECT_THAT(rig.doubts(),
              ::testing::Each(::testing::Not(AnyOf(HasSubstr("pitches_px says"), HasSubstr("it would be")))));
}

TEST(DescriptionWarnings, ExchangedCameras) {
  Rig rig;
  rig.exchanged = true;
  EXPECT_THAT(rig.doubts(), ::testing::ElementsAre(HasSubstr("\" exchanged it would be")));
}

TEST(DescriptionWarnings, AWrongPitchIsNamedAndNoOriginThatSeemsToMendIt) {
  Rig rig;
  rig.shown.directions.at(0).pitches_px.at(1) *= 1.004;
  EXPECT_THAT(rig.doubts(),
              AllOf(::testing::Not(::testing::IsEmpty()), ::testing::Each(HasSubstr("pitches_px says"))));
}

// A camera that missed an image: what its phases say of the pitches is not asked, and no other sentence takes
// the place of this one, though the other camera's pitches are doubted beside it.
TEST(DescriptionWarnings, ARepeatedImageStaysTold) {
  Rig rig;
  rig.repeats = 5;
  const std::string repeated = "image 6 repeats image 5", of_first = '"' + rig.twin.cameras[0].name + '"',
                    of_second = '"' + rig.twin.cameras[1].name + '"';
  const std::vector<std::string> alone = rig.doubts();
  EXPECT_THAT(alone, ::testing::Contains(AllOf(HasSubstr(repeated), HasSubstr(of_first))));
  EXPECT_THAT(alone, ::testing::Each(::testing::Not(HasSubstr("pitches_px says"))));
  rig.shown.directions.at(0).pitches_px.at(1) *= 1.004;
  const std::vector<std::string> both = rig.doubts();
  ASSERT_FALSE(both.empty());
  EXPECT_THAT(both.front(), AllOf(HasSubstr("pitches_px says"), HasSubstr(of_second)));
  EXPECT_THAT(both, ::testing::Contains(AllOf(HasSubstr(repeated), HasSubstr(of_first))));
  EXPECT_THAT(both, ::testing::Not(::testing::Contains(
                        AllOf(HasSubstr("pitches_px says"), HasSubstr("camera " + of_first)))));
}

}  // namespace
}  // namespace fringetwin::measure::description_warnings_test
