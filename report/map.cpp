// SPDX-License-Identifier: Apache-2.0
#include "report/map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "report/png.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::report {
namespace {

std::vector<float> finite_values(const ImageF& image, bool absolute) {
  std::vector<float> values;
  // two million values fix a percentile to better than its printed digits
  const std::size_t stride = std::max<std::size_t>(1, image.size() / 2'000'000);
  values.reserve(image.size() / stride + 1);
  for (std::size_t i = 0; i < image.size(); i += stride)
    if (std::isfinite(image.data[i])) values.push_back(absolute ? std::abs(image.data[i]) : image.data[i]);
  return values;
}

int limit_decimals(const MapLimits& limits) {
  const double span = limits.high - limits.low;
  return std::clamp(2 - static_cast<int>(std::floor(std::log10(span))), 0, 7);
}

std::string limit_text(double value, const MapLimits& limits) {
  return limits.low < 0.0 && limits.high > 0.0 ? signed_fixed(value, limit_decimals(limits))
                                               : fixed(value, limit_decimals(limits));
}

std::string image_html(const std::string& png, const std::string& alt, int width, int height,
                       const std::string& css_class = "") {
  return fmt::format("<img{} alt=\"{}\" width=\"{}\" height=\"{}\" src=\"{}\">",
                     css_class.empty() ? "" : " class=\"" + css_class + "\"", escape_html(alt), width, height,
                     png_data_uri(png));
}

/// ASCII only: OpenCV's Hershey fonts know no minus sign or micro.
std::string ascii(const std::string& text) {
  std::string out = replace_all(replace_all(text, "−", "-"), "µ", "u");
  std::erase_if(out, [](char c) { return static_cast<unsigned char>(c) > 126; });
  return out;
}

void draw_bar(cv::Mat& canvas, int top, const MapStyle& style) {
  const int margin = 16, width = canvas.cols - 2 * margin, height = 16;
  const double scale = std::clamp(canvas.cols / 1600.0, 0.3, 0.6);
  for (int x = 0; x < width; ++x) {
    const int level = kFirstLevel + x * (kLevels - 1) / std::max(1, width - 1);
    canvas(cv::Rect(margin + x, top + 8, 1, height)).setTo(level);
  }
  cv::rectangle(canvas, cv::Rect(margin, top + 8, width, height), cv::Scalar(2), 1);
  const auto label = [&](const std::string& text, double fraction) {
    int base = 0;
    const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &base);
    const int x = std::clamp(margin + static_cast<int>(fraction * width) - size.width / 2, 2,
                             std::max(2, canvas.cols - size.width - 2));
    cv::putText(canvas, text, {x, top + 42}, cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar(2), 1, cv::LINE_8);
  };
  const MapLimits& l = style.limits;
  label(ascii(limit_text(l.low, l)), 0.0);
  label(ascii(limit_text(l.high, l)), 1.0);
  label(ascii(style.title + " [" + style.unit + "]"), 0.5);
}

}  // namespace

double percentile(std::vector<float> values, double percent) {
  std::erase_if(values, [](float v) { return !std::isfinite(v); });
  return quantile(values, percent / 100.0);
}

MapLimits robust_limits(const ImageF& image, double low_percent, double high_percent) {
  const std::vector<float> values = finite_values(image, false);
  if (values.empty()) return {};
  MapLimits limits{percentile(values, low_percent), percentile(values, high_percent)};
  if (limits.low < limits.high) return limits;
  const double half = std::max(1e-6, 1e-3 * std::abs(limits.low));
  return {limits.low - half, limits.high + half};
}

MapLimits symmetric_limits(const ImageF& image, double percent) {
  const std::vector<float> values = finite_values(image, true);
  const double a = values.empty() ? 1.0 : std::max(percentile(values, percent), 1e-6);
  return {-a, a};
}

ImageF shrink_by_area_mean(const ImageF& image, int max_width_px) {
  FT_CHECK(max_width_px > 0, "a map needs a positive width");
  const int k = (image.width + max_width_px - 1) / max_width_px;
  if (k <= 1) return image;
  ImageF out((image.width + k - 1) / k, (image.height + k - 1) / k);
#pragma omp parallel for schedule(static)
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      double sum = 0.0;
      int n = 0, all = 0;
      for (int v = y * k; v < std::min((y + 1) * k, image.height); ++v)
        for (int u = x * k; u < std::min((x + 1) * k, image.width); ++u) {
          ++all;
          const float value = image(u, v);
          if (!std::isfinite(value)) continue;
          sum += static_cast<double>(value);
          ++n;
        }
      out(x, y) = 2 * n >= all ? static_cast<float>(sum / n) : std::numeric_limits<float>::quiet_NaN();
    }
  return out;
}

