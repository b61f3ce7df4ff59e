// SPDX-License-Identifier: Apache-2.0
// Capture sets without a twin: the images come as they are stored, and what does not fit together is told.
//
// | check                | tolerance | origin                                      |
// |----------------------|-----------|---------------------------------------------|
// | gray and EXR values  | exact     | integers and float32 are stored as they are |
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::stored_images_test {
namespace {
using ::testing::AllOf;
using ::testing::HasSubstr;

/// Images of a size of its own, whose values tell their number.
CameraImages make_images(const std::string& camera, int width, int bit_depth) {
  CameraImages images{.camera = camera, .bit_depth = bit_depth};
  for (int number = 0; number < 3; ++number)
    images.images.emplace_back(width, 4, static_cast<float>(10 * number + (bit_depth > 8 ? 300 : 0)));
  images.white = ImageF(width, 4, 200.0f);
  return images;
}

class StoredImages : public ::testing::Test {
 protected:
  void SetUp() override {
    write_camera_images(set(), left_);
    write_camera_images(set(), right_);
    write_capture_toml(set(), {&left_, &right_}, {}, "png");
  }
  std::filesystem::path set() const { return folder_.path(); }
  /// What the set is refused for.
  std::string refusal() const {
    try {
      load_stored_images(read_capture_set(set()));
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::input);
      return error.what();
    }
    return "not refused";
  }

  ScratchFolder folder_;
  CameraImages left_ = make_images("left", 6, 8), right_ = make_images("right", 5, 12);
};

TEST_F(StoredImages, ComeAsTheyAreStored) {
  const auto cameras = load_stored_images(read_capture_set(set()));
  ASSERT_EQ(cameras.size(), 2U);
  for (const auto& [read, written, bits] : {std::tuple{&cameras[0], &left_, 8}, {&cameras[1], &right_, 16}}) {
    EXPECT_EQ(read->camera, written->camera);
    EXPECT_EQ(read->bit_depth, bits);
    ASSERT_EQ(read->images.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(read->images[i].data, written->images[i].data);
    EXPECT_EQ(read->white->data, written->white->data);
    EXPECT_FALSE(read->black);
  }
}

TEST_F(StoredImages, RadianceComesAsItIsStored) {
  left_.radiance = true;
  left_.images[1].data.back() = 0.125f;
  left_.white.reset();
  write_camera_radiance(set(), left_);
  write_capture_toml(set(), {&left_}, {}, "exr");
  const CameraImages read = load_stored_images(read_capture_set(set())).front();
  EXPECT_TRUE(read.radiance);
  ASSERT_EQ(read.images.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(read.images[i].data, left_.images[i].data);
}

TEST_F(StoredImages, ReferencesAmongThePatternsNumbersAreNoImagesOfTheSequence) {
  write_gray_png(set() / "left/0003.png", ImageF(6, 4, 9.0f), 8);
  write_capture_toml(
      set(), {CaptureEntry{.name = "left", .pattern = "left/%04d.png", .black = "left/0003.png"}}, {});
  const CameraImages read = load_stored_images(read_capture_set(set())).front();
  EXPECT_EQ(read.images.size(), 3U);
  EXPECT_EQ(read.black->data.front(), 9.0f);
}

TEST_F(StoredImages, WhatDoesNotFitTogetherIsTold) {
  write_gray_png(set() / "left/0001.png", ImageF(7, 4, 9.0f), 8);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("left/0001.png"), HasSubstr("7 x 4"), HasSubstr("6 x 4"),
                               HasSubstr("first image")));
  write_gray_png(set() / "left/0001.png", ImageF(6, 4, 9.0f), 16);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("left/0001.png"), HasSubstr("16 bit"), HasSubstr("8 bit")));
  write_exr(set() / "left/0001.exr", {{"Y", &left_.images[1]}});
  write_capture_toml(set(), {CaptureEntry{.name = "left", .files = {"left/0000.png", "left/0001.exr"}}}, {});
  EXPECT_THAT(refusal(), AllOf(HasSubstr("0001.exr"), HasSubstr("not both")));
  write_capture_toml(set(), {CaptureEntry{.name = "left", .pattern = "nowhere/%04d.png"}}, {});
  EXPECT_THAT(refusal(), AllOf(HasSubstr("nowhere/"), HasSubstr("has no image")));
}

}  // namespace
}  // namespace fringetwin::testing::stored_images_test
