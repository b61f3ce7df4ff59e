// SPDX-License-Identifier: Apache-2.0
// Boards drawn at known places.
//
// | check                           | tolerance   | origin                                           |
// |---------------------------------|-------------|--------------------------------------------------|
// | chessboard, ChArUco corners     | 0.1 px rms  | detectors on 8-bit pictures with 2 DN noise      |
// | circles: centroid of the ellipse | 0.05 px rms | the same; closed form of the ellipse's centre     |
// | projector corner, quadratic map | 1e-9 px     | the model holds exactly                          |
// | scatter / its sigma             | 1 ± 0.25    | 3 standard errors of 80 corners x 2              |
#include "calib/board/board_detector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <opencv2/aruco/charuco.hpp>
#include <random>

#include "calib/board/observe.hpp"
#include "calib/board/projector_corners.hpp"
#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::calib::board_detector_test {
namespace {

/// Board plane (in spacings, first corner at 0) -> picture; a perspective view.
Eigen::Matrix3d view_of_board(double roll = 0.15) {
  Eigen::Matrix3d H;
  H << 42.0 * std::cos(roll), -40.0 * std::sin(roll), 130.0, 41.0 * std::sin(roll), 39.0 * std::cos(roll),
      90.0, 0.012, -0.008, 1.0;
  return H;
}

Eigen::Vector2d map(const Eigen::Matrix3d& H, double x, double y) {
  return (H * Eigen::Vector3d(x, y, 1.0)).hnormalized();
}

/// 5 x 5 samples per pixel of a drawing in board coordinates, with noise.
ImageF picture(const Eigen::Matrix3d& H, const std::function<double(double, double)>& level) {
  ImageF image(640, 480);
  std::mt19937_64 random(3);
  std::normal_distribution<float> noise(0.0F, 2.0F);
  const Eigen::Matrix3d back = H.inverse();
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      double sum = 0.0;
      for (int j = -2; j <= 2; ++j)
        for (int i = -2; i <= 2; ++i) {
          const Eigen::Vector2d p = map(back, x + 0.2 * i, y + 0.2 * j);
          sum += level(p.x(), p.y());
        }
      image(x, y) = static_cast<float>(std::round(30.0 + 150.0 * sum / 25.0)) + noise(random);
    }
  return image;
}

double chess_level(const Board& b, double x, double y) {
  if (x < -1.0 || y < -1.0 || x > b.width_n || y > b.height_n) return 1.0;
  return (static_cast<int>(std::floor(x)) + static_cast<int>(std::floor(y))) % 2 == 0 ? 0.0 : 1.0;
}

/// Centre of the ellipse that a circle of this radius (spacings) is mapped to: last column of H C* H^T, C*
/// the circle's dual. Radius 0: the picture of the centre.
Eigen::Vector2d ellipse_centre(const Eigen::Matrix3d& H, double x, double y, double radius) {
  const Eigen::Vector3d c(x, y, 1.0);
  const Eigen::Matrix3d dual =
      c * c.transpose() - radius * radius * Eigen::Matrix3d(Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal());
  return Eigen::Vector3d((H * dual * H.transpose()).col(2)).hnormalized();
}

double rms_error(const std::vector<Corner>& corners, const Board& board, const Eigen::Matrix3d& H, int& n,
                 double radius = 0.0) {
  double sum = 0.0;
  n = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!corners[i].seen()) continue;
    const auto width = static_cast<std::size_t>(board.width_n);
    sum += (corners[i].q_px -
            ellipse_centre(H, static_cast<double>(i % width), static_cast<double>(i / width), radius))
               .squaredNorm();
    ++n;
  }
  return std::sqrt(sum / std::max(n, 1));
}

