// SPDX-License-Identifier: Apache-2.0
// Tabulates the light of patterns for the shaders: an EffectivePattern as samples; with a halo of the
// projector the sum of one for each part of its light.
#pragma once
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::render {

/// Tabulates one period of a phase step: sample i at theta = 2 pi (x - origin)/pitch = 2 pi i / samples, i.e.
/// at x = origin + i pitch / samples; the step's own shift 2 pi n/N is in the values.
std::vector<float> periodic_waveform(const Twin& twin, const PatternSpec& pattern, int samples);

/// Tabulates any pattern along its whole axis: sample i at *first_px + i / samples_per_px, covering the
/// projector's image [-0.5, size - 0.5] and pattern_margin_px() on either side.
std::vector<float> axis_waveform(const Twin& twin, const PatternSpec& pattern, double samples_per_px,
                                 double* first_px);

/// Tabulates the frame buffer's pixels one by one from *first_px on, with the same margin (pixel structure
/// without Gaussian blur).
std::vector<float> pixel_waveform(const Twin& twin, const PatternSpec& pattern, int* first_px);

/// Tabulates a white image across one projector pixel from border to border, with the gaps between pixels and
/// the Gaussian blur, mean 1; two samples more than one period. The table is empty without gaps or blur.
std::vector<float> gap_waveform(const Projector& projector);

}  // namespace fringetwin::render
