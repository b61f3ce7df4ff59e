// SPDX-License-Identifier: Apache-2.0
#include "calib/board/board_detector.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "twin/base/errors.hpp"
#include "twin/base/out_of_memory.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::calib {
namespace {

constexpr int kLeastCharucoCorners = 6;

/// 8 bit, stretched over the middle 99 % of the values (the detectors want contrast, not radiometry).
cv::Mat to_8_bit(const ImageF& image) {
  std::vector<float> values;
  for (const float v : image.data)
    if (std::isfinite(v)) values.push_back(v);
  if (values.empty()) return cv::Mat::zeros(image.height, image.width, CV_8UC1);
  const double low = lower_quantile(values, 0.005);
  const double high = std::max(lower_quantile(values, 0.995), low + 1e-6);
  cv::Mat out(image.height, image.width, CV_8UC1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const float v = image(x, y);
      out.at<unsigned char>(y, x) =
          std::isfinite(v) ? cv::saturate_cast<unsigned char>(255.0 * (v - low) / (high - low)) : 0;
    }
  return out;
}

/// Half the distance to the nearest neighbour, within what cornerSubPix works well with.
int refinement_window(const std::vector<cv::Point2f>& points, int width_n) {
  double least = INFINITY;
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    if ((i + 1) % static_cast<std::size_t>(width_n) != 0)
      least = std::min(least, cv::norm(points[i + 1] - points[i]));
  return std::clamp(static_cast<int>(0.35 * least), 3, 15);
}

/// Moves each point to where the gradients around the corner meet. The detectors' own places are up to 0.5 px
/// off (measured on drawn boards: findChessboardCornersSB 0.3 px, interpolateCornersCharuco 0.7 px; after
/// this below 0.1).
void refine(const cv::Mat& image, std::vector<cv::Point2f>& points, int half) {
  cv::cornerSubPix(image, points, {half, half}, {-1, -1},
                   cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-4));
}

std::vector<cv::Point2f> find_chessboard(const cv::Mat& image, const Board& board) {
  const cv::Size size(board.width_n, board.height_n);
  std::vector<cv::Point2f> points;
  const int robust = cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY;
  const int classic = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  if (!cv::findChessboardCornersSB(image, size, points, robust)) {
    points.clear();
    if (!cv::findChessboardCorners(image, size, points, classic)) return {};
  }
  refine(image, points, refinement_window(points, board.width_n));
  return points;
}

std::vector<cv::Point2f> find_circles(const cv::Mat& image, cv::Size size, int flags) {
  std::vector<cv::Point2f> points;
  for (const bool bright : {false, true}) {  // dark circles on a bright board, or the reverse
    cv::Mat picture = image;
    if (bright) cv::bitwise_not(image, picture);
    for (const int how : {0, static_cast<int>(cv::CALIB_CB_CLUSTERING)})
      if (cv::findCirclesGrid(picture, size, points, flags | how)) return points;
  }
  return {};
}

std::vector<Corner> to_corners(const std::vector<cv::Point2f>& points) {
  std::vector<Corner> corners;
  for (const auto& p : points) corners.push_back({{p.x, p.y}, 1.0});
  return corners;
}

/// Where the board's squares differ at its two ends, the dark one beside the first corner says which end is
/// read first, however the camera stands.
bool is_unique(const Board& board) { return (board.width_n + board.height_n) % 2 != 0; }

/// Puts the first corner where the square inside of it is dark. All squares between corners say so together.
void begin_at_dark(std::vector<Corner>& corners, const Board& board, const cv::Mat& image) {
  double dark = 0.0;  // in DN, of the squares of the first one's colour less the others
  for (int row = 0; row + 1 < board.height_n; ++row)
    for (int col = 0; col + 1 < board.width_n; ++col) {
      const std::size_t i = row * board.width_n + col, below = i + static_cast<std::size_t>(board.width_n);
      const Eigen::Vector2d middle =
          0.25 * (corners[i].q_px + corners[i + 1].q_px + corners[below].q_px + corners[below + 1].q_px);
      const int x = std::clamp(static_cast<int>(std::lround(middle.x())), 0, image.cols - 1),
                y = std::clamp(static_cast<int>(std::lround(middle.y())), 0, image.rows - 1);
      dark += ((row + col) % 2 == 0 ? -1.0 : 1.0) * image.at<unsigned char>(y, x);
    }
  if (dark < 0.0) std::ranges::reverse(corners);
}

/// Rows to the right in the picture.
void make_upright(std::vector<Corner>& corners, int width_n) {
  double dx = 0.0;
  for (std::size_t i = 0; i < corners.size(); i += static_cast<std::size_t>(width_n))
    dx += corners[i + static_cast<std::size_t>(width_n) - 1].q_px.x() - corners[i].q_px.x();
  if (dx < 0.0) std::ranges::reverse(corners);
}

std::optional<std::vector<Corner>> find_regular(const std::vector<cv::Point2f>& points, const Board& board) {
  if (points.size() != board.corners()) return std::nullopt;
  std::vector<Corner> corners = to_corners(points);
  make_upright(corners, board.width_n);
  return corners;
}

