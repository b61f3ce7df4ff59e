// SPDX-License-Identifier: Apache-2.0
// | check                        | tolerance      | origin                                         |
// |------------------------------|----------------|------------------------------------------------|
// | positions read back          | half a step    | rounding to whole steps of the half size/32767 |
#include "report/cloud_canvas.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "report/text.hpp"

namespace fringetwin::report::cloud_canvas_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string unbase64(const std::string& text) {
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  unsigned bits = 0, held = 0;
  for (const char c : text) {
    if (c == '=') break;
    held = held << 6u | static_cast<unsigned>(alphabet.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    out += static_cast<char>(held >> bits & 0xffu);
  }
  return out;
}

std::string attribute(const std::string& html, const std::string& name) {
  const std::string key = " data-" + name + "=\"";
  const auto at = html.find(key);
  if (at == std::string::npos) return "";
  return html.substr(at + key.size(), html.find('"', at + key.size()) - at - key.size());
}

CloudCanvas canvas() {
  CloudCanvas c;
  c.style.scale = Scale::diverging;
  c.style.limits = {-2.0, 2.0};
  c.style.unit = "µm";
  return c;
}

TEST(CloudCanvas, PointsAndColoursReadBack) {
  const std::vector<Eigen::Vector3d> points = {{10, -3, 250}, {12.5, 4, 251}, {9, 0.125, 249}};
  const std::string html = cloud_canvas_html(points, {-2, 0, 2}, canvas(), "c");
  const double step = std::stod(attribute(html, "step"));
  EXPECT_NEAR(step, 0.5 * 7.0 / 32767.0, 1e-9);  // the cloud is widest along y
  const std::string bytes = unbase64(attribute(html, "points"));
  ASSERT_EQ(bytes.size(), 18u);
  const Eigen::Vector3d center(10.75, 0.5, 250);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto low = static_cast<unsigned char>(bytes[6 * i + 2 * axis]);
      const auto high = static_cast<signed char>(bytes[6 * i + 2 * axis + 1]);
      EXPECT_NEAR(step * (256 * high + low) + center[static_cast<Eigen::Index>(axis)],
                  points[i][static_cast<Eigen::Index>(axis)], 0.51 * step);
    }
  const std::string levels = unbase64(attribute(html, "levels"));
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_EQ(static_cast<unsigned char>(levels[0]), kFirstLevel);
  EXPECT_EQ(static_cast<unsigned char>(levels[1]), kFirstLevel + (kLevels - 1) / 2);
  EXPECT_EQ(static_cast<unsigned char>(levels[2]), 255);
  EXPECT_EQ(unbase64(attribute(html, "palette")).size(), 768u);
}

TEST(CloudCanvas, ManyPointsBecomeFewAndPrintKeepsThePicture) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 50'000; ++i) points.emplace_back(0.01 * (i % 250), 0.01 * (i / 250), 300.0);
  points.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  const std::vector<float> value(points.size(), 0.0f);
  const std::string html = cloud_canvas_html(points, value, canvas(), "c");
  EXPECT_EQ(unbase64(attribute(html, "levels")).size(), 12'000u);
  EXPECT_EQ(unbase64(attribute(html, "points")).size(), 72'000u);
  EXPECT_THAT(html, HasSubstr("class=\"still\"><div class=\"map\"><img"));
  EXPECT_THAT(html, HasSubstr(count(12000) + " of " + count(50001) + " points"));
  EXPECT_EQ(html, cloud_canvas_html(points, value, canvas(), "c"));  // the same page every time
}

TEST(CloudCanvas, NothingToDrawNeedsNoScript) {
  const std::string html = cloud_canvas_html({}, {}, canvas(), "c");
  EXPECT_THAT(html, Not(HasSubstr("canvas")));
  EXPECT_THAT(cloud_canvas_html({{0, 0, 1}}, {1.0f}, canvas(), "c"), HasSubstr("<canvas"));
}

TEST(CloudCanvas, HostileLabelsStayText) {
  CloudCanvas c = canvas();
  c.label = "\"><script>alert(1)</script>";
  const std::string html = cloud_canvas_html({{0, 0, 1}}, {1.0f}, c, "a\" onload=\"b");
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, Not(HasSubstr("onload=\"")));
}

}  // namespace
}  // namespace fringetwin::report::cloud_canvas_test
