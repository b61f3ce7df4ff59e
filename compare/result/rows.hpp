// SPDX-License-Identifier: Apache-2.0
// Holds what one comparison of a real with a simulated side found, table by table and row by row, as plain
// values before they become JSON or a page. docs/METRICS.md leads to every formula. A number that is unknown
// is NaN; differences are simulated - real.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "measure/fit/fit_types.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::compare {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// The fits of one object on both sides, and how far they differ.
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
/// How many pixels of one camera and direction a measurement decoded, and what the repair of fringe orders
/// did.
struct DecodeRow {
  std::string camera, direction;
  std::uint64_t n_valid = 0, orders_checked = 0, orders_changed = 0, orders_left = 0;
};

/// One geometry indicator in mm: form, size, flatness or spacing (docs/metrics/geometry.md, "Indicators").
struct Indicator {
  /// sphere_form, sphere_form_95, sphere_size, plane_flatness, plane_flatness_95, sphere_spacing
  std::string name;
  std::vector<std::string> objects;  ///< two for a spacing
  struct Value {
    double mm = std::numeric_limits<double>::quiet_NaN(), sigma_mm = mm;
  };
  Value simulated, real;

  double difference_mm() const { return simulated.mm - real.mm; }
  /// NaN where a sigma is unknown.
  double z() const {
    const double sigma = std::hypot(simulated.sigma_mm, real.sigma_mm);
    return sigma > 0.0 ? difference_mm() / sigma : std::numeric_limits<double>::quiet_NaN();
  }
};

/// The line between simulated irradiance and the real gray values of one camera.
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
/// Where the residual variance after the gain fit comes from (docs/metrics/gray.md). All in DN²; the parts
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
/// The gray-value differences of one camera in one image after the gain fit.
struct GrayRow {
  std::string camera;
  std::string pattern;  ///< PatternSpec::label
  double mean_dn = 0, rms_dn = 0, p99_dn = 0;
  std::uint64_t n = 0;
};
/// The phase differences of one camera and direction at the finest pitch.
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
/// Where the mean square of the phase difference comes from (docs/metrics/phase.md). All in rad^2; the parts
/// add up to total.
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
/// Gray noise of one interval of gray levels.
struct NoiseLevel {
  double level_dn = 0, measured_dn = 0, predicted_dn = 0;
  std::uint64_t n = 0;
};

/// One camera and direction. Ratios are measured / predicted standard deviations, each value against its own
/// prediction.
struct NoiseRow {
  std::string camera, direction;
  bool sensor_known =
      false;      ///< false: the twin's sensor has no noise, so only its rounding is the prediction
  int steps = 0;  ///< N: the residuals of one pixel have N - 3 degrees of freedom
  double gray_measured_dn = 0, gray_predicted_dn = 0, gray_ratio = 0, gray_ratio_sigma = 0;
  std::uint64_t n = 0;
  double phase_measured_rad = 0, phase_predicted_rad = 0, phase_ratio = 0, phase_ratio_sigma = 0;
  std::uint64_t n_phase = 0;

  // for the page only
  std::vector<NoiseLevel> levels;
  ImageF ratio_map;  ///< gray ratio of blocks of kNoiseBlock px; NaN where too few values
  /// Quantiles of the residuals over their predicted sigma against those of the normal distribution.
  std::vector<double> normal_quantile, residual_quantile;
};

inline constexpr int kNoiseBlock = 24;

inline constexpr int kShiftBlock = 32;

/// One component over the blocks that tell it; NaN when none does.
struct ShiftComponent {
  double mean_px = 0, mean_sigma_px = 0, rms_px = 0, largest_px = 0;
  std::uint64_t n_blocks = 0;
};

/// The simulated image moved by (dx, dy) lies on the real one.
struct ShiftRow {
  std::string camera;
  ShiftComponent dx, dy;
  double chi2_before = 0, chi2_after = 0;  ///< per degree of freedom, of blocks that tell a component
  std::uint64_t n = 0;                     ///< gray values
  ImageF dx_px, dy_px;                     ///< one value per block; NaN where unknown
};

/// One entry of an uncertainty budget.
struct BudgetLine {
  std::string name;
  double variance = 0.0;  ///< square of the row's unit
};
/// The same with its share of the whole budget.
struct BudgetShare {
  std::string name;
  double variance = 0.0, share = 0.0;
};
/// Is a difference as large as the stated budget says it may be? (docs/metrics/verdict.md, "Explained")
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
  /// Returns the lines of the error budget, each with its share of the variance expected().
  std::vector<BudgetShare> shares() const;
};
/// Returns whether the error budget explains every row of this quantity; nullopt when there is no such row.
std::optional<bool> all_explained(const std::vector<ExplainedRow>& rows, const std::string& quantity);

/// What all_explained() says of each quantity: "explained", "not explained", or nothing.
struct BudgetVerdict {
  std::string gray, phase, geometry;
};

/// One number of the twin that a cause would change.
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
/// What may be wrong with the twin where noise does not explain the difference.
struct Causes {
  std::vector<CauseRow> rows;  ///< taken ones in order, then by their share
  std::string named;           ///< group of the first where it explains half or more; else empty
  double chi2 = kUnknown;      ///< per gray value, with the best gain and black level only
  bool textured = false;       ///< one factor per pixel was taken first
  double rest = kUnknown;      ///< share of the excess that all taken ones leave
  std::uint64_t n = 0;
};
/// One acceptance limit of the twin and whether the comparison meets it.
struct LimitRow {
  std::string name;
  double value = 0, limit = 0;  ///< value NaN: nothing to check it on, counts as not met
  bool pass = false;
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
  /// Returns the covariance as a list of rows, for JSON.
  std::vector<std::vector<double>> covariance_rows() const;
  std::vector<std::string> notes;
  /// With "texture": gain and black level of each camera that the pixels' factors refer to; see
  /// apply_texture().
  struct Line {
    double gain_dn = 0.0, black_level_dn = 0.0;
  };
  std::vector<std::optional<Line>> texture;  ///< order of twin.cameras; empty without
};

/// The tables in the order of result.json, the verdict on the limits, and the warnings.
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

struct Field;
/// The fields of each row type (fields.hpp), in the order of result.json. The pointer only chooses the row
/// type.
std::vector<Field> describe(const GainRow*);
std::vector<Field> describe(const GrayRow*);
std::vector<Field> describe(const GrayBudget*);
std::vector<Field> describe(const NoiseRow*);
std::vector<Field> describe(const ShiftRow*);
std::vector<Field> describe(const PhaseRow*);
std::vector<Field> describe(const PhaseBudget*);
std::vector<Field> describe(const Indicator*);
std::vector<Field> describe(const BudgetVerdict*);
std::vector<Field> describe(const BudgetShare*);
std::vector<Field> describe(const ExplainedRow*);
std::vector<Field> describe(const CauseParameter*);
std::vector<Field> describe(const CauseRow*);
std::vector<Field> describe(const Causes*);
std::vector<Field> describe(const RefinedRow*);
std::vector<Field> describe(const Refinement*);
std::vector<Field> describe(const LimitRow*);
std::vector<Field> describe(const DecodeRow*);

}  // namespace fringetwin::compare
