// SPDX-License-Identifier: Apache-2.0
// Judges whether a difference is no larger than the stated uncertainties allow: noise, quantisation,
// rendering, fit and calibration (docs/metrics/verdict.md, "Explained").
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "compare/gray/gain_fit.hpp"
#include "compare/gray/gray_noise.hpp"
#include "compare/gray/own_light.hpp"
#include "compare/phase/phase_budget.hpp"
#include "compare/result/own_kinds.hpp"
#include "compare/shape/shape_noise.hpp"
#include "compare/verdict/rig_budget.hpp"

namespace fringetwin::compare {

inline constexpr double kCoverage = 3.0;  ///< standard uncertainties
/// Times the rounding's variance: less noise than that is none.
inline constexpr double kNoisy = 2.0;
/// A sensor is refuted by a noise this much below 1 and below by `kCoverage` standard errors.
inline constexpr double kLeastExcess = 0.1;

/// Returns how far a mean of n squares over their expectation may be below 1 where noise explains it whose
/// variance is known to this relative standard uncertainty.
double allowed_for(double n, double known_to = kStatedKnownTo);
/// The same above 1, where chance reaches further, the more the fewer they are: what a chi^2 of n degrees of
/// freedom exceeds as seldom as a normal number its mean by kCoverage sigma (Wilson and Hilferty, PNAS 17,
/// 1931: its cube root is nearly normal).
double allowed_above(double n, double known_to = kStatedKnownTo);

inline constexpr const char* kShapeLine = "noise of the measured shape";

/// What is known of how exactly a camera was rendered; 0 where nothing was estimated.
struct RenderingError {
  double gray_dn = 0.0, phase_rad = 0.0;
  bool estimated = false;
  double with_edges_dn = 0.0;  ///< gray values, over pixels that an edge crosses, too
  /// Covariance of the gray values that a pixel has in the images (sequence order), which are off together,
  /// but otherwise in other pixels: the directions of its bounces. Empty: none.
  Eigen::MatrixXd scatter_dn2 = {};
  double scatters_alike = 1.0;  ///< in so many neighbouring pixels

  /// Returns the budget's line of this variance.
  BudgetLine line(double variance) const {
    return {estimated ? "rendering, the renderer's own estimate" : "rendering (not estimated)", variance};
  }
};
/// Returns what the notes say of one camera. The renderer states the gray error of the twin's sensor;
/// `gain_dn`: of the gain that was fitted.
RenderingError rendering_error(const Camera& camera, const std::vector<RenderNote>& notes, double gain_dn);

/// What every pixel of the simulated side has of its own.
struct OwnOfPixels {
  OwnKinds kinds = {};
  std::vector<int> images = {};  ///< that it was fitted to, of the sequence
  bool from_here = true;         ///< false: from images that may have been these or others
};

/// Holds how many pixels of a camera both sides decoded, and how many at least one of them sees with
/// modulation, unsaturated. Without both decodes: 0, nothing is known.
struct SeenPixels {
  std::uint64_t both = 0, either = 0;
};
SeenPixels seen_pixels(const measure::CameraDecode* real, const measure::CameraDecode* simulated);

// What the budgets of gray values have in common, those of phase steps and those of the images of a code:

/// Returns the sums of the fit of what pixel i has of its own, with the noise of its values; none where
/// nothing was fitted. What the pixel has already shifts and scales its light, which changes no leverage.
OwnLightSums own_light_sums(const GrayPair& pair, const OwnOfPixels& own, const GrayNoise& noise,
                            std::size_t i);

/// Returns the shape whose noise is in the budget: a factor of each pixel has what its normal is off by, and
/// leaves where the fringes lie.
ShapeInView shape_in_budget(const ShapeInView& shape, const OwnOfPixels& own);
/// Returns the lines of noise, of quantisation and of rendering. `noise_dn2`: of a value, rounding included;
/// `scatter_dn2`: of the directions of bounces.
std::vector<BudgetLine> noise_lines(const GrayNoise& noise, double noise_dn2, const RenderingError& rendering,
                                    double scatter_dn2);

/// Returns a row that says that nothing was compared, and why.
ExplainedRow not_compared(const std::string& quantity, const std::string& region, const std::string& why);

/// What a RigBudget has of one camera or direction.
struct RigVariance {
  const ImageF* variance = nullptr;  ///< null: not in the budget
  std::string line = kCalibrationLine;
};

/// `seen`: a row that took less than half of what either side sees is not called explained.

/// Judges the gray values of the interior pixels after the gain fit. `simulated`: its phases tell level,
/// contrast and shift of the fringe apart; null: levels only. `rig`: variance of the irradiance. `own`: what
/// of each pixel was fitted to the real phase steps, all of them: then the values scatter less than their
/// noise, which both limits count. `shape`: noise of the measured shape that is seen.
ExplainedRow explain_gray(const GrayPair& pair, const GainFit& fit, const GrayNoise& noise,
                          const ImageU8& interior, const measure::CameraDecode* simulated,
                          const RenderingError& rendering, const RigVariance& rig = {},
                          const SeenPixels& seen = {}, const OwnOfPixels& own = {},
                          const ShapeInView& shape = {});

/// Judges the phase difference of one direction over the interior pixels. `rig`: its variance, rad^2;
/// `texture`: how far it moves the phases; `shape`: noise of the measured shape that is seen.
ExplainedRow explain_phase(const std::string& camera, const measure::DirectionDecode& real,
                           const measure::DirectionDecode& simulated, const ImageU8& interior,
                           const TextureShift& texture, const RenderingError& rendering,
                           const RigVariance& rig = {}, const SeenPixels& seen = {},
                           const ShapeInView& shape = {});

/// Judges the ripples of a phase row that was compared: they show a wrong brightness or waveform of the
/// images where single values and regions do not. Not where the noise is hardly more than rounding, which
/// ripples, too; nor with the calibration in the budget, whose change of the phase is no noise.
void judge_ripple(const RippleTest& ripple, const RenderingError& rendering,
                  const measure::DirectionDecode& real, const measure::DirectionDecode& simulated,
                  ExplainedRow& row);

/// Calls the budget too wide in rows that take the twin's sensor noise, where the real images have clearly
/// less noise than that.
void hold_against_noise(const std::vector<NoiseRow>& noise, std::vector<ExplainedRow>& rows);

/// Returns the |z| that the largest of n numbers, Student's t with 38 degrees of freedom, exceeds as rarely
/// as a normal one exceeds 3 (Bonferroni): 3.21 of one.
double most_sigmas_of(std::uint64_t n);

/// Returns one row per object that was fitted on the real side; one without any z was not compared.
std::vector<ExplainedRow> explain_geometry(const std::vector<FitRow>& fits, const RigBudget* rig = nullptr);

}  // namespace fringetwin::compare
