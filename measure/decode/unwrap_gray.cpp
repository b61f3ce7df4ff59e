// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "fmt/format.h"
#include "measure/decode/unwrap.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure {
namespace {

unsigned binary_from_gray(unsigned g) {
  for (unsigned shift = 16; shift > 0; shift >>= 1) g ^= g >> shift;
  return g;
}

/// Returns the index (0 = MSB) of the bit that flips between words k-1 and k; the first at the ends of the
/// code.
int flipping_bit(unsigned k, int bits) { return std::max(0, bits - 1 - std::countr_zero(k)); }

/// Returns the coordinate in the repetition of the code that lies nearest the middle of the projector.
double into_range(const GrayPlan& plan, double x_px) {
  return plan.cyclic ? x_px - plan.span_px * round_even((x_px - plan.center_px) / plan.span_px) : x_px;
}

/// Half-period word h (complementary code) and v, the place inside the word by phase: the word that v
/// belongs to, right while the code edge is less than a quarter period away from where v puts it.
int word_from_half_periods(unsigned h, double v) {
  const int half = static_cast<int>(h);
  if (v < 0.25) return (half + 1) >> 1;
  if (v < 0.75) return half >> 1;
  return ((half + 1) >> 1) - 1;
}

/// Without the complementary bit: word k read at place v near an edge of its word may be the
/// neighbour across the OTHER edge (v = 0.99 read as k: inside k, or really k-1 at its upper edge). At
/// the edge that is near, the flipping bit is not settled (less than half its usual margin).
int word_by_margins(const GrayPlan& plan, unsigned k, double v, const float* margin, float amplitude,
                    std::size_t stride) {
  const int word = static_cast<int>(k);
  constexpr double kZone = 0.125;  // periods; no camera blurs an edge further, and noise stays outside
  if (v >= kZone && v < 1.0 - kZone) return word;
  const auto certainty = [&](int bit) {
    const float m = margin[bit * stride];
    return std::fabs(m) / (amplitude * (m > 0.0f ? plan.bright_margin : plan.dark_margin));
  };
  const float lower = certainty(flipping_bit(k, plan.bits)),
              upper = certainty(flipping_bit(k + 1, plan.bits));
  if (v >= 0.5) return lower < 0.5f && lower < upper ? word - 1 : word;
  return upper < 0.5f && upper < lower ? word + 1 : word;
}

}  // namespace

GrayPlan plan_gray(const DirectionFringes& direction, int steps, const CoordinateRange& range) {
  const std::string where = fmt::format("[fringes] direction {}", axis_name(direction.axis));
  if (!direction.gray)
    throw UserError(ExitCode::usage, where, "unwrap = \"gray\" needs a Gray code",
                    "add [fringes.gray] with bits");
  if (direction.pitches_px.size() != 1)
    throw UserError(
        ExitCode::usage, where,
        fmt::format("unwrap = \"gray\" needs exactly one pitch, there are {}", direction.pitches_px.size()),
        "the pitch is the width of a code word");
  const GrayCode& code = *direction.gray;
  if (code.bits < 1 || code.bits > 24)
    throw UserError(ExitCode::usage, where,
                    fmt::format("a Gray code of {} bits cannot be decoded", code.bits), "give 1 to 24 bits");
  if (steps == 0 && code.threshold == GrayCode::Threshold::mean)
    throw UserError(ExitCode::usage, where,
                    "threshold = \"mean\" is the mean of the phase steps, and steps = 0",
                    "use threshold = \"inverse\" or \"white-black\"");
  GrayPlan p{.pitch_px = direction.pitches_px.front(),
             .origin_px = direction.phase_origin_px.front(),
             .offset_periods = code.offset_periods,
             .bits = code.bits,
             .complementary = code.complementary};
  if (!(p.pitch_px > 0.0)) throw UserError(ExitCode::usage, where, "pitches_px must be positive");
  p.span_px = std::ldexp(p.pitch_px, code.bits);
  p.cyclic = range.known;
  p.center_px = range.center();
  if (range.known && p.span_px < range.size() * (1.0 - 1e-9))
    throw UserError(ExitCode::usage, where,
                    fmt::format("{} bits of {:g} px words cover {:g} px, the projector has {:g} px",
                                code.bits, p.pitch_px, p.span_px, range.size()),
                    "give more bits or a larger pitch");
  return p;
}

