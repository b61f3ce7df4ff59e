// SPDX-License-Identifier: Apache-2.0
#include "compare/pattern/pattern_bins.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kCells = 16;  ///< of the map, along each side
/// Cells along each side of the image of `phase_by_place`.
constexpr int kPhaseCells = 4;

/// Returns bins that hold equally many values.
Bins bins_of_equal_count(const std::vector<float>& values) {
  std::vector<float> sorted = values, edges;
  std::ranges::sort(sorted);
  for (std::size_t i = 1; i < kPatternBins; ++i)
    if (const float edge = sorted[i * sorted.size() / kPatternBins];
        edge > (edges.empty() ? sorted[0] : edges.back()))
      edges.push_back(edge);
  Bins bins{{}, std::vector<double>(edges.size() + 1), {}};
  std::vector<double> n(bins.at.size());
  for (const float value : values) {
    const auto bin = static_cast<std::size_t>(std::ranges::upper_bound(edges, value) - edges.begin());
    bins.of.push_back(static_cast<int>(bin));
    bins.at[bin] += static_cast<double>(value);
    n[bin] += 1.0;
  }
  for (std::size_t b = 0; b < n.size(); ++b) bins.at[b] /= n[b];
  return bins;
}

/// Returns so many bins of a period.
Bins bins_of_phase(const std::vector<LeftValue>& values, int n_bins) {
  Bins bins;
  for (const LeftValue& v : values) {
    const double turns = static_cast<double>(v.phase_rad) / kTwoPi, within = turns - std::floor(turns);
    bins.of.push_back(std::isfinite(turns) ? std::min(n_bins - 1, static_cast<int>(n_bins * within)) : -1);
  }
  for (int b = 0; b < n_bins; ++b) bins.at.push_back(kTwoPi * (b + 0.5) / n_bins);
  return bins;
}

/// Returns a bin for each image that there is, in their order.
Bins bins_of_images(const std::vector<LeftValue>& values) {
  std::vector<int> images;
  for (const LeftValue& v : values) images.push_back(v.image);
  std::ranges::sort(images);
  images.erase(std::unique(images.begin(), images.end()), images.end());
  Bins bins;
  for (const LeftValue& v : values)
    bins.of.push_back(static_cast<int>(std::ranges::lower_bound(images, v.image) - images.begin()));
  bins.at.assign(images.begin(), images.end());
  return bins;
}

/// Returns n x n cells, row by row, over the part of the image that holds values.
Bins bins_of_place(const std::vector<LeftValue>& values, int n) {
  const auto [left, right] = std::ranges::minmax(values, {}, &LeftValue::x_px);
  const auto [top, bottom] = std::ranges::minmax(values, {}, &LeftValue::y_px);
  const float x0 = left.x_px, y0 = top.y_px, width = right.x_px - x0 + 1.0F, height = bottom.y_px - y0 + 1.0F,
              side = static_cast<float>(n);
  Bins bins;
  for (const LeftValue& v : values)
    bins.of.push_back(static_cast<int>(side * (v.y_px - y0) / height) * n +
                      static_cast<int>(side * (v.x_px - x0) / width));
  for (int b = 0; b < n * n; ++b) {
    bins.at.push_back(static_cast<double>(x0) - 0.5 + (b % n + 0.5) * static_cast<double>(width) / n);
    bins.at_y.push_back(static_cast<double>(y0) - 0.5 + (b / n + 0.5) * static_cast<double>(height) / n);
  }
  return bins;
}

/// Returns the bins of a period in each of some parts, part by part; at_y: the number of the part.
Bins bins_of_phase_in(const Bins& parts, const std::vector<double>& numbers,
                      const std::vector<LeftValue>& values) {
  const Bins phases = bins_of_phase(values, kPhaseBins);
  Bins bins;
  for (std::size_t i = 0; i < values.size(); ++i)
    bins.of.push_back(phases.of[i] < 0 ? -1 : parts.of[i] * kPhaseBins + phases.of[i]);
  for (const double number : numbers)
    for (const double phase_rad : phases.at) {
      bins.at.push_back(phase_rad);
      bins.at_y.push_back(number);
    }
  return bins;
}

