// SPDX-License-Identifier: Apache-2.0
// photometry: gray values of real captures -> sensor, projector response, fringe contrast, vignetting.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "calib/page/photometry_page.hpp"
#include "cli/commands.hpp"
#include "cli/option_groups.hpp"
#include "cli/option_values.hpp"
#include "cli/tell/json_output.hpp"
#include "cli/twin_argument.hpp"
#include "compare/result/provenance.hpp"
#include "compare/verdict/limits.hpp"
#include "cosim/load.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"
#include "twin/merge/merge_into_twin.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

struct PhotometryCommand {
  std::string twin, out, into, channel;
  std::vector<std::string> captures, dark, flat, series;
  bool json = false;
};

/// "[CAMERA=]GLOB[@EXPOSURE_MS]"; the camera may be left out where there is only one.
struct Images {
  std::size_t camera = 0;
  std::string glob;
  std::optional<double> exposure_ms;
  std::vector<fs::path> files;
};

Images parse_images(const Twin& twin, const std::string& option, const std::string& text,
                    bool may_have_exposure) {
  Images out;
  const CameraArgument argument = parse_camera_argument(twin, option, text);
  out.camera = argument.camera;
  out.glob = argument.value;
  const auto at = out.glob.rfind('@');
  if (may_have_exposure && at != std::string::npos) {
    const double value = parse_number<double>(std::string_view(out.glob).substr(at + 1)).value_or(0.0);
    if (!(value > 0.0) || !std::isfinite(value))
      throw UserError(ExitCode::usage, option + " " + text, "the exposure behind @ is no positive number",
                      "write e.g. 'level1/*.png@20' for 20 ms");
    out.exposure_ms = value;
    out.glob.resize(at);
  }
  out.files = glob_files(out.glob);
  if (out.files.empty())
    throw UserError(ExitCode::input, option + " " + out.glob, "matches no image", "quote the glob");
  return out;
}

std::vector<GrayImage> load_images(const Twin& twin, const Images& request,
                                   const std::optional<ColourChannel>& channel,
                                   std::vector<fs::path>& inputs) {
  const Camera& camera = twin.cameras[request.camera];
  std::vector<GrayImage> images;
  for (const fs::path& file : request.files) {
    ImageF image = read_camera_gray(file, camera, channel).image;
    for (const float v : image.data)
      if (static_cast<double>(v) > camera.sensor.max_dn())
        throw UserError(ExitCode::input, file.string(),
                        fmt::format("has the gray value {}, above the {} bits of camera {}", v,
                                    camera.sensor.bit_depth, camera.name),
                        "set bit_depth under [camera.sensor]");
    images.push_back(GrayImage::packed(std::move(image)));
    inputs.push_back(file);
  }
  return images;
}

std::vector<calib::CameraFrames> load_frames(const Twin& twin, const PhotometryCommand& o,
                                             std::vector<fs::path>& inputs) {
  std::vector<calib::CameraFrames> frames(twin.cameras.size());
  std::vector<std::string> folders = o.captures;
  if (folders.empty() && o.series.empty() && twin.real.captures)
    folders.push_back(twin.real.captures->string());
  if (folders.empty() && o.series.empty() && o.dark.empty() && o.flat.empty())
    throw UserError(ExitCode::usage, "photometry", "has no images to work on",
                    "give --captures, --series, --dark or --flat, or [real] captures in the twin");
  for (const std::string& folder : folders) {
    cosim::Captures set = cosim::load_captures(twin, folder);
    for (std::size_t c = 0; c < set.cameras.size(); ++c)
      frames[c].captures.push_back(std::move(set.cameras[c]));
    inputs.insert(inputs.end(), set.files.begin(), set.files.end());
  }
  const std::optional<ColourChannel> channel = colour_channel_of(o.channel);
  const auto append = [&](const std::string& option, const std::vector<std::string>& texts,
                          std::vector<GrayImage> calib::CameraFrames::*to) {
    for (const std::string& text : texts) {
      const Images request = parse_images(twin, option, text, false);
      for (GrayImage& image : load_images(twin, request, channel, inputs))
        (frames[request.camera].*to).push_back(std::move(image));
    }
  };
  append("--dark", o.dark, &calib::CameraFrames::dark);
  append("--flat", o.flat, &calib::CameraFrames::flat);
  for (const std::string& text : o.series) {
    const Images request = parse_images(twin, "--series", text, true);
    frames[request.camera].series.push_back(
        {request.glob, load_images(twin, request, channel, inputs), request.exposure_ms});
  }
  return frames;
}

