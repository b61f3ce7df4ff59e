// SPDX-License-Identifier: Apache-2.0
// Lens models: .cameramodel files, and names with numbers straight into the lens and libmrcal.
#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "tests/fuzz/structured.hpp"
#include "tests/fuzz/target.hpp"
#include "twin/file/cameramodel.hpp"
#include "twin/lens/lens.hpp"

namespace fringetwin::fuzz {
namespace {

/// What a twin asks of a lens.
void use_lens(const std::string& model, const std::vector<double>& intrinsics, const Eigen::Vector2i& size) {
  const Lens lens(model, intrinsics, size, "input");
  for (const double at : {0.0, 0.5, 1.0})
    if (const auto ray = lens.unproject({at * lens.width(), at * lens.height()})) {
      Eigen::Matrix<double, 2, 3> jacobian;
      lens.project(*ray * 250.0, &jacobian);
    }
}

void read_model(const std::string& input) {
  const auto file = put_file("input.cameramodel", input);
  const CameraModelFile model = read_cameramodel(file);
  write_cameramodel(work_folder() / "again.cameramodel", model);
  read_cameramodel(work_folder() / "again.cameramodel");
  use_lens(model.lensmodel, model.intrinsics, {model.imagersize[0], model.imagersize[1]});
}

/// "NAME WIDTH HEIGHT numbers"
void read_name(const std::string& input) {
  std::istringstream words(input);
  std::string name, word;
  words >> name;
  std::vector<double> numbers;
  while (words >> word && numbers.size() < 100'000) numbers.push_back(std::strtod(word.c_str(), nullptr));
  numbers.resize(std::max<std::size_t>(numbers.size(), 2), 64.0);
  const auto pixels = [](double size) { return size >= 1.0 && size < 1e9 ? static_cast<int>(size) : 0; };
  use_lens(name, {numbers.begin() + 2, numbers.end()}, {pixels(numbers[0]), pixels(numbers[1])});
}

std::vector<std::string> lens_names() {
  std::string knots;
  for (int i = 0; i < 24; ++i) knots += " 0";
  const std::string core = " 160 120 260 260 79.5 59.5";
  return {"LENSMODEL_PINHOLE" + core,
          "LENSMODEL_STEREOGRAPHIC" + core,
          "LENSMODEL_LONLAT" + core,
          "LENSMODEL_LATLON" + core,
          "LENSMODEL_OPENCV4" + core + " -0.1 0.1 0 0",
          "LENSMODEL_OPENCV5" + core + " -0.1 0.1 0 0 0",
          "LENSMODEL_OPENCV8" + core + " -0.1 0.1 0 0 0 0 0 0",
          "LENSMODEL_OPENCV12" + core + " -0.1 0.1 0 0 0 0 0 0 0 0 0 0",
          "LENSMODEL_CAHVOR" + core + " 0 0 0 0 0",
          "LENSMODEL_CAHVORE_linearity=0.34" + core + " 0 0 0 0 0 0 0 0",
          "LENSMODEL_SPLINED_STEREOGRAPHIC_order=2_Nx=4_Ny=3_fov_x_deg=44" + core + knots,
          "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=4_Ny=3_fov_x_deg=44" + core + knots};
}

const std::vector<std::string> kLensWords = {
    "LENSMODEL_", "order=", "_Nx=",        "_Ny=",    "_fov_x_deg=", "65540",
    "33025",      "65026",  "_linearity=", "OPENCV4", "PINHOLE",     "SPLINED_STEREOGRAPHIC"};

}  // namespace

extern const Target cameramodel_target, lens_target;

const Target cameramodel_target = {
    "cameramodel",
    read_model,
    {"good/left.cameramodel", "good/splined.cameramodel", "cameramodel"},
    nullptr,
    mutate_lens,
    {"'lensmodel': ", "'intrinsics': ", "'extrinsics': ", "'rt_cam_ref': ", "'imagersize': ",
     "'icam_intrinsics': 0,", "None", "b'x'", "\"\"\"", "(", ")", "[", "]", "{", "}", "\\", "# ",
     "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=65540_Ny=4_fov_x_deg=44"}};

const Target lens_target = {"lens", read_name, {}, lens_names, mutate_lens, kLensWords};

}  // namespace fringetwin::fuzz
