// SPDX-License-Identifier: Apache-2.0
// Holds the tables of a result that judge, refinement, the budget and its verdicts, causes and limits: their
// rows, and what each number of a row is. The formulas: docs/metrics/verdict.md and docs/metrics/causes.md.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/result/field_options.hpp"
#include "compare/result/own_kinds.hpp"
#include "twin/base/constants.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::compare {

/// One number that `--refine` changed; as shown (px for a blur, not px^2).
struct RefinedRow {
  std::string name, unit;
  double before = 0.0, after = 0.0, sigma = 0.0;

  static void describe(auto& f) {
    f.name("name", "parameter of the twin", &RefinedRow::name).shown({"parameter"});
    f.add("unit", "its unit", &RefinedRow::unit).shown({"unit"});
    f.add("before", "value in the twin as written", &RefinedRow::before)
        .without_images()
        .shown({"twin as written", "", Column::significant, 7});
    f.add("after", "fitted value", &RefinedRow::after).shown({"refined", "", Column::with_sigma});
    f.sigma("after_sigma", "its standard error", &RefinedRow::sigma);
  }
};

/// How a twin was fitted to the capture (refine.hpp).
struct Refinement {
  std::vector<std::string> asked;
  std::vector<RefinedRow> rows;
  double chi2_before = kNaN, chi2_after = kNaN;  ///< per gray value
  std::uint64_t n = 0;
  int iterations = 0;
  bool converged = false;
  Eigen::MatrixXd covariance;  ///< of the parameters as fitted (a blur as its square), without switches
  /// Returns the covariance as a list of rows, for JSON.
  std::vector<std::vector<double>> covariance_rows() const;
  std::vector<std::string> notes;
  std::vector<std::string> warnings;  ///< for those of the result
  bool taken_back = false;            ///< the twin is as it was
  bool by_light = false;              ///< places are told by the light, too (Evidence, compare/refine)
  OwnKinds own;                       ///< what "texture" and "offset" gave every pixel
  /// With either: gain and black level of each camera that the pixels' numbers refer to; see apply_texture().
  struct Line {
    double gain_dn = 0.0, black_level_dn = 0.0;
  };
  std::vector<std::optional<Line>> texture;  ///< order of twin.cameras; empty without
  /// The same of any refinement, of the fit before anything is taken back; none where a camera had no part.
  std::vector<std::optional<Line>> lines;

  static void describe(auto& f) {
    using Row = Refinement;
    f.add("asked", "what --refine was given", &Row::asked);
    f.add("parameters", "fitted parameters", &Row::rows);
    f.add("covariance", "of the parameters as fitted", &Row::covariance_rows);
    f.positive("chi2_before", "of a gray value, before the fit", &Row::chi2_before);
    f.positive("chi2_after", "of a gray value, after the fit", &Row::chi2_after);
    f.add("iterations", "steps of the fit", &Row::iterations);
    f.add("converged", "whether the fit came to rest", &Row::converged);
    f.add("n", "gray values used", &Row::n);
    f.add("notes", "what a reader must know of the fit", &Row::notes);
  }
};

/// What may be said of a row and of a quantity, from best to worst.
inline constexpr const char* kExplained = "explained";
inline constexpr const char* kTooWide = "budget too wide";
inline constexpr const char* kNotCompared = "not compared";
inline constexpr const char* kNotExplained = "not explained";
/// Returns the worse of two of these; empty: nothing was said.
std::string worse_state(const std::string& a, const std::string& b);

/// The worst state of the rows of each quantity; nothing where there is no row.
struct BudgetVerdict {
  std::string gray, phase, geometry, coverage, code;

  static void describe(auto& f) {
    const auto add = [&f](const char* key, const char* says, std::string BudgetVerdict::*verdict) -> auto& {
      return f.add(key, says, verdict).one_of({kExplained, kNotExplained, kTooWide, kNotCompared});
    };
    const char* says = "whether the budget explains all differences of this quantity";
    add("gray", says, &BudgetVerdict::gray).or_null();
    add("phase", says, &BudgetVerdict::phase).or_null();
    add("geometry", says, &BudgetVerdict::geometry).or_null();
    add("coverage", says, &BudgetVerdict::coverage).or_null();
    add("code", "the same of the images of a Gray code beside phase steps", &BudgetVerdict::code).or_absent();
  }
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

  static void describe(auto& f) {
    f.name("name", "source of uncertainty", &BudgetShare::name);
    f.positive("variance", "square of its standard uncertainty, in the row's unit squared",
               &BudgetShare::variance);
    f.positive("share", "of the expected mean square", &BudgetShare::share);
  }
};

