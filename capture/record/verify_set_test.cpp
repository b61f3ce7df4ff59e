// SPDX-License-Identifier: Apache-2.0
// A good set, broken in every way, one at a time: each is found, and says what to do.
#include "capture/record/verify_set.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/seal.hpp"
#include "twin/base/sha256.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/captures/foreign_set.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::verify_set_test {
namespace {
namespace fs = std::filesystem;
using capture::SetCheck;
using capture::verify_set;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::ScratchFolder;

constexpr int kWidth = 24, kHeight = 10, kSteps = 4;

ImageF random_image(std::mt19937* generator, int width = kWidth) {
  ImageF image(width, kHeight);
  for (float& v : image.data) v = static_cast<float>((*generator)() % 4096);
  return image;
}

Twin make_twin(int steps = kSteps, int bit_depth = 12, int width = kWidth) {
  Twin twin;
  for (const char* name : {"left", "right"}) {
    Camera camera{
        name, Lens("LENSMODEL_PINHOLE", {30, 30, 9.5, 4.5}, {width, kHeight}, "test"), Pose{}, {}, {}};
    camera.sensor.bit_depth = bit_depth;
    twin.cameras.push_back(camera);
  }
  twin.fringes.unwrap = Unwrap::none;
  twin.fringes.steps = steps;
  twin.fringes.directions = {{Axis::x, {16.0}, {0.0}, std::nullopt}};
  return twin;
}

/// Writes a set as a recording leaves it: two cameras, white and black, the list of frames.
void record(const fs::path& dir, const std::string& sets = "", unsigned seed = 1, bool checksums = true) {
  std::mt19937 generator(seed);
  std::vector<CameraImages> cameras(2);
  std::map<std::string, std::string> provenance{{"device", "test"}, {"version", "1"}};
  if (!sets.empty()) provenance["sets"] = sets;
  for (std::size_t c = 0; c < 2; ++c) {
    cameras[c].camera = c == 0 ? "left" : "right";
    cameras[c].bit_depth = 12;
    for (int i = 0; i < kSteps; ++i) cameras[c].images.push_back(random_image(&generator));
    cameras[c].white = random_image(&generator);
    cameras[c].black = random_image(&generator);
    write_camera_images(dir, cameras[c]);
  }
  std::ofstream(dir / "frames.csv") << "camera,sequence,timestamp_ns\nleft,0,1000\nleft,1,17666\n";
  if (checksums)
    for (const auto& entry : fs::recursive_directory_iterator(dir))
      if (entry.is_regular_file()) {
        const std::string name = entry.path().lexically_relative(dir).string();
        if (entry.path().filename() != "capture.toml" && name.find("repeat_") == std::string::npos)
          provenance["sha256." + name] = sha256_of_file(entry.path());
      }
  write_capture_toml(dir, {&cameras[0], &cameras[1]}, provenance, "png");
}

std::string bytes_of(const fs::path& file) { return testing::read_file(file); }
void write_bytes(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

class VerifySetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    record(dir_);
    image_bytes_ = bytes_of(dir_ / "left/0002.png");
  }
  /// The only finding, and that verification failed for it.
  std::string finding(const Twin* twin = nullptr) const {
    const SetCheck check = verify_set(dir_, twin);
    EXPECT_FALSE(check.passed());
    EXPECT_EQ(check.findings.size(), 1u) << ::testing::PrintToString(check.findings);
    return check.findings.empty() ? "" : check.findings[0];
  }
  std::string name(const std::string& file) const { return (dir_ / file).string(); }

  ScratchFolder folder_;
  const fs::path dir_ = folder_ / "set";
  std::string image_bytes_;  ///< of a good one
};