TEST(BoardDetector, Chessboard) {
  BoardPattern pattern;
  for (const auto& [w, h] : {std::pair{9, 7}, std::pair{8, 6}}) {  // the first looks the same upside down
    pattern.board = {w, h, 10.0};
    const auto corners = find_board(
        picture(view_of_board(), [&](double x, double y) { return chess_level(pattern.board, x, y); }),
        pattern);
    ASSERT_TRUE(corners);
    int n = 0;
    EXPECT_LT(rms_error(*corners, pattern.board, view_of_board(), n), 0.1);
    EXPECT_EQ(n, w * h);
  }
  EXPECT_FALSE(find_board(picture(view_of_board(), [](double, double) { return 1.0; }), pattern));
}

// The squares inside the first and the last corner differ, so both ways up are one order of the corners.
TEST(BoardDetector, AChessboardOfTwoDifferentEndsIsReadFromTheSameOneUpsideDown) {
  const BoardPattern pattern{BoardKind::chessboard, {9, 6, 10.0}};
  const auto level = [&](double x, double y) { return chess_level(pattern.board, x, y); };
  Eigen::Matrix3d upside_down;
  upside_down << -1.0, 0.0, 639.0, 0.0, -1.0, 479.0, 0.0, 0.0, 1.0;
  for (const Eigen::Matrix3d& H : {view_of_board(), Eigen::Matrix3d(upside_down * view_of_board())}) {
    const auto corners = find_board(picture(H, level), pattern);
    ASSERT_TRUE(corners);
    int n = 0;
    EXPECT_LT(rms_error(*corners, pattern.board, H, n), 0.1);
  }
}

TEST(BoardDetector, Circles) {
  BoardPattern pattern;
  pattern.kind = BoardKind::circles;
  pattern.board = {8, 6, 10.0};
  const auto dots = [](double x, double y) {
    return std::hypot(x - std::round(x), y - std::round(y)) < 0.25 ? 0.0 : 1.0;
  };
  const auto grid = [&](double x, double y) {
    return x < -0.5 || y < -0.5 || x > 7.5 || y > 5.5 ? 1.0 : dots(x, y);
  };
  auto corners = find_board(picture(view_of_board(), grid), pattern);
  ASSERT_TRUE(corners);
  int n = 0;
  const double symmetric_px = rms_error(*corners, pattern.board, view_of_board(), n, 0.25);
  EXPECT_LT(symmetric_px, 0.05);
  EXPECT_EQ(n, 48);
  // 4 circles per row, 7 rows: a lattice of 8 x 7 with every second place empty
  pattern.kind = BoardKind::asymmetric_circles;
  pattern.board = {8, 7, 10.0};
  corners = find_board(picture(view_of_board(),
                               [&](double x, double y) {
                                 if (x < -0.5 || y < -0.5 || x > 7.5 || y > 6.5) return 1.0;
                                 return (std::lround(x) + std::lround(y)) % 2 == 0 &&
                                                std::hypot(x - std::round(x), y - std::round(y)) < 0.4
                                            ? 0.0
                                            : 1.0;
                               }),
                       pattern);
  ASSERT_TRUE(corners);
  const double asymmetric_px = rms_error(*corners, pattern.board, view_of_board(), n, 0.4);
  EXPECT_LT(asymmetric_px, 0.05);
  EXPECT_EQ(n, 28);
  std::printf(
      "circles: %.4f and %.4f px rms from the ellipses' centres, the larger ones %.4f px from their own\n",
      symmetric_px, asymmetric_px, rms_error(*corners, pattern.board, view_of_board(), n));
}