/// Is a difference as large as the stated budget says it may be? (docs/metrics/verdict.md, "Explained")
struct ExplainedRow {
  std::string quantity, region, unit;
  std::vector<BudgetLine> lines;
  double observed = kNaN;  ///< geometry: of the quantity with the largest |z|
  /// Weighted mean square over single values, and over means of blocks of pixels, of what the budget allows.
  double chi2 = kNaN, chi2_limit = kNaN;
  double regional_chi2 = kNaN, regional_limit = kNaN;
  double regional_chi2_of_noise = kNaN;  ///< where nothing of the rig were uncertain
  std::uint64_t n = 0, n_regions = 0;
  ImageF regions;  ///< chi2 per region of 16 x 16 px; NaN where too few pixels; empty for geometry
  std::string worst;
  std::string state = kNotCompared, why;
  double noise_chi2 = kNaN, chi2_least = kNaN, too_wide_factor = kNaN, compared_fraction = kNaN;
  double brightness_chi2 = kNaN, harmonic_chi2 = kNaN, ripple_limit = kNaN;
  /// Of what regions differ by, the share that goes with what smoothing of a measured shape has changed.
  double smoothed_fraction = 0.0;
  bool states_noise = false;  ///< the budget's noise is what the twin says of its sensor
  bool explained() const { return state == kExplained; }
  /// Takes a state that is worse than its own, and a sentence to say why, if there is one.
  void worsen(const char* to, const std::string& because = "");
  /// Returns the sum of the budget; NaN without one.
  double expected() const {
    if (lines.empty()) return kNaN;
    double sum = 0.0;
    for (const BudgetLine& line : lines) sum += line.variance;
    return sum;
  }
  /// Returns the lines of the error budget, each with its share of the variance expected().
  std::vector<BudgetShare> shares() const;

  static void describe(auto& f) {
    using Row = ExplainedRow;
    f.name("quantity", "what is judged", &Row::quantity)
        .one_of({"gray", "phase", "geometry", "coverage", "code"});
    f.name("region", "camera, camera and direction, or object", &Row::region);
    f.add("unit", "unit of the difference", &Row::unit);
    f.positive("observed", "mean square of the difference, in the row's unit squared", &Row::observed);
    f.positive("expected", "sum of the budget", &Row::expected);
    f.add("budget", "sources of uncertainty that make the expected mean square", &Row::shares);
    f.positive("chi2", "mean over single values of the square over what the budget allows", &Row::chi2);
    f.positive("chi2_limit", "largest chi2 that counts as explained", &Row::chi2_limit);
    f.positive("regional_chi2", "the same over means of regions", &Row::regional_chi2);
    f.positive("regional_limit", "largest regional chi2 that counts as explained", &Row::regional_limit);
    f.add("n", "values judged", &Row::n);
    f.add("n_regions", "regions judged", &Row::n_regions);
    f.add("explained", "whether the state is \"explained\"", &Row::explained);
    f.add("state",
          "explained, or else: chi2 beyond its limit, most not compared, or less scatter than the budget's "
          "noise",
          &Row::state)
        .one_of({kExplained, kNotExplained, kTooWide, kNotCompared})
        .not_required();
    f.add("why", "sentences on the state", &Row::why).or_absent();
    f.positive("noise_chi2", "chi2 against noise and quantisation alone", &Row::noise_chi2).not_required();
    f.positive("chi2_least", "below this noise_chi2 says that the budget is too wide", &Row::chi2_least)
        .not_required();
    f.positive("too_wide_factor", "noise stated over noise seen, where the budget is too wide",
               &Row::too_wide_factor)
        .not_required();
    f.positive("brightness_chi2", "phase: ripple that images of unequal brightness leave, 1 for noise",
               &Row::brightness_chi2)
        .not_required();
    f.positive("harmonic_chi2", "phase: ripple that fringes which are no sinusoids leave, 1 for noise",
               &Row::harmonic_chi2)
        .not_required();
    f.positive("ripple_limit", "largest of these two that counts as explained", &Row::ripple_limit)
        .not_required();
    f.positive("compared_fraction", "share of what could have been compared that was compared",
               &Row::compared_fraction)
        .not_required();
    f.add("worst", "geometry: the number of the fit with the largest |z|", &Row::worst).or_absent();
  }
};
/// Returns the worst state of the rows of this quantity; empty when there is no such row.
std::string worst_state(const std::vector<ExplainedRow>& rows, const std::string& quantity);