std::string pm(const calib::Estimate& e, int digits) {
  return fmt::format("{:.{}g} ± {:.2g}", e.value, digits, e.sigma);
}

void print_summary(const calib::Photometry& p) {
  for (const auto& c : p.cameras) {
    if (c.black_measured) fmt::print("{}: black level {} DN\n", c.camera, pm(c.black_level_dn, 5));
    if (c.transfer) {
      const auto& t = *c.transfer;
      fmt::print("{}: {} DN/e- ({} e-/DN) from {}, read noise {}\n", c.camera, pm(t.dn_per_electron, 4),
                 pm(t.electrons_per_dn, 4), c.noise_from,
                 std::isfinite(t.read_noise_dn.value) ? pm(t.read_noise_dn, 3) + " DN" : "not told");
      fmt::print(
          "{}: noise on its line to {:.1f} % rms ({:.1f} % worst) over {:.0f}...{:.0f} DN; gain changes by "
          "{} over it\n",
          c.camera, 100.0 * t.residual_rms, 100.0 * t.residual_worst, t.low_dn, t.high_dn,
          pm(t.slope_change, 2));
    }
    fmt::print("{}: {}\n", c.camera,
               c.saturation.reached ? fmt::format("saturates at {:.0f} DN ({:.2g} % of the values)",
                                                  c.saturation.level_dn, 100.0 * c.saturation.fraction)
                                    : "saturation not reached");
    if (c.linearity)
      fmt::print("{}: level against exposure straight to {:.2f} % (worst)\n", c.camera,
                 c.linearity->worst_percent);
    if (c.response) {
      const calib::ResponseFit& r = *c.response;
      fmt::print(
          "{}: response {}; every second exposure predicted to {:.3f} DN rms ({:.3f} with its own light)\n",
          c.camera,
          r.has_knee ? fmt::format("with a knee at {} DN, slope times {}", pm(r.knee_dn, 4),
                                   pm(r.knee_slope_ratio, 3))
                     : "without a knee",
          r.held_out_rms_dn, r.held_out_rms_own_light_dn);
    }
    if (c.flat) fmt::print("{}: {:.4f} of the light at the corners\n", c.camera, c.flat->corner);
    if (c.factors)
      fmt::print("{}: gains of the pixels differ by {:.3g} % rms, each known to {:.2g} %\n", c.camera,
                 100.0 * c.factors->rms, 100.0 * c.factors->noise);
    if (c.offsets)
      fmt::print("{}: offsets of the pixels differ by {:.3g} DN rms, each known to {:.2g} DN\n", c.camera,
                 c.offsets->rms, c.offsets->noise);
    if (c.light) {
      const auto [least, most] = std::ranges::minmax(c.light->factor);
      const double sigma = measure::largest_told(c.light->sigma);
      fmt::print(
          "{}: light of the images {:+.2f} ... {:+.2f} % (± {}){}\n", c.camera, 100.0 * (least - 1.0),
          100.0 * (most - 1.0), std::isfinite(sigma) ? fmt::format("{:.2g} %", 100.0 * sigma) : "unknown",
          c.light->differ() ? fmt::format(", which moves the phase by {:.2g} rad rms", c.light->phase_rms_rad)
                            : ", no more than chance");
    }
  }
  if (const auto* q = p.projector()) {
    if (q->response_known)
      fmt::print("projector: gamma {}, {:.2g} of the range off it\n", pm(q->gamma, 4), q->gamma_misfit);
    if (std::isfinite(q->blur_px.value)) fmt::print("projector: blur {} px\n", pm(q->blur_px, 3));
  }
}

/// Writes the maps of pixels that photometry.toml names.
void write_maps(const fs::path& dir, const calib::Photometry& photometry) {
  for (const calib::CameraPhotometry& c : photometry.cameras) {
    if (c.factors && c.factors->is_told())
      write_exr(dir / calib::pixel_map_file("prnu", c.camera), {{"factor", &c.factors->map}});
    if (c.offsets && c.offsets->is_told())
      write_exr(dir / calib::pixel_map_file("dsnu", c.camera), {{"offset_dn", &c.offsets->map}});
  }
}

