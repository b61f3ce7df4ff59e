// SPDX-License-Identifier: Apache-2.0
// Sums residuals over the blocks of an image and judges them: what a verdict's row says of single values and
// of regions (docs/metrics/verdict.md, "Explained"). Residuals with their variances go in, a row comes out.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "compare/result/rows.hpp"
#include "compare/verdict/explained.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::compare {

inline constexpr int kFewestInRegion = 64;  ///< pixels
inline constexpr const char* kOfPixels = "the pixels that a side sees with modulation";

/// What a measured shape adds to a value if all share one standard error of it: of its slopes, and of its
/// depths, that times the root of the share which a region's mean keeps; and what its smoothing has added,
/// with its sign.
struct OfShape {
  double slopes = 0.0, depths = 0.0, smoothed_slopes = 0.0, smoothed_depths = 0.0;
};

/// A mean of a block: weighted sum of residuals, its variance if they are noise, and the sum of the weights'
/// sizes (an error that all share moves the sum by that). The calibration moves all values together, too, but
/// not alike (a shifted fringe changes sign): (sum w g)^2 <= sum w^2 sum g^2.
struct BlockSum {
  double sum = 0.0, variance = 0.0, weight = 0.0, weight2 = 0.0, calibration = 0.0;
  double together = 0.0;  ///< what a known effect adds to the sum
  /// What the noise of a shape's slopes, and of its depths, adds to the sum if all share one standard error:
  /// of each value that times the root of the share which a region's mean keeps.
  double slopes = 0.0, depths = 0.0;
  /// What smoothing of the shape has added to the sum by its slopes, and by its depths, as other windows tell
  /// it: with noise, about as much as the shape has itself, so that of both only the larger one counts.
  double smoothed_slopes = 0.0, smoothed_depths = 0.0;
  int pixels = 0;
  void add(double weight_of_one, double residual, double noise, double calibration_of_one) {
    sum += weight_of_one * residual;
    variance += weight_of_one * weight_of_one * noise;
    weight += std::abs(weight_of_one);
    weight2 += weight_of_one * weight_of_one;
    calibration += calibration_of_one;
  }
  void add_shape(double weight_of_one, const OfShape& shape) {
    slopes += weight_of_one * shape.slopes, depths += weight_of_one * shape.depths;
    smoothed_slopes += weight_of_one * shape.smoothed_slopes;
    smoothed_depths += weight_of_one * shape.smoothed_depths;
  }
  void add_pixel(double variance_of_its_sum) { variance += variance_of_its_sum, ++pixels; }
  bool usable() const { return pixels >= kFewestInRegion && variance > 0.0; }
  double expected(double shared) const {
    return variance + weight * weight * shared + weight2 * calibration + together * together +
           std::max(slopes * slopes, smoothed_slopes * smoothed_slopes) +
           std::max(depths * depths, smoothed_depths * smoothed_depths);
  }
  double chi2(double shared) const { return sum * sum / expected(shared); }
  /// The same without what is uncertain of the rig.
  double chi2_of_noise(double shared) const { return sum * sum / (expected(shared) - weight2 * calibration); }
  double calibration_share(double shared) const { return weight2 * calibration / expected(shared); }
};

/// Sums over all of an image, by blocks.
struct Sums {
  double r2 = 0.0, chi2 = 0.0, noise = 0.0, regional = 0.0;
  double noise_chi2 = 0.0;  ///< against noise and quantisation alone
  double texture = 0.0;     ///< of the phase, of codes: by moved fringes and texture within a pixel
  double shape = 0.0;       ///< variance that the noise of a measured shape makes
  double smoothed = 0.0;    ///< that its smoothing makes
  double taken = 0.0;  ///< of the noise chi2 of gray values: what a fit of each pixel's own numbers takes
  double calibration = 0.0, share = 0.0, regional_share = 0.0;  ///< shares: of the expected chi2
  double regional_of_noise = 0.0;                               ///< without what is uncertain of the rig
  /// Of regions, over their noise: squares of their sums, of what smoothing of the shape has added to them,
  /// and products of both.
  double region_squares = 0.0, smoothed_squares = 0.0, region_smoothed = 0.0;
  std::uint64_t n = 0, n_regions = 0;
  std::uint64_t n_inside = 0;  ///< values that interior pixels have, usable or not
  /// Adds `values` values by the sum of their squares and by what one of them has on average. `own`: its
  /// noise and what else is its own; `shared`: variance that neighbours share; `moved`: that of the
  /// calibration.
  void add(double squares, double noise_of_one, double own, double shared, double moved, int values = 1) {
    r2 += squares;
    noise += values * noise_of_one;
    chi2 += squares / (own + shared + moved);
    noise_chi2 += squares / noise_of_one;
    calibration += values * moved;
    share += values * moved / (own + shared + moved);
    n += static_cast<std::uint64_t>(values);
  }
};

/// Returns the sum of all parts in their order; `regions` gets the chi2 of a region from each.
Sums add_up(const std::vector<Sums>& parts, int across, int down, ImageF& regions);

/// Calls `block(x0, y0, x1, y1)` -> Sums for every block, in parallel, added up in order.
template <class Block>
Sums sum_blocks(int width, int height, ImageF& regions, Block block) {
  const int across = (width + kRegion - 1) / kRegion, down = (height + kRegion - 1) / kRegion;
  std::vector<Sums> parts(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
#pragma omp parallel for schedule(dynamic)
  for (int b = 0; b < across * down; ++b) {
    const int x0 = b % across * kRegion, y0 = b / across * kRegion;
    parts[b] = block(x0, y0, std::min(x0 + kRegion, width), std::min(y0 + kRegion, height));
  }
  return add_up(parts, across, down, regions);
}

/// Counts a block's sum among the regions where it has enough pixels.
void add_region(const BlockSum& block, double shared, Sums& out);

/// Returns the share of the regions' squares that goes with what smoothing of the measured shape has added to
/// them, as other windows tell it. 0 where it goes against that, as the shape's noise does, and where regions
/// are few.
double smoothed_fraction(const Sums& s);

/// Writes what single values and regions show into the row. Returns false where the values are too few.
bool take_sums(const Sums& s, ExplainedRow& row);

/// Judges a row whose sums are in it by its upper limits. The shares are those of the expected chi2 that the
/// calibration makes: its error is one draw for all of the image, not an average over many, so 3 standard
/// uncertainties of it must pass. `kept`: share of the noise that fits to these values have left in them.
void judge(const Sums& s, double known_to, double kept, ExplainedRow& row);

/// Calls the budget too wide where the values scatter less than its noise alone, calibration and rendering
/// left out, says. `kept`: share of the noise that fits to these values have left in them. Rounding is not
/// held against a budget: two sides without noise may well round alike.
void judge_least(const Sums& s, double noise, double rounding, double kept, double known_to,
                 ExplainedRow& row);

/// Takes back "explained" where less than half was compared.
void judge_share(double fraction, const char* of, ExplainedRow& row);

inline double share_of(std::uint64_t part, std::uint64_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

/// Returns why a row has nothing to judge.
std::string too_few(std::uint64_t n, const SeenPixels& seen, std::uint64_t both);

}  // namespace fringetwin::compare
