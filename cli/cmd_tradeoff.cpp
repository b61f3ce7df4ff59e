// SPDX-License-Identifier: Apache-2.0
// needs: what each effect changes and costs, and the smallest model for a tolerance.
// pareto: error against time for every sampling scheme.
#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/option_groups.hpp"
#include "cli/tell/json_output.hpp"
#include "cli/twin_argument.hpp"
#include "cosim/load.hpp"
#include "cosim/write_results.hpp"
#include "tradeoff/needs.hpp"
#include "tradeoff/pareto.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {
namespace {

template <class Options>
struct TradeoffCommand {
  std::string twin, out, device;
  bool json = false;
  Options options;
};

/// Measures, and writes `name`.html and `name`.json, whose texts `html` and `json` return. Returns the
/// result.
template <class Options, class Measure, class Text>
auto measure_and_write(const TradeoffCommand<Options>& o, const Invocation& invocation,
                       const std::string& name, Measure measure, Text html, Text json) {
  const Twin twin = cosim::load_renderable_twin(o.twin);
  render::Renderer renderer(o.device);
  const auto result = measure(twin, renderer, o.options);
  const auto provenance = cosim::make_provenance({invocation.argv, version_string()}, twin, {},
                                                 {renderer.device().name, o.options.seed});
  const std::filesystem::path dir = o.out;
  begin_output(dir, {name + ".json"});
  write_text_file(dir / (name + ".html"), html(twin, result, o.options, provenance));
  write_text_file(dir / (name + ".json"), json(twin, result, o.options, provenance));
  for (const auto& warning : result.warnings) warn(warning);
  return result;
}

template <class Options>
int tell(const std::string& table, const TradeoffCommand<Options>& o, const std::string& name) {
  const std::filesystem::path dir = o.out;
  if (!print_json_if(o.json, dir / (name + ".json"))) fmt::print("{}", table);
  say("page: " + (dir / (name + ".html")).string());
  return static_cast<int>(ExitCode::ok);
}

int run_needs(TradeoffCommand<tradeoff::NeedsOptions> o, const Invocation& invocation) {
  check_out_folder(o.out);
  o.options.subset.seed = o.options.seed;
  const auto result = measure_and_write(o, invocation, "needs", tradeoff::run_needs, tradeoff::needs_html,
                                        tradeoff::needs_json);
  return tell(tradeoff::needs_table(result, o.options), o, "needs");
}

int run_pareto(TradeoffCommand<tradeoff::ParetoOptions> o, const Invocation& invocation) {
  check_out_folder(o.out);
  o.options.subset.seed = o.options.seed;
  if (o.options.quick) {
    o.options.subset.windows_per_camera = std::min(o.options.subset.windows_per_camera, 4);
    o.options.reference = {8, 16, 24};
    o.options.rounds = 1;
  }
  const auto result = measure_and_write(o, invocation, "pareto", tradeoff::run_pareto, tradeoff::pareto_html,
                                        tradeoff::pareto_json);
  return tell(tradeoff::pareto_table(result), o, "pareto");
}

/// Adds the options that both have behind their own.
template <class Options>
void add_sampling_options(CLI::App& sub, TradeoffCommand<Options>& o, const std::string& rounds) {
  begin_group(sub, "Pixels and rounds");
  sub.add_option("--windows", o.options.subset.windows_per_camera, "Windows of pixels looked at per camera")
      ->type_name("N")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  sub.add_option("--rounds", o.options.rounds, rounds)
      ->type_name("N")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub.add_option("--seed", o.options.seed, "Seed of the pixel choice, of noise and random samplers")
      ->type_name("N")
      ->capture_default_str();
  begin_group(sub, kComputing);
  sub.add_option("--device", o.device, "A part of a Vulkan device's name")
      ->type_name("NAME")
      ->default_str("FRINGETWIN_DEVICE, else the CPU");
}

}  // namespace

void add_needs(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<TradeoffCommand<tradeoff::NeedsOptions>>();
  CLI::App* sub = app.add_subcommand(
      "needs", "What each effect changes and costs on this scene; the smallest model for a tolerance");
  add_twin_argument(*sub, o->twin, "The twin.toml")->required();
  begin_group(*sub, kOutput);
  sub->add_option("--out", o->out, "Folder for needs.json and needs.html")->type_name("DIR")->required();
  add_json_flag(*sub, o->json, "needs.json");
  begin_group(*sub, "Tolerance");
  tradeoff::Tolerance& tolerance = o->options.tolerance;
  for (const auto& [name, value, text] :
       {std::tuple{"--phase-tolerance", &tolerance.phase_rad, "Largest change of the phase, rad rms"},
        std::tuple{"--gray-tolerance", &tolerance.gray_dn, "Largest change of the gray value, DN rms"},
        std::tuple{"--fit-tolerance", &tolerance.fit_mm, "Largest change of a fitted quantity, mm"}})
    sub->add_option(name, *value, text)
        ->type_name(name[2] == 'p'   ? "RAD"
                    : name[2] == 'g' ? "DN"
                                     : "MM")
        ->check(CLI::Validator(CLI::NonNegativeNumber).description("0 or more"))
        ->capture_default_str();
  add_sampling_options(*sub, *o, "Timed renders of each side");
  run_when_chosen(*sub, invocation, o, run_needs);
}

void add_pareto(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<TradeoffCommand<tradeoff::ParetoOptions>>();
  CLI::App* sub = app.add_subcommand(
      "pareto", "Error against time for every sampling scheme, sample count and precision on this scene");
  add_twin_argument(*sub, o->twin, "The twin.toml")->required();
  begin_group(*sub, kOutput);
  sub->add_option("--out", o->out, "Folder for pareto.json and pareto.html")->type_name("DIR")->required();
  add_json_flag(*sub, o->json, "pareto.json");
  begin_group(*sub, "Pixels and rounds");
  sub->add_flag("--quick", o->options.quick, "Few schemes, few pixels, one timing");
  sub->add_option(
         "--longest", o->options.longest_point_s,
         "A point that takes longer (s, all cameras) is rendered in windows only, its time extrapolated")
      ->type_name("S")
      ->check(CLI::Validator(CLI::PositiveNumber).description("above 0"))
      ->capture_default_str();
  add_sampling_options(*sub, *o, "Timed renders of each point that is fast enough");
  run_when_chosen(*sub, invocation, o, run_pareto);
}

}  // namespace fringetwin::cli
