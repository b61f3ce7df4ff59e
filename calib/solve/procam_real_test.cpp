// SPDX-License-Identifier: Apache-2.0
// Raw images of a real chessboard under two-axis Gray code -> projector corners.
//
// | check                                          | tolerance | origin                        |
// |------------------------------------------------|-----------|-------------------------------|
// | projector corners, median, at our corners      | 0.1 px    | corners_cam_proj.csv          |
// | projector corners, median, at the file's       | 0.1 px    | the same                      |
// | camera corners, median                         | 0.1 px    | the same                      |
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "calib/board/board_detector.hpp"
#include "calib/board/projector_corners.hpp"
#include "measure/decode/decode.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::calib::procam_real_test {
namespace {
namespace fs = std::filesystem;

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v[v.size() / 2];
}

TEST(ProcamImages, RawImagesGiveTheProjectorCorners) {
  const char* source = std::getenv("FRINGETWIN_SOURCE");
  const fs::path toml =
      fs::path(source != nullptr ? source : ".") / "datasets" / "kamino-procam-board" / "twin.toml";
  const fs::path set = captures_root() / "kamino-procam-board";
  if (!fs::exists(set) || !fs::exists(toml))
    GTEST_SKIP() << "real captures absent: " << set << " (FRINGETWIN_CAPTURES)";
  const Twin twin = load_twin(toml);
  const CaptureSet captures =
      read_capture_set(*twin.real.captures, static_cast<int>(expand_sequence(twin.fringes).size()));
  const CameraImages images = load_camera_images(captures, twin.cameras[0], twin.fringes);
  measure::DecodeOptions options;
  options.min_modulation_dn = twin.measure.min_modulation_dn;
  options.projector_width_px = twin.projector->lens.width();
  options.projector_height_px = twin.projector->lens.height();
  const measure::CameraDecode decode = measure::decode(images, twin.fringes, options);
  BoardPattern pattern;
  pattern.board = {9, 7, 75.0};
  auto corners = find_board(images.white->floats(), pattern);
  ASSERT_TRUE(corners);

  std::vector<Eigen::Vector2d> camera, projector;
  std::ifstream in(set / "corners_cam_proj.csv");
  std::string line;
  std::getline(in, line);
  for (int i = 0; i < 63 && std::getline(in, line); ++i) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    double pose = 0, x = 0, y = 0, u = 0, v = 0, px = 0, py = 0;
    words >> pose >> x >> y >> u >> v >> px >> py;
    camera.emplace_back(u, v);
    projector.emplace_back(px, py);
  }
  ASSERT_EQ(camera.size(), 63u);
  // Read at the file's camera corners, so that only the decoding differs; and at our own.
  std::vector<Corner> theirs;
  for (const auto& q : camera) theirs.push_back({q, 1.0});
  const auto decoded = projector_corners(decode, pattern.board, theirs);
  const auto own = projector_corners(decode, pattern.board, *corners);
  std::vector<double> camera_px, projector_px, own_px;
  for (std::size_t i = 0; i < 63; ++i) {
    ASSERT_TRUE(decoded[i].seen() && own[i].seen()) << i;
    camera_px.push_back(((*corners)[i].q_px - camera[i]).norm());
    projector_px.push_back((decoded[i].q_px - projector[i]).norm());
    own_px.push_back((own[i].q_px - projector[i]).norm());
  }
  std::printf(
      "median distance: camera %.3f px; projector %.3f px at the same camera corners, %.3f px at our own\n",
      median(camera_px), median(projector_px), median(own_px));
  EXPECT_LT(median(projector_px), 0.1);
  EXPECT_LT(median(camera_px), 0.1);
  EXPECT_LT(median(own_px), 0.1);
}

}  // namespace
}  // namespace fringetwin::calib::procam_real_test
