// SPDX-License-Identifier: Apache-2.0
// import opencv | kalibr | matrices | mrcal: a foreign calibration -> .cameramodel files and a twin.toml to
// start from. import captures: cmd_import_captures.cpp.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "calib/import/imported_rig.hpp"
#include "cli/commands.hpp"
#include "cli/import_rig.hpp"
#include "cli/option_values.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/progress.hpp"
#include "twin/file/opencv_import.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

struct ImportCommand {
  std::vector<std::string> files;    ///< kalibr: one; mrcal: the cameras' models
  std::vector<std::string> cameras;  ///< NAME=PARTS@WIDTHxHEIGHT
  std::string projector;             ///< PARTS@WIDTHxHEIGHT; kalibr: a camera's name; mrcal: a file
  std::string names;                 ///< kalibr, mrcal: of the cameras
  std::string unit = "mm";           ///< of the translations in the files
  bool list = false;
  RigOptions rig;
  double mm_per_unit() const { return unit == "m" ? 1000.0 : 1.0; }
};

constexpr const char* kOpencvExample =
    "NAME=MATRIX,DISTORTION[,ROTATION,TRANSLATION]@WIDTHxHEIGHT, e.g. left=M1,D1@1280x1024 (\"none\" for no "
    "distortion)";
constexpr const char* kMatricesExample =
    "NAME=K.txt,D.txt[,R.txt[,T.txt]]@WIDTHxHEIGHT, e.g. left=K1.txt,D1.txt@1280x1024 (\"none\" for no "
    "distortion)";

/// Warns where the file of a device's camera matrix states another size of its images than was given. A file
/// of several devices states the size of one of them, nobody knows which.
void doubt_sizes(const std::vector<DeviceRequest>& requests, const std::vector<OpenCvModel>& models) {
  for (std::size_t i = 0; i < models.size(); ++i) {
    const auto& stated = models[i].stated_imagersize_px;
    if (!stated || *stated == requests[i].imagersize) continue;
    if (std::ranges::count(models, models[i].matrix_file, &OpenCvModel::matrix_file) > 1) continue;
    warn(fmt::format("{}: {} says that the images are {}x{} (image_width, image_height), not {}x{}",
                     requests[i].name, models[i].matrix_file.string(), (*stated)[0], (*stated)[1],
                     requests[i].imagersize[0], requests[i].imagersize[1]));
  }
}

int run_opencv(const ImportCommand& o) {
  const std::vector<fs::path> files(o.files.begin(), o.files.end());
  if (o.list) {
    for (const auto& file : files)
      for (const auto& key : list_opencv_keys(file))
        fmt::print("{}\t{}\n", plain_text(file.string()), plain_text(key));
    return 0;
  }
  if (o.cameras.empty())
    throw UserError(ExitCode::usage, "import opencv", "needs --camera and --out",
                    "see the file's keys with --list, then e.g. --camera left=M1,D1@1280x1024 --out RIG");
  check_rig_options(o.rig);
  ImportedRig rig;
  rig.has_projector = !o.projector.empty();
  rig.source = fmt::format("{}", fmt::join(o.files, " "));
  const auto requests = parse_devices(o.cameras, o.projector, kOpencvExample);
  std::vector<OpenCvModel> models;
  for (const DeviceRequest& request : requests) {
    const auto& keys = request.parts;
    if (keys.size() != 2 && keys.size() != 4)
      throw UserError(ExitCode::usage, request.option,
                      fmt::format("has {} keys instead of 2 or 4", keys.size()),
                      std::string("write ") + kOpencvExample);
    if (keys.size() == 2 && &request != &requests.front())
      throw UserError(
          ExitCode::usage, request.option, "has no ROTATION,TRANSLATION, so its place in the rig is unknown",
          "name the matrices, e.g. right=M2,D2,R,T@1280x1024; only the first camera may be the world");
    const OpenCvModel model = import_opencv(
        files, {keys[0], keys[1], keys.size() == 4 ? keys[2] : "", keys.size() == 4 ? keys[3] : ""});
    RotTrans rt = Eigen::Map<const RotTrans>(model.rt_device_ref.data());
    rt.tail<3>() *= o.mm_per_unit();
    rig.devices.push_back({request.name, model.lensmodel, model.intrinsics, request.imagersize,
                           pose_from_rt(rt), "", rig.source + ": " + keys[0]});
    models.push_back(model);
  }
  doubt_sizes(requests, models);
  return finish_import(std::move(rig), o.rig);
}

int run_matrices(const ImportCommand& o) {
  check_rig_options(o.rig);
  ImportedRig rig;
  rig.has_projector = !o.projector.empty();
  const auto requests = parse_devices(o.cameras, o.projector, kMatricesExample);
  for (const DeviceRequest& request : requests) {
    const auto& parts = request.parts;
    if (parts.size() < 2 || parts.size() > 4)
      throw UserError(ExitCode::usage, request.option,
                      fmt::format("has {} files instead of 2 to 4", parts.size()),
                      std::string("write ") + kMatricesExample);
    if (parts.size() == 2 && &request != &requests.front())
      throw UserError(ExitCode::usage, request.option,
                      "has no rotation and translation, so its place in the rig is unknown",
                      "only the first camera may be the world");
    calib::MatrixFiles files;
    files.camera_matrix = parts[0];
    if (parts[1] != "none") files.distortion = parts[1];
    if (parts.size() > 2) files.rotation = parts[2];
    if (parts.size() > 3) files.translation = parts[3];
    rig.devices.push_back(calib::import_matrices(files, o.mm_per_unit()));
    rig.devices.back().name = request.name;
    rig.devices.back().imagersize_px = request.imagersize;
    rig.source += (rig.source.empty() ? "" : " ") + parts[0];
  }
  return finish_import(std::move(rig), o.rig);
}

