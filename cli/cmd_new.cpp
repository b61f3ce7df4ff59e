// SPDX-License-Identifier: Apache-2.0
// new: a commented twin.toml of a rig that is still to be built, and the commands to go on with.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "cli/commands.hpp"
#include "cli/option_groups.hpp"
#include "cli/option_values.hpp"
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
  double field_mm = 0.0;  ///< 0: half the distance
  NewRig rig;
};

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

int run_new(NewCommand& o) {
  o.rig.camera_px = size_of("--camera", o.camera);
  o.rig.projector_px = size_of("--projector", o.projector);
  o.rig.field_mm = o.field_mm > 0.0 ? o.field_mm : 0.5 * o.rig.distance_mm;
  check_out_folder(o.out);
  const fs::path file = fs::path(o.out) / "twin.toml";
  if (fs::exists(file))
    throw UserError(ExitCode::usage, file.string(), "exists, and may be yours", "choose another --out");
  begin_output(o.out, {});
  write_text_file(file, new_twin_toml(o.rig));
  const auto line = [](const std::vector<std::string>& words) {
    fmt::print("  {}\n", report::shell_command(words));
  };
  const std::string twin = file.string(), rendered = (fs::path(o.out) / "rendered").string();
  fmt::print("wrote {}. Next:\n", twin);
  line({"fringetwin", "render", twin, "--out", rendered});
  line({"fringetwin", "measure", twin, "--captures", rendered, "--out",
        (fs::path(o.out) / "measured").string()});
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

void add_new(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<NewCommand>();
  CLI::App* sub = app.add_subcommand(
      "new", "A commented twin.toml of a rig that is still to be built (of a calibrated one: import)");
  begin_group(*sub, kOutput);
  sub->add_option("--out", o->out, "Folder for twin.toml; one that is there is not overwritten")
      ->type_name("DIR")
      ->capture_default_str();
  begin_group(*sub, "Rig");
  sub->add_option("--camera", o->camera, "WIDTHxHEIGHT in px, or 1.3MP, 2MP, 3MP, 5MP, 12MP, 20MP")
      ->type_name("SIZE")
      ->capture_default_str();
  sub->add_option("--cameras", o->rig.cameras, "One camera, or two with the projector between them")
      ->type_name("N")
      ->check(CLI::Range(1, 2))
      ->capture_default_str();
  sub->add_option("--projector", o->projector, "WIDTHxHEIGHT in px")
      ->type_name("SIZE")
      ->capture_default_str();
  sub->add_option("--distance", o->rig.distance_mm, "From the first camera to the part")
      ->type_name("MM")
      ->check(CLI::Range(1.0, 1e5))
      ->capture_default_str();
  sub->add_option("--baseline", o->rig.baseline_mm,
                  "From the camera to the projector, or from camera to camera where there are two")
      ->type_name("MM")
      ->check(CLI::Range(0.1, 1e5))
      ->capture_default_str();
  sub->add_option("--field", o->field_mm, "Width that the first camera sees at the distance")
      ->type_name("MM")
      ->check(CLI::Range(0.1, 1e5))
      ->default_str("half the distance");
  run_when_chosen(*sub, invocation, o, run_new);
}

}  // namespace fringetwin::cli
