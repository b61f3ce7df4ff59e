// SPDX-License-Identifier: Apache-2.0
#include "cli/render_flags.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/option_groups.hpp"
#include "cosim/other_noise.hpp"
#include "render/renderer.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::cli {
namespace {

constexpr const char* kTwinsElse1e4 = "what the twin says, else 1e-4";

/// CLI11's own Range prints its bounds with six decimals: 1e-8 as 0.000000.
/// `words`: how the range is told.
CLI::Validator in_range(double min, double max, const std::string& words) {
  return CLI::Validator(
      [min, max, words](const std::string& text) -> std::string {
        double value = 0.0;
        if (!CLI::detail::lexical_cast(text, value)) return fmt::format("must be a number, is \"{}\"", text);
        return value >= min && value <= max ? "" : fmt::format("must be {}, is {}", words, text);
      },
      words);
}
CLI::Validator in_range(double min, double max) {
  return in_range(min, max, fmt::format("{} ... {}", min, max));
}

}  // namespace

void add_render_flags(CLI::App& sub, cosim::RenderRequest& request) {
  begin_group(sub, kRendering);
  sub.add_option("--samples", request.samples, "Samples per pixel (gauss: a square number)")
      ->type_name("N")
      ->default_str("as many as the target asks for");
  sub.add_option("--sampler", request.sampler, "How the points within a pixel are chosen")
      ->type_name("NAME")
      ->check(CLI::IsMember({"adaptive", "gauss", "multi-jittered", "sobol"}))
      ->default_str("what the twin says, else adaptive");
  sub.add_option("--phase-error", request.phase_error_rad,
                 "Target rms phase error, rad (picks the cheapest scheme)")
      ->type_name("RAD")
      ->check(in_range(1e-8, 1.0))
      ->default_str(kTwinsElse1e4);
  sub.add_option("--gray-error", request.gray_error,
                 "Target rms gray error over all pixels, fraction of full scale (adaptive)")
      ->type_name("SHARE")
      ->check(in_range(1e-8, 1.0))
      ->default_str(kTwinsElse1e4);
  sub.add_option("--seed", request.seed, "Seed of noise and random samplers")
      ->type_name("N")
      ->check(in_range(0.0, 18446744073709551615.0, "0 ... 2^64 - 1"))
      ->default_str(std::to_string(cosim::kDefaultSeed));
  begin_group(sub, kComputing);
  sub.add_option("--device", request.device, "A part of a Vulkan device's name, or \"list\"")
      ->type_name("NAME")
      ->default_str("FRINGETWIN_DEVICE, else the CPU");
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

}  // namespace fringetwin::cli
