// SPDX-License-Identifier: Apache-2.0
// calibrate: corners of a board, pictures of it or captures of it under fringes -> cameras and projector with
// their uncertainty. Flag names as mrcal-calibrate-cameras.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "calib/board/corners_vnl.hpp"
#include "calib/board/observe.hpp"
#include "calib/page/calibration_findings.hpp"
#include "calib/solve/calibrate.hpp"
#include "cli/commands.hpp"
#include "cli/option_groups.hpp"
#include "cli/option_values.hpp"
#include "cli/projector_from.hpp"
#include "cli/start/starting_twin.hpp"
#include "cli/tell/json_output.hpp"
#include "cli/twin_argument.hpp"
#include "compare/result/provenance.hpp"
#include "compare/verdict/limits.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"
#include "twin/number/parse_number.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

/// Help on what only --projector-from goes without
constexpr const char* kOfABoard = "none: a board needs it";
/// --sigma auto: as each device's residuals scatter
constexpr const char* kAuto = "auto";

struct CalibrateCommand {
  std::string corners, focal, imagersize, sigma, names, out, outlier_sigma = "5", projector = "projector";
  std::string twin, board = "chessboard", projector_from, captures;
  calib::BoardPattern pattern;
  bool has_weights = false, skip_regularization = false, keep_regularization = false, skip_rejection = false,
       skip_warp = false, json = false;
  double spacing_m = 0.0, circle_diameter_m = 0.0;
  int width_n = 0, height_n = 0;
  std::vector<std::string> globs;
  calib::CalibrateOptions calibrate;
};

double number(const std::string& option, const std::string& text) {
  const std::optional<double> value = parse_number<double>(text);
  if (!value) throw UserError(ExitCode::usage, option, "\"" + text + "\" is not a number", "");
  return *value;
}

/// One item for all devices, or one per device.
std::vector<std::string> per_device(const std::string& option, const std::string& text, std::size_t n) {
  std::vector<std::string> items = split_list(text);
  if (items.size() == 1) items.resize(n, items[0]);
  if (items.size() != n)
    throw UserError(ExitCode::usage, option,
                    fmt::format("has {} values for {} device{}", items.size(), n, n == 1 ? "" : "s"),
                    "give one for all, or one per device with commas between them");
  return items;
}

std::array<int, 2> size_of(const std::string& text) {
  const std::optional<std::array<int, 2>> size = parse_size(text);
  if (!size || (*size)[0] <= 0 || (*size)[1] <= 0)
    throw UserError(ExitCode::usage, "--imagersize", "\"" + text + "\" is not a size",
                    "write e.g. 1440x1080,1280x720");
  return *size;
}

/// mrcal writes "--imagersize W H": the second number then stands first among the globs.
void join_imagersize(CalibrateCommand& o) {
  const auto is_number = [](const std::string& s) {
    return !s.empty() && s.find_first_not_of("0123456789") == std::string::npos;
  };
  if (!is_number(o.imagersize) || o.globs.empty() || !is_number(o.globs.front())) return;
  o.imagersize += "x" + o.globs.front();
  o.globs.erase(o.globs.begin());
}

std::vector<calib::Device> devices_of(const CalibrateCommand& o) {
  const std::size_t n = o.globs.size();
  std::vector<std::string> names = split_list(o.names);
  for (std::size_t d = names.size(); d < n && o.names.empty(); ++d)
    names.push_back(fmt::format("camera-{}", d));
  if (names.size() != n)
    throw UserError(ExitCode::usage, "--names", fmt::format("has {} names for {} globs", names.size(), n),
                    "");
  const auto sizes = per_device("--imagersize", o.imagersize, n), focals = per_device("--focal", o.focal, n),
             sigmas = per_device("--sigma", o.sigma == kAuto ? "1" : o.sigma, n);
  std::vector<calib::Device> devices;
  for (std::size_t d = 0; d < n; ++d) {
    if (const std::string fault = name_fault(names[d]); !fault.empty())
      throw UserError(ExitCode::usage, "--names", "the name " + fault, kNameHint);
    for (std::size_t k = 0; k < d; ++k)
      if (names[k] == names[d]) throw UserError(ExitCode::usage, "--names", names[d] + " is given twice", "");
    devices.push_back({names[d], size_of(sizes[d]), number("--focal", focals[d]),
                       number("--sigma", sigmas[d]), names[d] == o.projector});
  }
  return devices;
}

