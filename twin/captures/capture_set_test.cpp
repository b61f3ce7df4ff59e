// SPDX-License-Identifier: Apache-2.0
// Capture sets: what is written comes back, and every fault has its sentence.
//
// | check                  | tolerance | origin                                       |
// |------------------------|-----------|----------------------------------------------|
// | gray and EXR values    | exact     | integers and float32 are stored as they are  |
// | file and line of error | exact     | the line is counted in this file             |
#include "twin/captures/capture_set.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "tests/support/twin/expect_user_error.hpp"
#include "twin/base/errors.hpp"
#include "twin/captures/foreign_set.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::capture_set_test {
namespace {
namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kWidth = 20, kHeight = 10;

Camera make_camera(const std::string& name, int bit_depth = 8) {
  Camera camera{
      name, Lens("LENSMODEL_PINHOLE", {30, 30, 9.5, 4.5}, {kWidth, kHeight}, "test"), Pose{}, {}, {}};
  camera.sensor.bit_depth = bit_depth;
  return camera;
}
Fringes make_fringes(int steps) {
  Fringes fringes;
  fringes.unwrap = Unwrap::none;
  fringes.steps = steps;
  fringes.directions = {{Axis::x, {16.0}, {0.0}, std::nullopt}};
  return fringes;
}
ImageF random_image(unsigned seed, int max_value) {
  std::mt19937 generator(seed);
  ImageF image(kWidth, kHeight);
  for (float& v : image.data) v = static_cast<float>(generator() % static_cast<unsigned>(max_value + 1));
  return image;
}
CameraImages make_images(const std::string& camera, int count, int bit_depth = 8) {
  CameraImages images;
  images.camera = camera;
  images.bit_depth = bit_depth;
  for (int i = 0; i < count; ++i)
    images.images.push_back(random_image(static_cast<unsigned>(i), (1 << bit_depth) - 1));
  return images;
}

/// A camera whose image is one colour of a sensor of kWidth x kHeight.
Camera make_channel(const std::string& name, const std::string& mosaic, MosaicColour colour) {
  Camera camera = make_camera(name);
  camera.channel = MosaicChannel{mosaic, colour, {kWidth, kHeight}};
  camera.lens = image_lens(camera.lens, *camera.channel, "test");
  return camera;
}

class CaptureSetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / fmt::format("fringetwin_captures_{}_{}", info->name(), ::getpid());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// A valid set of 4 images of camera "left".
  void write_set(int count = 4, int bit_depth = 8) const {
    const CameraImages images = make_images("left", count, bit_depth);
    write_camera_images(folder_, images);
    write_capture_toml(folder_, {&images}, {{"device", "test"}}, "png");
  }
  void write_toml(const std::string& text) const {
    std::ofstream(folder_ / "capture.toml") << "schema = \"fringetwin-captures/1\"\n" << text;
  }
  CameraImages load(int steps = 4, int bit_depth = 8, const std::string& name = "left") const {
    const Fringes fringes = make_fringes(steps);
    const CaptureSet set = read_capture_set(folder_, steps);
    return load_camera_images(set, make_camera(name, bit_depth), fringes);
  }
  std::string load_error(int steps = 4, int bit_depth = 8, const std::string& name = "left") const {
    try {
      load(steps, bit_depth, name);
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::input);
      return e.what();
    }
    ADD_FAILURE() << "no UserError was thrown";
    return "";
  }
  fs::path folder_;
};

