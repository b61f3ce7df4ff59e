// SPDX-License-Identifier: Apache-2.0
// new: a commented twin.toml of a rig that is still to be built, or of a calibrated one, and the commands to
// go on with.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>

#include "cli/commands.hpp"
#include "cli/import_rig.hpp"
#include "cli/option_groups.hpp"
#include "cli/option_values.hpp"
#include "cli/start/calibrated_twin.hpp"
#include "cli/start/new_twin.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/paths.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

struct NewCommand {
  std::string out = "rig", camera = "5MP", projector = "1280x720";
  std::vector<std::string> from;  ///< models of calibrated cameras; empty: a rig that is still to be built
  std::string from_projector;
  double field_mm = 0.0;  ///< 0: half the distance
  std::optional<double> distance_mm, ball_mm;
  NewRig rig;
};

constexpr double kMmPerMetre = 1000.0;  ///< models are in metres

/// Usual sensors by their size in millions of pixels.
const std::map<std::string, std::array<int, 2>> kSensors = {{"1.3MP", {1280, 1024}}, {"2MP", {1920, 1080}},
                                                            {"3MP", {2048, 1536}},   {"5MP", {2448, 2048}},
                                                            {"12MP", {4096, 3000}},  {"20MP", {5472, 3648}}};

std::array<int, 2> size_of(const std::string& option, const std::string& text) {
  if (const auto known = kSensors.find(text); known != kSensors.end()) return known->second;
  const auto size = parse_size(text);
  if (!size || std::ranges::any_of(*size, [](int px) { return px < 8 || px > 65535; }))
    throw UserError(ExitCode::usage, option + " " + text, "is no size",
                    "write WIDTHxHEIGHT (8 ... 65535 px), or 1.3MP, 2MP, 3MP, 5MP, 12MP, 20MP");
  return *size;
}

std::string text_of_new_rig(NewCommand& o) {
  o.rig.camera_px = size_of("--camera", o.camera);
  o.rig.projector_px = size_of("--projector", o.projector);
  o.rig.distance_mm = o.distance_mm.value_or(o.rig.distance_mm);
  o.rig.ball_mm = o.ball_mm;
  o.rig.field_mm = o.field_mm > 0.0 ? o.field_mm : 0.5 * o.rig.distance_mm;
  return new_twin_toml(o.rig);
}

/// Models of other programs need more than their file: which matrix is whose, the image size, the unit.
void check_is_model(const std::string& option, const std::string& file) {
  if (fs::path(file).extension() != ".cameramodel")
    throw UserError(
        ExitCode::usage, option + " " + file, "is no .cameramodel",
        "of other calibrations `fringetwin import` makes such models, and a twin.toml beside them "
        "(fringetwin import --help)");
}

/// Returns a file as twin.toml in `dir` names it: relative, so that both can be moved together.
std::string as_named_in(const fs::path& dir, const std::string& file) {
  // absolute: weakly_canonical() leaves a path relative whose first folder is not there yet
  const fs::path from = fs::weakly_canonical(fs::absolute(dir));
  return fs::weakly_canonical(fs::absolute(file)).lexically_relative(from).string();
}

std::string text_of_calibrated_rig(const NewCommand& o) {
  for (const std::string& file : o.from) check_is_model("--from", file);
  if (!o.from_projector.empty()) check_is_model("--from-projector", o.from_projector);
  const ImportedRig read = read_models(o.from, o.from_projector, kMmPerMetre);
  check_devices(read);
  CalibratedRig rig;
  rig.distance_mm = o.distance_mm;
  rig.ball_mm = o.ball_mm;
  for (const calib::ImportedDevice& device : read.devices)
    rig.cameras.push_back({device, as_named_in(o.out, device.where)});
  if (read.has_projector) {
    rig.projector = rig.cameras.back();
    rig.cameras.pop_back();
  }
  return calibrated_twin_toml(rig);
}

int run_new(NewCommand& o) {
  const std::string text = o.from.empty() ? text_of_new_rig(o) : text_of_calibrated_rig(o);
  check_out_folder(o.out);
  const fs::path file = fs::path(o.out) / "twin.toml";
  if (fs::exists(file))
    throw UserError(ExitCode::usage, file.string(), "exists, and may be yours", "choose another --out");
  begin_output(o.out, {});
  write_text_file(file, text);
  const auto line = [](const std::vector<std::string>& words) {
    fmt::print("  {}\n", report::shell_command(words));
  };
  const std::string twin = file.string(), rendered = (fs::path(o.out) / "rendered").string();
  fmt::print("wrote {}. Next:\n", twin);
  const bool renders = o.from.empty() || !o.from_projector.empty();
  if (renders) line({"fringetwin", "render", twin, "--out", rendered});
  line({"fringetwin", "measure", twin, "--captures", renders ? rendered : "CAPTURES", "--out",
        (fs::path(o.out) / "measured").string()});
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

void add_new(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<NewCommand>();
  CLI::App* sub = app.add_subcommand("new",
                                     "A commented twin.toml of a rig that is still to be built, or of "
                                     ".cameramodel files (other calibrations: "
                                     "import)");
  begin_group(*sub, kOutput);
  sub->add_option("--out", o->out, "Folder for twin.toml; one that is there is not overwritten")
      ->type_name("DIR")
      ->capture_default_str();
  begin_group(*sub, "Rig that is still to be built");
  std::vector<CLI::Option*> of_new_rigs;
  const auto rough = [&](CLI::Option* option) { of_new_rigs.push_back(option); };
  rough(sub->add_option("--camera", o->camera, "WIDTHxHEIGHT in px, or 1.3MP, 2MP, 3MP, 5MP, 12MP, 20MP")
            ->type_name("SIZE")
            ->capture_default_str());
  rough(sub->add_option("--cameras", o->rig.cameras, "One camera, or two with the projector between them")
            ->type_name("N")
            ->check(CLI::Range(1, 2))
            ->capture_default_str());
  rough(sub->add_option("--projector", o->projector, "WIDTHxHEIGHT in px")
            ->type_name("SIZE")
            ->capture_default_str());
  sub->add_option("--distance", o->distance_mm, "From the first camera to the part")
      ->type_name("MM")
      ->check(CLI::Range(1.0, 1e5))
      ->default_str("250; with --from: where the axes come nearest");
  sub->add_option("--ball", o->ball_mm, "Diameter of the ball to try the rig on")
      ->type_name("MM")
      ->check(CLI::Range(0.1, 1e4))
      ->default_str("half of the smaller side of what the camera sees");
  rough(sub->add_option("--baseline", o->rig.baseline_mm,
                        "From the camera to the projector, or from camera to camera where there are two")
            ->type_name("MM")
            ->check(CLI::Range(0.1, 1e5))
            ->capture_default_str());
  rough(sub->add_option("--field", o->field_mm, "Width that the first camera sees at the distance")
            ->type_name("MM")
            ->check(CLI::Range(0.1, 1e5))
            ->default_str("half the distance"));
  begin_group(*sub, "Calibrated rig");
  CLI::Option* from =
      sub->add_option("--from", o->from,
                      "The cameras' .cameramodel files in metres, one or two, the reference first")
          ->type_name("FILE")
          ->expected(1, 2)
          ->default_str("none");
  for (CLI::Option* option : of_new_rigs) from->excludes(option);
  sub->add_option("--from-projector", o->from_projector, "The projector's .cameramodel file")
      ->type_name("FILE")
      ->default_str("none")
      ->needs(from);
  run_when_chosen(*sub, invocation, o, run_new);
}

}  // namespace fringetwin::cli
