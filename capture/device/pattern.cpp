// SPDX-License-Identifier: Apache-2.0
#include "capture/device/pattern.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "twin/base/errors.hpp"

namespace fringetwin::capture {

std::vector<Pattern> sequence_patterns(const Fringes& fringes) {
  std::vector<Pattern> patterns;
  for (const PatternSpec& spec : expand_sequence(fringes))
    patterns.push_back({static_cast<int>(patterns.size()), 0.0, spec.label(fringes)});
  return patterns;
}

ImageF pattern_levels(const Fringes& fringes, const Pattern& pattern, int width, int height) {
  FT_CHECK(width > 0 && height > 0, "the projector has pixels");
  if (pattern.index < 0) return {width, height, static_cast<float>(pattern.level)};
  const std::vector<PatternSpec> sequence = expand_sequence(fringes);
  const PatternSpec& spec = sequence.at(pattern.index);
  if (spec.is_image()) {
    const ImageF& levels = *fringes.images.at(spec.image).levels;
    FT_CHECK(levels.width == width && levels.height == height, "a pattern image has the projector's size");
    return levels;
  }
  ImageF levels(width, height);
  if (fringes.directions.at(spec.direction).axis == Axis::x) {
    std::vector<float> row(static_cast<std::size_t>(width));
    for (int x = 0; x < width; ++x) row[x] = static_cast<float>(pattern_value(fringes, spec, x));
    for (int y = 0; y < height; ++y) std::ranges::copy(row, &levels(0, y));
  } else {
    for (int y = 0; y < height; ++y)
      std::fill_n(&levels(0, y), width, static_cast<float>(pattern_value(fringes, spec, y)));
  }
  return levels;
}

ImageU16 quantise_levels(const ImageF& levels, int bits) {
  FT_CHECK(bits >= 8 && bits <= 16, fmt::format("a display of {} bits", bits));
  const double top = static_cast<double>((1 << bits) - 1);
  ImageU16 out(levels.width, levels.height);
  // Truncation after adding a half: std::lround() would be a call of the library for every pixel.
  std::transform(levels.data.begin(), levels.data.end(), out.data.begin(), [top](float level) {
    return static_cast<std::uint16_t>(std::clamp(static_cast<double>(level), 0.0, 1.0) * top + 0.5);
  });
  return out;
}

}  // namespace fringetwin::capture