TEST_F(VerifySetTest, AWholeSetPasses) {
  const Twin twin = make_twin();
  for (const Twin* with : {static_cast<const Twin*>(nullptr), &twin}) {
    const SetCheck check = verify_set(dir_, with);
    EXPECT_THAT(check.findings, IsEmpty());
    EXPECT_EQ(check.sets, 1);
    EXPECT_EQ(check.cameras, 2);
    EXPECT_EQ(check.images, 2 * (kSteps + 2));
    EXPECT_EQ(check.checksums, 2 * (kSteps + 2) + 1);
    EXPECT_EQ(check.summary(), "12 images of 2 cameras, 13 checksums compared: complete");
  }
  EXPECT_THAT(verify_set(dir_ / ".").findings, IsEmpty());
  EXPECT_THAT(verify_set((dir_ / "left" / "..").string() + "/").findings, IsEmpty());
}

TEST_F(VerifySetTest, WithoutChecksumsTheResultSaysSo) {
  fs::remove_all(dir_);
  record(dir_, "", 1, false);
  const SetCheck check = verify_set(dir_);
  EXPECT_TRUE(check.passed());
  EXPECT_THAT(check.sets_without_checksums, ElementsAre(dir_.string()));
  EXPECT_EQ(
      check.summary(),
      "12 images of 2 cameras, 0 checksums compared: every image decodes, but the set has no checksums");
  fs::remove(dir_ / "left" / "0001.png");  // the right camera has it
  EXPECT_THAT(verify_set(dir_).findings,
              ElementsAre(AllOf(HasSubstr(name("left/0001.png")), HasSubstr("no such image"))));
  fs::remove(dir_ / "right" / "0001.png");
  EXPECT_THAT(
      verify_set(dir_).findings,
      ::testing::UnorderedElementsAre(HasSubstr(name("left/0002.png")), HasSubstr(name("left/0003.png")),
                                      HasSubstr(name("right/0002.png")), HasSubstr(name("right/0003.png"))));
}

TEST_F(VerifySetTest, MissingAndSuperfluousFiles) {
  fs::remove(dir_ / "left/0002.png");
  EXPECT_THAT(finding(), AllOf(HasSubstr(name("left/0002.png") + ": no such image"), HasSubstr("restore")));
  fs::remove(dir_ / "left/0003.png");
  EXPECT_THAT(finding(), HasSubstr("2 of the 6 images of camera \"left\" are missing"));
  record(dir_);
  fs::remove(dir_ / "right/white.png");
  EXPECT_THAT(finding(), HasSubstr(name("right/white.png") + ": no such image"));
  record(dir_);
  fs::remove(dir_ / "frames.csv");
  EXPECT_THAT(finding(), HasSubstr(name("frames.csv") + ": is missing"));
  record(dir_);
  for (const char* extra : {"left/0004.png", "left/0009.png", "left/copy of 0001.png"}) {
    write_bytes(dir_ / extra, image_bytes_);
    EXPECT_THAT(finding(), AllOf(HasSubstr(name(extra) + ": is no image of this set"), HasSubstr("move it")));
    fs::remove(dir_ / extra);
  }
  write_bytes(dir_ / "left/notes.txt", "the user's");
  EXPECT_TRUE(verify_set(dir_).passed());
}

TEST_F(VerifySetTest, DarkFramesOfTheMainSet) {
  fs::create_directories(dir_ / "dark/left");
  write_bytes(dir_ / "dark/left/0000.png", image_bytes_);
  record(dir_);  // with their checksums
  EXPECT_TRUE(verify_set(dir_).passed());
  write_bytes(dir_ / "dark/left/0001.png", image_bytes_);
  EXPECT_THAT(finding(), HasSubstr(name("dark/left/0001.png") + ": is no image of this set"));
  fs::remove(dir_ / "dark/left/0001.png");
  write_bytes(dir_ / "dark/left/0000.png", image_bytes_.substr(0, 100));
  EXPECT_THAT(finding(), HasSubstr(name("dark/left/0000.png") + ": is not the file that was recorded"));
}