/// A twin.toml of these devices, to go on from, with the fringes and sensors of --twin; only with the cameras
/// a twin can have.
std::string twin_toml(const calib::Calibration& c, const CalibrateCommand& o) {
  std::vector<StartingDevice> devices;
  for (const calib::Device& device : c.observations.devices)
    devices.push_back({device.name, device.imagersize_px[0], device.name == o.projector});
  const auto n_cameras = std::ranges::count(devices, false, &StartingDevice::is_projector);
  return n_cameras < 1 || n_cameras > 2
             ? ""
             : starting_twin_toml("calibrated rig", devices,
                                  o.twin.empty() ? KeptTables{} : kept_tables(o.twin));
}

std::vector<fs::path> files_of(const std::string& pattern) {
  std::vector<fs::path> files = glob_files(pattern);
  if (files.empty())
    throw UserError(ExitCode::input, pattern, "matches no picture, and there is no corner file yet",
                    "check the path, or give an existing --corners-cache");
  return files;
}

/// As mrcal does with its cache: a corner file that is there is used, else it is made from the pictures.
std::vector<calib::ImageCorners> corners_of(const CalibrateCommand& o) {
  if (fs::exists(o.corners)) return calib::read_corners_vnl(o.corners, o.has_weights);
  std::vector<calib::Picture> pictures;
  const std::vector<calib::Device> devices = devices_of(o);
  for (std::size_t d = 0; d < devices.size(); ++d)
    for (const fs::path& file : files_of(o.globs[d]))
      pictures.push_back({file,
                          {devices[d].imagersize_px[0], devices[d].imagersize_px[1],
                           fmt::format("device \"{}\"", devices[d].name), "check --imagersize"}});
  auto images = calib::detect_in_pictures(pictures, o.pattern);
  calib::write_corners_vnl(o.corners, images);
  say("corners: " + o.corners);
  return images;
}

/// The devices of a twin, whose lenses need only be rough, and the globs of the names detect_in_captures()
/// gives.
void take_devices(const Twin& twin, CalibrateCommand& o) {
  std::vector<std::string> names, sizes, focals;
  const auto take = [&](const std::string& name, const Lens& lens) {
    names.push_back(name);
    sizes.push_back(fmt::format("{}x{}", lens.width(), lens.height()));
    focals.push_back(fmt::format("{}", lens.intrinsics()[0]));
  };
  for (const Camera& camera : twin.cameras) take(camera.name, camera.whole_lens());
  if (twin.projector) take(o.projector, twin.projector->lens);
  o.names = fmt::format("{}", fmt::join(names, ","));
  o.imagersize = fmt::format("{}", fmt::join(sizes, ","));
  if (o.focal.empty()) o.focal = fmt::format("{}", fmt::join(focals, ","));
  o.globs.clear();
  for (std::size_t d = 0; d < names.size(); ++d)
    o.globs.push_back((twin.projector && d + 1 == names.size() ? "projector" : names[d]) + "-*");
}

void check_sources(const CalibrateCommand& o) {
  if (o.globs.empty())
    throw UserError(ExitCode::usage, "calibrate", "needs a glob per device, or --twin and capture folders",
                    "e.g. calibrate ... 'left-*.png' 'right-*.png'");
  if (!o.twin.empty()) return;
  for (const auto& [option, value] :
       {std::pair{"--corners-cache", o.corners}, {"--focal", o.focal}, {"--imagersize", o.imagersize}})
    if (value.empty()) throw UserError(ExitCode::usage, option, "is needed without --twin", "");
}