/// Row i of OpenCV's asymmetric grid starts at column i % 2 of the lattice and takes every second place.
std::optional<std::vector<Corner>> find_asymmetric(const cv::Mat& image, const Board& board) {
  FT_CHECK(board.width_n % 2 == 0, "the lattice of an asymmetric grid has an even number of columns");
  const int per_row = board.width_n / 2;
  const auto points = find_circles(image, {per_row, board.height_n}, cv::CALIB_CB_ASYMMETRIC_GRID);
  if (points.size() != board.corners() / 2) return std::nullopt;
  std::vector<Corner> corners(board.corners());
  for (int row = 0; row < board.height_n; ++row)
    for (int k = 0; k < per_row; ++k) {
      const auto& p = points[row * per_row + k];
      corners[row * board.width_n + 2 * k + row % 2] = {{p.x, p.y}, 1.0};
    }
  return corners;
}

int dictionary_number(const std::string& name) {
  static const std::map<std::string, int> kKnown{{"DICT_4X4_50", cv::aruco::DICT_4X4_50},
                                                 {"DICT_4X4_100", cv::aruco::DICT_4X4_100},
                                                 {"DICT_4X4_250", cv::aruco::DICT_4X4_250},
                                                 {"DICT_5X5_50", cv::aruco::DICT_5X5_50},
                                                 {"DICT_5X5_100", cv::aruco::DICT_5X5_100},
                                                 {"DICT_5X5_250", cv::aruco::DICT_5X5_250},
                                                 {"DICT_6X6_50", cv::aruco::DICT_6X6_50},
                                                 {"DICT_6X6_100", cv::aruco::DICT_6X6_100},
                                                 {"DICT_6X6_250", cv::aruco::DICT_6X6_250},
                                                 {"DICT_7X7_250", cv::aruco::DICT_7X7_250},
                                                 {"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL}};
  const auto found = kKnown.find(name);
  if (found == kKnown.end())
    throw UserError(ExitCode::usage, "ChArUco dictionary " + name, "is not known", "e.g. DICT_4X4_50");
  return found->second;
}

std::optional<std::vector<Corner>> find_charuco(const cv::Mat& image, const BoardPattern& pattern) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(dictionary_number(pattern.dictionary));
  // Lengths cancel: only their ratio is used without a camera matrix.
  const auto board =
      cv::aruco::CharucoBoard::create(pattern.board.width_n + 1, pattern.board.height_n + 1, 1.0F,
                                      static_cast<float>(pattern.marker_to_square), dictionary);
  std::vector<std::vector<cv::Point2f>> markers, rejected;
  std::vector<int> marker_ids, ids;
  const auto parameters = cv::aruco::DetectorParameters::create();
  cv::aruco::detectMarkers(image, dictionary, markers, marker_ids, parameters, rejected);
  if (markers.empty()) return std::nullopt;
  cv::aruco::refineDetectedMarkers(image, board, markers, marker_ids, rejected);
  std::vector<cv::Point2f> points;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, image, board, points, ids);
  if (static_cast<int>(ids.size()) < kLeastCharucoCorners) return std::nullopt;
  // Smaller than the white rim between the corner and the corners of the markers beside it.
  const double marker_px = cv::norm(markers[0][0] - markers[0][1]);
  const double rim_px = 0.5 * marker_px * (1.0 / pattern.marker_to_square - 1.0);
  refine(image, points, std::clamp(static_cast<int>(0.9 * rim_px), 2, 10));
  std::vector<Corner> corners(pattern.board.corners());
  for (std::size_t i = 0; i < ids.size(); ++i) corners[ids[i]] = {{points[i].x, points[i].y}, 1.0};
  return corners;
}

}  // namespace

BoardKind board_kind(const std::string& name) {
  if (name == "chessboard") return BoardKind::chessboard;
  if (name == "circles") return BoardKind::circles;
  if (name == "asymmetric-circles") return BoardKind::asymmetric_circles;
  if (name == "charuco") return BoardKind::charuco;
  throw UserError(ExitCode::usage, "--board " + name, "is not a kind of board",
                  "use chessboard, circles, asymmetric-circles or charuco");
}

std::optional<std::vector<Corner>> find_board(const ImageF& image, const BoardPattern& pattern) try {
  const cv::Mat picture = to_8_bit(image);
  const EndsOnCancel opencv_does_not_ask;
  switch (pattern.kind) {
    case BoardKind::chessboard: {
      auto corners = find_regular(find_chessboard(picture, pattern.board), pattern.board);
      if (corners && is_unique(pattern.board)) begin_at_dark(*corners, pattern.board, picture);
      return corners;
    }
    case BoardKind::circles:
      return find_regular(
          find_circles(picture, {pattern.board.width_n, pattern.board.height_n}, cv::CALIB_CB_SYMMETRIC_GRID),
          pattern.board);
    case BoardKind::asymmetric_circles:
      return find_asymmetric(picture, pattern.board);
    case BoardKind::charuco:
      return find_charuco(picture, pattern);
  }
  return std::nullopt;
} catch (const cv::Exception& fault) {
  if (fault.code == cv::Error::StsNoMem) throw OutOfMemory("OpenCV");
  return std::nullopt;  // the image is smaller than a window of the detector
}

}  // namespace fringetwin::calib
