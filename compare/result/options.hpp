// SPDX-License-Identifier: Apache-2.0
// Holds what a comparison is told besides the twin and the two sides: the phase steps to use, how the
// simulated images were rendered, and what came before it.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/result/held_out_table.hpp"
#include "compare/result/provenance.hpp"
#include "compare/result/rows.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {
class Renderer;
}

namespace fringetwin::compare {

struct CalibrationCovariance;
struct RigBudget;
struct ShapeNoise;

/// How one comparison is made.
struct CompareOptions {
  /// Phase steps of the gray/phase comparison; empty = all (a measured object is built from the
  /// even steps and compared with the odd ones).
  std::vector<int> use_steps;
  /// Images of the sequence that are not compared.
  std::vector<int> leave_out_images = {};
  std::string note;  ///< what this comparison can and cannot show, printed in the report
  /// How exact the simulated images are; a camera that is not named counts as exact.
  std::vector<RenderNote> rendered;
  /// Renders changed twins to find the cause of what the budget does not explain; null: causes are not looked
  /// for.
  render::Renderer* renderer = nullptr;
  /// True where the real images show other fringes than described: then causes are not looked for, either.
  bool shows_other_fringes = false;
  /// How the simulated images were rendered, for those of a changed rig; default: the twin's own options.
  std::optional<RenderOptions> render;
  /// With which seed. With a renderer, an untextured irradiance of the simulated side is taken for what it
  /// renders of the twin with these options and this seed.
  std::uint64_t seed = 0;
  /// What twin.calibration_uncertainty names, where it has been read already.
  std::shared_ptr<const CalibrationCovariance> calibration;
  /// Of the objects that were built from this capture; null: none were.
  std::shared_ptr<const ShapeNoise> shape_noise;
  /// Of the twin, where it was refined before; passed on to the result.
  std::optional<Refinement> refinement;
  /// The twin changed along each principal direction of the standard errors of the places that were refined,
  /// one of them far; empty: none were.
  std::vector<Twin> one_error_away = {};
  /// What these leave uncertain, where it is known already.
  std::shared_ptr<const RigBudget> refined_budget = {};
  std::vector<HeldOutRow> held_out;  ///< what images were predicted to that took no part in a fit; passed on
  std::vector<HeldOutMap> held_out_worst;  ///< of each camera, for the page
  /// Returns whether the simulated side has a factor or an offset per pixel from that refinement.
  bool textured() const { return refinement && !refinement->texture.empty(); }
};

}  // namespace fringetwin::compare
