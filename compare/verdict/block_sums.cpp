// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/block_sums.hpp"

#include <fmt/format.h>

#include <limits>

namespace fringetwin::compare {
namespace {

constexpr std::uint64_t kFewestJudged = 200;
constexpr double kLeastShare = 0.5;  ///< of what could have been compared

}  // namespace

Sums add_up(const std::vector<Sums>& parts, int across, int down, ImageF& regions) {
  Sums total;
  regions = ImageF(across, down, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t b = 0; b < parts.size(); ++b) {
    const Sums& part = parts[b];
    if (part.n_regions > 0)
      regions.data[b] = static_cast<float>(part.regional / static_cast<double>(part.n_regions));
    total.r2 += part.r2, total.chi2 += part.chi2, total.noise += part.noise, total.regional += part.regional;
    total.calibration += part.calibration, total.share += part.share;
    total.regional_share += part.regional_share, total.regional_of_noise += part.regional_of_noise;
    total.noise_chi2 += part.noise_chi2, total.texture += part.texture, total.taken += part.taken;
    total.shape += part.shape, total.smoothed += part.smoothed;
    total.region_squares += part.region_squares, total.smoothed_squares += part.smoothed_squares;
    total.region_smoothed += part.region_smoothed;
    total.n += part.n, total.n_regions += part.n_regions, total.n_inside += part.n_inside;
  }
  return total;
}

void add_region(const BlockSum& block, double shared, Sums& out) {
  if (!block.usable()) return;
  out.regional += block.chi2(shared);
  out.regional_of_noise += block.chi2_of_noise(shared);
  out.regional_share += block.calibration_share(shared);
  const double smoothed = block.smoothed_slopes + block.smoothed_depths;
  out.region_squares += block.sum * block.sum / block.variance;
  out.smoothed_squares += smoothed * smoothed / block.variance;
  out.region_smoothed += block.sum * smoothed / block.variance;
  ++out.n_regions;
}

double smoothed_fraction(const Sums& s) {
  constexpr std::uint64_t kFewest = 30;  // of which chance makes no half
  if (s.n_regions < kFewest || !(s.region_smoothed > 0.0) || !(s.smoothed_squares > 0.0)) return 0.0;
  return s.region_smoothed * s.region_smoothed / (s.smoothed_squares * s.region_squares);
}

bool take_sums(const Sums& s, ExplainedRow& row) {
  const auto n = static_cast<double>(s.n);
  row.n = s.n;
  if (s.n < kFewestJudged) return row.regions = {}, false;
  row.n_regions = s.n_regions;
  row.observed = s.r2 / n;
  row.chi2 = s.chi2 / n;
  row.regional_chi2 = s.n_regions > 0 ? s.regional / static_cast<double>(s.n_regions) : kNaN;
  row.regional_chi2_of_noise =
      s.n_regions > 0 ? s.regional_of_noise / static_cast<double>(s.n_regions) : kNaN;
  row.noise_chi2 = s.noise_chi2 / n;
  row.smoothed_fraction = smoothed_fraction(s);
  return true;
}

void judge(const Sums& s, double known_to, double kept, ExplainedRow& row) {
  constexpr double kMore = kCoverage * kCoverage - 1.0;
  const auto n = static_cast<double>(s.n);
  row.state = kExplained;
  row.chi2_limit = kept * (1.0 + allowed_above(n, known_to)) + kMore * s.share / n;
  if (!(row.chi2 <= row.chi2_limit)) row.worsen(kNotExplained);
  if (row.n_regions == 0) return;
  const auto n_regions = static_cast<double>(s.n_regions);
  row.regional_limit = 1.0 + allowed_above(n_regions, known_to) + kMore * (s.regional_share / n_regions);
  if (!(row.regional_chi2 <= row.regional_limit)) row.worsen(kNotExplained);
}

void judge_least(const Sums& s, double noise, double rounding, double kept, double known_to,
                 ExplainedRow& row) {
  if (!(noise > kNoisy * rounding)) return;
  row.chi2_least = kept * (1.0 - allowed_for(static_cast<double>(s.n), known_to));
  if (row.noise_chi2 >= row.chi2_least) return;
  row.worsen(kTooWide, fmt::format("single values scatter by {:.2f} of what the noise in the budget says",
                                   std::sqrt(row.noise_chi2 / kept)));
}

void judge_share(double fraction, const char* of, ExplainedRow& row) {
  row.compared_fraction = std::min(1.0, fraction);
  if (fraction >= kLeastShare) return;
  row.worsen(kNotCompared, fmt::format("only {:.3g} % of {} could be compared", 100.0 * fraction, of));
}

std::string too_few(std::uint64_t n, const SeenPixels& seen, std::uint64_t both) {
  std::string why =
      fmt::format("{} values inside surfaces that both sides decoded, {} are needed", n, kFewestJudged);
  if (seen.either > 0)
    why += fmt::format(" ({} of the {} pixels that a side sees with modulation agree in their fringe order)",
                       both, seen.either);
  return why;
}

}  // namespace fringetwin::compare
