// SPDX-License-Identifier: Apache-2.0
// Corner files as mrcal's tools know them, .npz and base85 as Python knows them.
//
// | check                        | tolerance | origin                                             |
// |------------------------------|-----------|----------------------------------------------------|
// | corner files, written, read  | exact     | shortest round-trip decimals                       |
// | base85                       | exact     | Python: base64.b85encode(bytes(range(10)))         |
// | .npz                         | exact     | read by numpy                                      |
// | computing for 200,000 images | 20 s      | every image with every other: 120 s and more       |
#include "calib/board/corners_vnl.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ctime>

#include "calib/board/npz.hpp"
#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::calib::corners_vnl_test {
namespace {

using fringetwin::testing::ScratchFolder;
using ::testing::HasSubstr;

std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

TEST(CornersVnl, LevelsWeightsAndMissingCorners) {
  const ScratchFolder dir;
  const auto file =
      dir.write("c.vnl",
                "## a comment\n# filename x y level\na0.png 1.5 2.5 0\na0.png 3 4 1\na0.png 5 6 -\n"
                "a0.png 7 8 -1\na1.png - - -\n");
  const auto images = read_corners_vnl(file);
  ASSERT_EQ(images.size(), 2u);
  ASSERT_EQ(images[0].corners.size(), 4u);
  EXPECT_EQ(images[0].corners[0].weight, 1.0);
  EXPECT_EQ(images[0].corners[1].weight, 0.5);
  EXPECT_FALSE(images[0].corners[2].seen());
  EXPECT_FALSE(images[0].corners[3].seen());
  EXPECT_TRUE(images[1].corners.empty());
  EXPECT_EQ(read_corners_vnl(dir.write("w.vnl", "# filename x y weight\na 1 2 0.25\na 1 3 1\n"))[0]
                .corners[0]
                .weight,
            0.25);
  EXPECT_EQ(read_corners_vnl(file, true)[0].corners[1].weight, 1.0);
  EXPECT_EQ(read_corners_vnl(dir.write("n.vnl", "# filename x y\na 1 2\na 1 3\n"))[0].corners[1].weight, 1.0);
}

TEST(CornersVnl, WhatIsWrittenIsRead) {
  const ScratchFolder dir;
  std::vector<ImageCorners> images{{"left 0.png", {}, 0}, {"b.png", {}, 0}};
  images[0].filename = "left0.png";
  images[0].corners = {{{1.0 / 3.0, 1e-17}, 0.1}, {{1439.123456789012345, 2.0}, 1.0}, Corner{}};
  write_corners_vnl(dir / "o.vnl", images);
  const auto again = read_corners_vnl(dir / "o.vnl");
  ASSERT_EQ(again.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again[0].corners[i].q_px, images[0].corners[i].q_px);
    EXPECT_EQ(again[0].corners[i].weight, images[0].corners[i].weight);
  }
  EXPECT_FALSE(again[0].corners[2].seen());
  EXPECT_TRUE(again[1].corners.empty());
}

TEST(CornersVnl, FaultsNameFileAndLine) {
  const ScratchFolder dir;
  const auto read = [&](const std::string& text) {
    const auto file = dir.write("bad.vnl", text);
    return refusal([&] { read_corners_vnl(file); });
  };
  EXPECT_THAT(read("# filename x y level\na 1 nan 0\n"),
              HasSubstr("bad.vnl:2: the corner of a is not finite"));
  EXPECT_THAT(read("a 1 2,5 0\n"), HasSubstr("bad.vnl:1: \"2,5\" is not a number"));
  EXPECT_THAT(read("a 1\n"), HasSubstr("has 2 columns"));
  EXPECT_THAT(read("a 1 2 0\nb 1 2 0\na 1 2 0\n"), HasSubstr("bad.vnl:3: the rows of a are in two places"));
  EXPECT_THAT(refusal([] { read_corners_vnl("/nowhere.vnl"); }),
              HasSubstr("/nowhere.vnl: the corner file cannot be read"));
  EXPECT_THAT(read(std::string(5000, 'a') + " 1 2 0\n"), HasSubstr("an image's name has 5000 characters"));
  EXPECT_THAT(read("# filename x y weight\na 1 2 1e300\n"), HasSubstr("the weight of a corner is 1e+300"));
  std::string row;
  for (int i = 0; i < 100000; ++i) row += "1 ";
  EXPECT_THAT(read(row), HasSubstr("has 64 columns"));
}

TEST(CornersVnl, ImagesFindTheirDeviceAndFrame) {
  const std::vector<Corner> two(2, Corner{{1.0, 1.0}, 1.0});
  const std::vector<ImageCorners> images{{"in/left-10.png", two, 0},
                                         {"in/left-007.png", two, 0},
                                         {"in/right-7.png", two, 0},
                                         {"in/right-11.png", two, 0},
                                         {"in/left-11.png", {}, 0}};
  Observations o;
  o.board = {2, 1, 10.0};
  o.devices.resize(2);
  assign_views(images, {"left-*.png", "in/right*"}, o);
  EXPECT_EQ(o.frames, (std::vector<std::string>{"007", "10", "11"}));
  ASSERT_EQ(o.views.size(), 4u);
  EXPECT_EQ(o.views[0].source, "in/left-007.png");
  EXPECT_EQ(o.views[1].source, "in/right-7.png");
  EXPECT_EQ(o.views[1].frame, 0);
  EXPECT_EQ(o.views[3].frame, 2);
  EXPECT_THAT(refusal([&] {
                assign_views(images, {"left*", "x*"}, o);
              }),
              HasSubstr("\"x*\" matches no image"));
  EXPECT_THAT(refusal([&] { assign_views(images, {"left*", "*"}, o); }), HasSubstr("belongs to"));
}