/// By cells of the image, numbered from 1.
Bins bins_of_phase_by_place(const std::vector<LeftValue>& values) {
  const Bins cells = bins_of_place(values, kPhaseCells);
  std::vector<double> numbers(cells.at.size());
  std::iota(numbers.begin(), numbers.end(), 1.0);
  return bins_of_phase_in(cells, numbers, values);
}

/// By images, with their numbers in the sequence.
Bins bins_of_phase_by_image(const std::vector<LeftValue>& values) {
  const Bins images = bins_of_images(values);
  return bins_of_phase_in(images, images.at, values);
}

}  // namespace

Bins bins_of(std::size_t coordinate, const LeftOver& camera) {
  switch (coordinate) {
    case kPhase:
      return bins_of_phase(camera.values, kPatternBins);
    case kImageNumber:
      return bins_of_images(camera.values);
    case kPlace:
      return bins_of_place(camera.values, kCells);
    case kPhaseByPlace:
      return bins_of_phase_by_place(camera.values);
    case kPhaseByImage:
      return bins_of_phase_by_image(camera.values);
    default:
      break;
  }
  std::vector<float> numbers;  // gray levels or radii
  for (const LeftValue& v : camera.values)
    numbers.push_back(coordinate == 0
                          ? v.level_dn
                          : static_cast<float>(std::hypot(static_cast<double>(v.x_px) - camera.middle_x_px,
                                                          static_cast<double>(v.y_px) - camera.middle_y_px)));
  return bins_of_equal_count(numbers);
}

std::vector<std::uint8_t> quarters_of_image(const std::vector<LeftValue>& values) {
  const auto middle = [](std::vector<float> v) { return static_cast<float>(quantile(v, 0.5)); };
  std::vector<float> x;
  std::array<std::vector<float>, 2> y;
  for (const LeftValue& v : values) x.push_back(v.x_px);
  const float middle_x = middle(x);
  for (const LeftValue& v : values) y[v.x_px < middle_x ? 0 : 1].push_back(v.y_px);
  const std::array<float, 2> middle_y{middle(y[0]), middle(y[1])};
  std::vector<std::uint8_t> parts;
  for (const LeftValue& v : values) {
    const std::size_t side = v.x_px < middle_x ? 0 : 1;
    parts.push_back(static_cast<std::uint8_t>(2 * side + (v.y_px < middle_y[side] ? 0 : 1)));
  }
  return parts;
}

std::vector<std::uint8_t> strips_of_image(const std::vector<LeftValue>& values, float LeftValue::*along) {
  std::vector<float> at;
  for (const LeftValue& v : values) at.push_back(v.*along);
  std::array<float, kPatternParts - 1> edges{};
  for (int k = 1; k < kPatternParts; ++k)
    edges[static_cast<std::size_t>(k - 1)] =
        static_cast<float>(quantile(at, static_cast<double>(k) / kPatternParts));
  std::vector<std::uint8_t> parts;
  for (const LeftValue& v : values)
    parts.push_back(static_cast<std::uint8_t>(std::ranges::upper_bound(edges, v.*along) - edges.begin()));
  return parts;
}

std::vector<int> numbers_of_pixels(const std::vector<LeftValue>& values) {
  std::unordered_map<std::uint64_t, int> number_of;
  std::vector<int> numbers;
  for (const LeftValue& v : values) {
    const std::uint64_t place =
        std::uint64_t{std::bit_cast<std::uint32_t>(v.x_px)} << 32 | std::bit_cast<std::uint32_t>(v.y_px);
    numbers.push_back(number_of.emplace(place, static_cast<int>(number_of.size())).first->second);
  }
  return numbers;
}

std::vector<std::uint8_t> quarters_of_sequence(const std::vector<LeftValue>& values) {
  const Bins images = bins_of_images(values);
  std::vector<std::uint8_t> parts;
  for (const int image : images.of)
    parts.push_back(
        static_cast<std::uint8_t>(static_cast<std::size_t>(image) * kPatternParts / images.at.size()));
  return parts;
}

}  // namespace fringetwin::compare