/// Moves the projector to the end and gives the cameras the names asked for.
void arrange(ImportedRig& rig, const ImportCommand& o) {
  const std::vector<std::string> names = split_list(o.names);
  const std::size_t n_cameras = rig.devices.size() - (rig.has_projector ? 1 : 0);
  if (!names.empty() && names.size() != n_cameras)
    throw UserError(ExitCode::usage, "--names",
                    fmt::format("has {} names for {} cameras", names.size(), n_cameras));
  for (std::size_t i = 0; i < names.size(); ++i) rig.devices[i].name = names[i];
  if (rig.has_projector) rig.devices.back().name = "projector";
}

int run_kalibr(const ImportCommand& o) {
  check_rig_options(o.rig);
  ImportedRig rig{.devices = calib::import_kalibr(o.files.at(0)), .source = o.files.at(0)};
  if (!o.projector.empty()) {
    const auto at = std::ranges::find_if(rig.devices, [&](const auto& d) { return d.name == o.projector; });
    if (at == rig.devices.end())
      throw UserError(ExitCode::usage, "--projector " + o.projector, "the camchain has no such camera",
                      "name it as there: cam2");
    std::rotate(at, at + 1, rig.devices.end());
    rig.has_projector = true;
  }
  arrange(rig, o);
  return finish_import(std::move(rig), o.rig);
}

int run_mrcal(const ImportCommand& o) {
  check_rig_options(o.rig);
  ImportedRig rig = read_models(o.files, o.projector, o.mm_per_unit());
  arrange(rig, o);
  return finish_import(std::move(rig), o.rig);
}

CLI::App* add(CLI::App& import, Invocation& invocation, const char* name, const char* what,
              const std::shared_ptr<ImportCommand>& options, int (*run)(const ImportCommand&)) {
  CLI::App* sub = import.add_subcommand(name, what);
  add_rig_options(*sub, options->rig);
  run_when_chosen(*sub, invocation, options, run);
  return sub;
}

void add_unit(CLI::App& sub, ImportCommand& options) {
  sub.add_option("--unit", options.unit, "Unit of the translations in the files: mm or m")
      ->type_name("UNIT")
      ->check(CLI::IsMember({"mm", "m"}))
      ->capture_default_str();
}

}  // namespace

void add_import(CLI::App& app, Invocation& invocation) {
  CLI::App* import = app.add_subcommand("import", "Bring in a foreign calibration, or foreign captures");
  import->require_subcommand(1);

  auto o = std::make_shared<ImportCommand>();
  CLI::App* opencv =
      add(*import, invocation, "opencv", "OpenCV YAML/XML files (cv::FileStorage)", o, run_opencv);
  opencv->add_option("files", o->files, "YAML or XML files")->type_name("FILE")->required();
  opencv->add_flag("--list", o->list, "List the matrices in the files and stop");
  opencv
      ->add_option("--camera", o->cameras,
                   "NAME=MATRIX,DISTORTION[,ROTATION,TRANSLATION]@WIDTHxHEIGHT; once per camera; x_cam = R "
                   "x_ref + T; \"none\" for no distortion; FILE:MATRIX where several files have one of that "
                   "name; only the first may leave out its place")
      ->type_name("DEVICE");
  opencv->add_option("--projector", o->projector, "MATRIX,DISTORTION,ROTATION,TRANSLATION@WIDTHxHEIGHT")
      ->type_name("DEVICE");
  add_unit(*opencv, *o);

  o = std::make_shared<ImportCommand>();
  CLI::App* matrices =
      add(*import, invocation, "matrices", "Files of plain numbers (numpy.savetxt)", o, run_matrices);
  matrices
      ->add_option(
          "--camera", o->cameras,
          "NAME=K.txt,D.txt[,R.txt[,T.txt]]@WIDTHxHEIGHT; once per camera; \"none\" for no distortion; R "
          "3x3, Rodrigues, or 3x4 and 4x4 with the translation in it; only the first may leave out its place")
      ->type_name("DEVICE")
      ->required();
  matrices->add_option("--projector", o->projector, "K.txt,D.txt,R.txt[,T.txt]@WIDTHxHEIGHT")
      ->type_name("DEVICE");
  add_unit(*matrices, *o);

  o = std::make_shared<ImportCommand>();
  CLI::App* kalibr = add(*import, invocation, "kalibr", "A Kalibr camchain (YAML)", o, run_kalibr);
  kalibr->add_option("file", o->files, "The camchain")->type_name("FILE")->required()->expected(1);
  kalibr->add_option("--projector", o->projector, "The cam that is the projector, e.g. cam2")
      ->type_name("DEVICE");
  kalibr->add_option("--names", o->names, "Names of the cameras: left,right")
      ->type_name("NAMES")
      ->default_str("cam0,cam1");

  o = std::make_shared<ImportCommand>();
  o->unit = "m";
  CLI::App* mrcal = add(*import, invocation, "mrcal", "mrcal's .cameramodel files", o, run_mrcal);
  mrcal->add_option("files", o->files, "The cameras' models, the reference first")
      ->type_name("FILE")
      ->required();
  mrcal->add_option("--projector", o->projector, "The projector's model")->type_name("DEVICE");
  mrcal->add_option("--names", o->names, "Names of the cameras: left,right")
      ->type_name("NAMES")
      ->default_str("those of the files");
  add_unit(*mrcal, *o);

  add_import_captures(*import, invocation);
}

}  // namespace fringetwin::cli
