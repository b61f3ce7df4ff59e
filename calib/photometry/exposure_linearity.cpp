// SPDX-License-Identifier: Apache-2.0
#include "calib/photometry/exposure_linearity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "twin/base/errors.hpp"

namespace fringetwin::calib {
namespace {

constexpr int kBlock_px = 32;
// Of a block so few values may be at saturation: defects, or noise whose loss shifts the mean by a
// ten-thousandth. Pixels that were chosen one by one would be those that noise has darkened.
constexpr double kMostSaturated = 1e-3;
constexpr double kLeastBlocks = 0.05;  ///< of all

/// One series as its blocks see it.
struct BlockedSeries {
  const StillSeries* series = nullptr;
  std::vector<double> sum_dn, n;  ///< of each block
  std::vector<bool> counts;       ///< is not saturated
  double saturated = 0.0;         ///< share of its values
};

double share_of(const std::vector<bool>& all) {
  return static_cast<double>(std::ranges::count(all, true)) / static_cast<double>(all.size());
}

BlockedSeries blocked(const StillSeries& series, double saturation_dn) {
  const GrayImage& first = series.images.front();
  BlockedSeries out;
  out.series = &series;
  double saturated = 0.0;
  for (int y = 0; y < first.height; y += kBlock_px)
    for (int x = 0; x < first.width; x += kBlock_px) {
      double sum = 0.0, n = 0.0, at_end = 0.0;
      for (const GrayImage& image : series.images)
        for (int v = y; v < std::min(y + kBlock_px, first.height); ++v)
          for (int u = x; u < std::min(x + kBlock_px, first.width); ++u) {
            const auto value = static_cast<double>(image(u, v));
            sum += value;
            n += 1.0;
            at_end += value >= saturation_dn ? 1.0 : 0.0;
          }
      out.sum_dn.push_back(sum);
      out.n.push_back(n);
      out.counts.push_back(at_end <= std::max(1.0, kMostSaturated * n));
      saturated += at_end;
    }
  out.saturated = saturated / static_cast<double>(first.size() * series.images.size());
  return out;
}

/// Takes the series that leave too few blocks out, and of the others the blocks that one of them saturates.
/// Warnings say so.
std::vector<BlockedSeries> unsaturated_series(const std::vector<StillSeries>& stills, double saturation_dn,
                                              const std::string& camera, std::vector<std::string>& warnings) {
  std::vector<BlockedSeries> out;
  for (const StillSeries& series : stills) {
    if (!series.exposure_ms) continue;
    FT_CHECK(!series.images.empty(), "images of a series");
    for (const GrayImage& image : series.images)
      FT_CHECK(image.width == stills.front().images.front().width &&
                   image.height == stills.front().images.front().height,
               "images of one size");
    out.push_back(blocked(series, saturation_dn));
  }
  const auto text = [&](const BlockedSeries& b) {
    return fmt::format(
        "camera {}: {:.3g} % of the values of the series at {:g} ms are at {:g} DN, where they end", camera,
        100.0 * b.saturated, *b.series->exposure_ms, saturation_dn);
  };
  std::erase_if(out, [&](const BlockedSeries& b) {
    const bool is_out = share_of(b.counts) < kLeastBlocks;
    if (is_out) warnings.push_back(text(b) + ": it takes no part in level against exposure");
    return is_out;
  });
  if (out.empty()) return out;
  std::vector<bool> counts(out.front().counts.size(), true);
  for (const BlockedSeries& b : out)
    for (std::size_t k = 0; k < counts.size(); ++k) counts[k] = counts[k] && b.counts[k];
  if (share_of(counts) < 1.0)
    warnings.push_back(fmt::format(
        "{}: level against exposure is told by the {:.3g} % of the image that no series "
        "saturates",
        text(*std::ranges::max_element(out, {}, &BlockedSeries::saturated)), 100.0 * share_of(counts)));
  for (BlockedSeries& b : out) b.counts = counts;
  return out;
}

/// Returns the mean over the blocks that count; NaN without any.
double level_of(const BlockedSeries& b) {
  double sum = 0.0, n = 0.0;
  for (std::size_t k = 0; k < b.counts.size(); ++k)
    if (b.counts[k]) sum += b.sum_dn[k], n += b.n[k];
  return sum / n;
}

}  // namespace

std::optional<ExposureLinearity> exposure_linearity(const std::vector<StillSeries>& stills,
                                                    double saturation_dn, const std::string& camera,
                                                    std::vector<std::string>& warnings) {
  ExposureLinearity l;
  for (const BlockedSeries& b : unsaturated_series(stills, saturation_dn, camera, warnings)) {
    l.exposure_ms.push_back(*b.series->exposure_ms);
    l.level_dn.push_back(level_of(b));
    if (std::isnan(l.level_dn.back())) return std::nullopt;
  }
  const std::size_t n = l.exposure_ms.size();
  if (n < 3) return std::nullopt;
  // Weights 1/level^2, as EMVA 1288 does: relative residuals count.
  double s = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double w = 1.0 / std::pow(std::max(1.0, l.level_dn[i]), 2), x = l.exposure_ms[i], y = l.level_dn[i];
    s += w, sx += w * x, sy += w * y, sxx += w * x * x, sxy += w * x * y;
  }
  const double determinant = s * sxx - sx * sx;
  if (!(determinant > 1e-12 * s * sxx)) return std::nullopt;
  l.slope_dn_per_ms.value = (s * sxy - sx * sy) / determinant;
  l.offset_dn.value = (sxx * sy - sx * sxy) / determinant;
  double chi2 = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double line = l.offset_dn.value + l.slope_dn_per_ms.value * l.exposure_ms[i];
    const double off = l.level_dn[i] - line;
    chi2 += std::pow(off / std::max(1.0, l.level_dn[i]), 2);
    l.residual_percent.push_back(100.0 * off / line);
    if (std::abs(l.residual_percent.back()) > std::abs(l.worst_percent))
      l.worst_percent = l.residual_percent.back();
  }
  const double variance = n > 2 ? chi2 / static_cast<double>(n - 2) : 0.0;
  l.slope_dn_per_ms.sigma = std::sqrt(variance * s / determinant);
  l.offset_dn.sigma = std::sqrt(variance * sxx / determinant);
  return l;
}

}  // namespace fringetwin::calib