void read_gray_row(const GrayPlan& plan, const GrayRow& row, const float* threshold, int n,
                   GrayScratch& scratch) {
  const int planes = plan.bits + (plan.complementary ? 1 : 0);
  const auto stride = static_cast<std::size_t>(n);
  scratch.margin.resize(planes * stride);
  scratch.word.assign(stride, 0u);
  const bool pairs = !row.inverse.empty();
  for (int b = 0; b < planes; ++b) {
    const bool last = b == plan.bits;  // the complementary bit
    const float* bright = last ? row.complementary : row.bits[b];
    const float* dark = !pairs ? threshold : last ? row.complementary_inverse : row.inverse[b];
    const float scale = pairs ? 0.5f : 1.0f;
    float* margin = scratch.margin.data() + b * stride;
    for (int x = 0; x < n; ++x) {
      margin[x] = scale * (bright[x] - dark[x]);
      scratch.word[x] = (scratch.word[x] << 1) | (margin[x] > 0.0f ? 1u : 0u);
    }
  }
  for (unsigned& w : scratch.word) w = binary_from_gray(w);
}

void unwrap_gray_row(const GrayPlan& plan, const PitchRow& pitch, const float* amplitude, int n,
                     const GrayScratch& scratch, double* x_px, float* variance_px2) {
  const double scale = plan.pitch_px * kPerCycle;
  const auto stride = static_cast<std::size_t>(n);
  for (int x = 0; x < n; ++x) {
    const double t = kPerCycle * static_cast<double>(pitch.phase_rad[x]);
    if (!(std::fabs(t) <= 1.0)) {  // masked
      x_px[x] = kNaN;
      variance_px2[x] = std::numeric_limits<float>::quiet_NaN();
      continue;
    }
    const double u = t - plan.offset_periods;
    const double v = u - std::floor(u);
    const unsigned read = scratch.word[x];
    const int k = plan.complementary
                      ? word_from_half_periods(read, v)
                      : word_by_margins(plan, read, v, scratch.margin.data() + x, amplitude[x], stride);
    x_px[x] = into_range(plan, plan.origin_px + plan.pitch_px * (k + v + plan.offset_periods));
    variance_px2[x] = static_cast<float>(static_cast<double>(pitch.variance_rad2[x]) * scale * scale);
  }
}

void gray_only_row(const GrayPlan& plan, int n, const GrayScratch& scratch, double* x_px,
                   float* variance_px2) {
  const double word_periods = plan.complementary ? 0.5 : 1.0;
  const double word_px = word_periods * plan.pitch_px;
  const auto planes = static_cast<std::size_t>(plan.bits + (plan.complementary ? 1 : 0));
  const auto stride = static_cast<std::size_t>(n);
  const auto least = static_cast<float>(0.5 * plan.min_bit_difference_dn);
  for (int x = 0; x < n; ++x) {
    const auto at = static_cast<std::size_t>(x);
    bool certain = true;
    for (std::size_t b = 0; b < planes; ++b)
      certain = certain && std::fabs(scratch.margin[b * stride + at]) >= least;
    const double k = static_cast<double>(scratch.word[at]);
    const double center = plan.origin_px + word_px * (k + 0.5) + plan.pitch_px * plan.offset_periods;
    x_px[x] = certain ? into_range(plan, center) : kNaN;
    variance_px2[x] = static_cast<float>(word_px * word_px / 12.0);
  }
}

}  // namespace fringetwin::measure
