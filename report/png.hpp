// SPDX-License-Identifier: Apache-2.0
// Encodes images as PNG in memory. Maps are palette images: a third of the bytes of RGB, so that a page of
// many maps stays small (cv::imencode writes no palettes).
#pragma once
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "report/color_scale.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::report {

/// `text`: tEXt chunks (keyword, value), e.g. unit and limits of a map.
std::string encode_palette_png(const ImageU8& indices, const std::array<Rgb, 256>& palette,
                               const std::vector<std::pair<std::string, std::string>>& text = {});

std::string base64(const std::string& bytes);
/// "data:image/png;base64,..."
std::string png_data_uri(const std::string& png);

}  // namespace fringetwin::report