/// --projector-from needs no board: what describes one is refused.
int run_without_board(CalibrateCommand o, const Invocation& invocation) {
  join_imagersize(o);
  for (const auto& [option, given] : {std::pair{"--object-spacing", o.spacing_m != 0.0},
                                      {"--object-width-n", o.width_n != 0},
                                      {"--object-height-n", o.height_n != 0},
                                      {"--circle-diameter", o.circle_diameter_m != 0.0},
                                      {"--corners-cache", !o.corners.empty()},
                                      {"--focal", !o.focal.empty()},
                                      {"--sigma", !o.sigma.empty()},
                                      {"--names", !o.names.empty()}})
    if (given)
      throw UserError(ExitCode::usage, option, "says nothing with --projector-from, which needs no board",
                      "");
  if (o.captures.empty())
    throw UserError(ExitCode::usage, "--captures", "is needed with --projector-from", "");
  if (!o.globs.empty() || !o.twin.empty())
    throw UserError(ExitCode::usage, "--projector-from", "goes without globs and --twin",
                    "give the folder of images by --captures");
  if (o.calibrate.lensmodel != "LENSMODEL_PINHOLE" && o.calibrate.lensmodel != "LENSMODEL_OPENCV4")
    throw UserError(ExitCode::usage, "--lensmodel",
                    "with --projector-from LENSMODEL_PINHOLE or LENSMODEL_OPENCV4 "
                    "(k1 alone)",
                    "");
  ProjectorFromCommand command{
      .twin = o.projector_from, .captures = o.captures, .out = o.out, .json = o.json};
  if (!o.imagersize.empty()) command.imagersize_px = size_of(o.imagersize);
  command.solve_k1 = o.calibrate.lensmodel == "LENSMODEL_OPENCV4";
  return run_projector_from(command, invocation);
}