TEST(BoardDetector, CharucoAlsoInPart) {
  BoardPattern pattern;
  pattern.kind = BoardKind::charuco;
  pattern.board = {8, 6, 10.0};
  const auto board = cv::aruco::CharucoBoard::create(
      9, 7, 1.0F, 0.75F, cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50));
  cv::Mat drawing;
  board->draw(cv::Size(900, 700), drawing, 0, 1);
  for (const double cut : {99.0, 4.5}) {  // the board ends at this column: partly covered
    const auto level = [&](double x, double y) {
      const auto px = static_cast<int>(std::floor(100.0 * (x + 1.0))),
                 py = static_cast<int>(std::floor(100.0 * (y + 1.0)));
      if (px < 0 || py < 0 || px >= 900 || py >= 700 || x > cut) return 1.0;
      return drawing.at<unsigned char>(py, px) / 255.0;
    };
    const auto corners = find_board(picture(view_of_board(), level), pattern);
    ASSERT_TRUE(corners);
    int n = 0;
    EXPECT_LT(rms_error(*corners, pattern.board, view_of_board(), n), 0.1);
    if (cut > 10.0)
      EXPECT_EQ(n, 48);
    else
      EXPECT_THAT(n, ::testing::AllOf(::testing::Ge(18), ::testing::Le(30)));
  }
}

TEST(BoardDetector, NoBoardInImagesTooSmallForOne) {
  for (const char* kind : {"chessboard", "circles", "asymmetric-circles", "charuco"})
    for (const int side : {1, 2, 9, 30}) {
      ImageF image(side, side);
      for (int i = 0; i < side; ++i) image(i, i) = 255.0F;
      BoardPattern pattern;
      pattern.kind = board_kind(kind);
      pattern.board = {8, 6, 10.0};
      EXPECT_FALSE(find_board(image, pattern)) << kind << " " << side;
    }
}

TEST(BoardDetector, PicturesOfAnotherSizeAreRefused) {
  const testing::ScratchFolder folder;
  write_gray_png(folder / "a.png", ImageF(40, 30), 8);
  try {
    detect_in_pictures({{folder / "a.png", {30, 40, "device \"left\"", "check --imagersize"}}}, {});
    FAIL();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input);
    EXPECT_THAT(e.what(), ::testing::HasSubstr("a.png: is 40 x 30 px, device \"left\" has 30 x 40; width and "
                                               "height are swapped; check --imagersize"));
  }
}

// What is calibrated is the lens of the whole sensor: its corners are told in that one's pixels.
TEST(BoardDetector, CornersOfOneColourAreOfTheWholeSensor) {
  const BoardPattern pattern{BoardKind::chessboard, {9, 6, 10.0}};
  CameraImages images{.camera = "left"};
  images.images.assign(
      3, picture(view_of_board(), [&](double x, double y) { return chess_level(pattern.board, x, y); }));
  for (GrayImage& image : images.images)
    for (float& v : image.as_floats()) v = std::clamp(std::round(v), 0.0F, 255.0F);
  const testing::ScratchFolder folder;
  write_camera_images(folder.path(), images);
  write_capture_toml(folder.path(), {&images}, {}, "png");
  Twin twin;
  twin.fringes.steps = 3;
  twin.fringes.unwrap = Unwrap::none;
  twin.fringes.directions = {{Axis::x, {16.0}, {0.0}, std::nullopt}};
  const auto corners = [&](const Lens& lens, const std::optional<MosaicChannel>& channel) {
    twin.cameras = {{"left", lens, Pose{}, {}, {}}};
    twin.cameras[0].channel = channel;
    return detect_in_captures(twin, {folder.path()}, pattern).at(0).corners;
  };
  const Lens plain("LENSMODEL_PINHOLE", {900, 900, 319.5, 239.5}, {640, 480}, "test");
  const MosaicChannel blue{"RGGB", MosaicColour::blue, {1280, 960}};
  const auto of_image = corners(plain, std::nullopt), of_sensor = corners(plain, blue);
  ASSERT_EQ(of_image.size(), 54u);
  ASSERT_EQ(of_sensor.size(), 54u);
  for (std::size_t i = 0; i < of_image.size(); ++i) {
    EXPECT_EQ(of_sensor[i].q_px, 2.0 * of_image[i].q_px + Eigen::Vector2d(1.0, 1.0));
    EXPECT_EQ(of_sensor[i].weight, of_image[i].weight);
  }
}

TEST(BoardDetector, NamesOfBoards) {
  EXPECT_EQ(board_kind("asymmetric-circles"), BoardKind::asymmetric_circles);
  EXPECT_THROW(board_kind("checker"), UserError);
}

