// SPDX-License-Identifier: Apache-2.0
// Decides how phase steps are made that are no pure cosines: behind the projector's response, of a waveform
// of their own, with harmonics. Such a step is a short Fourier series: carried as a cosine/sine pair per
// harmonic, one trace holds every step; or each step is evaluated directly in the trace. The cheaper way is
// taken.
#pragma once
#include <optional>

#include "render/base/phase_series.hpp"
#include "render/base/renderer_tuning.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Cosine/sine pairs that a pass over all pixels takes: more are worth a second one.
inline constexpr int kMostPairs = 16;

/// Returns the shortest series whose dropped harmonics, after the constant blur, sum up to at most
/// `relative_bound` of the fundamental; empty when that takes more than `most` harmonics. With N steps a
/// dropped amplitude b shifts the phase by at most b / |a_1| rad. `added`: the harmonics of the pitch;
/// `more`: by how much those of the orders 2, 3 ... are larger somewhere.
PhaseSeries short_series(const Projector& projector, const Fringes& fringes, double pitch_px,
                         double relative_bound, int most, const Harmonics& added = {},
                         const std::vector<double>& more = {});

/// Returns the number of harmonics of that shortest series; 64 when the bound takes more.
int count_harmonics(const Projector& projector, const Fringes& fringes, double pitch_px,
                    double relative_bound, const Harmonics& added = {}, const std::vector<double>& more = {});

/// Returns the series of all pitches, an empty one where the steps are evaluated directly. Automatic takes
/// the cheaper way for all pitches together; `harmonics` insists where the series is short enough. With pixel
/// structure there is none: the pattern is no function of the phase then. The dropped harmonics are bounded
/// by a tenth of phase_error_rad, the twin's own unless given.
SeriesTable choose_series(const Twin& twin, PatternMethod method = PatternMethod::automatic,
                          std::optional<double> phase_error_rad = {});

/// Returns series of the same lengths, as large as those at any place of the projector's image and in any
/// image of the sequence.
SeriesTable largest_series(const Twin& twin, const SeriesTable& series);
/// Returns what the series have more per term of the harmonics' field, of the same lengths.
SeriesOfField field_series(const Twin& twin, const SeriesTable& series);
/// Returns the series of one image of the sequence, a phase step: that of its pitch with the harmonics of the
/// image.
PhaseSeries series_of_image(const Twin& twin, const PhaseSeries& of_pitch, const PatternSpec& spec,
                            std::size_t image);

}  // namespace fringetwin::render
