// SPDX-License-Identifier: Apache-2.0
#include "measure/description/repeated_images.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fringetwin::measure {
namespace {

/// Largest difference of two images that show the same, over the one that neighbouring steps make: flicker
/// and noise stay below, other patterns far above.
constexpr double kSame = 0.35;
constexpr std::uint64_t kFewest = 200;  ///< pixels

/// Returns the rms difference of two images over the chosen pixels, after one factor for the light.
double rms_difference(const GrayImage& a, const GrayImage& b, const ImageU8& chosen) {
  double aa = 0.0, ab = 0.0, bb = 0.0;
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen.data[i] == 0) continue;
    const auto x = static_cast<double>(a[i]), y = static_cast<double>(b[i]);
    aa += x * x, ab += x * y, bb += y * y;
    ++n;
  }
  if (n < kFewest || aa <= 0.0) return INFINITY;
  return std::sqrt(std::max(0.0, bb - ab * ab / aa) / static_cast<double>(n));
}

/// Returns the rms of half of the range of gray values of the chosen pixels over the images: about the
/// fringe's amplitude.
double rms_amplitude(const std::vector<const GrayImage*>& images, const ImageU8& chosen) {
  double sum = 0.0;
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen.data[i] == 0) continue;
    const auto [low, high] =
        std::minmax_element(images.begin(), images.end(),
                            [i](const GrayImage* a, const GrayImage* b) { return (*a)[i] < (*b)[i]; });
    sum += std::pow(0.5 * static_cast<double>((**high)[i] - (**low)[i]), 2);
    ++n;
  }
  return n > 0 ? std::sqrt(sum / static_cast<double>(n)) : 0.0;
}

}  // namespace

std::vector<std::pair<int, int>> repeated_images(const CameraImages& images, const Fringes& fringes,
                                                 const ImageU8& reached) {
  std::vector<std::pair<int, int>> out;
  if (fringes.steps < 3) return out;
  const std::vector<PatternSpec> sequence = expand_sequence(fringes);
  for (int direction = 0; direction < static_cast<int>(fringes.directions.size()); ++direction) {
    std::vector<int> numbers;
    std::vector<const GrayImage*> shown;
    for (std::size_t i = 0; i < sequence.size(); ++i)
      if (sequence[i].kind == PatternSpec::Kind::phase_step && sequence[i].direction == direction) {
        numbers.push_back(static_cast<int>(i));
        shown.push_back(&images.images[i]);
      }
    // neighbouring steps differ by 2 A sin(pi / N) times a cosine
    const double neighbours =
        std::numbers::sqrt2 * std::sin(std::numbers::pi / fringes.steps) * rms_amplitude(shown, reached);
    for (std::size_t a = 0; a < shown.size(); ++a)
      for (std::size_t b = a + 1; b < std::min(shown.size(), a + 3); ++b)
        if (rms_difference(*shown[a], *shown[b], reached) < kSame * neighbours)
          out.emplace_back(numbers[a], numbers[b]);
  }
  return out;
}

}  // namespace fringetwin::measure