int run_calibrate(CalibrateCommand o, const Invocation& invocation) {
  if (!o.projector_from.empty()) return run_without_board(o, invocation);
  if (!o.captures.empty())
    throw UserError(ExitCode::usage, "--captures", "goes with --projector-from",
                    "with --twin, give the folders without an option");
  for (const auto& [option, given] : {std::pair{"--object-spacing", o.spacing_m > 0.0},
                                      {"--object-width-n", o.width_n > 0},
                                      {"--object-height-n", o.height_n > 0}})
    if (!given) throw UserError(ExitCode::usage, option, "must be given and positive", "describe the board");
  join_imagersize(o);
  check_sources(o);
  check_out_folder(o.out);
  if (o.sigma.empty()) o.sigma = o.twin.empty() ? "1" : kAuto;
  o.pattern.kind = calib::board_kind(o.board);
  o.pattern.board = {o.width_n, o.height_n, 1000.0 * o.spacing_m};
  const fs::path dir = o.out;
  if (const fs::path written = dir / "twin.toml";
      !o.twin.empty() && fs::exists(written) && fs::equivalent(written, o.twin))
    throw UserError(ExitCode::usage, "--out " + dir.string(),
                    "has the twin that --twin names, which would be written over",
                    "give another folder: the twin written has the calibrated devices, and no objects");
  std::vector<calib::ImageCorners> images;
  if (!o.twin.empty()) {
    const Twin twin = compare::load_checked_twin(o.twin);
    const std::vector<fs::path> folders(o.globs.begin(), o.globs.end());
    images = calib::detect_in_captures(twin, folders, o.pattern);
    take_devices(twin, o);
    if (o.corners.empty()) {
      begin_output(dir, {"calibration.json"});
      o.corners = (dir / "corners.vnl").string();
    }
    calib::write_corners_vnl(o.corners, images);
  } else {
    images = corners_of(o);
  }
  calib::Observations observations{
      .board = {o.width_n, o.height_n, 1000.0 * o.spacing_m}, .devices = devices_of(o), .file = o.corners};
  o.calibrate.regularize = !o.skip_regularization;
  o.calibrate.drop_regularization = !o.keep_regularization;
  o.calibrate.reject_outliers = !o.skip_rejection;
  o.calibrate.solve_warp = !o.skip_warp;
  o.calibrate.estimate_sigmas = o.sigma == kAuto;
  o.calibrate.circle_diameter_mm = 1000.0 * o.circle_diameter_m;
  o.calibrate.outlier_sigmas.clear();
  for (const auto& item : split_list(o.outlier_sigma))
    o.calibrate.outlier_sigmas.push_back(number("--outlier-sigma", item));
  calib::assign_views(images, o.globs, observations);

  const bool has_circles =
      o.pattern.kind == calib::BoardKind::circles || o.pattern.kind == calib::BoardKind::asymmetric_circles;
  if (has_circles && !(o.circle_diameter_m > 0.0))
    warn("the centres of the circles are not corrected for perspective; give --circle-diameter");
  const calib::Calibration c = calib::calibrate(observations, o.calibrate);
  const calib::Findings findings = calib::calibration_findings(c, o.calibrate);
  const calib::Origin origin{invocation.argv, version_string(),
                             compare::sha256_of_files({fs::path(o.corners)})};
  const std::vector<std::string> summary = calib::summary_lines(c);

  begin_output(dir, {"calibration.json"});
  std::vector<std::string> comments{" generated with  " + report::shell_command(invocation.argv)};
  for (const auto& line : summary) comments.push_back(" " + line);
  std::vector<std::string> files;
  for (std::size_t d = 0; d < c.devices.size(); ++d) {
    files.push_back(c.devices[d].name + ".cameramodel");
    calib::write_calibrated_model(dir / files.back(), c, static_cast<int>(d), comments);
  }
  if (const std::string toml = twin_toml(c, o); !toml.empty()) write_text_file(dir / "twin.toml", toml);
  write_text_file(dir / "calibration.html", calib::calibration_html(c, o.calibrate, findings, origin));
  write_text_file(dir / "calibration.json", calib::calibration_json(c, o.calibrate, findings, origin, files));
  for (const auto& warning : c.warnings) warn(warning);
  say("page: " + (dir / "calibration.html").string());
  if (print_json_if(o.json, dir / "calibration.json")) return static_cast<int>(ExitCode::ok);
  for (const auto& line : summary) fmt::print("{}\n", plain_text(line));
  for (std::size_t d = 0; d < c.devices.size(); ++d)
    fmt::print(
        "{}: f {:.3f} {:.3f} c {:.3f} {:.3f} px, rms {:.4f} px, centre known to {:.4f} px at {:.4g} mm\n",
        c.devices[d].name, c.devices[d].intrinsics[0], c.devices[d].intrinsics[1], c.devices[d].intrinsics[2],
        c.devices[d].intrinsics[3], c.devices[d].fit.rms_px, findings.devices[d].centre_sigma_px,
        findings.devices[d].distance_mm);
  for (const calib::PairFindings& p : findings.pairs)
    fmt::print("{} and {}: {:.3f} +- {:.2g} mm apart\n", c.devices[p.first].name, c.devices[p.second].name,
               p.baseline_mm, p.baseline_sigma_mm);
  return static_cast<int>(ExitCode::ok);
}

void add_input_options(CLI::App& sub, CalibrateCommand& o) {
  begin_group(sub, kInput);
  add_twin_option(sub, "--twin", o.twin,
                  "Calibrate from captures of the board under the fringes of this twin.toml; its lenses need "
                  "only be rough");
  sub.add_option("--corners-cache", o.corners,
                 "Corner file (.vnl: filename x y level); made from the pictures when it is not there")
      ->type_name("FILE");
  sub.add_flag("--corners-cache-has-weights", o.has_weights,
               "The last column is a weight even if its legend says level");
  sub.add_option("--imagersize", o.imagersize, "WIDTHxHEIGHT in px; one for all, or one per device: AxB,CxD")
      ->type_name("WIDTHxHEIGHT");
}

