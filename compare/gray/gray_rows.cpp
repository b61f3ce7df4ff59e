// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/gray_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace fringetwin::compare {
namespace {

GrayRow one_row(const GrayPair& pair, const GainFit& fit, int image) {
  std::vector<float> d;
  d.reserve(pair.mask.size());
  double sum = 0.0, sum2 = 0.0;
  for (std::size_t i = 0; i < pair.mask.size(); ++i) {
    if (pair.mask.data[i] == 0) continue;
    const float value = gray_difference(pair, fit, image, i);
    if (std::isnan(value)) continue;
    d.push_back(value);
    const double v = static_cast<double>(value);
    sum += v;
    sum2 += v * v;
  }
  GrayRow row;
  row.n = d.size();
  const double n = static_cast<double>(d.size());
  row.mean_dn = d.empty() ? kNaN : sum / n;
  row.rms_dn = d.empty() ? kNaN : std::sqrt(sum2 / n);
  row.p99_dn = percentile_of_magnitude(d, row.rms_dn, 99.0);
  return row;
}

}  // namespace

double percentile_of_magnitude(const std::vector<float>& values, double rms, double percent) {
  if (values.empty()) return kNaN;
  if (!(rms > 0.0)) return 0.0;
  constexpr std::size_t kBins = 4096;
  const double width = 10.0 * rms / kBins;
  std::array<std::size_t, kBins> counts{};
  for (float v : values) {
    const double bin = std::abs(static_cast<double>(v)) / width;
    if (bin < kBins) ++counts[static_cast<std::size_t>(bin)];
  }
  const double wanted = percent / 100.0 * static_cast<double>(values.size());
  double below = 0.0;
  for (std::size_t i = 0; i < kBins; ++i) {
    const double here = static_cast<double>(counts[i]);
    if (here > 0.0 && below + here >= wanted)
      return (static_cast<double>(i) + (wanted - below) / here) * width;
    below += here;
  }
  return 10.0 * rms;
}

std::vector<GrayRow> gray_rows(const Twin& twin, const GrayPair& pair, const GainFit& fit) {
  std::vector<GrayRow> rows(pair.images.size());
#pragma omp parallel for schedule(dynamic)
  for (std::size_t k = 0; k < pair.images.size(); ++k) {
    rows[k] = one_row(pair, fit, pair.images[k]);
    rows[k].camera = pair.camera->name;
    rows[k].pattern = pair.patterns[pair.images[k]].label(twin.fringes);
  }
  return rows;
}

float gray_difference(const GrayPair& pair, const GainFit& fit, int image, std::size_t i) {
  const float unknown = std::numeric_limits<float>::quiet_NaN();
  const UsableRange& u = fit.usable;
  const double y = pair.real_at(image, i), v = pair.source_at(image, i), e = pair.irradiance_at(image, i);
  const double clip = u.gain_dn * e + u.black_level_dn;
  const bool use = pair.mask.data[i] != 0 && is_usable(u, y, v, clip);
  return use ? static_cast<float>(fit.row.gain_dn * e + fit.row.black_level_dn - y) : unknown;
}

ImageF gray_difference(const GrayPair& pair, const GainFit& fit, int image) {
  ImageF out(pair.width(), pair.height());
#pragma omp parallel for schedule(static)
  for (int y = 0; y < pair.height(); ++y)
    for (int x = 0; x < pair.width(); ++x) out(x, y) = gray_difference(pair, fit, image, out.index(x, y));
  return out;
}

ImageF predicted_gray(const GrayPair& pair, const GainFit& fit, int image) {
  ImageF out(pair.width(), pair.height());
  const double max =
      pair.real->radiance ? std::numeric_limits<double>::infinity() : pair.real->saturation_dn();
#pragma omp parallel for schedule(static)
  for (int y = 0; y < pair.height(); ++y)
    for (int x = 0; x < pair.width(); ++x) {
      const std::size_t i = out.index(x, y);
      const double dn = fit.row.gain_dn * pair.irradiance_at(image, i) + fit.row.black_level_dn;
      out.data[i] = static_cast<float>(std::clamp(dn, 0.0, max));
    }
  return out;
}

}  // namespace fringetwin::compare
