// SPDX-License-Identifier: Apache-2.0
// | check                      | tolerance | origin                                        |
// |----------------------------|-----------|-----------------------------------------------|
// | colours read back          | 1 level   | PNG is lossless; 253 levels of the scale       |
// | area mean, percentiles     | float eps | hand calculation                              |
#include "report/map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "report/cloud_view.hpp"
#include "report/png.hpp"

namespace fringetwin::report::map_test {
namespace {

const float kNan = std::numeric_limits<float>::quiet_NaN();

cv::Mat decode(const std::string& png) {
  return cv::imdecode(std::vector<unsigned char>(png.begin(), png.end()), cv::IMREAD_COLOR);
}

Rgb pixel(const cv::Mat& m, int x, int y) {
  const cv::Vec3b v = m.at<cv::Vec3b>(y, x);
  return {v[2], v[1], v[0]};
}

void expect_color(Rgb a, Rgb b) {
  EXPECT_NEAR(a.r, b.r, 1);
  EXPECT_NEAR(a.g, b.g, 1);
  EXPECT_NEAR(a.b, b.b, 1);
}

TEST(ColorScale, DivergingIsWhiteAtZeroBlueBelowRedAbove) {
  expect_color(scale_color(Scale::diverging, 0.5), {255, 255, 255});
  EXPECT_GT(scale_color(Scale::diverging, 0.2).b, scale_color(Scale::diverging, 0.2).r + 50);
  EXPECT_GT(scale_color(Scale::diverging, 0.8).r, scale_color(Scale::diverging, 0.8).b + 50);
  EXPECT_EQ(scale_color(Scale::diverging, -3.0).r, scale_color(Scale::diverging, 0.0).r);
}

TEST(ColorScale, SequentialScalesGetLighterAllTheWay) {
  for (Scale scale : {Scale::viridis, Scale::cividis, Scale::gray}) {
    double before = -1.0;
    for (int i = 0; i <= 16; ++i) {
      const Rgb c = scale_color(scale, i / 16.0);
      const double luma = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
      EXPECT_GT(luma, before);
      before = luma;
    }
  }
}

TEST(Png, TextThatIsNotAsciiGoesIntoAnUtf8Chunk) {
  const std::string png = encode_palette_png(ImageU8(2, 2, 0), map_palette(Scale::gray, {0, 0, 0}),
                                             {{"Title", "a − b"}, {"Unit", "mm"}});
  EXPECT_NE(png.find("iTXtTitle"), std::string::npos);
  EXPECT_NE(png.find("a − b"), std::string::npos);
  EXPECT_NE(png.find("tEXtUnit"), std::string::npos);
  EXPECT_EQ(png.find("tEXtTitle"), std::string::npos);  // Latin-1 by the standard
  EXPECT_EQ(decode(png).cols, 2);
}

TEST(CloudView, ScaleBarIsRoundAndFits) {
  // a quarter of 640 px at 0.1 mm is 16 mm: the bar is 10 mm, 15.63 % of the width
  EXPECT_EQ(scale_bar_html(0.1, 640), "<div class=\"scale\"><span style=\"width:15.62%\"></span>10 mm</div>");
  EXPECT_NE(scale_bar_html(0.05, 640).find("5 mm"), std::string::npos);
  EXPECT_NE(scale_bar_html(2.0, 640).find("200 mm"), std::string::npos);
  EXPECT_EQ(scale_bar_html(0.0, 640), "");
}

TEST(Map, PngReadsBackWithNanAndLimits) {
  ImageF image(4, 2, 0.0f);
  image(0, 0) = -1.0f;
  image(1, 0) = 1.0f;
  image(2, 0) = kNan;
  image(3, 0) = 50.0f;  // beyond the limit: the end colour
  MapStyle style;
  style.scale = Scale::diverging;
  style.limits = {-1.0, 1.0};
  const cv::Mat m = decode(map_png(image, style));
  ASSERT_EQ(m.cols, 4);
  ASSERT_EQ(m.rows, 2);
  expect_color(pixel(m, 0, 0), scale_color(Scale::diverging, 0.0));
  expect_color(pixel(m, 1, 0), scale_color(Scale::diverging, 1.0));
  expect_color(pixel(m, 2, 0), kNanColor);
  expect_color(pixel(m, 3, 0), scale_color(Scale::diverging, 1.0));
  expect_color(pixel(m, 0, 1), {255, 255, 255});
}

TEST(Map, Base64MatchesRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64(std::string("\xff\x00\x80", 3)), "/wCA");
}

TEST(Map, PercentilesLeaveNanOut) {
  std::vector<float> v{kNan, 4, 1, 3, 2, 0};
  EXPECT_DOUBLE_EQ(percentile(v, 0), 0);
  EXPECT_DOUBLE_EQ(percentile(v, 100), 4);
  EXPECT_DOUBLE_EQ(percentile(v, 50), 2);
  EXPECT_DOUBLE_EQ(percentile(v, 62.5), 2.5);
  EXPECT_TRUE(std::isnan(percentile({kNan}, 50)));
}

TEST(Map, LimitsAreRobustAndNeverEmpty) {
  ImageF image(100, 100, 2.0f);
  for (std::size_t i = 0; i < 5000; ++i) image.data[i] = 1.0f;
  image.data[0] = 1e9f;
  const MapLimits limits = robust_limits(image);
  EXPECT_DOUBLE_EQ(limits.low, 1.0);
  EXPECT_DOUBLE_EQ(limits.high, 2.0);
  const MapLimits flat = robust_limits(ImageF(3, 3, 7.0f));
  EXPECT_LT(flat.low, flat.high);
  const MapLimits none = robust_limits(ImageF(3, 3, kNan));
  EXPECT_LT(none.low, none.high);
  const MapLimits both = symmetric_limits(ImageF(3, 3, -4.0f));
  EXPECT_DOUBLE_EQ(both.low, -4.0);
  EXPECT_DOUBLE_EQ(both.high, 4.0);
}

TEST(Map, ShrinksByAreaMeanAndSkipsNan) {
  ImageF image(5, 4);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 5; ++x) image(x, y) = static_cast<float>(x + 10 * y);
  image(0, 0) = kNan;                                  // one of four: the mean of the rest
  image(2, 2) = image(3, 2) = image(2, 3) = kNan;      // three of four: unknown
  const ImageF small = shrink_by_area_mean(image, 3);  // factor 2
  ASSERT_EQ(small.width, 3);
  ASSERT_EQ(small.height, 2);
  EXPECT_FLOAT_EQ(small(0, 0), (1 + 10 + 11) / 3.0f);
  EXPECT_FLOAT_EQ(small(1, 0), (2 + 3 + 12 + 13) / 4.0f);
  EXPECT_TRUE(std::isnan(small(1, 1)));
  EXPECT_FLOAT_EQ(small(2, 0), (4 + 14) / 2.0f);  // the block at the border has two pixels
  EXPECT_EQ(shrink_by_area_mean(image, 5).width, 5);
}