/// Returns the tables, without keys, that photometry of the twin may have values for.
std::vector<TomlBlock> photometry_tables(const Twin& twin) {
  std::vector<TomlBlock> tables;
  for (const Camera& camera : twin.cameras)
    tables.push_back({.table = {"camera", "sensor"}, .entry = camera.name});
  if (twin.projector) tables.push_back({.table = {"projector"}});
  return tables;
}

/// Puts the values into the twin; the maps of pixels, which lie in `out`, by their path from there.
void put_into_twin(const calib::Photometry& photometry, const std::string& into, const fs::path& out) {
  std::vector<TomlBlock> blocks = calib::photometry_blocks(photometry);
  name_files_from(into, out, {"prnu", "dsnu"}, blocks);
  const std::size_t n = merge_into_twin(into, blocks);
  say(fmt::format("{} measured {} put into {}", n, n == 1 ? "value" : "values", into));
}

int run_photometry(const PhotometryCommand& o, const Invocation& invocation) {
  check_out_folder(o.out);
  const Twin twin = compare::load_checked_twin(o.twin);
  if (!o.into.empty()) check_merge_into_twin(o.into, photometry_tables(twin));
  std::vector<fs::path> inputs = twin.input_files;
  const std::vector<calib::CameraFrames> frames = load_frames(twin, o, inputs);
  const calib::Photometry photometry = calib::analyse_photometry(twin, frames);
  const calib::Origin origin{invocation.argv, version_string(), compare::sha256_of_files(inputs)};
  const fs::path dir = o.out;
  begin_output(dir, {"photometry.json"});
  write_maps(dir, photometry);
  write_text_file(dir / "photometry.toml", calib::photometry_toml(photometry));
  write_text_file(dir / "photometry.html", calib::photometry_html(photometry, origin));
  write_text_file(dir / "photometry.json", calib::photometry_json(photometry, origin));
  for (const auto& warning : photometry.warnings) warn(warning);
  if (!print_json_if(o.json, dir / "photometry.json")) print_summary(photometry);
  say("blocks for twin.toml: " + (dir / "photometry.toml").string());
  if (!o.into.empty()) put_into_twin(photometry, o.into, dir);
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

void add_photometry(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<PhotometryCommand>();
  CLI::App* sub = app.add_subcommand(
      "photometry", "Captures -> sensor noise and gain, projector response, fringe contrast, vignetting");
  add_twin_argument(*sub, o->twin, "The twin.toml: image sizes, bit depths, fringes")->required();
  begin_group(*sub, kInput);
  sub->add_option("--captures", o->captures,
                  "Folder with a capture.toml; several folders: repeats of one still scene")
      ->type_name("DIR")
      ->default_str("the twin's [real]");
  sub->add_option("--series", o->series,
                  "[CAMERA=]GLOB[@EXPOSURE_MS]: repeated images of one level of light; once per level")
      ->type_name("FILES");
  sub->add_option("--dark", o->dark, "[CAMERA=]GLOB: images with the lens covered")->type_name("FILES");
  sub->add_option("--flat", o->flat, "[CAMERA=]GLOB: images of an evenly lit surface")->type_name("FILES");
  sub->add_option(
         "--channel", o->channel,
         "Colour that is taken of colour images of --series, --dark and --flat; a capture set says its "
         "own")
      ->type_name("COLOUR")
      ->check(CLI::IsMember(kColourChannelNames))
      ->default_str("colour images are refused");
  begin_group(*sub, kOutput);
  sub->add_option("--out", o->out,
                  "Folder for photometry.toml, photometry.json, photometry.html and the maps of pixels")
      ->type_name("DIR")
      ->required();
  add_json_flag(*sub, o->json, "photometry.json");
  add_twin_option(*sub, "--into", o->into,
                  "Put what was measured into this twin.toml; all its other lines stay");
  run_when_chosen(*sub, invocation, o, run_photometry);
}

}  // namespace fringetwin::cli
