// SPDX-License-Identifier: Apache-2.0
// Our TOML files: twins (with the meshes and images they name), capture sets, studies.
#include <algorithm>

#include "capture/record/verify_set.hpp"
#include "compare/verdict/calibration_covariance.hpp"
#include "cosim/load.hpp"
#include "study/study_file.hpp"
#include "tests/fuzz/structured.hpp"
#include "tests/fuzz/target.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/captures/stored_images.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::fuzz {
namespace {
namespace fs = std::filesystem;

/// The twins, captures and studies that are shipped, by their names below datasets/: where the checkout lies
/// and in which order its disk lists them makes no difference.
std::vector<std::string> shipped(const std::string& name_part) {
  const fs::path datasets = source_folder() / "datasets";
  std::vector<fs::path> names;
  for (const auto& entry : fs::recursive_directory_iterator(datasets)) {
    const fs::path name = entry.path().lexically_relative(datasets);
    if (name.extension() == ".toml" && name.string().find(name_part) != std::string::npos)
      names.push_back(name);
  }
  std::ranges::sort(names);
  std::vector<std::string> files;
  for (const fs::path& name : names) files.push_back(get_file(datasets / name));
  return files;
}

void read_twin(const std::string& input) {
  const Twin twin = cosim::load_for_run(put_file("input.toml", input));
  if (twin.calibration_uncertainty) compare::read_calibration_covariance(twin);
}

/// The good twin with images of a few pixels.
const Twin& tiny_twin() {
  static const Twin twin = load_twin(
      work_folder() / "twin.toml",
      {{"camera.left.imagersize", "[16, 12]"}, {"camera.left.intrinsics", "[26, 26, 7.5, 5.5, 0, 0, 0, 0]"}});
  return twin;
}

/// A folder with images of that twin's sequence.
fs::path make_set() {
  const fs::path folder = work_folder() / "set";
  fs::create_directories(folder);
  CameraImages images{.camera = "left"};
  images.images.assign(expand_sequence(tiny_twin().fringes).size(), ImageF(16, 12, 100.0f));
  write_camera_images(folder, images);
  return folder;
}

void read_set(const std::string& input) {
  static const fs::path folder = make_set();
  put_file("set/capture.toml", input);
  const int n = static_cast<int>(expand_sequence(tiny_twin().fringes).size());
  read_or_refuse([&] {
    load_camera_images(read_capture_set(folder, n), tiny_twin().cameras.front(), tiny_twin().fringes);
  });
  read_or_refuse([] { load_stored_images(read_capture_set(folder)); });
  capture::verify_set(folder, &tiny_twin());
}

void read_study(const std::string& input) {
  const study::StudyFile file = study::load_study(put_file("input.toml", input));
  study::kind_of(file)->plan();
}

/// An image that the sequence shows after everything else.
void read_pattern(const std::string& input) {
  static const fs::path twin = [] {
    std::string text = get_file(work_folder() / "twin.toml");
    text.insert(text.find("steps = "), "images = [\"input.png\"]\n");
    return put_file("images.toml", text);
  }();
  put_file("input.png", input);
  load_twin(twin);
}

std::vector<std::string> pattern_images() {
  std::vector<std::string> files;
  for (const int bits : {8, 16}) {
    write_gray_png(work_folder() / "seed.png", ImageF(64, 48, 7.0f), bits);
    files.push_back(get_file(work_folder() / "seed.png"));
  }
  return files;
}

}  // namespace

extern const Target twin_target, capture_set_target, study_target, patterns_target;

const Target twin_target = {"twin",
                            read_twin,
                            {"good/twin.toml", "twin"},
                            [] { return shipped("twin"); },
                            mutate_toml,
                            {"[[camera]]\n",
                             "[projector]\n",
                             "[[object]]\n",
                             "[fringes.gray]\n",
                             "[camera.optics]\n",
                             "[limits]\n",
                             "[uncertainty]\n",
                             "shape = \"mesh\"\nfile = \"part.ply\"\n",
                             "file = \"part.obj\"\n",
                             "shape = \"measured\"\n",
                             "model = \"left.cameramodel\"\n",
                             "model = \"pipe\"\n",
                             "file = \"/dev/zero\"\n",
                             "images = [\"pipe\"]\n",
                             "calibration = \"calibration.json\"\n",
                             "unwrap = \"gray\"\n",
                             "directions = [\"x\", \"y\"]\n",
                             "${FRINGETWIN_CAPTURES}",
                             "${HOME}",
                             "\"\"\"",
                             "'''",
                             "\\u0000"}};

const Target capture_set_target = {
    "capture_set",
    read_set,
    {"good/capture.toml", "capture_set"},
    [] { return shipped("capture"); },
    mutate_toml,
    {"files = [\"left/0000.png\"]\n", "pattern = \"left/%d.png\"\n", "%04d/../", "%99999999d", "%%",
     "root = \"..\"\n", "root = \"/dev\"\n", "white = \"pipe\"\n", "black = \"left/0000.png\"\n",
     "gray_code_exposure = \"different\"\n", "channel = \"green\"\n", "[provenance.sha256]\n",
     "\"sets\" = \"left .. . set\"\n", "\"left/0000.png\" = \"aa\"\n"}};

const Target study_target = {
    "study",
    read_study,
    {"good/study.toml", "study"},
    [] { return shipped("studies"); },
    mutate_toml,
    {"kind = \"monte-carlo\"\n", "kind = \"volume-map\"\n", "kind = \"optimise\"\n", "[[vary]]\n",
     "[[uncertain]]\n", "[[record]]\n", "range = [1, 2]\n", "count = 5\n", "scale = \"log\"\n",
     "design = \"sobol\"\n", "twin = \"twin.toml\"\n", "twin = \"pipe\"\n",
     "key = \"camera.left.sensor.gain_dn\"\n", "calibration = true\n", "sigma = 0.1\n",
     "object.part.radius_mm"}};

const Target patterns_target = {"patterns",     read_pattern, {"patterns"},
                                pattern_images, mutate_png,   {"IHDR", "IDAT"}};

}  // namespace fringetwin::fuzz
