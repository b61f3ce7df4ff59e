// SPDX-License-Identifier: Apache-2.0
// Foreign calibrations (OpenCV, Kalibr, matrices) and corner files.
#include <algorithm>

#include "calib/board/corners_vnl.hpp"
#include "calib/import/check_import.hpp"
#include "tests/fuzz/mutate.hpp"
#include "tests/fuzz/target.hpp"
#include "twin/file/opencv_import.hpp"

namespace fringetwin::fuzz {
namespace {
namespace fs = std::filesystem;

void read_opencv(const std::string& input) {
  const std::size_t first = std::min(input.find_first_not_of(" \t\r\n"), input.size());
  const char start = first < input.size() ? input[first] : ' ';
  const fs::path file = put_file(start == '<'   ? "input.xml"
                                 : start == '{' ? "input.json"
                                                : "input.yml",
                                 input);
  read_or_refuse([&] { list_opencv_keys(file); });
  import_opencv({file}, {"M1", "D1", "R", "T"});
}

/// The input in the place of each file in turn.
void read_matrices(const std::string& input) {
  const fs::path file = put_file("input.txt", input);
  const calib::MatrixFiles good{work_folder() / "K.txt", work_folder() / "D.txt", work_folder() / "R.txt",
                                work_folder() / "T.txt"};
  for (fs::path calib::MatrixFiles::*place :
       {&calib::MatrixFiles::camera_matrix, &calib::MatrixFiles::distortion, &calib::MatrixFiles::rotation,
        &calib::MatrixFiles::translation}) {
    calib::MatrixFiles files = good;
    files.*place = file;
    read_or_refuse([&] { calib::import_matrices(files, 1.0); });
  }
}

void read_corners(const std::string& input) {
  const fs::path file = put_file("input.vnl", input);
  read_or_refuse([&] {
    calib::Observations seen{.board = {4, 4, 10.0}};
    for (const char* name : {"left", "right"}) seen.devices.push_back({name, {640, 480}, 500.0, 1.0, false});
    calib::assign_views(calib::read_corners_vnl(file), {"left*", "right*"}, seen);
    calib::check_observations(seen);
  });
  read_or_refuse([&] { calib::read_corners_vnl(file, true); });
  std::vector<calib::ImportedDevice> devices = calib::import_kalibr(work_folder() / "camchain.yaml");
  devices[0].name = "left";
  devices[1].name = "right";
  calib::check_poses(devices, calib::read_correspondences(file, devices), 3.0);
}

}  // namespace

extern const Target opencv_target, kalibr_target, matrices_target, corners_target;

const Target opencv_target = {
    "opencv",
    read_opencv,
    {"good/calibration.yml", "good/calibration.xml", "good/calibration_of_opencv.json", "opencv"},
    nullptr,
    mutate_text,
    {"%YAML:1.0\n---\n",
     "!!opencv-matrix",
     "!!binary |\n",
     "   rows: 3\n",
     "   dt: f\n",
     "   dt: \"3d\"\n",
     "   data: [ ",
     "- ",
     ":{ ",
     "&a ",
     "*a",
     "<?xml version=\"1.0\"?>\n",
     "<opencv_storage>\n",
     "</opencv_storage>",
     "<!--",
     "-->",
     "<_>",
     "</_>",
     "type_id=\"opencv-matrix\"",
     "type_id=\"opencv-nd-matrix\"",
     "&lt;",
     "&#",
     "\"type_id\": \"opencv-matrix\"",
     "{\"a\":",
     "\"$base64$",
     ".Nan",
     "-.Inf"}};

const Target kalibr_target = {
    "kalibr",
    [](const std::string& input) { calib::import_kalibr(put_file("input.yaml", input)); },
    {"good/camchain.yaml", "kalibr"},
    nullptr,
    mutate_text,
    {"cam0:\n", "cam1:\n", "cam2:\n", "  T_cn_cnm1:\n", "  - [1.0, 0.0, 0.0, 0.0]\n",
     "  camera_model: pinhole\n", "  distortion_model: none\n", "  resolution: [752, 480]\n", "equidistant",
     "plumb_bob", "---\n", "1e308", "#"}};

const Target matrices_target = {
    "matrices", read_matrices, {"good/K.txt", "good/D.txt", "good/R.txt", "good/T.txt", "matrices"},
    nullptr,    mutate_text,   {"[[", "]]", "# ", ",", ";", "\n", " 0", "1e308", "nan"}};

const Target corners_target = {
    "corners",
    read_corners,
    {"good/corners.vnl", "corners"},
    [] { return std::vector<std::string>{"x y x2 y2\n300.25,200.5,290.25,200.5\n310 - - 200\n"}; },
    mutate_text,
    {"# filename x y weight\n", "# filename x y level\n", " - - -\n", " - -\n", "left0.png ", "right0.png ",
     "nan", " 1e308"}};

}  // namespace fringetwin::fuzz
