// SPDX-License-Identifier: Apache-2.0
// Observations that cannot be right are refused with one sentence that names the fault and the view. No
// tolerances: the sentences are compared.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "calib/solve/calibrate.hpp"
#include "tests/support/calib/calib_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::calib::bad_input_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class BadInput : public ::testing::Test {
 protected:
  BadInput() {
    std::mt19937_64 random(11);
    testing::BoardDraw draw;
    draw.n_boards = 8;
    good_ = testing::draw_observations(testing::true_paper_rig(), random, draw);
  }
  View& view(Observations& o, int device, int frame) const {
    return *std::find_if(o.views.begin(), o.views.end(),
                         [&](const View& v) { return v.device == device && v.frame == frame; });
  }
  std::string refusal(const Observations& o, ExitCode code = ExitCode::input) const {
    try {
      calibrate(o, {});
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), code) << e.what();
      return e.what();
    }
    return "nothing was refused";
  }
  Observations good_;
};

TEST_F(BadInput, TheGoodOnesPass) { EXPECT_LT(calibrate(good_, {}).fit.rms_px, 0.16); }

TEST_F(BadInput, AFifthOfADevicesCornersMayBeOutliers) {
  Calibration c = calibrate(good_, {});
  const int n = c.devices[1].fit.n_corners + c.devices[1].fit.n_outliers;
  const auto with_outliers = [&](int n_outliers) {
    c.devices[1].fit.n_outliers = n_outliers;
    c.devices[1].fit.n_corners = n - n_outliers;
  };
  with_outliers(n / 5);
  EXPECT_NO_THROW(check_solution(c, {}));
  with_outliers(n / 5 + 1);
  try {
    check_solution(c, {});
    ADD_FAILURE() << "accepted";
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::no_convergence);
    EXPECT_THAT(e.what(), AllOf(HasSubstr(c.devices[1].name),
                                HasSubstr(std::to_string(n / 5 + 1) + " of its " + std::to_string(n))));
  }
}

TEST_F(BadInput, ReversedBoardInOneDevice) {
  for (const int device : {0, 1, 2}) {
    Observations o = good_;
    std::reverse(view(o, device, 3).corners.begin(), view(o, device, 3).corners.end());
    EXPECT_THAT(refusal(o),
                HasSubstr(o.devices[static_cast<std::size_t>(device)].name + ", view 3: the corners of " +
                          o.devices[static_cast<std::size_t>(device)].name +
                          " run in the reverse order (the board turned by 180 degrees)"));
  }
}

TEST_F(BadInput, ReversedBoardWithTwoDevices) {
  Observations o = good_;
  o.devices.pop_back();
  std::erase_if(o.views, [](const View& v) { return v.device == 2; });
  std::reverse(view(o, 1, 5).corners.begin(), view(o, 1, 5).corners.end());
  EXPECT_THAT(refusal(o), HasSubstr("view 5: the corners of right or of left run in the reverse order"));
}

TEST_F(BadInput, MirroredBoard) {
  Observations o = good_;
  auto& corners = view(o, 2, 1).corners;
  for (auto row = corners.begin(); row != corners.end(); row += o.board.width_n)
    std::reverse(row, row + o.board.width_n);
  EXPECT_THAT(refusal(o),
              HasSubstr("projector, view 1: the corners of projector are mirrored left to right"));
}

TEST_F(BadInput, ADeviceWhoseViewsAreMirrored) {
  for (const int device : {0, 2}) {
    Observations o = good_;
    for (View& v : o.views)
      if (v.device == device)
        for (auto row = v.corners.begin(); row != v.corners.end(); row += o.board.width_n)
          std::reverse(row, row + o.board.width_n);
    EXPECT_THAT(refusal(o), HasSubstr(o.devices[static_cast<std::size_t>(device)].name +
                                      ": 8 of its 8 views have the corners as in a mirror"));
  }
}

