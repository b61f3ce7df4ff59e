// SPDX-License-Identifier: Apache-2.0
// render: the capture set that the cameras of a twin would record.
#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/option_groups.hpp"
#include "cli/render_flags.hpp"
#include "cli/twin_argument.hpp"
#include "cosim/load.hpp"
#include "cosim/write_results.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cli {
namespace {

struct RenderCommand {
  std::string twin;
  std::string out;
  cosim::RenderRequest request;
  bool radiance = false;
};

int run_render(const RenderCommand& o) {
  if (o.request.device == "list") return print_devices();
  if (o.twin.empty())
    throw UserError(ExitCode::usage, "render", "no twin given", "fringetwin render TWIN.toml --out DIR");
  if (o.out.empty()) throw UserError(ExitCode::usage, "render", "no output folder given", "add --out DIR");
  check_out_folder(o.out);
  const Twin twin = cosim::load_renderable_twin(o.twin);
  cosim::check_renderable(twin);
  StageTimer timer;
  render::Renderer renderer(o.request.device);
  timer.start("render");
  const cosim::Simulated simulated = cosim::simulate(twin, o.request, renderer);
  timer.start("write");
  cosim::write_simulated(o.out, twin, simulated.captures, o.radiance ? &simulated.irradiance : nullptr,
                         simulated.rendering);
  timer.stop();
  for (const compare::RenderNote& note : simulated.rendering.notes) say(note.camera + ": " + note.text());
  say(fmt::format("rendered {} camera(s) x {} images in {:.2f} s on {}; written to {} in {:.2f} s",
                  simulated.captures.size(), simulated.captures.front().images.size(),
                  timer.seconds["render"], simulated.rendering.device, o.out, timer.seconds["write"]));
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

void add_render(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<RenderCommand>();
  CLI::App* sub =
      app.add_subcommand("render", "Render every image of the sequence as each camera would record it");
  add_twin_argument(*sub, options->twin, "The twin.toml");
  begin_group(*sub, kOutput);
  sub->add_option("--out", options->out, "Folder for the capture set (made if missing)")->type_name("DIR");
  sub->add_flag("--radiance", options->radiance, "Also write float32 EXR images (E before the sensor)");
  add_render_flags(*sub, options->request);
  run_when_chosen(*sub, invocation, options, run_render);
}

}  // namespace fringetwin::cli