TEST_F(VerifySetTest, ChangedImages) {
  const std::string other = bytes_of(dir_ / "left/0001.png");
  write_bytes(dir_ / "left/0002.png", other);  // a good image, but not the one recorded
  EXPECT_THAT(finding(), HasSubstr(name("left/0002.png") + ": is not the image that was recorded"));
  record(dir_);
  std::mt19937 generator(9);
  write_gray_png(dir_ / "left/0002.png", random_image(&generator, kWidth + 1), 16);
  EXPECT_THAT(verify_set(dir_).findings, ElementsAre(HasSubstr("is not the image"),
                                                     HasSubstr("is 25 x 10 px, 16 bit, the others of camera "
                                                               "\"left\" are 24 x 10 px, 16 bit")));
  write_gray_png(dir_ / "left/0002.png", ImageF(kWidth, kHeight, 7.0f), 8);
  EXPECT_THAT(verify_set(dir_).findings, ::testing::Contains(HasSubstr("24 x 10 px, 8 bit")));
  write_bytes(dir_ / "left/0002.png", "");
  EXPECT_THAT(finding(), HasSubstr("is empty (0 bytes)"));
  record(dir_);
  std::ofstream(dir_ / "frames.csv", std::ios::app) << "left,2,3000\n";
  EXPECT_THAT(finding(), HasSubstr(name("frames.csv") + ": is not the file that was recorded"));
}

TEST_F(VerifySetTest, TheDescription) {
  const std::string toml = bytes_of(dir_ / "capture.toml");
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = toml;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return text;
  };
  write_bytes(dir_ / "capture.toml", changed("device\" = \"test", "device\" = \"best"));
  const std::string sentence = finding();
  EXPECT_THAT(sentence, HasSubstr(name("capture.toml") + ": was changed after it was written"));
  // what it says to do, done
  const auto from = sentence.find('"') + 1;
  write_bytes(dir_ / "capture.toml", sentence.substr(from, sentence.find('"', from) - from) +
                                         bytes_of(dir_ / "capture.toml").substr(toml.find('\n')));
  EXPECT_TRUE(verify_set(dir_).passed());

  write_bytes(dir_ / "capture.toml", toml.substr(toml.find('\n') + 1));
  EXPECT_THAT(finding(), HasSubstr("has lost its first line"));
  const std::string bare = toml.substr(toml.find('\n') + 1);
  const auto line = bare.find("\"sha256.left/0003.png\"");
  write_bytes(dir_ / "capture.toml", seal(bare.substr(0, line) + bare.substr(bare.find('\n', line) + 1)));
  EXPECT_THAT(finding(), HasSubstr(name("left/0003.png") + ": has no checksum"));
  write_bytes(dir_ / "capture.toml", seal(changed("captures/1", "captures/9").substr(toml.find('\n') + 1)));
  EXPECT_THAT(finding(), HasSubstr("must be \"fringetwin-captures/1\""));
}

TEST_F(VerifySetTest, UnfinishedSets) {
  write_bytes(dir_ / "capture.journal", "x");
  EXPECT_THAT(finding(), AllOf(HasSubstr("capture.journal: says that"), HasSubstr("--resume")));
  EXPECT_TRUE(verify_set(dir_).unfinished);
  fs::remove(dir_ / "capture.toml");
  EXPECT_THAT(finding(),
              AllOf(HasSubstr(dir_.string() + ": the recording has not ended"), HasSubstr("--resume")));
  EXPECT_TRUE(verify_set(dir_).unfinished);
  fs::remove(dir_ / "capture.journal");
  EXPECT_THAT(finding(), HasSubstr("has no capture.toml, so it is no capture set"));
  EXPECT_FALSE(verify_set(dir_).unfinished);
  EXPECT_THROW(verify_set(dir_ / "nowhere"), UserError);
}

TEST_F(VerifySetTest, LeftoversOfABrokenOffWrite) {
  for (const char* file : {"left/0001.png", "capture.toml"}) {
    fs::path temporary;
    {
      const TemporaryFile writing(dir_ / file);
      temporary = writing.path();
      write_bytes(temporary, "half");
      EXPECT_THAT(finding(),
                  AllOf(HasSubstr(temporary.filename().string() + ": is left over"), HasSubstr("delete it")));
    }
    EXPECT_TRUE(verify_set(dir_).passed());
  }
}