TEST_F(CaptureSetTest, WhatIsWrittenComesBack) {
  for (const int bit_depth : {8, 10, 12, 16}) {
    CameraImages left = make_images("left", 5, bit_depth), right = make_images("right", 5, bit_depth);
    left.white = random_image(50, 255);
    left.black = random_image(51, 3);
    left.gray_code_exposure = 2.5;
    right.gray_code_exposure = std::nan("");
    write_camera_images(folder_, left);
    write_camera_images(folder_, right);
    write_capture_toml(folder_, {&left, &right}, {{"seed", "7"}, {"a.b", "quote \" \\ \n"}}, "png");

    const CaptureSet set = read_capture_set(folder_, 5);
    EXPECT_EQ(set.provenance.at("seed"), "7");
    EXPECT_EQ(set.provenance.at("a.b"), "quote \" \\ \n");
    const CameraImages back = load_camera_images(set, make_camera("left", bit_depth), make_fringes(5));
    ASSERT_EQ(back.images.size(), 5u);
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(back.images[i].floats().data, left.images[i].floats().data);
    EXPECT_EQ(back.white->floats().data, left.white->floats().data);
    EXPECT_EQ(back.black->floats().data, left.black->floats().data);
    EXPECT_EQ(back.gray_code_exposure, 2.5);
    EXPECT_EQ(back.bit_depth, bit_depth);
    EXPECT_EQ(back.saturation_dn(), (1 << bit_depth) - 1);
    EXPECT_EQ(read_gray(folder_ / "left" / "0000.png").file_bits, bit_depth == 8 ? 8 : 16);
    EXPECT_TRUE(std::isnan(*set.find("right")->gray_code_exposure));
  }
}

TEST_F(CaptureSetTest, RadianceKeepsEveryBitAlsoFromASubFolder) {
  CameraImages images = make_images("left", 3);
  for (GrayImage& image : images.images)
    for (float& v : image.as_floats()) v = std::sqrt(v) * 0.1f;
  images.radiance = true;
  images.white = images.images[0];
  write_camera_radiance(folder_, images);
  write_capture_toml(folder_ / "radiance", {&images}, {}, "exr", "..");
  const CaptureSet set = read_capture_set(folder_ / "radiance", 3);
  const CameraImages back = load_camera_images(set, make_camera("left"), make_fringes(3));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(back.images[i].floats().data, images.images[i].floats().data);
  EXPECT_EQ(back.white->floats().data, images.white->floats().data);
  EXPECT_TRUE(back.radiance);
  EXPECT_TRUE(std::isinf(back.saturation_dn()));
  EXPECT_EQ(read_exr(folder_ / "left" / "0000.exr").front().first, "Y");
}

TEST_F(CaptureSetTest, AShorterSequenceOverALongerOneStaysReadable) {
  write_set(6);
  write_set(4);
  EXPECT_EQ(load(4).images.size(), 4u);
  EXPECT_FALSE(fs::exists(folder_ / "left" / "0004.png"));
}

TEST_F(CaptureSetTest, FilesRootWhiteAndBlackOfAForeignSet) {
  fs::create_directories(folder_ / "images");
  for (int i = 0; i < 5; ++i)
    write_gray_png(folder_ / "images" / fmt::format("g_{}.png", i),
                   random_image(static_cast<unsigned>(i), 255), 8);
  write_toml(
      "[[camera]]\nname = \"left\"\nroot = \"images\"\nfiles = [\"g_3.png\", \"g_0.png\", \"g_1.png\"]\n"
      "white = \"g_2.png\"\n[provenance]\nwhen = 2024-05-01T10:00:00Z\n[provenance.camera]\ngain = 2\non = "
      "true\n");
  const CameraImages images = load(3);
  EXPECT_EQ(images.images[0].floats().data, random_image(3, 255).data);
  EXPECT_EQ(images.images[2].floats().data, random_image(1, 255).data);
  EXPECT_EQ(images.white->floats().data, random_image(2, 255).data);
  const auto provenance = read_capture_set(folder_, 3).provenance;
  EXPECT_EQ(provenance.at("camera.gain"), "2");
  EXPECT_EQ(provenance.at("camera.on"), "true");
  EXPECT_EQ(provenance.at("when"), "2024-05-01T10:00:00Z");
  // a pattern over the same numbers: white and black are no images of the sequence
  write_toml(
      "[[camera]]\nname = \"left\"\npattern = \"images/g_%d.png\"\nwhite = \"images/g_3.png\"\nblack = "
      "\"images/g_4.png\"\n");
  EXPECT_EQ(load(3).images.size(), 3u);
}