TEST_F(BadInput, OneViewOfAnotherBoard) {
  testing::TrueRig rig = testing::true_paper_rig();
  rig.board.spacing_mm = 10.0;
  std::mt19937_64 random(12);
  testing::BoardDraw draw;
  draw.n_boards = 1;
  const Observations other = testing::draw_observations(rig, random, draw);
  Observations o = good_;
  for (int d = 0; d < 3; ++d) view(o, d, 4).corners = other.find(d, 0)->corners;
  EXPECT_THAT(refusal(o), AllOf(HasSubstr("view 4: it shows another board: its corners are"),
                                HasSubstr("of the other views 12 mm")));
  o = good_;
  view(o, 1, 2).corners.resize(70);
  EXPECT_THAT(refusal(o), HasSubstr("right, view 2: has 70 corners, the board has 10 x 8 = 80"));
}

TEST_F(BadInput, SwappedCameras) {
  Observations o = good_;
  for (View& v : o.views)
    if (v.device < 2) v.device = 1 - v.device;
  EXPECT_THAT(refusal(o), AllOf(HasSubstr("right: lies"), HasSubstr("the two cameras look swapped")));
  o = good_;
  std::swap(view(o, 0, 6).corners, view(o, 1, 6).corners);
  EXPECT_THAT(refusal(o), HasSubstr("view 6: the corners of left and right are swapped"));
  o = good_;
  for (View& v : o.views)
    if (v.device > 0) v.device = 3 - v.device;  // the camera's corners given as the projector's
  EXPECT_THAT(refusal(o), AllOf(HasSubstr("lies outside the imager of 1280 x 720"),
                                HasSubstr("are two devices swapped")));
}

TEST_F(BadInput, TooFewViews) {
  EXPECT_THAT(refusal(select_frames(good_, {0, 3, 5})),
              HasSubstr("left: sees the board in 3 views only; at least 4 are needed"));
  Observations o = good_;
  std::erase_if(o.views, [](const View& v) { return (v.device == 0) == (v.frame < 4); });
  EXPECT_THAT(refusal(o), HasSubstr("left: shares 0 views with the other devices"));
}

TEST_F(BadInput, NotANumber) {
  Observations o = good_;
  view(o, 1, 2).corners[13].q_px.y() = std::nan("");
  EXPECT_THAT(refusal(o), HasSubstr("right, view 2: corner 13 (row 1, column 3) is not finite"));
}

TEST_F(BadInput, MillimetresForMetres) {
  Observations o = good_;
  o.board.spacing_mm = 12000.0;  // --object-spacing 12
  EXPECT_THAT(refusal(o), AllOf(HasSubstr("the spacing is in metres, and this looks like millimetres"),
                                HasSubstr("did you mean 0.012?")));
  o.board.spacing_mm = 0.012;
  EXPECT_THAT(refusal(o), HasSubstr("did you mean 0.012?"));
}

TEST_F(BadInput, ABoardThatMoved) {
  Observations o = good_;
  std::mt19937_64 random(13);
  testing::BoardDraw draw;
  draw.n_boards = 1;
  view(o, 1, 4).corners =
      testing::draw_observations(testing::true_paper_rig(), random, draw).find(1, 0)->corners;
  EXPECT_THAT(refusal(o),
              AllOf(HasSubstr("view 4: does not fit with the others"), HasSubstr("a board that moved")));
}

TEST_F(BadInput, AbsurdFocalLength) {
  Observations o = good_;
  o.devices[2].focal_px = 8.0;  // mm
  EXPECT_THAT(refusal(o),
              HasSubstr("projector: a rough focal length of 8 px does not go with an imager of 1280 x 720"));
}

TEST_F(BadInput, UnknownLensModel) {
  CalibrateOptions options;
  options.lensmodel = "LENSMODEL_OPENCV7";
  EXPECT_THROW(calibrate(good_, options), UserError);
}

}  // namespace
}  // namespace fringetwin::calib::bad_input_test
