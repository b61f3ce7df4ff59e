// SPDX-License-Identifier: Apache-2.0
// Ctrl-C outside rendering ends the work; and fringes that cannot be unwrapped are refused before it.
// No tolerances.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include "measure/measurement.hpp"
#include "tests/support/measure/measure_rig.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::measure::cancel_test {
namespace {

using ::testing::HasSubstr;

template <class Work>
bool is_cancelled(const Work& work) {
  try {
    work();
  } catch (const Cancelled&) {
    return true;
  }
  return false;
}

std::vector<CameraImages> gray_images(const Twin& twin) {
  std::vector<CameraImages> all;
  for (const Camera& camera : twin.cameras) {
    CameraImages images;
    images.camera = camera.name;
    images.images.assign(expand_sequence(twin.fringes).size(),
                         ImageF(camera.lens.width(), camera.lens.height(), 100.0f));
    all.push_back(images);
  }
  return all;
}

// In a process of its own: a cancelled program stays cancelled.
TEST(CancelDeathTest, MeasuringLoadingAndWritingStop) {
  EXPECT_EXIT(
      {
        const Twin twin = testing::scaled_paper_rig(0.1);
        const std::vector<CameraImages> images = gray_images(twin);
        const std::filesystem::path dir =
            std::filesystem::temp_directory_path() / ("fringetwin_cancel_" + std::to_string(::getpid()));
        install_cancel_handler();
        const bool ran = !is_cancelled([&] { measure(twin, images); });
        raise(SIGINT);
        const bool measured = !is_cancelled([&] { measure(twin, images); });
        Measurement m;
        m.cameras.resize(1);
        const bool wrote = !is_cancelled([&] { write_measurement(dir, m); });
        const bool wrote_images = !is_cancelled([&] { write_camera_radiance(dir, images[0]); });
        std::filesystem::remove_all(dir);
        _exit(ran && !measured && !wrote && !wrote_images ? 0 : 1);
      },
      ::testing::ExitedWithCode(0), "");
}

std::string refusal(const Twin& twin) {
  try {
    check_fringes(twin);
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
    return e.what();
  }
  return "";
}

TEST(CheckFringes, WhatMeasureWouldRefuse) {
  Twin twin = testing::scaled_paper_rig();
  EXPECT_EQ(refusal(twin), "");
  DirectionFringes& x = twin.fringes.directions.at(0);
  x.pitches_px = {10, 20, 30};
  EXPECT_THAT(refusal(twin), HasSubstr("does not cover the projector"));
  twin.fringes.unwrap = Unwrap::none;
  EXPECT_EQ(refusal(twin), "");
  twin.fringes.unwrap = Unwrap::hierarchical;
  EXPECT_THAT(refusal(twin), HasSubstr("the coarsest pitch of 30 px does not cover"));
  twin.projector.reset();  // pitches are nominal units then: no size to cover
  EXPECT_EQ(refusal(twin), "");
}

}  // namespace
}  // namespace fringetwin::measure::cancel_test