TEST(Map, FileHasABarBelowTheFullResolution) {
  const auto file = std::filesystem::temp_directory_path() / "fringetwin_map_test.png";
  MapStyle style;
  style.unit = "mrad";
  style.title = "a − b";
  style.limits = {0, 1};
  write_map_png(file, ImageF(300, 200, 0.5f), style);
  const cv::Mat m = cv::imread(file.string());
  ASSERT_EQ(m.cols, 300);
  EXPECT_GT(m.rows, 200);
  expect_color(pixel(m, 150, 100), scale_color(Scale::viridis, 0.5));
}

TEST(Map, HtmlPrintsUnitAndLimits) {
  MapStyle style;
  style.title = "classes";
  EXPECT_NE(map_html(ImageF(2, 2), style).find("alt=\"classes\""), std::string::npos) << "of no unit";
  style.unit = "µm";
  style.title = "deviation <1>";
  style.scale = Scale::diverging;
  style.limits = {-2.5, 2.5};
  const std::string html = map_html(ImageF(8, 8, 1.0f), style);
  for (const char* words :
       {"µm", "−2.50", "+2.50", "deviation &lt;1&gt;", "data:image/png;base64,", "linear-gradient"})
    EXPECT_NE(html.find(words), std::string::npos) << words;
}

TEST(CloudView, NearestPointWins) {
  CloudView view;
  view.forward_world = {0, 0, 1};
  view.dot_px = 3;
  std::vector<Eigen::Vector3d> points{{0, 0, 10}, {0, 0, 5}, {1, 1, 10}, {-1, -1, 10}};
  const CloudPicture picture = draw_cloud(points, {1, 2, 3, 4}, view);
  EXPECT_EQ(picture.n_drawn, 4u);
  EXPECT_FLOAT_EQ(picture.value(321, 241), 2.0f);
  // world x points right, y down: (1, 1) lies in the lower right
  bool lower_right = false, upper_left = false;
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      lower_right = lower_right || (picture.value(x, y) == 3.0f && x > 320 && y > 240);
      upper_left = upper_left || (picture.value(x, y) == 4.0f && x < 320 && y < 240);
    }
  EXPECT_TRUE(lower_right);
  EXPECT_TRUE(upper_left);
}

TEST(CloudView, StrayAndBrokenPointsDoNoHarm) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 10000; ++i) points.emplace_back(i % 100, i / 100, 0);
  points.emplace_back(1e6, 0, 0);
  points.emplace_back(std::nan(""), 0, 0);
  const CloudPicture picture = draw_cloud(points, std::vector<float>(points.size(), 1.0f), {});
  EXPECT_LT(picture.mm_per_px, 0.5);
  EXPECT_EQ(picture.n_drawn, 10001u);
  EXPECT_EQ(draw_cloud({}, {}, {}).n_drawn, 0u);
}

}  // namespace
}  // namespace fringetwin::report::map_test
