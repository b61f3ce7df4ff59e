// SPDX-License-Identifier: Apache-2.0
// Turns values into colours, by scales that the colour-blind can read.
#pragma once
#include <array>
#include <cstdint>
#include <string>

namespace fringetwin::report {

struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;
};

enum class Scale {
  viridis,    ///< values
  cividis,    ///< values
  diverging,  ///< signed differences: blue, white at zero, red (ColorBrewer RdBu)
  gray        ///< gray levels
};

/// t in [0, 1]; outside is clamped to the ends.
Rgb scale_color(Scale scale, double t);

/// Palette of a map: entry 0 = NaN, 1 = white, 2 = black, 3...255 = the scale from low to high.
inline constexpr int kFirstLevel = 3;
inline constexpr int kLevels = 256 - kFirstLevel;
std::array<Rgb, 256> map_palette(Scale scale, Rgb nan_color);
/// Light gray that neither the diverging nor the two sequential scales contain.
inline constexpr Rgb kNanColor{222, 222, 222};

/// CSS linear-gradient of the scale, for the colour bar. direction e.g. "to right".
std::string css_gradient(Scale scale, const std::string& direction);

}  // namespace fringetwin::report