TEST(CornersVnl, SentencesOfViewsNameTheFile) {
  const std::vector<Corner> two(2, Corner{{1.0, 1.0}, 1.0});
  const std::vector<ImageCorners> images{{"left-1.png", two, 3}, {"left-01.png", two, 5}};
  Observations o;
  o.board = {2, 1, 10.0};
  o.devices.resize(1);
  o.file = "c.vnl";
  EXPECT_EQ(refusal([&] { assign_views(images, {"x*"}, o); }),
            "c.vnl: \"x*\" matches no image; its first image is left-1.png");
  EXPECT_THAT(refusal([&] { assign_views(images, {"left*"}, o); }),
              HasSubstr("c.vnl:5: left-01.png: has the same frame number as left-1.png"));
  o.board = {3, 3, 10.0};
  o.devices[0] = {"left", {100, 100}, 100.0};
  assign_views({images[0]}, {"left*"}, o);
  EXPECT_THAT(refusal([&] { check_observations(o); }),
              HasSubstr("c.vnl: left, view 0 (left-1.png): has 2 corners, the board has 3 x 3"));
}

TEST(CornersVnl, NumbersAndWordsHaveAnOrder) {  // 9 < 10, but "1a" between them had none
  std::vector<ImageCorners> images;
  for (int i = 0; i < 100; ++i)
    images.push_back({"left-" + std::to_string(i) + (i % 3 == 0 ? "a" : "") + ".png", {}, 0});
  for (ImageCorners& image : images) image.corners.assign(2, Corner{{1.0, 1.0}, 1.0});
  Observations o;
  o.devices.resize(1);
  assign_views(images, {"left*"}, o);
  ASSERT_EQ(o.frames.size(), 100u);
  EXPECT_EQ(o.frames[9], "9a");
  EXPECT_EQ(o.frames[10], "10");
}

/// Two minutes while every image was compared with every other.
TEST(CornersVnl, ManyImagesTakeTheirShareOfTimeOnly) {
  const ScratchFolder dir;
  std::string text;
  for (int i = 0; i < 200000; ++i) text += (i % 2 ? "left-" : "right-") + std::to_string(i / 2) + " 1 1\n";
  const std::clock_t begin = std::clock();  // of computing, whatever else the machine does
  const auto images = read_corners_vnl(dir.write("many.vnl", text));
  Observations o;
  o.board = {1, 1, 10.0};
  o.devices.resize(2);
  assign_views(images, {"left*", "right*"}, o);
  EXPECT_EQ(o.frames.size(), 100000u);
  EXPECT_EQ(o.views.size(), 200000u);
  EXPECT_LT((std::clock() - begin) / CLOCKS_PER_SEC, 20);
}

TEST(Npz, NumpyReadsIt) {
  std::string bytes;
  for (int i = 0; i < 10; ++i) bytes += static_cast<char>(i);
  EXPECT_EQ(base85(bytes), "009C61O)~M2nh");
  if (!fringetwin::testing::has_mrcal_python()) GTEST_SKIP() << "no Debian Python with numpy";
  NpzWriter npz;
  const std::vector<double> numbers{1.0 / 3.0, -2.5, 1e300, 0.0, 5.0, 6.0};
  npz.add("a", numbers, {2, 3});
  npz.add("one", std::vector<double>{7.0}, {1});
  npz.add("none", std::vector<double>{}, {0, 6});
  npz.add("i", std::vector<std::int32_t>{-1, 2}, {2});
  npz.add("yes", true);
  npz.add("d", 0.1);
  npz.add("s", std::string("LENSMODEL_OPENCV4"));
  npz.add("empty", std::string());
  const ScratchFolder dir;
  const auto file = dir.write("t.npz", npz.bytes());
  const auto script = dir.write("t.py", R"(
import numpy as np, sys
n = np.load(sys.argv[1], allow_pickle=False)
assert n['a'].shape == (2,3) and n['a'].dtype == float and n['a'][0,0] == 1./3. and n['a'][1,2] == 6
assert n['one'].shape == (1,) and n['none'].shape == (0,6)
assert n['i'].dtype == np.int32 and list(n['i']) == [-1,2]
assert n['yes'].item() is True and n['d'].item() == 0.1
assert n['s'].item() == 'LENSMODEL_OPENCV4' and n['empty'].item() == ''
print('good')
)");
  const auto run =
      fringetwin::testing::run("/usr/bin/python3 " + script.string() + " " + file.string() + " 2>&1");
  EXPECT_EQ(run.output, "good\n");
}

}  // namespace
}  // namespace fringetwin::calib::corners_vnl_test
