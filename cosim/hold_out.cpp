// SPDX-License-Identifier: Apache-2.0
#include "cosim/hold_out.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "compare/held_out/held_out.hpp"
#include "compare/refine/asked_parameters.hpp"
#include "cosim/shape/measured_shapes.hpp"
#include "measure/measurement.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cosim {
namespace {

/// Returns whether what is asked for gives the pixels numbers of their own.
bool refits_texture(const std::vector<std::string>& asked) {
  return std::ranges::any_of(asked, [](const std::string& a) { return a == "texture" || a == "offset"; });
}

/// Returns the twin of one fold: a measured object's shape is told by the steps that are fitted alone; a
/// texture that is fitted anew has nothing of the one before, which may come from the images held out; and no
/// light is taken out of the images that are compared, which all of a pitch would tell. Besides, the leverage
/// of a measured shape. `told`: as of build_measured_shapes().
std::pair<Twin, double> twin_of_fold(const Run& run, const std::vector<std::string>& asked,
                                     const compare::Fold& fold, std::set<std::string>& told) {
  double leverage = 0.0;
  Twin twin = has_measured_shape(*run.as_written) ? *run.as_written : run.twin;
  twin.measure.correct_light = false;
  if (refits_texture(asked))
    for (Camera& camera : twin.cameras) camera.texture = nullptr;
  if (const auto noise = build_measured_shapes(twin, run.real.images, fold.fitted, &told))
    leverage = noise->leverage;
  return {std::move(twin), leverage};
}

/// Returns what the images of one fold are predicted to.
compare::HeldOut of_fold(const Run& run, const RenderRequest& render, const std::vector<std::string>& asked,
                         const compare::Fold& fold, std::set<std::string>& told) {
  const auto [twin, leverage] = twin_of_fold(run, asked, fold, told);
  const bool is_as_it_was =
      !has_measured_shape(*run.as_written) && !run.twin.measure.correct_light &&
      (!refits_texture(asked) ||
       std::ranges::none_of(run.twin.cameras, [](const Camera& c) { return c.texture != nullptr; }));
  compare::Side anew;
  compare::CompareOptions options = run.options;
  if (!is_as_it_was) {
    Simulated simulated = simulate(twin, render, *run.renderer);
    anew.images = std::move(simulated.captures);
    anew.irradiance = std::move(simulated.irradiance);
    anew.measurement = measure::measure(twin, anew.images, fold.fitted);
    options.rendered = simulated.rendering.notes;
  }
  return compare::predict_held_out({.twin = twin,
                                    .real = run.real.images,
                                    .simulated = is_as_it_was ? run.simulated : anew,
                                    .options = options,
                                    .asked = asked,
                                    .fold = fold,
                                    .shape_leverage = leverage});
}

}  // namespace

HeldOutBy held_out_by(const std::string& name) {
  if (name == "steps") return HeldOutBy::steps;
  if (name == "pitches") return HeldOutBy::pitches;
  throw UserError(ExitCode::usage, "--hold-out-by " + name, "is not known", "use steps or pitches");
}

void check_hold_out(const Run& run, const std::vector<std::string>& asked) {
  const int n_folds = run.twin.compare.hold_out;
  if (n_folds == 0 && run.twin.compare.hold_out_by == HeldOutBy::pitches)
    throw UserError(ExitCode::usage, "--hold-out-by pitches", "says no number of folds",
                    "add --hold-out K, or hold_out = K beside hold_out_by in [compare]");
  if (n_folds == 0) return;
  if (run.real.images.empty())
    throw UserError(ExitCode::usage, run.twin.file.string(),
                    "images to hold out must be real ones, but [real] names no captures",
                    "add [real] captures = \"FOLDER\"");
  if (run.twin.fringes.steps == 0 && has_measured_shape(run.twin))
    throw UserError(ExitCode::usage, run.twin.file.string(),
                    "no bit of a code alone can be held out of a measured shape: all of them told it",
                    "describe the object by its shape or a mesh");
  if (run.twin.compare.hold_out_by == HeldOutBy::pitches && has_measured_shape(run.twin))
    throw UserError(ExitCode::usage, run.twin.file.string(),
                    "no pitch can be held out of a measured shape: all of them told it",
                    "hold out phase steps, or describe the object by its shape or a mesh");
  compare::folds_of(run.twin.fringes, n_folds, run.twin.compare.hold_out_by);
  if (run.twin.compare.hold_out_by == HeldOutBy::pitches && !asked.empty() &&
      compare::refinable_parameters(run.twin, asked, {0}).size() <
          compare::refinable_parameters(run.twin, asked).size())
    throw UserError(
        ExitCode::usage, "--hold-out-by pitches",
        fmt::format("--refine {} asks for numbers of single images (exposure, light, shifts), and "
                    "nothing else tells those of a pitch that is held out",
                    fmt::join(asked, ",")),
        "leave these groups out, or hold out phase steps: --hold-out-by steps");
}

void hold_out(Run& run, const RenderRequest& render, const std::vector<std::string>& asked) {
  if (run.twin.compare.hold_out == 0) return;
  run.timer.start("hold_out");
  if (!refits_texture(asked))
    for (const Camera& camera : run.twin.cameras)
      if (camera.texture)
        warn(fmt::format(
            "{}: the twin's texture is not fitted anew for each fold: if it comes from these images, "
            "those held out are no independent ones",
            camera.name));
  const std::vector<compare::Fold> folds =
      compare::folds_of(run.twin.fringes, run.twin.compare.hold_out, run.twin.compare.hold_out_by);
  std::vector<compare::HeldOutRow> all;
  std::vector<compare::HeldOutMap> worst;
  std::set<std::string> told;  // warnings: once, not of each fold
  for (std::size_t f = 0; f < folds.size(); ++f) {
    throw_if_cancelled();
    say(fmt::format("hold-out: fold {} of {}", f + 1, folds.size()));
    compare::HeldOut predicted = of_fold(run, render, asked, folds[f], told);
    compare::keep_worst(worst, std::move(predicted.worst));
    for (compare::HeldOutRow& row : predicted.rows) {
      row.fold = f + 1;
      row.folds = folds.size();
      all.push_back(std::move(row));
    }
  }
  run.options.held_out = std::move(all);
  run.options.held_out_worst = std::move(worst);
  run.timer.stop();
}

}  // namespace fringetwin::cosim
