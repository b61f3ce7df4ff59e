// SPDX-License-Identifier: Apache-2.0
// Real against simulated: gain, gray, phase, geometry (docs/formats/results.md; docs/METRICS.md has
// the formula of every number).
#pragma once
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compare/result/indicator_row.hpp"
#include "compare/result/noise_row.hpp"
#include "compare/result/provenance.hpp"
#include "compare/result/shift_row.hpp"
#include "measure/measurement.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {
class Renderer;
}

namespace fringetwin::compare {

struct Side {
  std::vector<CameraImages> images;  ///< order of twin.cameras; empty = published numbers only
  std::optional<measure::Measurement> measurement;
  /// Irradiance of the simulated side where known (renderer or EXR), sequence order; may be empty.
  std::vector<CameraImages> irradiance;
};

/// One number that `--refine` changed; as shown (px for a blur, not px^2).
struct RefinedRow {
  std::string name, unit;
  double before = 0.0, after = 0.0, sigma = 0.0;
};
/// How a twin was fitted to the capture (refine.hpp).
struct Refinement {
  std::vector<std::string> asked;
  std::vector<RefinedRow> rows;
  double chi2_before = std::numeric_limits<double>::quiet_NaN(),
         chi2_after = chi2_before;  ///< per gray value
  std::uint64_t n = 0;
  int iterations = 0;
  bool converged = false;
  Eigen::MatrixXd covariance;  ///< of the parameters as fitted (a blur as its square), without switches
  std::vector<std::string> notes;
  /// With "texture": gain and black level of each camera that the pixels' factors refer to; see
  /// apply_texture().
  struct Line {
    double gain_dn = 0.0, black_level_dn = 0.0;
  };
  std::vector<std::optional<Line>> texture;  ///< order of twin.cameras; empty without
};

/// A side's decode of one camera; null where it was not measured.
inline const measure::CameraDecode* decode_of(const Side& side, std::size_t camera) {
  return side.measurement ? &side.measurement->cameras.at(camera) : nullptr;
}

struct CompareOptions {
  /// Phase steps of the gray/phase comparison; empty = all (a measured object is built from the
  /// even steps and compared with the odd ones).
  std::vector<int> use_steps;
  std::string note;  ///< what this comparison can and cannot show, printed in the report
  /// How exact the simulated images are; a camera that is not named counts as exact.
  std::vector<RenderNote> rendered;
  /// Renders changed twins to find the cause of what the budget does not explain; null: causes are not looked
  /// for.
  render::Renderer* renderer = nullptr;
  /// How the simulated images were rendered, for those of a changed rig; default: the twin's own options.
  std::optional<RenderOptions> render;
  std::uint64_t seed = 0;
  /// Of the twin, where it was refined before; passed on to the result.
  std::optional<Refinement> refinement;
};

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

struct GainRow {
  std::string camera;
  bool usable = false;  ///< false: too few usable samples, the numbers are NaN
  double gain_dn = 0, gain_sigma_dn = 0, black_level_dn = 0, black_level_sigma_dn = 0;
  double rms_before_dn = 0, rms_after_dn = 0, r2 = 0;
  std::uint64_t n = 0;      ///< gray values (pixel x image)
  std::string black_state;  ///< "fitted", or why the black level was held at the twin's
  /// Standard error ratio: cluster-robust / as if all residuals were independent. Far above 1 =
  /// spatially correlated residuals (albedo, shading, geometry), which the sigmas here allow for.
  double sigma_inflation = 1.0;
  double robust_scale_dn = 0, outlier_fraction = 0;  ///< 1.4826 MAD; share beyond the Huber threshold
  /// Range of predicted gray values used (values near a clip are left out).
  double low_dn = 0, high_dn = 0;
};
/// Where the residual variance after the gain fit comes from (docs/METRICS.md). All in DN²; the parts
/// add up to total.
struct GrayBudget {
  std::string camera;
  std::string noise_source;  ///< which estimate noise_dn2 is
  double total_dn2 = 0, noise_dn2 = 0, albedo_dn2 = 0, harmonics_dn2 = 0, geometry_dn2 = 0, rest_dn2 = 0;
  /// Of harmonics: the orders 0 and 1 (contrast and offset of the projected fringe), and the rest.
  double contrast_dn2 = 0, higher_orders_dn2 = 0;
  /// Straight line through that noise: variance = noise_offset_dn2 + noise_per_dn * DN.
  double noise_offset_dn2 = 0, noise_per_dn = 0;
  double albedo_sigma = 0;  ///< robust relative spread of the per-pixel scale factor
  /// Amplitude of order 0...6 of the common periodic residual, relative to the local mean gray
  /// value above black.
  std::vector<double> harmonic_amplitude;
  std::uint64_t n_pixels = 0, n = 0;
};
struct GrayRow {
  std::string camera;
  std::string pattern;  ///< PatternSpec::label
  double mean_dn = 0, rms_dn = 0, p99_dn = 0;
  std::uint64_t n = 0;
};
struct PhaseRow {
  std::string camera, direction;
  double mean_rad = 0, rms_rad = 0, p99_rad = 0, mean_relative = 0;
  std::uint64_t n = 0, n_order_disagree = 0;
  /// Of the pixels valid on both sides; NaN when there are none.
  double order_disagree_fraction() const {
    return n + n_order_disagree > 0
               ? static_cast<double>(n_order_disagree) / static_cast<double>(n + n_order_disagree)
               : kUnknown;
  }
};
/// Where the mean square of the phase difference comes from (docs/METRICS.md). All in rad^2; the parts add up
/// to total.
struct PhaseBudget {
  std::string camera, direction;
  int alias_order = 1;  ///< order of the ripple that projector harmonics leave in the steps used
  double total_rad2 = 0, offset_rad2 = 0, brightness_rad2 = 0, harmonic_rad2 = 0, noise_rad2 = 0,
         low_frequency_rad2 = 0, high_frequency_rad2 = 0;
  double harmonic_amplitude_rad = 0;  ///< of that order at the finest pitch
  std::uint64_t n = 0;
  /// Share of the variance about the mean that brightness, harmonics and noise explain.
  double explained() const {
    return (brightness_rad2 + harmonic_rad2 + noise_rad2) / (total_rad2 - offset_rad2);
  }
};
struct FitRow {
  std::string object, kind;
  std::optional<measure::ObjectFit> simulated, real;  ///< real may hold published numbers (n = 0)
  std::map<std::string, double> difference, z;        ///< simulated - real; z absent where a sigma is unknown
  std::map<std::string, Eigen::Vector3d> difference_vectors, z_vectors;
  /// Where a published real side gives an rms but no sigma: its sigmas, by their own keys, estimated from
  /// that rms, and the z they make (published_sigma.hpp).
  std::map<std::string, double> real_sigma_estimated, z_estimated;
  std::map<std::string, Eigen::Vector3d> real_sigma_estimated_vectors, z_estimated_vectors;
};
/// One entry of an uncertainty budget.
struct BudgetLine {
  std::string name;
  double variance = 0.0;  ///< square of the row's unit
};
/// Is a difference as large as the stated budget says it may be? (docs/METRICS.md, "Explained")
struct ExplainedRow {
  std::string quantity;  ///< "gray", "phase", "geometry"
  std::string region;    ///< camera, camera and direction, or object
  std::string unit;
  std::vector<BudgetLine> lines;
  double observed =
      kUnknown;  ///< mean square of the difference; geometry: of the quantity with the largest |z|
  /// Weighted mean square over single values, and over means of blocks of pixels, of what the budget allows.
  double chi2 = kUnknown, chi2_limit = kUnknown;
  double regional_chi2 = kUnknown, regional_limit = kUnknown;
  std::uint64_t n = 0, n_regions = 0;
  ImageF regions;     ///< chi2 per region of 16 x 16 px; NaN where too few pixels; empty for geometry
  std::string worst;  ///< geometry: the number with the largest |z|
  bool explained = false;
  double expected() const {
    double sum = 0.0;
    for (const BudgetLine& line : lines) sum += line.variance;
    return sum;
  }
};
struct CauseParameter {
  std::string name, unit;
  double twin = 0.0, estimate = 0.0, sigma = 0.0;
};
/// One way the twin may be wrong, fitted in one linear step.
struct CauseRow {
  std::string group, cause;
  double alone = 0.0;          ///< share of the excess chi2 that it takes away by itself
  int order = 0;               ///< 1 = the first one taken; 0 = not taken
  double in_order = kUnknown;  ///< share that it takes away after those before it
  std::vector<CauseParameter> parameters;
};
struct Causes {
  std::vector<CauseRow> rows;  ///< taken ones in order, then by their share
  std::string named;           ///< group of the first where it explains half or more; else empty
  double chi2 = kUnknown;      ///< per gray value, with the best gain and black level only
  bool textured = false;       ///< one factor per pixel was taken first
  double rest = kUnknown;      ///< share of the excess that all taken ones leave
  std::uint64_t n = 0;
};
struct LimitRow {
  std::string name;
  double value = 0, limit = 0;  ///< value NaN: nothing to check it on, counts as not met
  bool pass = false;
};

struct Comparison {
  std::vector<FitRow> fits;
  std::vector<Indicator> indicators;
  std::vector<GainRow> gain;
  std::vector<GrayRow> gray;
  std::vector<GrayBudget> gray_budget;
  std::vector<PhaseRow> phase;
  std::vector<PhaseBudget> phase_budget;
  std::vector<NoiseRow> noise;
  std::vector<ShiftRow> shift;
  std::vector<ExplainedRow> explained;
  Causes causes;
  std::optional<Refinement> refinement;
  std::vector<LimitRow> limits;
  bool pass = true;
  std::vector<std::string> warnings;
};

/// With twin.calibration_uncertainty and a renderer the calibration's covariance is part of the budgets; that
/// takes a rendering and a measurement per parameter.
/// All differences are simulated - real. Pixels whose predicted value is near a clip, saturated
/// pixels and images of another exposure are left out of gain and gray. A side without images leaves
/// gain, gray and phase empty. Throws UserError(usage) for an unknown name in twin.limits and
/// UserError(input) where the two sides do not belong together (sizes, number of images).
Comparison compare(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options);

}  // namespace fringetwin::compare
