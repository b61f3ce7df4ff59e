// SPDX-License-Identifier: Apache-2.0
// import opencv: a foreign calibration -> .cameramodel files and a twin.toml to start from.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <sstream>

#include "cli/commands.hpp"
#include "cli/out_folder.hpp"
#include "twin/cameramodel.hpp"
#include "twin/errors.hpp"
#include "twin/image_io.hpp"
#include "twin/lens.hpp"
#include "twin/opencv_import.hpp"
#include "twin/paths.hpp"
#include "twin/progress.hpp"

namespace fringetwin::cli {

namespace {

constexpr double kMetresPerMm = 1e-3;  // mrcal's convention: .cameramodel files in metres

struct Options {
  std::vector<std::string> files;
  std::vector<std::string> cameras;  ///< NAME=MATRIX,DISTORTION[,ROTATION,TRANSLATION][@WIDTHxHEIGHT]
  std::string projector;             ///< MATRIX,DISTORTION,ROTATION,TRANSLATION@WIDTHxHEIGHT
  std::string unit = "mm";           ///< of the translations in the files
  std::string out;
  bool list = false;
};

struct Request {
  std::string name;
  OpenCvDevice keys;
  std::array<int, 2> imagersize{};
};

Request parse_request(const std::string& option, const std::string& text) {
  const auto fail = [&](const std::string& what) -> UserError {
    return UserError(
        ExitCode::usage, option + " " + text, what,
        "write NAME=MATRIX,DISTORTION[,ROTATION,TRANSLATION]@WIDTHxHEIGHT, e.g. left=M1,D1@1280x1024");
  };
  const auto equals = text.find('=');
  const auto at = text.find('@');
  if (equals == std::string::npos || at == std::string::npos || at < equals) throw fail("cannot be read");
  Request request;
  request.name = text.substr(0, equals);
  if (const std::string fault = name_fault(request.name); !fault.empty())
    throw UserError(ExitCode::usage, option + " " + text, "the name " + fault, kNameHint);
  std::vector<std::string> keys;
  std::stringstream list(text.substr(equals + 1, at - equals - 1));
  for (std::string key; std::getline(list, key, ',');) keys.push_back(key);
  if (keys.size() != 2 && keys.size() != 4)
    throw fail(fmt::format("has {} keys instead of 2 or 4", keys.size()));
  request.keys = {keys[0], keys[1], keys.size() == 4 ? keys[2] : "", keys.size() == 4 ? keys[3] : ""};
  char by = 0;
  std::stringstream size(text.substr(at + 1));
  if (!(size >> request.imagersize[0] >> by >> request.imagersize[1]) || by != 'x' || size.peek() != EOF)
    throw fail("the image size cannot be read");
  return request;
}

/// The devices asked for: cameras in order, the projector last. Each becomes a file of its name; all but the
/// first need their place, for the world is the first camera's calibration frame.
std::vector<Request> parse_requests(const Options& o) {
  std::vector<Request> requests;
  for (const auto& text : o.cameras) requests.push_back(parse_request("--camera", text));
  if (requests.size() > 2)
    throw UserError(ExitCode::usage, "--camera", fmt::format("is given {} times", requests.size()),
                    "a twin has one camera or two");
  if (!o.projector.empty()) requests.push_back(parse_request("--projector", "projector=" + o.projector));
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const std::string option =
        i < o.cameras.size() ? "--camera " + o.cameras[i] : "--projector " + o.projector;
    for (std::size_t k = 0; k < i; ++k)
      if (requests[k].name == requests[i].name)
        throw UserError(
            ExitCode::usage, option,
            fmt::format("{0}.cameramodel would be written twice: an earlier --camera is named \"{0}\", "
                        "too",
                        requests[i].name),
            "give each camera a name of its own, other than \"projector\"");
    if (i > 0 && requests[i].keys.rotation_key.empty())
      throw UserError(
          ExitCode::usage, option, "has no ROTATION,TRANSLATION, so its place in the rig is unknown",
          "name the matrices, e.g. right=M2,D2,R,T@1280x1024; only the first camera may be the world");
  }
  return requests;
}

void write_model(const std::filesystem::path& file, const Request& request, const OpenCvModel& model,
                 const Options& o) {
  CameraModelFile out;
  out.lensmodel = model.lensmodel;
  out.intrinsics = model.intrinsics;
  out.rt_cam_ref = model.rt_device_ref;
  for (std::size_t i = 3; i < 6; ++i) out.rt_cam_ref[i] *= o.unit == "m" ? 1.0 : kMetresPerMm;
  out.imagersize = request.imagersize;
  out.comments = {fmt::format(" imported by fringetwin from {} ({}, {})", fmt::join(o.files, " "),
                              request.keys.matrix_key, request.keys.distortion_key),
                  " translation in metres"};
  write_cameramodel(file, out);
}

int run(const Options& o) {
  std::vector<std::filesystem::path> files(o.files.begin(), o.files.end());
  if (o.list) {
    for (const auto& file : files)
      for (const auto& key : list_opencv_keys(file)) fmt::print("{}\t{}\n", file.string(), key);
    return 0;
  }
  if (o.cameras.empty() || o.out.empty())
    throw UserError(ExitCode::usage, "import opencv", "needs --camera and --out",
                    "see the file's keys with --list, then e.g. --camera left=M1,D1@1280x1024 --out RIG");
  check_out_folder(o.out);
  const std::vector<Request> requests = parse_requests(o);
  std::vector<OpenCvModel> models;
  for (const Request& request : requests) {
    const OpenCvModel& model = models.emplace_back(import_opencv(files, request.keys));
    // Refuses a lens that does not invert, before anything is written.
    (void)Lens(model.lensmodel, model.intrinsics, {request.imagersize[0], request.imagersize[1]},
               request.name);
  }
  begin_output(o.out, {"twin.toml"});
  std::string toml = "schema = \"fringetwin-twin/1\"\nname = \"imported rig\"\ncameramodel_unit = \"m\"\n";
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const std::string file = requests[i].name + ".cameramodel";
    write_model(std::filesystem::path(o.out) / file, requests[i], models[i], o);
    toml += i < o.cameras.size()
                ? fmt::format("\n[[camera]]\nname = \"{}\"\nmodel = \"{}\"\n", requests[i].name, file)
                : fmt::format("\n[projector]\nmodel = \"{}\"\nintensity = 40.0\n", file);
  }
  toml +=
      "\n# Describe the projected sequence (docs/FORMATS.md), then the part and what to fit.\n"
      "[fringes]\ndirections = [\"x\"]\npitches_px = [13, 14, 15]\nsteps = 4\nunwrap = \"heterodyne\"\n";
  write_text_file(std::filesystem::path(o.out) / "twin.toml", toml);
  say(fmt::format("wrote {} model file(s) and twin.toml to {}", requests.size(), o.out));
  return 0;
}

}  // namespace

void add_import(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<Options>();
  CLI::App* import = app.add_subcommand("import", "Bring in a foreign calibration");
  import->require_subcommand(1);
  CLI::App* opencv = import->add_subcommand("opencv", "OpenCV YAML/XML files (cv::FileStorage)");
  opencv->add_option("files", options->files, "YAML or XML files")->required();
  opencv->add_flag("--list", options->list, "List the matrices in the files and stop");
  opencv->add_option("--camera", options->cameras,
                     "NAME=MATRIX,DISTORTION[,ROTATION,TRANSLATION]@WIDTHxHEIGHT; once per camera; x_cam = R "
                     "x_ref + T; only "
                     "the first may leave out its place");
  opencv->add_option("--projector", options->projector,
                     "MATRIX,DISTORTION,ROTATION,TRANSLATION@WIDTHxHEIGHT");
  opencv->add_option("--unit", options->unit, "Unit of the translations in the files: mm or m")
      ->check(CLI::IsMember({"mm", "m"}))
      ->capture_default_str();
  opencv->add_option("--out", options->out, "Folder for the .cameramodel files and twin.toml");
  opencv->callback([options, &invocation] { invocation.run = [options] { return run(*options); }; });
}

}  // namespace fringetwin::cli
