// SPDX-License-Identifier: Apache-2.0
// pareto: error against time for every sampling scheme.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/version.hpp"
#include "cosim/measured_shapes.hpp"
#include "cosim/write_results.hpp"
#include "tradeoff/pareto.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {

namespace {

struct ParetoCommand {
  std::string twin, out, device;
  tradeoff::ParetoOptions pareto;
};

int run_pareto(ParetoCommand o, const Invocation& invocation) {
  check_out_folder(o.out);
  const Twin twin = cosim::load_renderable_twin(o.twin);
  o.pareto.subset.seed = o.pareto.seed;
  if (o.pareto.quick) {
    o.pareto.subset.windows_per_camera = std::min(o.pareto.subset.windows_per_camera, 4);
    o.pareto.reference = {8, 16, 24};
    o.pareto.rounds = 1;
  }
  render::Renderer renderer(o.device);
  const tradeoff::ParetoResult result = tradeoff::run_pareto(twin, renderer, o.pareto);
  const auto provenance = cosim::make_provenance({invocation.argv, version_string()}, twin, {},
                                                 {renderer.device().name, o.pareto.seed});
  const std::filesystem::path dir = o.out;
  begin_output(dir, {"pareto.json"});
  write_text_file(dir / "pareto.html", tradeoff::pareto_html(twin, result, o.pareto, provenance));
  write_text_file(dir / "pareto.json", tradeoff::pareto_json(twin, result, o.pareto, provenance));
  for (const auto& warning : result.warnings) warn(warning);
  fmt::print("{}", tradeoff::pareto_table(result));
  say("page: " + (dir / "pareto.html").string());
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

void add_pareto(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<ParetoCommand>();
  CLI::App* sub = app.add_subcommand(
      "pareto", "Error against time for every sampling scheme, sample count and precision on this scene");
  sub->add_option("twin", o->twin, "The twin.toml")->required();
  sub->add_option("--out", o->out, "Folder for pareto.json and pareto.html")->required();
  sub->add_flag("--quick", o->pareto.quick, "Few schemes, few pixels, one timing");
  sub->add_option(
         "--longest", o->pareto.longest_point_s,
         "A point that takes longer (s, all cameras) is rendered in windows only, its time extrapolated")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_option("--windows", o->pareto.subset.windows_per_camera, "Windows of pixels looked at per camera")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  sub->add_option("--rounds", o->pareto.rounds, "Timed renders of each point that is fast enough")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub->add_option("--seed", o->pareto.seed, "Seed of the pixel choice, of noise and random samplers")
      ->capture_default_str();
  sub->add_option("--device", o->device, "A part of a Vulkan device's name");
  sub->callback(
      [o, &invocation] { invocation.run = [o, &invocation] { return run_pareto(*o, invocation); }; });
}

}  // namespace fringetwin::cli
