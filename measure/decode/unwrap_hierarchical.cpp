// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "fmt/format.h"
#include "measure/decode/unwrap.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure {

HierarchicalPlan plan_hierarchical(const DirectionFringes& direction, CoordinateRange& range) {
  HierarchicalPlan p;
  const std::string where = fmt::format("[fringes] direction {}", axis_name(direction.axis));
  if (direction.pitches_px.empty())
    throw UserError(ExitCode::usage, where, "unwrap = \"hierarchical\" needs at least one pitch");
  p.index.resize(direction.pitches_px.size());
  std::iota(p.index.begin(), p.index.end(), 0);
  std::ranges::sort(p.index, [&](int a, int b) { return direction.pitches_px[a] > direction.pitches_px[b]; });
  for (const int i : p.index) {
    p.pitch_px.push_back(direction.pitches_px[i]);
    p.origin_px.push_back(direction.phase_origin_px[i]);
  }
  if (!(p.pitch_px.back() > 0.0)) throw UserError(ExitCode::usage, where, "pitches_px must be positive");
  const double coarsest = p.pitch_px.front();
  if (!range.known) range.end = range.begin + coarsest;
  if (!(coarsest >= range.size()))
    throw UserError(ExitCode::usage, where,
                    fmt::format("the coarsest pitch of {:g} px does not cover the projector's {:g} px",
                                coarsest, range.size()),
                    "unwrap = \"hierarchical\" needs a pitch at least as large as the projector");
  p.center_px = range.center();
  return p;
}

void unwrap_hierarchical_row(const HierarchicalPlan& plan, const std::vector<PitchRow>& pitches, int n,
                             double* x_px, float* variance_px2) {
  std::fill(x_px, x_px + n, plan.center_px);
  for (std::size_t i = 0; i < pitches.size(); ++i) {
    const double pitch = plan.pitch_px[i], origin = plan.origin_px[i], inverse = 1.0 / pitch;
    // The coarsest order is the one nearest the centre of the range: nothing to compare it with.
    const double gate = i == 0 ? std::numeric_limits<double>::infinity() : plan.gate_cycles;
    const float* phase = pitches[i].phase_rad;
    for (int x = 0; x < n; ++x) {
      const double t = kPerCycle * static_cast<double>(phase[x]);
      const double exact = (x_px[x] - origin) * inverse - t;
      const double order = round_even(exact);
      const bool trusted = std::fabs(exact - order) <= gate;
      x_px[x] = trusted ? origin + pitch * (order + t) : std::numeric_limits<double>::quiet_NaN();
    }
  }
  const double scale = plan.pitch_px.back() * kPerCycle;
  for (int x = 0; x < n; ++x)
    variance_px2[x] =
        static_cast<float>(static_cast<double>(pitches.back().variance_rad2[x]) * scale * scale);
}

}  // namespace fringetwin::measure