TEST_F(CaptureSetTest, BmpTifAndPgmImagesAreImagesToo) {
  for (const std::string extension : {"bmp", "tif", "pgm"}) {
    for (int i = 0; i < 3; ++i)
      ASSERT_TRUE(cv::imwrite((folder_ / fmt::format("{}.{}", i, extension)).string(),
                              cv::Mat(kHeight, kWidth, CV_8U, cv::Scalar(10 * i))));
    write_toml("[[camera]]\nname = \"left\"\npattern = \"%01d." + extension + "\"\n");
    EXPECT_EQ(load(3).images[2](3, 3), 20.0f);
  }
}

TEST_F(CaptureSetTest, CapturesVariableInRoot) {
  write_set();
  ASSERT_EQ(::setenv("FRINGETWIN_CAPTURES", folder_.c_str(), 1), 0);
  write_toml("[[camera]]\nname = \"left\"\nroot = \"${FRINGETWIN_CAPTURES}/left\"\npattern = \"%04d.png\"\n");
  EXPECT_EQ(load().images.size(), 4u);
  ::unsetenv("FRINGETWIN_CAPTURES");
  write_toml("[[camera]]\nname = \"left\"\nroot = \"${HOME}/left\"\npattern = \"%04d.png\"\n");
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:4"), HasSubstr("unknown variable")));
}

TEST_F(CaptureSetTest, MissingFolderFileAndCamera) {
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml"), HasSubstr("no such file")));
  write_set();
  EXPECT_THAT(load_error(4, 8, "right"),
              AllOf(HasSubstr("no camera \"right\""), HasSubstr("it has \"left\"")));
  fs::remove_all(folder_);
  EXPECT_THAT(load_error(), HasSubstr("no such folder"));
}

TEST_F(CaptureSetTest, MissingImage) {
  write_set();
  fs::remove(folder_ / "left" / "0002.png");
  EXPECT_THAT(load_error(), AllOf(HasSubstr("0002.png: no such image"), HasSubstr("2 images without a gap"),
                                  HasSubstr("the sequence has 4")));
  write_toml("[[camera]]\nname = \"left\"\nfiles = [\"left/0000.png\", \"left/0001.png\", \"no.png\"]\n");
  EXPECT_THAT(load_error(3), AllOf(HasSubstr("no.png"), HasSubstr("no such image")));
}

TEST_F(CaptureSetTest, WrongCountsNameBoth) {
  write_set(5);
  EXPECT_THAT(load_error(4), AllOf(HasSubstr("left/%04d.png"), HasSubstr("has 5 images on disk"),
                                   HasSubstr("the sequence has 4")));
  EXPECT_THAT(load_error(6),
              AllOf(HasSubstr("0005.png"), HasSubstr("has 5 images"), HasSubstr("the sequence has 6")));
  write_toml(
      "[[camera]]\nname = \"left\"\nfiles = [\"left/0000.png\", \"left/0001.png\", \"left/0002.png\"]\n");
  EXPECT_THAT(load_error(4), AllOf(HasSubstr("lists 3 images"), HasSubstr("the sequence has 4")));
}

TEST_F(CaptureSetTest, TruncatedImage) {
  write_set();
  fs::resize_file(folder_ / "left" / "0001.png", fs::file_size(folder_ / "left" / "0001.png") / 2);
  EXPECT_THAT(load_error(), AllOf(HasSubstr("0001.png"), HasSubstr("is truncated")));
}

TEST_F(CaptureSetTest, OddSizeNamesBothSizes) {
  write_set();
  write_gray_png(folder_ / "left" / "0003.png", ImageF(kWidth + 1, kHeight), 8);
  EXPECT_THAT(load_error(),
              AllOf(HasSubstr("0003.png: is 21 x 10 px"), HasSubstr("camera \"left\" has 20 x 10")));
}

