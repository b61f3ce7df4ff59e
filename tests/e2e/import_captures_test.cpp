// SPDX-License-Identifier: Apache-2.0
// import captures: the same images under foreign names give the same result to the last bit; every mistake
// has its sentence.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "tests/support/twin/png_bytes.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::import_captures_test {
namespace {
namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int kImages = 12;  // 3 pitches of 4 steps

/// Two cameras, triangulated against each other.
std::string stereo_twin() {
  return small_twin({{"[projector]",
                      "[[camera]]\nname = \"right\"\nlensmodel = \"LENSMODEL_PINHOLE\"\nimagersize = "
                      "[160, 120]\nintrinsics = [260, 260, 79.5, 59.5]\nrt_cam_world = [0, -0.2, 0, 55, "
                      "0, 6]\n[camera.sensor]\ngain_dn = 20\n[projector]"},
                     {"triangulate = \"projector\"", "triangulate = \"stereo\""}});
}

class ImportCaptures : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (have_device()) rendered_ = render_twin(stereo_twin(), suite_dir());
  }
  void SetUp() override {
    FT_NEED_DEVICE();
    ASSERT_EQ(rendered_.exit_code, 0) << rendered_.err;
    dir_ = scratch_folder("import_captures");
  }
  static fs::path suite_dir() {
    static const fs::path dir = scratch_folder("import_captures_rendered");
    return dir;
  }
  static std::string twin() { return (suite_dir() / "twin.toml").string(); }
  static fs::path rendered(const std::string& camera, int number) {
    const std::string digits = std::to_string(number);
    return suite_dir() / "out" / camera / (std::string(4 - digits.size(), '0') + digits + ".png");
  }
  /// Image `number` of the sequence under another name.
  void copy(const std::string& camera, int number, const std::string& name) const {
    fs::create_directories((dir_ / name).parent_path());
    fs::copy_file(rendered(camera, number), dir_ / name, fs::copy_options::overwrite_existing);
  }
  void copy_all(const std::string& left = "raw/img", const std::string& right = "raw/other ") const {
    for (int i = 0; i < kImages; ++i) {
      copy("left", i, left + std::to_string(i + 1) + ".png");  // img2.png, img10.png
      copy("right", i, right + std::to_string(i) + ".png");
    }
  }
  RunResult import(std::vector<std::string> more, const std::string& out = "set") const {
    std::vector<std::string> args = {"import", "captures", twin(), "--out", (dir_ / out).string()};
    args.insert(args.end(), more.begin(), more.end());
    return run_fringetwin(args);
  }
  std::string path(const std::string& name) const { return (dir_ / name).string(); }
  std::string globs(const std::string& camera) const {
    return camera + "=" + path(camera == "left" ? "raw/img*.png" : "raw/other *.png");
  }
  /// points.ply and the phases of both cameras, as bytes.
  std::vector<std::string> measured(const fs::path& captures, const std::string& name) const {
    const fs::path out = dir_ / name;
    const RunResult run =
        run_fringetwin({"measure", twin(), "--captures", captures.string(), "--out", out.string()});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return {read_file(out / "points.ply"), read_file(out / "phase_left.exr"),
            read_file(out / "phase_right.exr")};
  }

  static RunResult rendered_;
  fs::path dir_;
};
RunResult ImportCaptures::rendered_;

