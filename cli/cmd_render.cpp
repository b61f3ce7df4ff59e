// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/pipeline.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cli {

namespace {

struct RenderCommand {
  std::string twin;
  std::string out;
  RenderFlags flags;
};

int run_render(const RenderCommand& o) {
  if (o.flags.device == "list") return print_devices();
  if (o.twin.empty())
    throw UserError(ExitCode::usage, "render", "no twin given", "fringetwin render TWIN.toml --out DIR");
  if (o.out.empty()) throw UserError(ExitCode::usage, "render", "no output folder given", "add --out DIR");
  check_out_folder(o.out);
  const Twin twin = load_renderable_twin(o.twin);
  check_renderable(twin);
  StageTimer timer;
  render::Renderer renderer(o.flags.device);
  timer.start("render");
  const Simulated simulated = simulate(twin, o.flags, renderer);
  timer.start("write");
  write_simulated(o.out, simulated, o.flags.radiance, o.flags.seed, twin);
  timer.stop();
  for (const compare::RenderNote& note : simulated.notes) say(note.camera + ": " + note.text());
  say(fmt::format("rendered {} camera(s) x {} images in {:.2f} s on {}; written to {} in {:.2f} s",
                  simulated.captures.size(), simulated.captures.front().images.size(),
                  timer.seconds["render"], simulated.device, o.out, timer.seconds["write"]));
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

void add_render(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<RenderCommand>();
  CLI::App* sub =
      app.add_subcommand("render", "Render every image of the sequence as each camera would record it");
  sub->add_option("twin", options->twin, "The twin.toml");
  sub->add_option("--out", options->out, "Folder for the capture set (made if missing)");
  add_render_flags(*sub, options->flags);
  sub->add_flag("--radiance", options->flags.radiance, "Also write float32 EXR images (E before the sensor)");
  sub->callback([options, &invocation] { invocation.run = [options] { return run_render(*options); }; });
}

}  // namespace fringetwin::cli
