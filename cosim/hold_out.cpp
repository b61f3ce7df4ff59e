// SPDX-License-Identifier: Apache-2.0
#include "cosim/hold_out.hpp"

#include <fmt/format.h>

#include <utility>

#include "compare/held_out/held_out.hpp"
#include "cosim/measured_shapes.hpp"
#include "measure/measurement.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cosim {
namespace {

/// Returns the rows of one fold. A measured object's shape is told by the steps that are fitted alone.
std::vector<compare::HeldOutRow> rows_of(const Run& run, const RenderRequest& render,
                                         const std::vector<std::string>& asked, const compare::Fold& fold) {
  Twin rebuilt;
  compare::Side anew;
  compare::CompareOptions options = run.options;
  const bool is_measured = has_measured_shape(*run.as_written);
  if (is_measured) {
    rebuilt = *run.as_written;
    build_measured_shapes(rebuilt, run.real.images, fold.fitted);
    Simulated simulated = simulate(rebuilt, render, *run.renderer);
    anew.images = std::move(simulated.captures);
    anew.irradiance = std::move(simulated.irradiance);
    anew.measurement = measure::measure(rebuilt, anew.images, fold.fitted);
    options.rendered = simulated.rendering.notes;
  }
  return compare::predict_held_out({.twin = is_measured ? rebuilt : run.twin,
                                    .real = run.real.images,
                                    .simulated = is_measured ? anew : run.simulated,
                                    .options = options,
                                    .asked = asked,
                                    .fold = fold,
                                    .shape_leverage = measured_shape_leverage(*run.as_written)});
}

}  // namespace

void check_hold_out(const Run& run) {
  const int n_folds = run.twin.compare.hold_out;
  if (n_folds == 0) return;
  if (run.real.images.empty())
    throw UserError(ExitCode::usage, run.twin.file.string(),
                    "images to hold out must be real ones, but [real] names no captures",
                    "add [real] captures = \"FOLDER\"");
  compare::folds_of(run.twin.fringes.steps, n_folds);
}

void hold_out(Run& run, const RenderRequest& render, const std::vector<std::string>& asked) {
  if (run.twin.compare.hold_out == 0) return;
  run.timer.start("hold_out");
  const std::vector<compare::Fold> folds =
      compare::folds_of(run.twin.fringes.steps, run.twin.compare.hold_out);
  std::vector<compare::HeldOutRow> all;
  for (std::size_t f = 0; f < folds.size(); ++f) {
    throw_if_cancelled();
    say(fmt::format("hold-out: fold {} of {}", f + 1, folds.size()));
    for (compare::HeldOutRow& row : rows_of(run, render, asked, folds[f])) {
      row.fold = f + 1;
      row.folds = folds.size();
      all.push_back(std::move(row));
    }
  }
  run.options.held_out = std::move(all);
  run.timer.stop();
}

}  // namespace fringetwin::cosim
