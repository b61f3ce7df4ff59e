// SPDX-License-Identifier: Apache-2.0
// Finds out (`fringetwin needs`) what each effect changes and costs on the user's own scene, and the smallest
// model for a tolerance.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "compare/result/provenance.hpp"
#include "render/renderer.hpp"
#include "tradeoff/image_change.hpp"
#include "tradeoff/pixel_subset.hpp"
#include "tradeoff/recommend.hpp"
#include "twin/base/stopwatch.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/effects.hpp"
#include "twin/twin.hpp"

namespace fringetwin::tradeoff {

struct NeedsOptions {
  Tolerance tolerance{1e-2, 0.5, 1e-3};
  SubsetOptions subset;
  int rounds = 3;  ///< timed renders of each side, taken in turns; the smallest counts
  /// A side that takes longer than this is rendered once only, s.
  double once_above_s = 20.0;
  std::uint64_t seed = 0;
};

/// One fitted object with and without an effect.
struct FitChange {
  std::string object;
  double change_mm = 0.0;  ///< cosim::fit_distance_mm()
  std::size_t n_with = 0, n_without = 0;
};

struct EffectRow {
  std::string name, without, switch_on;
  EffectStage stage = EffectStage::light;
  bool on = false;
  // Only where the effect is on:
  ImageChange change;
  std::vector<FitChange> fits;
  Elapsed with, without_time;  ///< smallest of the rounds, whole images, render + sensor
  double cost = 1.0;           ///< time with / without: CPU time on a CPU device, else wall time
  bool leave_off = false;
  double fit_change_mm() const;  ///< largest; NaN when the chain has no fits
  Change judged() const;
};

struct NeedsResult {
  std::vector<EffectRow> rows;  ///< in the order of effects()
  PixelSubset subset;
  render::DeviceInfo device;
  bool has_fits = false;
  /// The renderer's own error on the subset against the double reference: changes below mean nothing.
  ImageChange floor;
  double reference_uncertainty_dn = 0.0;
  /// The recommended model as a whole against the full one.
  Change reduced;
  Elapsed full_time, reduced_time;
  double reduced_cost = 1.0;  ///< time of the full model / of the reduced one
  std::vector<std::string> warnings;
  std::map<std::string, double> timing_s;
};

/// Renders and measures the scene with and without each effect. Meshes must be loaded and measured shapes
/// built. Throws UserError(usage) without a projector or objects, Cancelled.
NeedsResult run_needs(const Twin& twin, render::Renderer& renderer, const NeedsOptions& options);

/// Returns the gray values that the cameras of `model` record, in the DN of the cameras of `units` (another
/// bit depth of the same range is scaled back), so that both can be compared and measured alike.
std::vector<CameraImages> expose_in_units_of(const Twin& units, const Twin& model,
                                             const std::vector<render::RenderedCamera>& rendered,
                                             std::uint64_t seed);

/// Returns the table as text, for stdout; the whole as JSON; the page.
std::string needs_table(const NeedsResult& result, const NeedsOptions& options);
std::string needs_json(const Twin& twin, const NeedsResult& result, const NeedsOptions& options,
                       const compare::Provenance& provenance);
std::string needs_html(const Twin& twin, const NeedsResult& result, const NeedsOptions& options,
                       const compare::Provenance& provenance);

}  // namespace fringetwin::tradeoff
