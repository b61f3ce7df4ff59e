// SPDX-License-Identifier: Apache-2.0
// Splits the phase difference of the two sides into projector harmonics, noise, and what varies slowly or
// fast besides (docs/metrics/phase.md, "Phase budget").
#pragma once
#include <optional>
#include <vector>

#include "compare/phase/texture_shift.hpp"
#include "compare/result/rows.hpp"
#include "measure/decode/decode.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Returns the order of the phase ripple that harmonics leave in these steps of N: their number when they are
/// equally spaced over the period (harmonics that many steps apart +-1 alias onto the fundamental), else 1.
int alias_order(const std::vector<int>& steps, int steps_total);

/// Splits the difference of one camera and direction. `use_steps`: phase steps both sides were measured
/// with, empty = all. nullopt without phase steps or with fewer than 1000 common pixels.
std::optional<PhaseBudget> phase_budget(const Twin& twin, const measure::DirectionDecode& real,
                                        const measure::DirectionDecode& simulated,
                                        const std::vector<int>& use_steps);

/// Returns the part of brightness_rad2 that the factors of the real images' light predict, over those that
/// the twin's camera has by its keys: of the pitches in the coordinate, rms over all phases
/// (measure::light_phase_rms_rad). NaN where the steps used are not equally spaced over the period, or no
/// pixel is valid. `real`: decoded from images whose light was not taken out.
double predicted_brightness_rad2(const Twin& twin, std::size_t camera, const measure::DirectionDecode& real,
                                 const std::vector<int>& use_steps, const measure::LightFactors& light);

/// Holds how much of the whitened difference the ripples take away that a faulty light leaves, per function
/// fitted: 1 is expected of noise.
struct RippleTest {
  double brightness_chi2 = kNaN;  ///< orders 1 and 2 of the pitches; NaN where harmonics have these orders
  double harmonic_chi2 = kNaN;    ///< the alias order and its double
  int order = 1;                  ///< the alias order
  int strongest = 1;              ///< it or its double, whichever has more of the ripple
  int functions = 0;              ///< of each of the two groups
  double information = 0.0;       ///< sum of 1/variance, rad^-2
};
/// Tests the difference over the interior pixels for ripples, each pixel by the variance of its noise. Pixels
/// that a texture moves are left out, as their shift follows the fringes. nullopt without phase steps or with
/// fewer than 1000 pixels.
std::optional<RippleTest> test_ripple(const Twin& twin, const measure::DirectionDecode& real,
                                      const measure::DirectionDecode& simulated,
                                      const std::vector<int>& use_steps, const ImageU8& interior,
                                      const TextureShift& texture);

}  // namespace fringetwin::compare