// Raw images of the whole sensor, and images that have only the channel's pixels already, gray and EXR.
TEST_F(CaptureSetTest, OneColourOfAMosaic) {
  const Camera blue = make_channel("left", "GRBG", MosaicColour::blue);  // columns 0, 2 ..., rows 1, 3 ...
  CameraImages raw = make_images("left", 4), own = raw;
  for (GrayImage& image : own.images) {
    ImageF part(kWidth / 2, kHeight / 2);
    for (int y = 0; y < part.height; ++y)
      for (int x = 0; x < part.width; ++x) part(x, y) = image(2 * x, 2 * y + 1);
    image = std::move(part);
  }
  for (const CameraImages* images : {&raw, &own}) {
    for (const bool radiance : {false, true}) {
      fs::remove_all(folder_ / "left");
      CameraImages stored = *images;
      stored.radiance = radiance;
      radiance ? write_camera_radiance(folder_, stored) : write_camera_images(folder_, stored);
      write_capture_toml(folder_, {&stored}, {}, radiance ? "exr" : "png");
      const CameraImages back = load_camera_images(read_capture_set(folder_, 4), blue, make_fringes(4));
      for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_EQ(back.images[k].width, kWidth / 2);
        EXPECT_EQ(back.images[k].floats().data, own.images[k].floats().data) << k << ' ' << radiance;
      }
    }
  }
  write_camera_images(folder_, raw);
  write_capture_toml(folder_, {&raw}, {}, "png");
  write_gray_png(folder_ / "left" / "0003.png", ImageF(kWidth, kHeight + 1), 8);
  testing::expect_user_error(
      ExitCode::input,
      "0003.png: is 20 x 11 px, channel \"blue\" of camera \"left\" has 10 x 5, its whole sensor 20 x 10",
      [&] { load_camera_images(read_capture_set(folder_, 4), blue, make_fringes(4)); });
}

// Red of a colour image is made up at the places of green pixels.
TEST_F(CaptureSetTest, AColourOfAColourImageIsNoMosaic) {
  write_set();
  std::ofstream(folder_ / "capture.toml")
      << "schema = \"fringetwin-captures/1\"\nchannel = \"red\"\n[[camera]]\nname = \"left\"\npattern = "
         "\"left/%04d.png\"\n";
  const Camera green = make_channel("left", "RGGB", MosaicColour::green);
  testing::expect_user_error(
      ExitCode::input,
      "is taken for the colour \"red\" of a colour image, camera \"left\" has the pixels of a raw mosaic",
      [&] { load_camera_images(read_capture_set(folder_, 4), green, make_fringes(4)); });
  EXPECT_EQ(load().images.size(), 4u);  // a gray file in a set of colour ones
}

TEST_F(CaptureSetTest, ColourImage) {
  write_set();
  ASSERT_TRUE(cv::imwrite((folder_ / "left" / "0001.png").string(),
                          cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar(5, 5, 5))));
  EXPECT_THAT(load_error(), AllOf(HasSubstr("0001.png"), HasSubstr("is a colour image (RGB)"),
                                  HasSubstr("channel = \"green\" in capture.toml")));
}

/// Puts the values of `image` into one colour, and others into the rest; a PNG, or what the name says.
void write_coloured(const fs::path& file, const ImageF& image, int bit_depth, ColourChannel channel) {
  std::vector<cv::Mat> planes;  // blue first
  for (int place = 2; place >= 0; --place) {
    cv::Mat plane(image.height, image.width, CV_32F);
    cv::randu(plane, 0, 1 << bit_depth);
    if (place == static_cast<int>(channel))
      plane = cv::Mat(image.height, image.width, CV_32F, const_cast<float*>(image.data.data())).clone();
    plane.convertTo(plane, bit_depth == 8 ? CV_8U : CV_16U);
    planes.push_back(plane);
  }
  cv::Mat merged;
  cv::merge(planes, merged);
  ASSERT_TRUE(cv::imwrite(file.string(), merged));
}

