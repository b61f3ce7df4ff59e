// SPDX-License-Identifier: Apache-2.0
// Judges whether a difference is no larger than the stated uncertainties allow: noise, quantisation,
// rendering, fit and calibration (docs/metrics/verdict.md, "Explained").
#pragma once
#include <optional>
#include <vector>

#include "compare/gray/gain_fit.hpp"
#include "compare/gray/gray_noise.hpp"
#include "compare/verdict/calibration_budget.hpp"

namespace fringetwin::compare {

inline constexpr const char* kCalibrationLine = "calibration covariance";

/// What is known of how exactly a camera was rendered; 0 where nothing was estimated.
struct RenderingError {
  double gray_dn = 0.0, phase_rad = 0.0;
  bool estimated = false;
};
/// Returns what the notes say of one camera. The renderer states the gray error of the twin's sensor;
/// `gain_dn`: of the gain that was fitted.
RenderingError rendering_error(const Camera& camera, const std::vector<RenderNote>& notes, double gain_dn);

/// In the functions below `calibration` is that of a camera or direction of CalibrationBudget; null: not in
/// the budget.

/// Judges the gray values of the interior pixels after the gain fit. `simulated`: its phases tell level,
/// contrast and shift of the fringe apart; null: levels only.
std::optional<ExplainedRow> explain_gray(const GrayPair& pair, const GainFit& fit, const GrayNoise& noise,
                                         const ImageU8& interior, const measure::CameraDecode* simulated,
                                         const RenderingError& rendering,
                                         const ImageF* calibration = nullptr);

/// Judges the phase difference of one direction over the interior pixels.
std::optional<ExplainedRow> explain_phase(const std::string& camera, const measure::DirectionDecode& real,
                                          const measure::DirectionDecode& simulated, const ImageU8& interior,
                                          const RenderingError& rendering,
                                          const ImageF* calibration = nullptr);

/// Returns one row per fitted object that has a z.
std::vector<ExplainedRow> explain_geometry(const std::vector<FitRow>& fits,
                                           const CalibrationBudget* calibration = nullptr);

}  // namespace fringetwin::compare