/// One number of the twin that a cause would change.
struct CauseParameter {
  std::string name, unit;
  double twin = 0.0, estimate = 0.0, sigma = 0.0;

  static void describe(auto& f) {
    using Row = CauseParameter;
    f.name("name", "parameter of the twin", &Row::name);
    f.add("unit", "its unit", &Row::unit);
    f.add("twin", "value in the twin", &Row::twin).without_images();
    f.add("estimate", "value that would fit the real images", &Row::estimate);
    f.sigma("estimate_sigma", "its standard error", &Row::sigma);
  }
};

/// What a cause leaves in sums of one kind over regions.
struct CauseRegion {
  std::string kind;
  double chi2 = kNaN, limit = kNaN;
  std::uint64_t n = 0;
  bool passes() const { return n == 0 || chi2 <= limit; }

  static void describe(auto& f) {
    using Row = CauseRegion;
    f.name("kind", "what of a region is summed", &Row::kind).one_of({"level", "contrast", "shift", "image"});
    f.positive("chi2", "mean over regions of the squared sum over what noise allows", &Row::chi2);
    f.positive("limit", "largest chi2 that counts as explained", &Row::limit);
    f.add("n", "sums over regions", &Row::n);
  }
};

/// One way the twin may be wrong, fitted in one linear step, the likely ones to convergence.
struct CauseRow {
  std::string group, cause;
  double alone = kNaN;
  int order = 0;
  double in_order = kNaN;
  std::vector<CauseParameter> parameters;
  double chi2_after = kNaN;  ///< NaN: not fitted to convergence
  bool passes = false;
  std::vector<CauseRegion> regions_after;
  bool fits_agree = true;     ///< whether fit_z_after is within its limit; not written
  double fit_z_after = kNaN;  ///< NaN: not a cause that moves or grows objects, or no fit has a z
  double removed = 0.0;       ///< of chi2, less the number of parameters

  static void describe(auto& f) {
    using Row = CauseRow;
    f.name("group", "group of parameters that were fitted", &Row::group);
    f.add("cause", "what the twin may be wrong about", &Row::cause);
    f.add("alone", "share of the excess that it takes away by itself", &Row::alone);
    f.add("order", "1 for the first one taken, 0 for one that was not taken", &Row::order);
    f.add("in_order", "share of the excess that it takes away after those before it", &Row::in_order);
    f.add("parameters", "what the group would have to be", &Row::parameters);
    f.positive("chi2_after", "of a gray value, with the group fitted to convergence", &Row::chi2_after)
        .not_required();
    f.add("passes", "whether what it then leaves is explained, in values and regions", &Row::passes)
        .not_required();
    f.add("regions_after", "what it then leaves in regions", &Row::regions_after).not_required();
    f.positive("fit_z_after", "largest |z| of the objects' fits with what it moves and grows",
               &Row::fit_z_after)
        .not_required();
  }
};

/// Gain and black level of a camera as they are fitted together with the cause named.
struct CauseGain {
  std::string camera;
  double gain_dn = kNaN, gain_sigma_dn = kNaN, black_level_dn = kNaN, black_level_sigma_dn = kNaN;

  static void describe(auto& f) {
    using Row = CauseGain;
    f.name("camera", "camera of the twin", &Row::camera);
    f.add("gain_dn", "gain with the cause", &Row::gain_dn);
    f.sigma("gain_sigma_dn", "standard error of that gain", &Row::gain_sigma_dn);
    f.add("black_level_dn", "black level with the cause", &Row::black_level_dn);
    f.sigma("black_level_sigma_dn", "standard error of that black level", &Row::black_level_sigma_dn);
  }
};

/// Means of what is left of one camera's gray values over one of the coordinates of PatternRow.
struct PatternProfile {
  std::string camera;
  std::vector<double> at, at_y, mean, n;  ///< at_y: of places, and of phases in parts

  static void describe(auto& f) {
    using Row = PatternProfile;
    f.name("camera", "camera of the twin", &Row::camera);
    f.add("at", "the coordinate, in the row's unit; x of a place", &Row::at);
    f.add("at_y",
          "y of a place, px; number of the cell of phase_by_place, from 1, row by row; of the image of "
          "phase_by_image in the sequence; empty for the others",
          &Row::at_y);
    f.add("mean", "real - predicted, in standard deviations of a gray value", &Row::mean);
    f.add("n", "gray values", &Row::n);
  }
};

