// SPDX-License-Identifier: Apache-2.0
// needs: what each effect changes and costs, and the smallest model for a tolerance.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/version.hpp"
#include "cosim/measured_shapes.hpp"
#include "cosim/write_results.hpp"
#include "tradeoff/needs.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {

namespace {

struct NeedsCommand {
  std::string twin, out, device;
  tradeoff::NeedsOptions needs;
};

int run_needs(NeedsCommand o, const Invocation& invocation) {
  check_out_folder(o.out);
  const Twin twin = cosim::load_renderable_twin(o.twin);
  o.needs.subset.seed = o.needs.seed;
  render::Renderer renderer(o.device);
  const tradeoff::NeedsResult result = tradeoff::run_needs(twin, renderer, o.needs);
  const auto provenance = cosim::make_provenance({invocation.argv, version_string()}, twin, {},
                                                 {renderer.device().name, o.needs.seed});
  const std::filesystem::path dir = o.out;
  begin_output(dir, {"needs.json"});
  write_text_file(dir / "needs.html", tradeoff::needs_html(twin, result, o.needs, provenance));
  write_text_file(dir / "needs.json", tradeoff::needs_json(twin, result, o.needs, provenance));
  for (const auto& warning : result.warnings) warn(warning);
  fmt::print("{}", tradeoff::needs_table(result, o.needs));
  say("page: " + (dir / "needs.html").string());
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

void add_needs(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<NeedsCommand>();
  CLI::App* sub = app.add_subcommand(
      "needs", "What each effect changes and costs on this scene; the smallest model for a tolerance");
  sub->add_option("twin", o->twin, "The twin.toml")->required();
  sub->add_option("--out", o->out, "Folder for needs.json and needs.html")->required();
  sub->add_option("--phase-tolerance", o->needs.tolerance.phase_rad, "Largest change of the phase, rad rms")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_option("--gray-tolerance", o->needs.tolerance.gray_dn, "Largest change of the gray value, DN rms")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_option("--fit-tolerance", o->needs.tolerance.fit_mm, "Largest change of a fitted quantity, mm")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_option("--windows", o->needs.subset.windows_per_camera, "Windows of pixels looked at per camera")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  sub->add_option("--rounds", o->needs.rounds, "Timed renders of each side")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub->add_option("--seed", o->needs.seed, "Seed of the pixel choice, of noise and random samplers")
      ->capture_default_str();
  sub->add_option("--device", o->device, "A part of a Vulkan device's name");
  sub->callback(
      [o, &invocation] { invocation.run = [o, &invocation] { return run_needs(*o, invocation); }; });
}

}  // namespace fringetwin::cli