TEST_F(CaptureSetTest, OneColourOfColourImages) {
  for (const int bit_depth : {8, 12})
    for (const ColourChannel channel : {ColourChannel::red, ColourChannel::green, ColourChannel::blue}) {
      CameraImages images = make_images("left", 4, bit_depth);
      images.white = random_image(60, 255);
      write_camera_images(folder_, images);
      for (const int i : {0, 2})  // the others stay gray
        write_coloured(folder_ / fmt::format("left/000{}.png", i),
                       images.images[static_cast<std::size_t>(i)].floats(), bit_depth, channel);
      write_coloured(folder_ / "left/white.png", images.white->floats(), bit_depth, channel);
      write_toml(fmt::format("channel = \"{}\"\n", colour_channel_name(channel)) +
                 "[[camera]]\nname = \"left\"\npattern = \"left/%04d.png\"\nwhite = \"left/white.png\"\n");
      const CameraImages back = load(4, bit_depth);
      for (std::size_t i = 0; i < 4; ++i)
        EXPECT_EQ(back.images[i].floats().data, images.images[i].floats().data);
      EXPECT_EQ(back.white->floats().data, images.white->floats().data);
    }
}

TEST_F(CaptureSetTest, OtherColoursMayBeAboveTheSensorsRange) {
  write_set(4, 12);
  const ImageF bright(kWidth, kHeight, 5000.0F);
  const std::string camera = "[[camera]]\nname = \"left\"\npattern = \"left/%04d.png\"\n";
  write_coloured(folder_ / "left/0001.png", bright, 12, ColourChannel::green);
  write_toml("channel = \"red\"\n" + camera);
  EXPECT_EQ(load(4, 12).images.size(), 4u);
  write_toml("channel = \"green\"\n" + camera);
  EXPECT_THAT(load_error(4, 12), HasSubstr("0001.png: value 5000 at pixel (0, 0) is above the 4095"));
}

TEST_F(CaptureSetTest, ChannelsThatAreNone) {
  const std::string camera = "[[camera]]\nname = \"left\"\npattern = \"left/%04d.png\"\n";
  write_toml("channel = \"gren\"\n" + camera);
  EXPECT_THAT(load_error(),
              AllOf(HasSubstr("capture.toml:2"), HasSubstr("channel"), HasSubstr("did you mean \"green\"?")));
  write_toml("channel = 1\n" + camera);
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:2"), HasSubstr("channel")));
  write_toml(camera + "channel = \"green\"\n");
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:5"), HasSubstr("unknown key \"channel\"")));
}

TEST_F(CaptureSetTest, AForeignSetKeepsItsChannel) {
  CaptureSet set;
  set.file = folder_ / "set" / "capture.toml";
  set.cameras.emplace_back().name = "left";
  set.cameras[0].files = {folder_ / "0.png"};
  write_coloured(folder_ / "0.png", random_image(1, 255), 8, ColourChannel::blue);
  fs::create_directories(folder_ / "set");
  for (const std::optional<ColourChannel> channel : {std::optional(ColourChannel::blue), {}}) {
    set.channel = channel;
    write_foreign_set(set);
    EXPECT_EQ(read_capture_set(folder_ / "set", 1).channel, channel);
  }
}

TEST_F(CaptureSetTest, ValueAboveTheSensorsRange) {
  write_set(4, 12);
  ImageF image(kWidth, kHeight);
  image(7, 3) = 4096.0f;
  write_gray_png(folder_ / "left" / "0002.png", image, 16);
  EXPECT_THAT(load_error(4, 12), AllOf(HasSubstr("0002.png: value 4096 at pixel (7, 3)"),
                                       HasSubstr("above the 4095"), HasSubstr("12 bit")));
  EXPECT_EQ(load(4, 16).images.size(), 4u);
}

