// SPDX-License-Identifier: Apache-2.0
// Capture sets without a twin: the images come as they are stored, and what does not fit together is told.
//
// | check                | tolerance | origin                                      |
// |----------------------|-----------|---------------------------------------------|
// | gray and EXR values  | exact     | integers and float32 are stored as they are |
#include "twin/captures/stored_images.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <tuple>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::stored_images_test {
namespace {
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kHeight = 4;

/// Every value tells its pixel, image and camera.
ImageF image_of(int width, int number, float more = 0.0f) {
  ImageF image(width, kHeight);
  for (std::size_t i = 0; i < image.size(); ++i)
    image.data[i] = static_cast<float>(i) + 40.0f * static_cast<float>(number) + more;
  return image;
}

CameraImages make_images(const std::string& camera, int width, int count, int bit_depth) {
  CameraImages images{.camera = camera, .bit_depth = bit_depth};
  for (int number = 0; number < count; ++number)
    images.images.push_back(image_of(width, number, bit_depth > 8 ? 3000.0f : 0.0f));
  images.white = image_of(width, 5);
  return images;
}

class StoredImagesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    write_camera_images(set(), right_);
    write_camera_images(set(), left_);
    write_capture_toml(set(), {&right_, &left_}, {}, "png");
  }
  std::filesystem::path set() const { return folder_.path(); }
  std::vector<StoredImages> load() const { return load_stored_images(read_capture_set(set())); }
  void write_toml(const CaptureEntry& entry, const std::optional<ColourChannel>& channel = {}) const {
    write_capture_toml(set(), {entry}, {}, channel);
  }
  /// What the set is refused for.
  std::string refusal() const {
    try {
      load();
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::input);
      return error.what();
    }
    return "not refused";
  }

  ScratchFolder folder_;
  CameraImages left_ = make_images("left", 6, 3, 8), right_ = make_images("right", 5, 4, 12);
};

TEST_F(StoredImagesTest, ComeAsTheyAreStored) {
  const auto cameras = load();
  ASSERT_EQ(cameras.size(), 2U);
  for (const auto& [read, written, bits] : {std::tuple{&cameras[0], &right_, 16}, {&cameras[1], &left_, 8}}) {
    EXPECT_EQ(read->camera, written->camera);
    EXPECT_EQ(read->file_bits, bits);
    EXPECT_FALSE(read->radiance);
    ASSERT_EQ(read->images.size(), written->images.size());
    for (std::size_t i = 0; i < read->images.size(); ++i) {
      EXPECT_EQ(read->images[i].width, written->images[i].width);
      EXPECT_EQ(read->images[i].floats().data, written->images[i].floats().data);
    }
    EXPECT_EQ(read->white->floats().data, written->white->floats().data);
    EXPECT_FALSE(read->black);
  }
}

TEST_F(StoredImagesTest, RadianceComesAsItIsStored) {
  left_.radiance = true;
  left_.images[1].as_floats().back() = 0.125f;
  left_.white.reset();
  write_camera_radiance(set(), left_);
  write_capture_toml(set(), {&left_}, {}, "exr");
  const StoredImages read = load().front();
  EXPECT_TRUE(read.radiance);
  EXPECT_EQ(read.file_bits, 32);
  ASSERT_EQ(read.images.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(read.images[i].floats().data, left_.images[i].floats().data);
  EXPECT_EQ(read.images[1].floats().data.back(), 0.125f);
}

TEST_F(StoredImagesTest, TheColourOfASetIsTaken) {
  cv::Mat colours(kHeight, 6, CV_8UC3);
  for (int i = 0; i < 6 * kHeight; ++i)
    colours.at<cv::Vec3b>(i / 6, i % 6) = {static_cast<uchar>(i), static_cast<uchar>(100 + i), 0};
  cv::imwrite(set() / "left/colour.png", colours);
  const CaptureEntry entry{.name = "left", .files = {"left/colour.png"}};
  write_toml(entry, ColourChannel::green);
  EXPECT_EQ(load().front().images.front()(2, 1), 108.0f);
  write_toml(entry);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("left/colour.png"), HasSubstr("channel")));
}

TEST_F(StoredImagesTest, APatternHasTheImagesOnDisk) {
  write_gray_png(set() / "left/0003.png", ImageF(6, kHeight, 9.0f), 8);
  write_toml({.name = "left", .pattern = "left/%04d.png", .black = "left/0003.png"});
  const StoredImages read = load().front();
  EXPECT_EQ(read.images.size(), 3U);  // the black one is none of the sequence
  EXPECT_EQ(read.black->floats().data.front(), 9.0f);
  std::filesystem::remove(set() / "left/0001.png");
  EXPECT_EQ(load().front().images.size(), 1U);  // without a gap
  std::filesystem::remove(set() / "left/0000.png");
  EXPECT_THAT(refusal(),
              AllOf(HasSubstr("left/%04d.png"), HasSubstr("has no image"), HasSubstr("counts from 0")));
  for (int number = 0; number < 10'001; ++number)
    std::ofstream(set() / fmt::format("left/{:04}.png", number)) << "no image";
  write_toml({.name = "left", .pattern = "left/%04d.png"});
  EXPECT_THAT(refusal(), AllOf(HasSubstr("pattern"), HasSubstr("more than 10000 images")));
}

TEST_F(StoredImagesTest, FilesOfEightAndSixteenBitsAreOfSixteen) {
  write_gray_png(set() / "left/0001.png", image_of(6, 70), 16);
  const StoredImages left = load().at(1);
  EXPECT_EQ(left.file_bits, 16);
  EXPECT_EQ(left.images[1].floats().data.front(), 2800.0f);
}

TEST_F(StoredImagesTest, WhatDoesNotFitTogetherIsTold) {
  write_gray_png(set() / "left/0001.png", ImageF(7, kHeight, 9.0f), 8);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("left/0001.png"), HasSubstr("7 x 4"), HasSubstr("6 x 4"),
                               HasSubstr("first image")));
  write_gray_png(set() / "left/0001.png", left_.images[1].floats(), 8);
  write_gray_png(set() / "left/white.png", ImageF(kHeight, 6, 9.0f), 8);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("left/white.png"), HasSubstr("4 x 6"), HasSubstr("6 x 4")));
  const ImageF second = left_.images[1].floats();
  write_exr(set() / "left/0001.exr", {{"Y", &second}});
  write_toml({.name = "left", .files = {"left/0000.png", "left/0001.exr"}});
  EXPECT_THAT(refusal(), AllOf(HasSubstr("0001.exr"), HasSubstr("not both")));
  std::ofstream(set() / "capture.toml")
      << "schema = \"fringetwin-captures/1\"\n[[camera]]\nname = \"left\"\nfiles = []\n";
  EXPECT_THAT(refusal(),
              AllOf(HasSubstr("capture.toml"), HasSubstr("has no image"), Not(HasSubstr("pattern"))));
}

}  // namespace
}  // namespace fringetwin::testing::stored_images_test