TEST_F(VerifySetTest, SetsThatItNames) {
  record(dir_, "repeat_01 repeat_02");
  record(dir_ / "repeat_01", "", 2);
  record(dir_ / "repeat_02", "", 3);
  const SetCheck good = verify_set(dir_);
  EXPECT_THAT(good.findings, IsEmpty());
  EXPECT_EQ(good.sets, 3);
  EXPECT_EQ(good.images, 36);
  EXPECT_EQ(good.summary(), "36 images of 2 cameras in 3 sets, 39 checksums compared: complete");

  write_bytes(dir_ / "repeat_02/left/0001.png", bytes_of(dir_ / "left/0001.png"));
  EXPECT_THAT(finding(), HasSubstr(name("repeat_02/left/0001.png") + ": is not the image"));
  fs::remove_all(dir_ / "repeat_02");
  EXPECT_THAT(finding(), HasSubstr(name("repeat_02") + ": has no capture.toml"));
  fs::create_directories(dir_ / "repeat_02");
  write_bytes(dir_ / "repeat_02/capture.journal", "x");
  EXPECT_THAT(finding(), HasSubstr("--resume"));
  record(dir_ / "repeat_02", "", 3);
  record(dir_, "repeat_01 repeat_02 repeat_01 repeat_02");
  EXPECT_EQ(verify_set(dir_).sets, 3);
  std::string many;
  for (int k = 0; k < 1002; ++k) many += fmt::format("{}/.. ", k);
  for (int k = 0; k < 1002; ++k) many += fmt::format("part_{} ", k);
  record(dir_, many);
  EXPECT_THAT(
      verify_set(dir_).findings,
      ::testing::Contains(name("capture.toml") + ": `sets` names more than 1000 sub-folders; mend the file"));
  record(dir_, "../other");
  EXPECT_THAT(finding(), HasSubstr("`sets` names ../other, which is no sub-folder"));
}

TEST_F(VerifySetTest, AgainstATwin) {
  const auto of = [&](const Twin& twin) { return verify_set(dir_, &twin).findings; };
  EXPECT_THAT(of(make_twin(kSteps + 1)),
              ElementsAre(HasSubstr("left/0004.png: no such image; camera \"left\" has 4"),
                          HasSubstr("the sequence has 5")));
  EXPECT_THAT(of(make_twin(kSteps - 1)),
              ElementsAre(HasSubstr("camera \"left\" has 4 images on disk, the sequence has 3"),
                          HasSubstr("camera \"right\" has 4")));
  EXPECT_THAT(of(make_twin(kSteps, 12, kWidth + 1)), ::testing::Each(HasSubstr("is 24 x 10 px, camera")));
  EXPECT_THAT(of(make_twin(kSteps, 10)), ::testing::Each(HasSubstr("is above the 1023 of a 10 bit sensor")));
  Twin twin = make_twin();
  twin.cameras[1].name = "upper";
  EXPECT_THAT(of(twin), ElementsAre(HasSubstr("has no camera \"upper\"")));
}

/// A set as `import captures` describes one: among files that are none of its business.
TEST_F(VerifySetTest, AForeignSet) {
  const fs::path raw = folder_ / "raw";
  CaptureSet set;
  set.file = folder_ / "described" / "capture.toml";
  std::mt19937 generator(3);
  for (const char* camera : {"left", "right"}) {
    set.cameras.emplace_back().name = camera;
    for (int i = 0; i < kSteps; ++i) {
      set.cameras.back().files.push_back(raw / fmt::format("{}{}.png", camera, i));
      write_gray_png(set.cameras.back().files.back(), random_image(&generator), 16);
    }
  }
  const Twin twin = make_twin();
  check_foreign_set(set, twin);
  write_foreign_set(set);
  write_bytes(raw / "left4.png", "of another set");
  const SetCheck check = verify_set(folder_ / "described", &twin);
  EXPECT_THAT(check.findings, IsEmpty());
  EXPECT_EQ(check.summary(), "8 images of 2 cameras, 8 checksums compared: complete");
  write_gray_png(raw / "right2.png", random_image(&generator), 16);
  EXPECT_THAT(verify_set(folder_ / "described").findings,
              ElementsAre(HasSubstr((raw / "right2.png").string() + ": is not the image")));
  fs::remove(raw / "right2.png");
  EXPECT_THAT(verify_set(folder_ / "described").findings,
              ElementsAre(HasSubstr("right2.png: no such image")));
}

