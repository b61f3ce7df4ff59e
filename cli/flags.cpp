// SPDX-License-Identifier: Apache-2.0
#include "cli/flags.hpp"

#include <fmt/format.h>
#include <glob.h>

#include <CLI/CLI.hpp>
#include <sstream>

#include "render/renderer.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::cli {
namespace {

/// CLI11's own Range prints its bounds with six decimals: 1e-8 as 0.000000.
CLI::Validator in_range(double min, double max) {
  return CLI::Validator(
      [min, max](const std::string& text) -> std::string {
        double value = 0.0;
        if (!CLI::detail::lexical_cast(text, value)) return fmt::format("must be a number, is \"{}\"", text);
        return value >= min && value <= max ? "" : fmt::format("must be {} ... {}, is {}", min, max, text);
      },
      fmt::format("{} ... {}", min, max));
}

}  // namespace

void add_render_flags(CLI::App& sub, cosim::RenderRequest& request) {
  sub.add_option("--samples", request.samples, "Samples per pixel (gauss: a square number)");
  sub.add_option("--sampler", request.sampler, "adaptive, gauss, multi-jittered or sobol")
      ->check(CLI::IsMember({"adaptive", "gauss", "multi-jittered", "sobol"}));
  sub.add_option("--phase-error", request.phase_error_rad,
                 "Target rms phase error, rad (picks the cheapest scheme)")
      ->check(in_range(1e-8, 1.0));
  sub.add_option("--gray-error", request.gray_error,
                 "Target rms gray error over all pixels, fraction of full scale (adaptive)")
      ->check(in_range(1e-8, 1.0));
  sub.add_option("--seed", request.seed, "Seed of noise and random samplers")
      ->check(in_range(0.0, 18446744073709551615.0))
      ->capture_default_str();
  sub.add_option("--device", request.device, "A part of a Vulkan device's name, or \"list\"");
}

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> out;
  std::stringstream list(text);
  for (std::string item; std::getline(list, item, ',');) out.push_back(item);
  return out;
}

std::optional<std::array<int, 2>> parse_size(const std::string& text) {
  std::array<int, 2> size{};
  char by = 0;
  std::stringstream in(text);
  if (!(in >> size[0] >> by >> size[1]) || by != 'x' || in.peek() != EOF) return std::nullopt;
  return size;
}

std::string starting_twin_toml(const std::string& name,
                               const std::vector<std::pair<std::string, bool>>& devices) {
  std::string toml =
      fmt::format("schema = \"fringetwin-twin/1\"\nname = \"{}\"\ncameramodel_unit = \"m\"\n", name);
  for (const auto& [device, is_projector] : devices)
    toml += is_projector
                ? fmt::format("\n[projector]\nmodel = \"{}.cameramodel\"\nintensity = 40.0\n", device)
                : fmt::format("\n[[camera]]\nname = \"{0}\"\nmodel = \"{0}.cameramodel\"\n", device);
  return toml +
         "\n# Describe the projected sequence (docs/FORMATS.md), then the part and what to fit.\n"
         "[fringes]\ndirections = [\"x\"]\npitches_px = [13, 14, 15]\nsteps = 4\nunwrap = \"heterodyne\"\n";
}

int print_devices() {
  const auto devices = render::list_devices();
  if (devices.empty())
    throw UserError(ExitCode::device, "Vulkan", "no device found",
                    "install a driver (Debian: mesa-vulkan-drivers) or set VK_ICD_FILENAMES");
  for (const auto& device : devices)
    fmt::print("{}\t{}\tVulkan {}\t{}\n", device.name, device.driver, device.api_version,
               device.is_cpu ? "cpu" : "gpu");
  return static_cast<int>(ExitCode::ok);
}

std::vector<std::filesystem::path> glob_files(const std::string& pattern) {
  glob_t found = {};
  std::vector<std::filesystem::path> files;
  if (glob(pattern.c_str(), 0, nullptr, &found) == 0)
    for (std::size_t i = 0; i < found.gl_pathc; ++i) files.emplace_back(found.gl_pathv[i]);
  globfree(&found);
  return files;
}

CameraArgument parse_camera_argument(const Twin& twin, const std::string& option, const std::string& text) {
  for (std::size_t c = 0; c < twin.cameras.size(); ++c)
    if (text.starts_with(twin.cameras[c].name + "="))
      return {c, text.substr(twin.cameras[c].name.size() + 1)};
  if (twin.cameras.size() > 1)
    throw UserError(ExitCode::usage, option + " " + text, "names no camera of the twin",
                    fmt::format("write {}={}", twin.cameras[0].name, text));
  return {0, text};
}

}  // namespace fringetwin::cli
