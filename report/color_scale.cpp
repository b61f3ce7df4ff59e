// SPDX-License-Identifier: Apache-2.0
#include "report/color_scale.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace fringetwin::report {
namespace {

using Lut = std::array<Rgb, 256>;

Lut opencv_lut(int colormap) {
  cv::Mat ramp(1, 256, CV_8UC1), colors;
  for (int i = 0; i < 256; ++i) ramp.at<unsigned char>(0, i) = static_cast<unsigned char>(i);
  cv::applyColorMap(ramp, colors, colormap);
  Lut lut;
  for (int i = 0; i < 256; ++i) {
    const cv::Vec3b bgr = colors.at<cv::Vec3b>(0, i);
    lut[i] = {bgr[2], bgr[1], bgr[0]};
  }
  return lut;
}

/// ColorBrewer RdBu, 11 classes, reversed (blue = negative), with a pure white centre.
constexpr std::array<Rgb, 11> kBlueWhiteRed{{{5, 48, 97},
                                             {33, 102, 172},
                                             {67, 147, 195},
                                             {146, 197, 222},
                                             {209, 229, 240},
                                             {255, 255, 255},
                                             {253, 219, 199},
                                             {244, 165, 130},
                                             {214, 96, 77},
                                             {178, 24, 43},
                                             {103, 0, 31}}};

std::uint8_t mix(std::uint8_t a, std::uint8_t b, double t) {
  return static_cast<std::uint8_t>(std::lround(a + t * (b - a)));
}

Rgb diverging_color(double t) {
  const double at = t * static_cast<double>(kBlueWhiteRed.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(at), kBlueWhiteRed.size() - 2);
  const double f = at - static_cast<double>(i);
  const Rgb &a = kBlueWhiteRed[i], &b = kBlueWhiteRed[i + 1];
  return {mix(a.r, b.r, f), mix(a.g, b.g, f), mix(a.b, b.b, f)};
}

}  // namespace

Rgb scale_color(Scale scale, double t) {
  static const Lut viridis = opencv_lut(cv::COLORMAP_VIRIDIS);
  static const Lut cividis = opencv_lut(cv::COLORMAP_CIVIDIS);
  t = std::clamp(t, 0.0, 1.0);
  const auto level = static_cast<std::size_t>(std::lround(255.0 * t));
  switch (scale) {
    case Scale::viridis:
      return viridis[level];
    case Scale::cividis:
      return cividis[level];
    case Scale::diverging:
      return diverging_color(t);
    case Scale::gray:
      break;
  }
  const auto v = static_cast<std::uint8_t>(level);
  return {v, v, v};
}

std::array<Rgb, 256> map_palette(Scale scale, Rgb nan_color) {
  std::array<Rgb, 256> palette;
  palette[0] = nan_color;
  palette[1] = {255, 255, 255};
  palette[2] = {0, 0, 0};
  for (int i = 0; i < kLevels; ++i)
    palette[kFirstLevel + i] = scale_color(scale, static_cast<double>(i) / (kLevels - 1));
  return palette;
}

std::string css_gradient(Scale scale, const std::string& direction) {
  std::string css = "linear-gradient(" + direction;
  constexpr int kStops = 24;
  for (int i = 0; i <= kStops; ++i) {
    const Rgb c = scale_color(scale, static_cast<double>(i) / kStops);
    css += fmt::format(",#{:02x}{:02x}{:02x}", c.r, c.g, c.b);
  }
  return css + ")";
}

}  // namespace fringetwin::report
