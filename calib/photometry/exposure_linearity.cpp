// SPDX-License-Identifier: Apache-2.0
#include "calib/photometry/exposure_linearity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace fringetwin::calib {
namespace {

/// Returns the share of a series' pixels that one of its images has at saturation.
double saturated_share(const StillSeries& series, double saturation_dn) {
  std::size_t saturated = 0, n = 0;
  for (std::size_t i = 0; i < series.images.front().size(); ++i, ++n)
    saturated += std::ranges::any_of(series.images, [&](const ImageF& image) {
      return static_cast<double>(image.data[i]) >= saturation_dn;
    });
  return static_cast<double>(saturated) / static_cast<double>(std::max<std::size_t>(n, 1));
}

/// Returns 1 for the pixels that no image of the series comes near saturation with.
ImageU8 far_from_saturation(const std::vector<const StillSeries*>& all, double saturation_dn) {
  const double most_dn = saturation_dn - std::max(2.0, 0.01 * saturation_dn);  // some sigma of its noise
  const ImageF& first = all.front()->images.front();
  ImageU8 far(first.width, first.height, 1);
  for (const StillSeries* series : all)
    for (const ImageF& image : series->images)
      for (std::size_t i = 0; i < far.size(); ++i)
        if (static_cast<double>(image.data[i]) > most_dn) far.data[i] = 0;
  return far;
}

/// Returns the series with an exposure and the pixels that tell how level follows it: those that none of the
/// series saturates. Series that leave too few are left out, the longest exposures first. Warnings say what
/// is left out.
std::pair<std::vector<const StillSeries*>, ImageU8> unsaturated_series(const std::vector<StillSeries>& stills,
                                                                       double saturation_dn,
                                                                       const std::string& camera,
                                                                       std::vector<std::string>& warnings) {
  constexpr double kLeastShare = 0.05;
  std::vector<const StillSeries*> series;
  for (const StillSeries& s : stills)
    if (s.exposure_ms) series.push_back(&s);
  std::ranges::stable_sort(series, {}, [](const StillSeries* s) { return *s->exposure_ms; });
  while (!series.empty()) {
    const double saturated = saturated_share(*series.back(), saturation_dn);
    if (saturated == 0.0) break;
    ImageU8 far = far_from_saturation(series, saturation_dn);
    const double left =
        static_cast<double>(std::ranges::count(far.data, 1)) / static_cast<double>(far.size());
    const std::string begin =
        fmt::format("camera {}: {:.3g} % of the pixels of the series at {:g} ms are saturated", camera,
                    100.0 * saturated, *series.back()->exposure_ms);
    if (left >= kLeastShare) {
      warnings.push_back(fmt::format(
          "{}: level against exposure is told by the {:.3g} % of the pixels that no series saturates", begin,
          100.0 * left));
      return {std::move(series), std::move(far)};
    }
    warnings.push_back(begin + ": it takes no part in level against exposure");
    series.pop_back();
  }
  ImageU8 all;
  if (!series.empty()) {
    const ImageF& first = series.front()->images.front();
    all = ImageU8(first.width, first.height, 1);
  }
  return {std::move(series), std::move(all)};
}

/// Returns the mean of an image over the pixels of a mask.
double mean_of(const ImageF& image, const ImageU8& mask) {
  double sum = 0.0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < image.size(); ++i)
    if (mask.data[i] != 0) sum += static_cast<double>(image.data[i]), ++n;
  return sum / static_cast<double>(std::max<std::size_t>(n, 1));
}

}  // namespace

std::optional<ExposureLinearity> exposure_linearity(const std::vector<StillSeries>& stills,
                                                    double saturation_dn, const std::string& camera,
                                                    std::vector<std::string>& warnings) {
  ExposureLinearity l;
  const auto [all_series, mask] = unsaturated_series(stills, saturation_dn, camera, warnings);
  for (const StillSeries* series : all_series) {
    double mean = 0.0;
    for (const ImageF& image : series->images)
      mean += mean_of(image, mask) / static_cast<double>(series->images.size());
    l.exposure_ms.push_back(*series->exposure_ms);
    l.level_dn.push_back(mean);
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