void add_board_options(CLI::App& sub, CalibrateCommand& o) {
  begin_group(sub, "Board");
  sub.add_option("--board", o.board,
                 "What to look for in pictures: chessboard, circles, asymmetric-circles, charuco")
      ->type_name("NAME")
      ->capture_default_str();
  sub.add_option("--object-width-n", o.width_n, "Corners per row")->type_name("N")->default_str(kOfABoard);
  sub.add_option("--object-height-n", o.height_n, "Rows of corners")->type_name("N")->default_str(kOfABoard);
  sub.add_option("--object-spacing", o.spacing_m, "Distance of the board's corners in METRES")
      ->type_name("M")
      ->default_str(kOfABoard);
  sub.add_option("--circle-diameter", o.circle_diameter_m,
                 "Diameter of a circle grid's circles in METRES: their centres are corrected for perspective")
      ->type_name("M")
      ->default_str("no correction");
  sub.add_option("--charuco-dictionary", o.pattern.dictionary, "ArUco dictionary of a ChArUco board")
      ->type_name("NAME")
      ->capture_default_str();
  sub.add_option("--charuco-marker", o.pattern.marker_to_square,
                 "Side of a ChArUco board's marker / side of its square")
      ->type_name("RATIO")
      ->capture_default_str();
  sub.add_flag("--skip-calobject-warp-solve", o.skip_warp, "Take the board as flat");
}

void add_projector_from_options(CLI::App& sub, CalibrateCommand& o) {
  begin_group(sub, "Projector without a board");
  add_twin_option(
      sub, "--projector-from", o.projector_from,
      "Solve the projector alone: from --captures of any scene of several depths, whose shape the "
      "two calibrated cameras of this twin.toml measure");
  sub.add_option("--captures", o.captures, "The folder of these captures")->type_name("DIR");
}

void add_solve_options(CLI::App& sub, CalibrateCommand& o) {
  begin_group(sub, "Solve");
  sub.add_option("--lensmodel", o.calibrate.lensmodel, "Lens model of all devices")
      ->type_name("NAME")
      ->capture_default_str();
  sub.add_option("--focal", o.focal, "Rough focal length in px; one for all, or one per device: A,B,C")
      ->type_name("PX")
      ->default_str("of the lenses, with --twin");
  auto* keep = sub.add_flag("--keep-regularization", o.keep_regularization,
                            "Regularisation in the last solve too, as mrcal does (default: only where the "
                            "corners leave a parameter open)");
  sub.add_flag("--skip-regularization", o.skip_regularization,
               "Never regularisation in the last solve; parameters left open are an error")
      ->excludes(keep);
  begin_group(sub, "Noise and outliers");
  sub.add_option("--sigma", o.sigma,
                 "Noise of a corner, relative; one for all, one per device, or \"auto\": as the residuals "
                 "of each scatter")
      ->type_name("SIGMAS")
      ->default_str("1, with --twin auto");
  sub.add_flag("--skip-outlier-rejection", o.skip_rejection, "Keep every corner");
  sub.add_option("--outlier-sigma", o.outlier_sigma,
                 "A corner further off than this many sigmas of its device is an outlier; one for all, or "
                 "one per device")
      ->type_name("SIGMAS")
      ->capture_default_str();
  sub.add_option("--max-rms", o.calibrate.max_rms_px, "Largest rms of a device (px, 2-norm) that is accepted")
      ->type_name("PX")
      ->capture_default_str();
}

}  // namespace

void add_calibrate(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<CalibrateCommand>();
  CLI::App* sub = app.add_subcommand(
      "calibrate",
      "Cameras and a projector from the corners of a board, solved jointly, with their uncertainty");
  sub->add_option("globs", o->globs,
                  "Per device: which images are its (quote it); with --twin: folders of captures")
      ->type_name("GLOB|DIR");
  add_input_options(*sub, *o);
  add_board_options(*sub, *o);
  add_solve_options(*sub, *o);
  add_projector_from_options(*sub, *o);
  begin_group(*sub, kOutput);
  sub->add_option(
         "--outdir,--out", o->out,
         "Folder for the .cameramodel files, calibration.json, calibration.html (of --projector-from "
         "projector.json and a picture)")
      ->type_name("DIR")
      ->required();
  add_json_flag(*sub, o->json, "calibration.json (of --projector-from projector.json)");
  sub->add_option("--names", o->names, "Names of the devices: left,right,projector")
      ->type_name("NAMES")
      ->default_str("camera-0,camera-1,...");
  sub->add_option("--projector", o->projector, "Name of the device that becomes [projector] in twin.toml")
      ->type_name("NAME")
      ->capture_default_str();
  run_when_chosen(*sub, invocation, o, run_calibrate);
}

}  // namespace fringetwin::cli