/// A set of colour images is decoded to its end for the channel that it names, and for none without.
TEST_F(VerifySetTest, AForeignSetOfColourImages) {
  const fs::path raw = folder_ / "raw";
  CaptureSet set;
  set.file = folder_ / "described" / "capture.toml";
  set.channel = ColourChannel::green;
  Twin twin = make_twin();
  twin.cameras.erase(twin.cameras.begin() + 1, twin.cameras.end());
  twin.cameras[0].sensor.bit_depth = 8;
  set.cameras.emplace_back().name = twin.cameras[0].name;
  const std::string pixels(3 * kWidth * kHeight, 'x');
  for (int i = 0; i < kSteps; ++i) {
    set.cameras[0].files.push_back(raw / fmt::format("{}.ppm", i));
    write_text_file(set.cameras[0].files.back(), fmt::format("P6 {} {} 255\n", kWidth, kHeight) + pixels);
  }
  check_foreign_set(set, twin);
  write_foreign_set(set);
  EXPECT_THAT(verify_set(folder_ / "described", &twin).findings, IsEmpty());
  set.channel.reset();
  write_foreign_set(set);
  EXPECT_THAT(verify_set(folder_ / "described").findings,
              ::testing::Each(HasSubstr("is a colour image (3 channels)")));
  EXPECT_FALSE(verify_set(folder_ / "described").passed());
}

/// Every file of the set, cut at every kind of place and with any byte changed: no such set passes. Without
/// checksums this holds for the images all the same, as far as a reader of the images could notice.
TEST_F(VerifySetTest, NothingHalfPasses) {
  std::mt19937 generator(20261122);
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(dir_))
    if (entry.is_regular_file()) files.push_back(entry.path());
  ASSERT_EQ(files.size(), 14u);
  constexpr int kTries = 12;
  for (const fs::path& file : files) {
    const std::string whole = bytes_of(file);
    for (int i = 0; i < kTries; ++i) {
      const std::size_t at = i == 0 ? whole.size() - 1 : generator() % whole.size();
      std::string flipped = whole;
      flipped[at] = static_cast<char>(flipped[at] ^ (1 << (generator() % 8)));
      write_bytes(file, whole.substr(0, at));
      EXPECT_FALSE(verify_set(dir_).passed()) << file << " cut to " << at;
      write_bytes(file, flipped);
      EXPECT_FALSE(verify_set(dir_).passed()) << file << " changed at " << at;
    }
    write_bytes(file, whole);
  }
  EXPECT_TRUE(verify_set(dir_).passed());
}

TEST_F(VerifySetTest, NoHalfImagePassesWithoutChecksums) {
  fs::remove_all(dir_);
  record(dir_, "", 1, false);
  std::mt19937 generator(20261123);
  const fs::path file = dir_ / "left/0001.png";
  const std::string whole = bytes_of(file);
  for (std::size_t at = 0; at < whole.size(); at += 1 + generator() % 4) {
    write_bytes(file, whole.substr(0, at));
    EXPECT_FALSE(verify_set(dir_).passed()) << "cut to " << at;
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << (generator() % 8)));
    write_bytes(file, flipped);
    EXPECT_FALSE(verify_set(dir_).passed()) << "changed at " << at;
  }
}

}  // namespace
}  // namespace fringetwin::testing::verify_set_test