TEST_F(ImportCaptures, ForeignNamesGiveTheSameResult) {
  copy_all();
  const RunResult run = import({"--map", globs("left"), "--map", globs("right")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("left\t9\tx pitch 15 step 2/4\t" + path("raw/img10.png") + "\n"));
  const std::string toml = read_file(dir_ / "set/capture.toml");
  EXPECT_THAT(toml, HasSubstr("root = \"../raw\""));
  EXPECT_THAT(toml, HasSubstr("\"sha256.../raw/img10.png\" = \""));
  EXPECT_FALSE(fs::exists(dir_ / "set/left"));  // described, not copied
  const RunResult verified = run_fringetwin({"capture", twin(), "--verify", (dir_ / "set").string()});
  EXPECT_EQ(verified.exit_code, 0) << verified.err;
  EXPECT_EQ(verified.out, "24 images of 2 cameras, 24 checksums compared: complete\n");
  const auto original = measured(suite_dir() / "out", "measured_original");
  EXPECT_GT(original[0].size(), 10000u);
  EXPECT_TRUE(measured(dir_ / "set", "measured_imported") == original);
}

/// Writes an RGB image with the values of a gray one in one colour, and noise in the others.
void colour_in(const fs::path& gray_file, ColourChannel channel, const fs::path& to) {
  static std::mt19937 generator(24);
  const ImageF gray = read_gray(gray_file).image;
  std::string rows;
  for (const float value : gray.data)
    for (int place = 0; place < 3; ++place)
      rows +=
          static_cast<char>(place == static_cast<int>(channel) ? static_cast<unsigned>(value) : generator());
  write_file(to, png_bytes({gray.width, gray.height, 8, 2}, rows));
}

TEST_F(ImportCaptures, OneColourGivesTheResultOfGrayImages) {
  const auto original = measured(suite_dir() / "out", "measured_original");
  for (const ColourChannel colour : {ColourChannel::red, ColourChannel::green, ColourChannel::blue}) {
    const std::string& channel = colour_channel_name(colour);
    for (int i = 0; i < kImages; ++i) {
      colour_in(rendered("left", i), colour, dir_ / "raw" / ("img" + std::to_string(i) + ".png"));
      colour_in(rendered("right", i), colour, dir_ / "raw" / ("other " + std::to_string(i) + ".png"));
    }
    const RunResult run = import(
        {"--map", globs("left"), "--map", globs("right"), "--channel", channel, "--overwrite"}, channel);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(read_file(dir_ / channel / "capture.toml"), HasSubstr("\nchannel = \"" + channel + "\"\n"));
    const RunResult verified = run_fringetwin({"capture", twin(), "--verify", (dir_ / channel).string()});
    EXPECT_EQ(verified.exit_code, 0) << verified.err;
    EXPECT_TRUE(measured(dir_ / channel, "measured_" + channel) == original) << channel;
  }
  expect_refused(import({"--map", globs("left"), "--map", globs("right")}), 3,
                 {"is a colour image (RGB)", "channel = \"green\" in capture.toml", "--channel green"});
  expect_refused(import({"--map", globs("left"), "--map", globs("right"), "--channel", "cyan"}), 2,
                 {"--channel"});
}

TEST_F(ImportCaptures, NumbersAndOrder) {
  // the steps of each pitch backwards, numbered from 5; an image of white light between them
  std::string order;
  for (int i = 0; i < kImages; ++i) {
    const int number = 5 + (kImages - 1 - i) + (i < 6 ? 1 : 0);
    copy("left", i, "L/shot_" + std::string(number < 10 ? "0" : "") + std::to_string(number) + ".png");
    copy("right", i, "R/" + std::to_string(100 + i) + ".png");
  }
  copy("left", 0, "L/shot_11.png");
  const RunResult run =
      import({"--map", "left=" + path("L/shot_%02d.png"), "--order", "left=17-12,10-5", "--map",
              "right=" + path("R/%d.png@100"), "--white", "left=" + path("L/shot_11.png")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(measured(dir_ / "set", "measured_imported") ==
              measured(suite_dir() / "out", "measured_original"));
  // the same by places in the glob: shot_05 is 0
  ASSERT_EQ(import({"--map", "left=" + path("L/*.png"), "--order", "left=12-7,5-0", "--map",
                    "right=" + path("R/%d.png@100")},
                   "set2")
                .exit_code,
            0);
  EXPECT_TRUE(measured(dir_ / "set2", "measured_by_place") == measured(dir_ / "set", "measured_by_number"));
}

// A glob finds the white and the black image, too; named as that they are none of the sequence. A link to
// their folder names the same files.
TEST_F(ImportCaptures, ReferencesInTheSequencesFolderAreLeftOut) {
  copy_all("set/img", "set/other ");
  copy("left", 0, "set/img_white.png");
  copy("left", 1, "set/img_black.png");
  fs::create_directory_symlink(dir_ / "set", dir_ / "link");
  const std::string left = "left=" + path("set/img*.png"), right = "right=" + path("set/other *.png");
  ASSERT_EQ(import({"--map", left, "--map", right, "--white", "left=" + path("link/img_white.png"), "--black",
                    "left=" + path("set/img_black.png")})
                .exit_code,
            0);
  EXPECT_TRUE(measured(dir_ / "set", "measured_with_references") ==
              measured(suite_dir() / "out", "measured_original"));
  expect_refused(import({"--map", left, "--map", right, "--overwrite"}), 3, {"the sequence has"});
}

TEST_F(ImportCaptures, DescribedInPlaceAndThroughALink) {
  copy_all("set/img", "set/other ");
  const std::string left = "left=" + path("set/img*.png"), right = "right=" + path("set/other *.png");
  ASSERT_EQ(import({"--map", left, "--map", right}).exit_code, 0);
  EXPECT_THAT(read_file(dir_ / "set/capture.toml"), HasSubstr("root = \".\""));
  fs::create_directories(dir_ / "deep/er");
  fs::create_directory_symlink(dir_ / "deep/er", dir_ / "link");
  ASSERT_EQ(import({"--map", left, "--map", right}, "link").exit_code, 0);
  EXPECT_TRUE(measured(dir_ / "link", "measured_link") == measured(dir_ / "set", "measured_in_place"));
}

TEST_F(ImportCaptures, WhatIsThereStays) {
  copy_all();
  const std::vector<std::string> maps = {"--map", globs("left"), "--map", globs("right")};
  write_file(dir_ / "set/capture.toml", "mine");
  expect_refused(import(maps), 2, {"capture.toml: is there already", "--overwrite"});
  EXPECT_EQ(read_file(dir_ / "set/capture.toml"), "mine");
  auto overwriting = maps;
  overwriting.push_back("--overwrite");
  // a fault found on the way leaves the old one
  fs::resize_file(dir_ / "raw/img7.png", 200);
  expect_refused(import(overwriting), 3, {path("raw/img7.png"), "truncated"});
  EXPECT_EQ(read_file(dir_ / "set/capture.toml"), "mine");
  copy("left", 6, "raw/img7.png");
  EXPECT_EQ(import(overwriting).exit_code, 0);
  EXPECT_NE(read_file(dir_ / "set/capture.toml"), "mine");
  write_file(dir_ / "set/capture.journal", "x");
  expect_refused(import(overwriting), 2, {"holds an unfinished recording"});
}

TEST_F(ImportCaptures, WrongMapsAreRefused) {
  copy_all();
  const std::string left = globs("left"), right = globs("right");
  const auto refused = [&](const std::vector<std::string>& args, int code,
                           const std::vector<std::string>& parts) {
    expect_refused(import(args), code, parts);
    EXPECT_FALSE(fs::exists(dir_ / "set")) << args.back();
  };
  refused({"--map", left}, 2, {"camera \"right\" has no images", "--map 'right="});
  refused({"--map", left, "--map", left}, 2, {"camera \"left\" has images already"});
  refused({"--map", "up=" + path("raw/*.png")}, 2, {"names no camera of the twin", "left="});
  refused({"--map", left, "--map", "right=" + path("raw/no*.png")}, 3, {"matches no image"});
  refused({"--map", left, "--map", "right=" + path("raw/img*.png")}, 3, {"is an image of both camera"});
  refused(
      {"--map", "left=" + path("raw/img?.png"), "--map", right}, 3,
      {"gives 9 images, the sequence has 12", "0-3: x pitch 13 in 4 steps", "8-11: x pitch 15 in 4 steps"});
  refused({"--map", "left=" + path("raw/img%d.png@2"), "--map", right}, 3,
          {"gives 11 images, the sequence has 12"});
  refused({"--map", "left=" + path("raw/img%d.png"), "--map", right}, 3, {"img0.png: no such image", "@1"});
  refused({"--map", "left=" + path("raw/img%4d.png"), "--map", right}, 2, {"one number such as %02d"});
  refused({"--map", "left=" + path("raw/img%d.png@x"), "--map", right}, 2, {"behind @"});
  refused({"--map", left, "--map", right, "--order", "0-11a"}, 2, {"--order 0-11a: is no list of numbers"});
  refused({"--map", left, "--map", right, "--order", "0-10,12"}, 2,
          {"names image 12", "matches 12 (0 to 11)"});
  refused({"--map", left, "--map", right, "--order", "right=0-10"}, 3,
          {"gives 11 images, the sequence has 12"});
  refused({"--map", "left=" + path("raw/img%d.png@1"), "--map", right, "--order", "0-11"}, 2,
          {"exclude each other"});
  refused({"--map", left, "--map", right, "--white", "left=" + path("raw/none.png")}, 3,
          {"none.png: no such image"});
  refused({"--map", left, "--map", right, "--gray-code-exposure", "0"}, 2, {"--gray-code-exposure 0"});
}

TEST_F(ImportCaptures, WrongImagesAreRefused) {
  copy_all();
  const std::vector<std::string> maps = {"--map", globs("left"), "--map", globs("right")};
  const std::string colour = "P6\n160 120\n255\n" + std::string(160 * 120 * 3, 'a');
  write_file(dir_ / "raw/img3.png", colour);
  expect_refused(import(maps), 3, {path("raw/img3.png"), "is a colour image"});
  write_file(dir_ / "raw/img3.png", "P5\n160 119\n255\n" + std::string(160 * 119, 'a'));
  expect_refused(import(maps), 3, {path("raw/img3.png"), "is 160 x 119 px", "has 160 x 120"});
  write_file(dir_ / "raw/img3.png", "P5\n160 120\n65535\n" + std::string(160 * 120 * 2, 'a'));
  expect_refused(import(maps), 3, {path("raw/img3.png"), "is above the 255 of a 8 bit sensor"});
  write_file(dir_ / "raw/img3.png", "no image");
  expect_refused(import(maps), 3, {path("raw/img3.png"), "is no image that can be decoded"});
  EXPECT_FALSE(fs::exists(dir_ / "set"));
}

}  // namespace
}  // namespace fringetwin::testing::import_captures_test
