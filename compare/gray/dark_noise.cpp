// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/dark_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kWeights[] = {1.0, -2.0, 1.0};
constexpr double kSumOfSquares = 2.0 * (1.0 + 4.0 + 1.0);  ///< of the weights, for both images

struct DarkDifferences {
  std::vector<double> size_dn;
  double level_sum_dn = 0.0;
  std::size_t at_zero = 0;
};

/// Returns whether pixel i and its eight neighbours are compared; `width`: of the image.
bool is_inside(const GrayPair& pair, std::size_t i, std::size_t width) {
  for (const std::size_t row : {i - width, i, i + width})
    for (std::size_t k = row - 1; k <= row + 1; ++k)
      if (pair.mask.data[k] == 0) return false;
  return true;
}

/// Returns the two images that are darkest in the rows above and below the three pixels about i: their own
/// noise has no part in the choice. Nothing where no two are dark.
std::optional<std::array<int, 2>> two_darkest(const GrayPair& pair, const std::vector<int>& codes,
                                              std::size_t i, std::size_t width) {
  constexpr double kDark = 0.1;         // of the way from the darkest to the brightest
  constexpr double kLeastShare = 0.05;  // of the scale: less is no code
  std::vector<std::pair<double, int>> around;
  for (const int image : codes) {
    double sum_dn = 0.0;
    for (const std::size_t row : {i - width, i + width})
      for (std::size_t k = row - 1; k <= row + 1; ++k) sum_dn += pair.real_at(image, k);
    around.emplace_back(sum_dn / 6.0, image);
  }
  std::ranges::sort(around);
  const double least_dn = around.front().first, range_dn = around.back().first - least_dn;
  if (range_dn < kLeastShare * pair.real->saturation_dn() || around[1].first > least_dn + kDark * range_dn)
    return std::nullopt;
  return std::array{around[0].second, around[1].second};
}

/// Adds the second difference of pixel i and its neighbours in the row, if two images leave them dark.
void add_triple(const GrayPair& pair, const std::vector<int>& codes, std::size_t i, DarkDifferences& out) {
  const auto width = static_cast<std::size_t>(pair.width());
  if (!is_inside(pair, i, width)) return;
  const auto dark = two_darkest(pair, codes, i, width);
  if (!dark) return;
  double second_dn = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double a = pair.real_at((*dark)[0], i + k - 1), b = pair.real_at((*dark)[1], i + k - 1);
    second_dn += kWeights[k] * (a - b);
    out.level_sum_dn += (a + b) / 6.0;
    if (a <= 0.0 || b <= 0.0) ++out.at_zero;
  }
  out.size_dn.push_back(std::abs(second_dn));
}

/// Returns the mean square of differences that are no outliers, which the edges of a code make.
double trimmed_square(std::vector<double>& size_dn, double least) {
  constexpr double kOutlier = 4.0;
  double square = std::max(std::pow(kMadToSigma * upper_median(size_dn), 2), least);
  for (int round = 0; round < 3; ++round) {
    double squares = 0.0, n = 0.0;
    for (const double d : size_dn)
      if (d * d < kOutlier * kOutlier * square) squares += d * d, n += 1.0;
    square = std::max(squares / n, least);
  }
  return square;
}

}  // namespace

std::optional<DarkNoise> dark_noise(const GrayPair& pair) {
  constexpr std::size_t kFewest = 1000;  // the variance is known to 5 %
  constexpr double kMostAtZero = 0.01;
  const std::vector<int> codes = pair.code_images();
  if (codes.size() < 3 || pair.real->radiance) return std::nullopt;
  constexpr int kMostTriples = 100'000;
  const int rows_apart = std::max(2, pair.width() / 3 * pair.height() / kMostTriples);
  std::vector<DarkDifferences> rows(static_cast<std::size_t>(pair.height()));
#pragma omp parallel for schedule(dynamic)
  for (int y = 1; y < pair.height() - 1; y += rows_apart)
    for (int x = 1; x + 1 < pair.width(); x += 3) add_triple(pair, codes, pair.mask.index(x, y), rows[y]);
  DarkDifferences all;
  for (const DarkDifferences& row : rows) {
    all.size_dn.insert(all.size_dn.end(), row.size_dn.begin(), row.size_dn.end());
    all.level_sum_dn += row.level_sum_dn;
    all.at_zero += row.at_zero;
  }
  const auto n = static_cast<double>(all.size_dn.size());
  if (all.size_dn.size() < kFewest || static_cast<double>(all.at_zero) > kMostAtZero * 3.0 * n)
    return std::nullopt;
  const double dn2 = trimmed_square(all.size_dn, kSumOfSquares * kRoundingVariance) / kSumOfSquares;
  return DarkNoise{all.level_sum_dn / n, dn2, dn2 * std::sqrt(2.0 / n)};
}

}  // namespace fringetwin::compare