TEST_F(CaptureSetTest, EightBitImagesOfADeeperSensor) {
  write_set(4, 8);
  EXPECT_THAT(load_error(4, 12), AllOf(HasSubstr("holds 8 bit values"), HasSubstr("bit_depth = 12")));
}

TEST_F(CaptureSetTest, ExrAndGrayImagesDoNotMix) {
  write_set();
  write_toml("[[camera]]\nname = \"left\"\nfiles = [\"left/0000.png\", \"left/0001.png\", \"a.exr\"]\n");
  const ImageF image(kWidth, kHeight);
  write_exr(folder_ / "a.exr", {{"Y", &image}});
  EXPECT_THAT(load_error(3), AllOf(HasSubstr("a.exr"), HasSubstr("not both")));
  write_toml("[[camera]]\nname = \"left\"\nfiles = [\"a.exr\", \"a.exr\", \"b.exr\"]\n");
  write_exr(folder_ / "b.exr", {{"R", &image}, {"G", &image}});
  EXPECT_THAT(load_error(3), AllOf(HasSubstr("b.exr"), HasSubstr("has 2 channels")));
  const ImageF odd(3, 3);
  write_exr(folder_ / "b.exr", {{"Y", &odd}});
  EXPECT_THAT(load_error(3), AllOf(HasSubstr("b.exr"), HasSubstr("is 3 x 3 px")));
}

TEST_F(CaptureSetTest, LightThatIsNoneIsRefused) {
  CameraImages images = make_images("left", 4);
  images.radiance = true;
  for (const float value : {std::nanf(""), -INFINITY, 1e30F}) {
    images.images[2].writable(3, 1) = value;
    write_camera_radiance(folder_, images);
    write_capture_toml(folder_, {&images}, {}, "exr");
    EXPECT_THAT(load_error(),
                AllOf(HasSubstr("0002.exr: value "), HasSubstr("at pixel (3, 1) is no irradiance")));
  }
}

TEST_F(CaptureSetTest, ImagesOfSeveralSizes) {
  write_set();
  write_gray_png(folder_ / "left" / "0001.png", ImageF(kHeight, kWidth), 8);
  write_gray_png(folder_ / "left" / "0003.png", ImageF(1, 1), 8);
  EXPECT_THAT(load_error(), HasSubstr("0001.png: is 10 x 20 px, camera \"left\" has 20 x 10; width and "
                                      "height are swapped; check imagersize"));
}

TEST_F(CaptureSetTest, WhiteImageAmongTheSequence) {
  write_set();
  write_toml("[[camera]]\nname = \"left\"\npattern = \"left/%04d.png\"\nwhite = \"left/0002.png\"\n");
  EXPECT_THAT(load_error(), HasSubstr("camera \"left\" has its white or black image among the 4"));
}

TEST_F(CaptureSetTest, WhiteBlackThresholdNeedsItsImages) {
  write_set(4);
  Fringes fringes = make_fringes(4);
  fringes.unwrap = Unwrap::gray;
  fringes.steps = 0;
  GrayCode gray;
  gray.bits = 4;
  gray.threshold = GrayCode::Threshold::white_black;
  fringes.directions[0].gray = gray;
  try {
    load_camera_images(read_capture_set(folder_, 4), make_camera("left"), fringes);
    FAIL();
  } catch (const UserError& e) {
    EXPECT_THAT(e.what(), HasSubstr("needs white and black images"));
  }
}