struct Scene {
  measure::CameraDecode decode;
  std::vector<Corner> corners;
  Board board{10, 8, 10.0};
  Eigen::Vector2d truth(const Eigen::Vector2d& q) const {
    return {100.0 + 0.7 * q.x() + 0.05 * q.y() + 1e-4 * q.x() * q.x(),
            50.0 - 0.03 * q.x() + 0.6 * q.y() + 5e-5 * q.x() * q.y()};
  }
};

/// A chessboard of 24-px squares whose black ones do not decode.
Scene scene(double sigma_px, double outlier_share) {
  Scene s;
  s.decode.directions.resize(2);
  s.decode.flags = ImageU8(320, 260, 0);
  s.decode.directions[1].axis = Axis::y;
  for (auto& d : s.decode.directions) d.coordinate_px = ImageD(320, 260, std::nan(""));
  for (int row = 0; row < 8; ++row)
    for (int col = 0; col < 10; ++col) s.corners.push_back({{40.3 + 24.0 * col, 40.7 + 24.0 * row}, 1.0});
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, sigma_px);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int y = 0; y < 260; ++y)
    for (int x = 0; x < 320; ++x) {
      if ((static_cast<int>(std::floor((x - 16.3) / 24.0)) +
           static_cast<int>(std::floor((y - 16.7) / 24.0))) %
              2 ==
          0)
        continue;
      const Eigen::Vector2d q = s.truth(Eigen::Vector2d(x, y));
      const bool outlier = unit(random) < outlier_share;
      s.decode.directions[0].coordinate_px(x, y) = q.x() + noise(random) + (outlier ? 16.0 : 0.0);
      s.decode.directions[1].coordinate_px(x, y) = q.y() + noise(random);
    }
  return s;
}

TEST(ProjectorCorners, ExactWhereTheModelHolds) {
  const Scene s = scene(0.0, 0.0);
  const auto corners = projector_corners(s.decode, s.board, s.corners);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    ASSERT_TRUE(corners[i].seen()) << i;
    EXPECT_LT((corners[i].q_px - s.truth(s.corners[i].q_px)).norm(), 1e-9);
  }
}

TEST(ProjectorCorners, ScatterIsWhatSigmaSaysAndOutliersDoNotCount) {
  const Scene s = scene(0.2, 0.05);
  const auto corners = projector_corners(s.decode, s.board, s.corners);
  double sum = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    ASSERT_TRUE(corners[i].seen()) << i;
    const Eigen::Vector2d error = corners[i].q_px - s.truth(s.corners[i].q_px);
    sum += error.squaredNorm() / std::pow(corners[i].sigma_px, 2);
    largest = std::max(largest, corners[i].sigma_px);
  }
  EXPECT_NEAR(std::sqrt(sum / 160.0), 1.0, 0.25);
  EXPECT_LT(largest, 0.06);
  const auto weighted = weighted_corners({corners});
  for (const Corner& c : weighted[0])
    EXPECT_THAT(c.weight, ::testing::AllOf(::testing::Gt(0.5), ::testing::Le(1.0)));
}

TEST(ProjectorCorners, NothingIsInventedWhereNothingDecodes) {
  Scene s = scene(0.1, 0.0);
  for (auto& d : s.decode.directions)
    for (int y = 0; y < 260; ++y)
      for (int x = 200; x < 320; ++x) d.coordinate_px(x, y) = std::nan("");
  s.corners[3] = {};
  const auto corners = projector_corners(s.decode, s.board, s.corners);
  EXPECT_FALSE(corners[3].seen());
  EXPECT_FALSE(corners[9].seen());
  EXPECT_TRUE(corners[1].seen());
  s.decode.directions.pop_back();
  EXPECT_THROW(projector_corners(s.decode, s.board, s.corners), UserError);
}

}  // namespace
}  // namespace fringetwin::calib::board_detector_test