/// How much of what is left follows one coordinate of the gray values.
struct PatternRow {
  std::string coordinate, unit;
  double alone = kNaN;
  int order = 0;
  double in_order = kNaN;
  std::uint64_t harmonic = 0;
  std::vector<PatternProfile> profile;

  static void describe(auto& f) {
    using Row = PatternRow;
    f.name("coordinate", "what the gray values are sorted by", &Row::coordinate)
        .one_of({"gray_level", "phase", "image", "radius", "place", "phase_by_place", "phase_by_image"})
        .shown({"what is left over"});
    f.add("unit", "its unit", &Row::unit);
    f.add("alone", "share of the excess that its means take away", &Row::alone)
        .shown({"follows it", "% of the excess", Column::fixed, 1, 100.0});
    f.add("order", "1 for what most follows, the same for those that cannot be told apart, 0: not named",
          &Row::order)
        .shown({"order"});
    f.add("in_order", "share of the excess that its means take away after those before it", &Row::in_order)
        .shown({"after those before", "%", Column::fixed, 1, 100.0});
    f.add("harmonic",
          "phase, phase_by_place, phase_by_image: the harmonic that holds most of the means' squares, else 0",
          &Row::harmonic);
    f.add("profile", "the means, of each camera", &Row::profile);
  }
};

/// Stands between groups that explain a difference only together.
inline constexpr const char* kCausesTogether = " + ";

/// What may be wrong with the twin where noise does not explain the difference.
struct Causes {
  std::vector<CauseRow> rows;  ///< taken ones in order, then by their share
  std::string named;           ///< the only explanation, where it is one group; else empty
  /// Explanations that pass and cannot be told apart; the groups of each, with kCausesTogether between them.
  std::vector<std::string> together;
  double chi2 = kNaN;
  double chi2_limit = kNaN;  ///< what explains must leave no more; not written
  double rest = kNaN;
  std::uint64_t n = 0;
  double chi2_after = kNaN;          ///< of a gray value, where the cause was fitted to convergence
  std::vector<CauseGain> gain;       ///< one per camera; empty: not offered
  std::string with;                  ///< what they were fitted together with
  std::string why;                   ///< why not; empty where nothing is named
  std::vector<PatternRow> pattern;   ///< of what is left, where nothing is named
  std::vector<std::string> refined;  ///< groups that were fitted just before

  static void describe(auto& f) {
    f.add("named", "the group that explains the difference, where one alone does", &Causes::named).or_null();
    f.add("together", "what explains the difference, and cannot be told apart", &Causes::together)
        .not_required();
    f.positive("chi2", "of a gray value, with the best gain and black level only", &Causes::chi2);
    f.add("rest", "share of the excess that all taken ones leave", &Causes::rest);
    f.add("n", "gray values used", &Causes::n);
    f.add("tested", "every group that was fitted", &Causes::rows);
    f.positive("chi2_after", "of a gray value, with the cause fitted to convergence", &Causes::chi2_after)
        .not_required();
    f.add("gain", "gain and black level fitted together with the cause", &Causes::gain).not_required();
    f.add("with", "the groups of parameters that these were fitted with", &Causes::with).or_absent();
    f.add("why", "why no gain is offered with the cause named", &Causes::why).or_absent();
    f.add("pattern", "what the rest follows where no cause is named", &Causes::pattern).not_required();
  }
};

/// One acceptance limit of the twin and whether the comparison meets it.
struct LimitRow {
  std::string name;
  double value = 0, limit = 0;  ///< value NaN: nothing to check it on, counts as not met
  bool pass = false;

  static void describe(auto& f) {
    f.name("name", "key of [limits] in the twin", &LimitRow::name);
    f.add("value", "worst value over all rows", &LimitRow::value);
    f.add("limit", "what the twin allows", &LimitRow::limit).known();
    f.add("pass", "whether the value is within the limit", &LimitRow::pass);
  }
};

struct VerdictTables {
  std::optional<Refinement> refinement;
  std::vector<ExplainedRow> explained;
  Causes causes;
  std::vector<LimitRow> limits;
  /// Returns what worst_state() says of each quantity.
  BudgetVerdict budget_verdict() const;

  static void describe(auto& t) {
    t.row("refinement", &VerdictTables::refinement);
    t.row("budget_verdict", &VerdictTables::budget_verdict);
    t.rows("explained", &VerdictTables::explained);
    t.row("causes", &VerdictTables::causes);
    t.rows("limits", &VerdictTables::limits).in_measurements();
  }
};

}  // namespace fringetwin::compare
