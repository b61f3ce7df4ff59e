// SPDX-License-Identifier: Apache-2.0
#include "cli/flags.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/pipeline.hpp"
#include "twin/errors.hpp"

namespace fringetwin::cli {

void add_render_flags(CLI::App& sub, RenderFlags& flags) {
  sub.add_option("--samples", flags.samples, "Samples per pixel (gauss: a square number)");
  sub.add_option("--sampler", flags.sampler, "gauss, multi-jittered or sobol")
      ->check(CLI::IsMember({"gauss", "multi-jittered", "sobol"}));
  sub.add_option("--phase-error", flags.phase_error_rad,
                 "Target rms phase error, rad (picks the cheapest scheme)")
      ->check(CLI::PositiveNumber);
  sub.add_option("--seed", flags.seed, "Seed of noise and random samplers")->capture_default_str();
  sub.add_option("--device", flags.device, "A part of a Vulkan device's name, or \"list\"");
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