ImageU8 map_indices(const ImageF& image, const MapLimits& limits) {
  FT_CHECK(limits.low < limits.high, "the limits of a map increase");
  ImageU8 out(image.width, image.height);
  const double scale = (kLevels - 1) / (limits.high - limits.low);
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(image.size()); ++i) {
    const double v = image.data[i];
    if (std::isnan(v)) continue;  // index 0
    const double level = std::clamp((v - limits.low) * scale, 0.0, static_cast<double>(kLevels - 1));
    out.data[i] = static_cast<unsigned char>(kFirstLevel + std::lround(level));
  }
  return out;
}

std::string color_bar_html(const MapStyle& style) {
  const MapLimits& l = style.limits;
  std::string out =
      "<div class=\"bar\"><div class=\"ramp\" style=\"background:" + css_gradient(style.scale, "to right") +
      "\"></div><div class=\"ticks\">";
  for (int i = 0; i <= 4; ++i)
    out += "<span>" + escape_html(limit_text(l.low + (l.high - l.low) * i / 4.0, l)) + "</span>";
  return out + "</div><div class=\"barunit\">" + escape_html(style.title) +
         (style.unit.empty() ? "" : " [" + escape_html(style.unit) + "]") + "</div></div>";
}

std::string map_png(const ImageF& image, const MapStyle& style) {
  return encode_palette_png(map_indices(image, style.limits), map_palette(style.scale, style.nan_color),
                            {{"Title", style.title},
                             {"Unit", style.unit},
                             {"Low", fmt::format("{:.9g}", style.limits.low)},
                             {"High", fmt::format("{:.9g}", style.limits.high)}});
}

std::string map_html(const ImageF& image, const MapStyle& style) {
  const ImageF shown = shrink_by_area_mean(image, style.max_width_px);
  return "<div class=\"map\">" +
         image_html(map_png(shown, style), style.title + (style.unit.empty() ? "" : " in " + style.unit),
                    shown.width, shown.height) +
         (style.show_bar ? color_bar_html(style) : "") + "</div>\n";
}

void write_map_png(const std::filesystem::path& file, const ImageF& image, const MapStyle& style) {
  constexpr int kBarHeight = 52;
  const ImageU8 picture = map_indices(image, style.limits);
  ImageU8 page(std::max(image.width, 240), image.height + kBarHeight, 1);
  for (int y = 0; y < image.height; ++y)
    std::copy_n(&picture.data[picture.index(0, y)], image.width, &page.data[page.index(0, y)]);
  cv::Mat canvas(page.height, page.width, CV_8UC1, page.data.data());
  draw_bar(canvas, image.height, style);
  const std::string png = encode_palette_png(page, map_palette(style.scale, style.nan_color),
                                             {{"Title", style.title},
                                              {"Unit", style.unit},
                                              {"Low", fmt::format("{:.9g}", style.limits.low)},
                                              {"High", fmt::format("{:.9g}", style.limits.high)}});
  write_text_file(file, png);
}

std::string slider_html(const ImageF& left, const std::string& left_label, const ImageF& right,
                        const std::string& right_label, const MapStyle& style, const std::string& id) {
  FT_CHECK(left.same_size(right), "the two images of a slider have one size");
  const ImageF a = shrink_by_area_mean(left, style.max_width_px);
  const ImageF b = shrink_by_area_mean(right, style.max_width_px);
  return fmt::format(
      "<div class=\"slider\" id=\"{0}\" style=\"--cut:50%\"><div class=\"stack\">{1}{2}<span class=\"tag "
      "tag-left\">{3}</span><span class=\"tag tag-right\">{4}</span><span class=\"cut\"></span></div><input "
      "type=\"range\" min=\"0\" max=\"100\" value=\"50\" aria-label=\"{3} or {4}\" "
      "oninput=\"this.parentNode.style.setProperty('--cut',this.value+'%')\">{5}</div>\n",
      safe_id(id), image_html(map_png(a, style), left_label, a.width, a.height, "under"),
      image_html(map_png(b, style), right_label, b.width, b.height, "over"), escape_html(left_label),
      escape_html(right_label), style.show_bar ? color_bar_html(style) : "");
}

}  // namespace fringetwin::report
