// SPDX-License-Identifier: Apache-2.0
// tolerance: 1e-12 relative for sums of small integers and one product; the form of six points is their
// range, in single precision (1e-6 of 0.05 mm).
#include "study/run/image_results.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "report/json.hpp"
#include "study/plan/recorded_numbers.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::image_results_test {
namespace {

using study::pick_numbers;
using study::Record;
using ::testing::HasSubstr;

Twin small() {
  const auto file = scratch_folder("image_results") / "twin.toml";
  write_file(file, small_twin());
  return load_twin(file);
}

/// Two cameras of 4 x 2 px; the first sees the ball with five pixels, the second with none.
struct Case {
  Twin twin = small();
  std::vector<render::RenderedCamera> rendered{2};
  std::vector<CameraImages> images{2};
  measure::Measurement measurement;
  mutable std::map<std::string, study::NoiseTheory> theory;

  Case() {
    twin.cameras.push_back(twin.cameras[0]);
    twin.cameras[1].name = "right";
    for (std::size_t c = 0; c < 2; ++c) {
      rendered[c].object = Image<std::int32_t>(4, 2, -1);
      images[c].camera = twin.cameras[c].name;
      images[c].images.assign(12, ImageF(4, 2, 100.0F));
    }
    for (const std::size_t i : {0, 1, 2, 5, 6}) rendered[0].object.data[i] = 0;
  }
  double at(const std::string& path) const {
    const std::vector<Record> records{{path, ""}};
    report::Json result = {{"fits", report::Json::array()}};
    result.update(study::image_results({twin, twin, rendered, images, measurement, theory}, records));
    return pick_numbers(result, records).at(path);
  }
};

TEST(ImageResults, AcquisitionIsImagesTimesTheLongestExposure) {
  Case c;
  EXPECT_EQ(c.at("acquisition.images"), 12.0);
  EXPECT_TRUE(std::isnan(c.at("acquisition.time_s"))) << "no camera says its exposure";
  c.twin.cameras[1].sensor.exposure_ms = 30.0;
  EXPECT_NEAR(c.at("acquisition.time_s"), 0.36, 0.36e-12);
  c.twin.cameras[0].sensor.exposure_ms = 20.0;
  EXPECT_NEAR(c.at("acquisition.time_s"), 0.36, 0.36e-12);
  for (CameraImages& images : c.images) images.white = images.black = ImageF(4, 2, 1.0F);
  EXPECT_EQ(c.at("acquisition.images"), 14.0);
}

TEST(ImageResults, SaturatedCountsPixelsOfObjectsOnce) {
  Case c;
  EXPECT_EQ(c.at("images.left.saturated"), 0.0);
  EXPECT_TRUE(std::isnan(c.at("images.right.saturated"))) << "it sees nothing";
  c.images[0].images[3].as_floats()[1] = 255.0F;
  c.images[0].images[7].as_floats()[1] = 255.0F;  // the same pixel
  c.images[0].images[7].as_floats()[6] = 255.0F;
  c.images[0].images[7].as_floats()[7] = 255.0F;  // of no object
  c.images[0].images[7].as_floats()[0] = 254.0F;
  EXPECT_NEAR(c.at("images.left.saturated"), 2.0 / 5.0, 1e-12);
  c.images[0].white = ImageF(4, 2, 255.0F);
  EXPECT_EQ(c.at("images.left.saturated"), 1.0);
  c.images[0].bit_depth = 10;
  EXPECT_EQ(c.at("images.left.saturated"), 0.0);
}

TEST(ImageResults, MeasuredIsTheShareOfTheFirstCamerasPixels) {
  Case c;
  EXPECT_EQ(c.at("images.left.measured"), 0.0);
  for (const auto& [x, y] : {std::pair{0, 0}, {2, 0}, {1, 1}, {3, 1}})  // the last sees no object
    c.measurement.cloud.q_cam_px.emplace_back(static_cast<float>(x), static_cast<float>(y));
  EXPECT_NEAR(c.at("images.left.measured"), 3.0 / 5.0, 1e-12);
  try {
    c.at("images.right.measured");
    ADD_FAILURE() << "points stand at the first camera's pixels";
  } catch (const UserError& e) {
    EXPECT_THAT(e.what(), HasSubstr("there is: camera, saturated"));
  }
}

measure::ObjectFit fit_of_the_ball() {
  measure::ObjectFit fit;
  fit.object = "ball";
  fit.kind = "sphere";
  return fit;
}

TEST(ImageResults, IndicatorsAreThoseOfTheFits) {
  Case c;
  measure::ObjectFit fit = fit_of_the_ball();
  c.measurement.fits = {fit};
  EXPECT_TRUE(std::isnan(c.at("indicators.ball.sphere_form"))) << "not usable";
  fit.usable = true;
  fit.numbers["radius_mm"] = 19.01;
  fit.deviation_mm = {0.01F, -0.02F, 0.0F, 0.03F, 0.005F, -0.01F};
  c.measurement.fits = {fit};
  EXPECT_NEAR(c.at("indicators.ball.sphere_form"), 0.05, 1e-7);
  EXPECT_NEAR(c.at("indicators.ball.sphere_form_95"), 0.05, 1e-7) << "95 % of six are six";
  EXPECT_NEAR(c.at("indicators.ball.sphere_size"), 0.02, 1e-12);
}

// The measured numbers of such a point are as good as any.
TEST(ImageResults, WhatTheTheoryDoesNotKnowIsNull) {
  Case c;
  c.measurement.fits = {fit_of_the_ball()};
  EXPECT_GT(c.at("theory.ball.radius_sigma_mm"), 0.0);
  c.theory.clear();
  c.twin.cameras[0].psf_px = 2.0;
  for (const char* name : {"n", "rms_mm", "radius_sigma_mm", "center_sigma_mm[2]"})
    EXPECT_TRUE(std::isnan(c.at(std::string("theory.ball.") + name))) << name;
}

TEST(ImageResults, OnlyWhatIsAskedForIsWorkedOut) {
  const Case c;
  EXPECT_EQ(study::image_results({c.twin, c.twin, c.rendered, c.images, c.measurement, c.theory}, {}).dump(),
            "{}");
  EXPECT_EQ(study::image_results({c.twin, c.twin, c.rendered, c.images, c.measurement, c.theory},
                                 {{"acquisition.images", ""}})
                .dump(),
            R"({"acquisition":{"images":12,"time_s":null}})");
}

}  // namespace
}  // namespace fringetwin::testing::image_results_test