TEST_F(CaptureSetTest, FaultsOfTheFileNameFileLineAndKey) {
  const std::string camera = "[[camera]]\nname = \"left\"\npattern = \"left/%04d.png\"\n";  // lines 2-4
  write_toml(camera + "patern = 1\n");
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:5"), HasSubstr("unknown key \"patern\""),
                                  HasSubstr("did you mean \"pattern\"?")));
  write_toml(camera + "files = [\"a.png\"]\n");
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:5"), HasSubstr("exclude each other")));
  write_toml("[[camera]]\nname = \"left\"\n");
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:2"), HasSubstr("needs pattern or files")));
  for (const std::string pattern :
       {"left.png", "%04d/%04d.png", "%4d.png", "%s.png", "%04", "left/%04d/../0000.png"}) {
    write_toml("[[camera]]\nname = \"left\"\npattern = \"" + pattern + "\"\n");
    EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:4"), HasSubstr("one number such as %04d")));
  }
  write_toml(camera + "gray_code_exposure = \"diferent\"\n");
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:5"), HasSubstr("camera[0].gray_code_exposure"),
                                  HasSubstr("did you mean \"different\"?")));
  write_toml(camera + "gray_code_exposure = 0\n");
  EXPECT_THAT(load_error(), HasSubstr("must be > 0, is 0"));
  write_toml(camera + camera);
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:6"), HasSubstr("name of an earlier camera")));
  write_toml("");
  EXPECT_THAT(load_error(), HasSubstr("needs a [[camera]]"));
  write_toml(camera + "name = \"again\"\n");
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:5"), HasSubstr("no valid TOML")));
  std::ofstream(folder_ / "capture.toml") << "schema = \"fringetwin-captures/2\"\n";
  EXPECT_THAT(load_error(),
              AllOf(HasSubstr("capture.toml:1"), HasSubstr("must be \"fringetwin-captures/1\"")));
}

TEST_F(CaptureSetTest, ListsLongerThanAnySequence) {
  std::string files, cameras;
  for (int i = 0; i < 10'001; ++i) files += "\"a.png\", ";
  write_toml("[[camera]]\nname = \"left\"\nfiles = [" + files + "]\n");
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:4"), HasSubstr("lists 10001 images")));
  for (int i = 0; i < 17; ++i)
    cameras += fmt::format("[[camera]]\nname = \"c{}\"\npattern = \"%d.png\"\n", i);
  write_toml(cameras);
  EXPECT_THAT(load_error(), HasSubstr("camera is given 17 times, at most 16 are read"));
}

TEST_F(CaptureSetTest, APathThatEndsAtANul) {
  write_toml("[[camera]]\nname = \"left\"\nroot = \"\\u0000\"\npattern = \"%d.png\"\n");
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml:4"), HasSubstr("holds a NUL character")));
}

TEST_F(CaptureSetTest, APipeInsteadOfAFileIsRefusedWithoutWaiting) {
  ASSERT_EQ(::mkfifo((folder_ / "capture.toml").c_str(), 0600), 0);
  EXPECT_THAT(load_error(), AllOf(HasSubstr("capture.toml"), HasSubstr("is a pipe or a device")));
}

TEST_F(CaptureSetTest, NamesThatTomlCannotHold) {
  CaptureSet set;
  set.file = folder_ / "set" / "capture.toml";
  set.cameras.emplace_back().name = "left";
  set.cameras[0].files = {folder_ / "b\xff" / "0.png", folder_ / "b\xff" / "1.png"};
  for (const fs::path& file : set.cameras[0].files) write_gray_png(file, ImageF(kWidth, kHeight), 8);
  fs::create_directories(folder_ / "set");
  try {
    write_foreign_set(set);
    FAIL();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input);
    EXPECT_THAT(e.what(), HasSubstr("is no UTF-8, so capture.toml cannot name it"));
  }
  EXPECT_FALSE(fs::exists(set.file));
}

TEST_F(CaptureSetTest, UnitExposureIsTheSame) {
  write_set();
  write_toml("[[camera]]\nname = \"left\"\npattern = \"left/%04d.png\"\ngray_code_exposure = 1\n");
  EXPECT_FALSE(load().gray_code_exposure);
}

}  // namespace
}  // namespace fringetwin::capture_set_test
