// SPDX-License-Identifier: Apache-2.0
// Finds the fringe orders of one image row: wrapped phases become absolute projector coordinates
// (docs/CONVENTIONS.md).
// Everywhere x = origin + pitch (order + t), t = phase/2pi in (-0.5, 0.5].
#pragma once
#include <optional>
#include <vector>

#include "twin/fringes.hpp"

namespace fringetwin::measure {

/// Returns the nearest integer, halves to even; vectorises without SSE4.1. |v| < 2^51.
inline double round_even(double v) {
  constexpr double kMagic = 6755399441055744.0;  // 1.5 * 2^52
  return (v + kMagic) - kMagic;
}

/// Where decoded coordinates may lie: [begin, end). Unknown size: end = begin + whole.
struct CoordinateRange {
  double begin = -0.5;
  double end = 0.0;
  bool known = false;  ///< the projector's size was given
  double center() const { return 0.5 * (begin + end); }
  double size() const { return end - begin; }
};

/// One pitch in one row: wrapped phase (NaN where masked) and its predicted variance.
struct PitchRow {
  const float* phase_rad = nullptr;
  const float* variance_rad2 = nullptr;
};

/// Three pitches p1 < p2 < p3 unwrapped in stages: the double beat 1 - 2 + 3 gives the order of the
/// beats 12 and 23, their optimal mean the order of each pitch (13/14/15: 1365 -> 182, 210 -> 13).
struct HeterodynePlan {
  int index[3] = {0, 1, 2};  ///< pitches sorted: index into the direction's list
  double pitch_px[3] = {}, origin_px[3] = {};
  double beat12_px = 0.0, beat23_px = 0.0, synthetic_px = 0.0;
  double origin12_px = 0.0, origin23_px = 0.0, origin_synthetic_px = 0.0;
  double sign_synthetic = 1.0;          ///< of the double beat 1 - 2 + 3
  double weight12 = 0.5;                ///< of the beat 12 in the optimal mean of both beats
  double gate_beat_px = 0.0;            ///< |x12 - x23| above: wrong order of a beat
  double gate_pitch_px = 0.0;           ///< |x_i - mean| above: wrong order of a pitch
  double begin_px = 0.0, end_px = 0.0;  ///< the range; the synthetic order nearest its middle is tried first
  /// Phase sigma at which the weakest stage fails at 3 sigma. Pixels whose predicted sigma is twice as
  /// large are not unwrapped: their orders would be guesses.
  double tolerance_rad = 0.0;
};
/// Throws UserError(usage) unless there are three different pitches whose synthetic period covers the
/// range. An unknown range is one synthetic period.
HeterodynePlan plan_heterodyne(const DirectionFringes& direction, CoordinateRange& range);
/// Writes x and its variance by inverse-variance mean of the three pitches; NaN where the stages disagree,
/// lead out of the range (with the neighbouring synthetic order, too), or the noise is too large. pitches in
/// plan order (1, 2, 3).
void unwrap_heterodyne_row(const HeterodynePlan& plan, const PitchRow (&pitches)[3], int n, double* x_px,
                           float* variance_px2);
/// Returns the result of the same last stage from a coordinate that is known within less than half a period,
/// or nullopt where the pitches do not agree there.
std::optional<double> resolve_heterodyne(const HeterodynePlan& plan, const double (&t)[3],
                                         const double (&variance_rad2)[3], double predicted_px);

/// Pitches coarse to fine; the coarsest covers the range.
struct HierarchicalPlan {
  std::vector<int> index;  ///< coarse to fine: index into the direction's list
  std::vector<double> pitch_px, origin_px;
  double center_px = 0.0;
  double gate_cycles = 0.3;  ///< distance from a whole order above which an order is not trusted
};
HierarchicalPlan plan_hierarchical(const DirectionFringes& direction, CoordinateRange& range);
/// Unwraps one row. The finest pitch alone sets the value: a coarse one adds more systematic error than it
/// removes noise. pitches in plan order.
void unwrap_hierarchical_row(const HierarchicalPlan& plan, const std::vector<PitchRow>& pitches, int n,
                             double* x_px, float* variance_px2);

/// The Gray-code images of one direction, one row: MSB first whatever the file order.
struct GrayRow {
  std::vector<const float*> bits, inverse;  ///< inverse empty without pairs
  const float* complementary = nullptr;
  const float* complementary_inverse = nullptr;
};
struct GrayPlan {
  double pitch_px = 1.0, origin_px = 0.0, offset_periods = 0.0;
  int bits = 0;
  bool complementary = false;
  /// The code repeats after this many px; the repetition nearest center_px is taken when `cyclic`.
  double span_px = 0.0, center_px = 0.0;
  bool cyclic = false;  ///< the projector's size is known
  /// Margin of a settled bright and dark bit per amplitude of the phase steps (medians).
  float bright_margin = 1.0f, dark_margin = 1.0f;
  double min_bit_difference_dn = 5.0;  ///< code only: |pattern - inverse|, 2 |value - threshold|
};
/// Throws UserError(usage) when there is no code, or it does not cover the range.
GrayPlan plan_gray(const DirectionFringes& direction, int steps, const CoordinateRange& range);
/// Scratch of one thread.
struct GrayScratch {
  std::vector<unsigned> word;
  std::vector<float> margin;  ///< bits x n: signed distance from the threshold
};
/// Reads signed margins and code words into the scratch. threshold: one per pixel (ignored with pairs).
void read_gray_row(const GrayPlan& plan, const GrayRow& row, const float* threshold, int n,
                   GrayScratch& scratch);
/// Finds the order from code and phase. Near a code edge (a quarter period) the complementary bit decides;
/// without it (an eighth), a bit that flips at an edge and is not settled tells which edge is near.
/// amplitude: of the phase steps, one per pixel.
void unwrap_gray_row(const GrayPlan& plan, const PitchRow& pitch, const float* amplitude, int n,
                     const GrayScratch& scratch, double* x_px, float* variance_px2);
/// Decodes one row of code only: centre of the word, variance of a uniform distribution; NaN where a bit is
/// uncertain.
void gray_only_row(const GrayPlan& plan, int n, const GrayScratch& scratch, double* x_px,
                   float* variance_px2);

}  // namespace fringetwin::measure
