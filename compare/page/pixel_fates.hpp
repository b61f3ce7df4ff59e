// SPDX-License-Identifier: Apache-2.0
// Says of each pixel of a measured camera what became of it: a point, or why not.
#pragma once
#include <array>
#include <cstddef>
#include <string>

#include "measure/measurement.hpp"

namespace fringetwin::compare {

/// In the order of the page: the better, the lower.
enum class PixelFate { point, decoded, dark, no_order, saturated };
inline constexpr std::size_t kFates = 5;

/// Returns the fate of each pixel of a camera. Only pixels of the first one carry points; one with several
/// faults has the last of the list.
Image<PixelFate> pixel_fates(const measure::Measurement& measurement, std::size_t camera);

/// Returns the words of a fate, as they follow "pixels that": "are decoded, without a point".
std::string fate_name(PixelFate fate, bool first_camera, const Fringes& fringes);
/// Returns why pixels have this fate, and what to do about it; empty where all is well.
std::string fate_reason(PixelFate fate, const Twin& twin, const measure::Measurement& measurement);

}  // namespace fringetwin::compare
