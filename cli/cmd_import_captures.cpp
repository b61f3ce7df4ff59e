// SPDX-License-Identifier: Apache-2.0
// import captures: a folder of images that another program recorded -> a capture.toml that describes them
// where they lie.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>

#include "capture/record/journal.hpp"
#include "cli/commands.hpp"
#include "cli/option_groups.hpp"
#include "cli/option_values.hpp"
#include "cli/twin_argument.hpp"
#include "compare/verdict/limits.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/progress.hpp"
#include "twin/captures/foreign_set.hpp"
#include "twin/captures/natural_order.hpp"
#include "twin/captures/numbered_name.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

struct ImportCaptures {
  std::string twin, out, gray_code_exposure, channel;
  std::vector<std::string> maps, orders, white, black;
  bool overwrite = false;
};

constexpr const char* kMapExample = "write e.g. --map 'left=raw/L_*.png' or --map 'left=raw/L_%02d.png@1'";

/// One --map, taken apart.
struct Map {
  std::string option;        ///< as typed, for messages
  std::string source;        ///< a glob, or a file name with one number
  std::optional<int> first;  ///< @FIRST
  std::string order_text;    ///< of --order, may be empty
  std::vector<int> order;
};

Map parse_map(const std::string& value, const std::string& order, const std::string& option) {
  Map map{option, value, {}, order, parse_number_list(order)};
  if (!order.empty() && map.order.empty())
    throw UserError(ExitCode::usage, "--order " + order, "is no list of numbers", "write e.g. 0-11,14,12");
  const auto at = value.rfind('@');
  if (value.find('%') == std::string::npos || at == std::string::npos) return map;
  const int first = parse_number<int>(std::string_view(value).substr(at + 1)).value_or(-1);
  if (first < 0) throw UserError(ExitCode::usage, option, "the first number behind @ is none", kMapExample);
  if (!order.empty())
    throw UserError(ExitCode::usage, option, fmt::format("@{} and --order exclude each other", first),
                    "--order names the numbers in the file names");
  map.first = first;
  map.source.resize(at);
  return map;
}

/// Files whose names have a number: those --order lists, else from the first one to the first that is
/// missing.
std::vector<fs::path> numbered_files(const Map& map) {
  const auto name = parse_numbered_name(map.source);
  if (!name) throw UserError(ExitCode::usage, map.option, "must have one number such as %02d", kMapExample);
  std::vector<fs::path> files;
  for (const int number : map.order) files.emplace_back((*name)(number));
  if (!map.order.empty()) return files;
  std::error_code error;
  for (int number = map.first.value_or(0); fs::exists((*name)(number), error); ++number)
    files.emplace_back((*name)(number));
  if (files.empty())
    throw UserError(ExitCode::input, (*name)(map.first.value_or(0)), "no such image",
                    "name the first number after @, e.g. 'left=raw/L_%02d.png@1'");
  return files;
}

/// Files in natural order, or those of them that --order lists by their place, from 0.
std::vector<fs::path> globbed_files(const Map& map) {
  std::vector<fs::path> found = glob_files(map.source);
  if (found.empty()) throw UserError(ExitCode::input, map.option, "matches no image", "quote the glob");
  std::ranges::sort(
      found, [](const fs::path& a, const fs::path& b) { return natural_less(a.string(), b.string()); });
  if (map.order.empty()) return found;
  std::vector<fs::path> files;
  for (const int number : map.order) {
    if (number >= static_cast<int>(found.size()))
      throw UserError(ExitCode::usage, "--order " + map.order_text,
                      fmt::format("names image {}, {} matches {} (0 to {})", number, map.source, found.size(),
                                  found.size() - 1));
    files.push_back(found[number]);
  }
  return files;
}

/// One list per camera: given for all, or with CAMERA= for one.
std::vector<std::string> orders_of(const Twin& twin, const std::vector<std::string>& options) {
  std::vector<std::string> orders(twin.cameras.size());
  for (const std::string& text : options) {
    if (text.find('=') == std::string::npos) {
      std::ranges::fill(orders, text);
      continue;
    }
    const CameraArgument argument = parse_camera_argument(twin, "--order", text);
    orders[argument.camera] = argument.value;
  }
  return orders;
}

std::optional<double> parse_exposure(const std::string& text) {
  if (text.empty()) return {};
  if (text == "different") return std::nan("");
  const double value = parse_number<double>(text).value_or(0.0);
  if (!(value > 0.0) || !std::isfinite(value))
    throw UserError(ExitCode::usage, "--gray-code-exposure " + text,
                    "is neither a positive number nor \"different\"", "1 is the exposure of the phase steps");
  if (value == 1.0) return {};
  return value;
}

/// Leaves the images that are named as white and black out of those of the sequence, where there are more
/// than it has: a glob or a row of numbers finds them, too.
void leave_out_references(CaptureCamera& camera, std::size_t n_sequence) {
  if (camera.files.size() <= n_sequence) return;
  const auto is_reference = [&camera](const fs::path& file) {
    std::error_code none;
    return std::ranges::any_of(std::array{camera.white, camera.black},
                               [&](const std::optional<fs::path>& reference) {
                                 return reference && fs::equivalent(file, *reference, none);
                               });
  };
  std::vector<fs::path> others;
  std::ranges::remove_copy_if(camera.files, std::back_inserter(others), is_reference);
  if (others.size() == n_sequence) camera.files = std::move(others);
}

CaptureSet describe(const Twin& twin, const ImportCaptures& o) {
  CaptureSet set;
  set.file = fs::path(o.out) / "capture.toml";
  set.channel = colour_channel_of(o.channel);
  set.provenance["imported by"] = "fringetwin " + version_string();
  for (const Camera& camera : twin.cameras) {
    set.cameras.emplace_back().name = camera.name;
    set.cameras.back().gray_code_exposure = parse_exposure(o.gray_code_exposure);
  }
  const std::vector<std::string> orders = orders_of(twin, o.orders);
  std::vector<bool> has_order(twin.cameras.size(), false);
  for (const std::string& text : o.maps) {
    const CameraArgument argument = parse_camera_argument(twin, "--map", text);
    CaptureCamera& camera = set.cameras[argument.camera];
    if (!camera.files.empty())
      throw UserError(ExitCode::usage, "--map " + text,
                      fmt::format("camera \"{}\" has images already", camera.name),
                      "give one --map per camera");
    const Map map = parse_map(argument.value, orders[argument.camera], "--map " + text);
    const bool numbered = map.source.find('%') != std::string::npos;
    for (const fs::path& file : numbered ? numbered_files(map) : globbed_files(map))
      camera.files.push_back(tidy_path(file));
    camera.pattern = map.option;
    has_order[argument.camera] = !map.order.empty();
    set.provenance["source " + camera.name] = argument.value;
    if (!map.order.empty()) set.provenance["order " + camera.name] = map.order_text;
  }
  const auto add_reference = [&](const std::string& option, const std::vector<std::string>& texts,
                                 std::optional<fs::path> CaptureCamera::*reference) {
    for (const std::string& text : texts) {
      const CameraArgument argument = parse_camera_argument(twin, option, text);
      set.cameras[argument.camera].*reference = tidy_path(argument.value);
    }
  };
  add_reference("--white", o.white, &CaptureCamera::white);
  add_reference("--black", o.black, &CaptureCamera::black);
  for (std::size_t c = 0; c < set.cameras.size(); ++c)
    if (!has_order[c]) leave_out_references(set.cameras[c], expand_sequence(twin.fringes).size());
  for (const CaptureCamera& camera : set.cameras)
    if (camera.files.empty())
      throw UserError(ExitCode::usage, "import captures",
                      fmt::format("camera \"{}\" has no images", camera.name),
                      fmt::format("add --map '{}=...'", camera.name));
  return set;
}

void check_free(const ImportCaptures& o) {
  check_out_folder(o.out);
  const fs::path dir = o.out;
  if (fs::exists(dir / capture::kJournalName))
    throw UserError(ExitCode::usage, o.out, "holds an unfinished recording", "choose another folder");
  if (!o.overwrite && fs::exists(dir / "capture.toml"))
    throw UserError(ExitCode::usage, (dir / "capture.toml").string(), "is there already",
                    "choose another folder, or replace it with --overwrite");
}

int run_import_captures(const ImportCaptures& o) {
  check_free(o);
  const Twin twin = compare::load_checked_twin(o.twin);
  const CaptureSet set = describe(twin, o);
  check_foreign_set(set, twin);
  begin_output(o.out, {});
  write_foreign_set(set);
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  for (const CaptureCamera& camera : set.cameras)
    for (std::size_t i = 0; i < camera.files.size(); ++i)
      fmt::print("{}\t{}\t{}\t{}\n", camera.name, i, plain_text(sequence[i].label(twin.fringes)),
                 plain_text(camera.files[i].string()));
  say("described in " + set.file.string() + "; is each image what its line says?");
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

void add_import_captures(CLI::App& import, Invocation& invocation) {
  auto o = std::make_shared<ImportCaptures>();
  CLI::App* sub = import.add_subcommand(
      "captures", "Images that another program recorded: described where they lie, not copied");
  add_twin_argument(*sub, o->twin, "The twin.toml: its cameras and its sequence")->required();
  begin_group(*sub, kInput);
  sub->add_option("--map", o->maps,
                  "CAMERA=GLOB, in natural order (img2 before img10), or CAMERA=NAME%02dNAME[@FIRST], "
                  "numbered from FIRST (0); once per camera, quoted")
      ->type_name("CAMERA=FILES")
      ->required();
  sub->add_option("--order", o->orders,
                  "[CAMERA=]LIST: which image is each of the sequence, e.g. 0-11,14,12: places in the glob "
                  "from 0, or numbers in the names")
      ->type_name("LIST")
      ->default_str("as they are counted");
  sub->add_option("--white", o->white, "CAMERA=FILE: the image with the projector's white field")
      ->type_name("FILE");
  sub->add_option("--black", o->black, "CAMERA=FILE: the image with the projector's black field")
      ->type_name("FILE");
  sub->add_option("--gray-code-exposure", o->gray_code_exposure,
                  "Exposure of the Gray-code images relative to the phase steps, or \"different\"")
      ->type_name("FACTOR")
      ->default_str("1");
  sub->add_option("--channel", o->channel,
                  "Colour that is taken of colour images; gray ones stay as they are")
      ->type_name("COLOUR")
      ->check(CLI::IsMember(kColourChannelNames))
      ->default_str("colour images are refused");
  begin_group(*sub, kOutput);
  sub->add_option("--out", o->out, "Folder for capture.toml")->type_name("DIR")->required();
  sub->add_flag("--overwrite", o->overwrite, "Replace a capture.toml that is there");
  run_when_chosen(*sub, invocation, o, run_import_captures);
}

}  // namespace fringetwin::cli
