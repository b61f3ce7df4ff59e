// SPDX-License-Identifier: Apache-2.0
// The pictures for a projector that runs by itself are bit for bit what a display would be given.
#include "capture/record/pattern_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/device/pattern.hpp"
#include "tests/support/capture/loop_rig.hpp"
#include "tests/support/twin/child_process.hpp"
#include "tests/support/twin/expect_user_error.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::pattern_files_test {
namespace {

using namespace fringetwin::capture;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class PatternFiles : public ::testing::Test {
 protected:
  PatternFiles() { set_quiet(true); }
  ~PatternFiles() override { set_quiet(false); }

  std::size_t write(bool overwrite = false) { return write_pattern_files(twin_, dir(), overwrite); }
  fs::path dir() const { return scratch_ / "patterns"; }
  /// Nothing else is left, not even hidden.
  std::size_t n_entries(const fs::path& folder) const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  void expect_shown(const std::string& name, const Pattern& pattern) const {
    const LoadedGray loaded = read_gray(dir() / name);
    EXPECT_EQ(loaded.file_bits, 8);
    const ImageU16 shown = quantise_levels(pattern_levels(twin_.fringes, pattern, 64, 48), 8);
    ASSERT_EQ(loaded.image.width, 64);
    EXPECT_TRUE(std::ranges::equal(loaded.image.data, shown.data)) << name;
  }

  Twin twin_ = loop_twin(1);
  ScratchFolder scratch_;
};

TEST_F(PatternFiles, AreWhatADisplayIsGiven) {
  EXPECT_EQ(write(), 8u);
  for (const Pattern& pattern : sequence_patterns(twin_.fringes))
    expect_shown(fmt::format("{:03d}.png", pattern.index), pattern);
  EXPECT_EQ(n_entries(dir()), 9u);
  EXPECT_EQ(n_entries(scratch_.path()), 1u);
  EXPECT_THAT(read_file(dir() / kPatternTableName),
              HasSubstr("number,file,kind,direction,pitch_px,step,bit,pattern\n"
                        "0,000.png,phase step,x,13,1,,x pitch 13 step 1/4\n"
                        "1,001.png,phase step,x,13,2,,x pitch 13 step 2/4\n"));
}

TEST_F(PatternFiles, BitsWhiteAndBlackStandBehind) {
  DirectionFringes& direction = twin_.fringes.directions[0];
  direction.axis = Axis::y;
  direction.pitches_px = {16.0};
  direction.phase_origin_px = {0.0};
  direction.gray = GrayCode{.bits = 2, .complementary = true, .threshold = GrayCode::Threshold::white_black};
  twin_.fringes.unwrap = Unwrap::gray;
  EXPECT_EQ(write(), 9u);
  expect_shown("007.png", even_field(1.0, "white"));
  expect_shown("008.png", even_field(0.0, "black"));
  EXPECT_THAT(read_file(dir() / kPatternTableName),
              HasSubstr("\n4,004.png,gray bit,y,16,,1,y gray bit 1/2 (most significant)\n"
                        "5,005.png,gray bit,y,16,,2,y gray bit 2/2 (least significant)\n"
                        "6,006.png,complementary bit,y,16,,,y complementary bit\n"
                        "7,007.png,white,,,,,white\n8,008.png,black,,,,,black\n"));
}

TEST_F(PatternFiles, OnlyOwnFilesAreReplacedAndOnlyWhenAsked) {
  fs::create_directory(dir());
  write();  // into an empty folder
  expect_user_error(ExitCode::usage, "is not empty; choose another folder, or replace", [&] { write(); });
  twin_.fringes.directions[0].pitches_px = {17.0};
  EXPECT_EQ(write(true), 4u);
  EXPECT_EQ(n_entries(dir()), 5u);
  scratch_.write("patterns/notes.txt", "the user's");
  expect_user_error(ExitCode::usage, "notes.txt: is no file of --patterns", [&] { write(true); });
  EXPECT_EQ(n_entries(dir()), 6u);
  // images of a recording have such names, too
  fs::remove(dir() / "notes.txt");
  fs::remove(dir() / kPatternTableName);
  expect_user_error(ExitCode::usage, ".png: is no file of --patterns", [&] { write(true); });
  scratch_.write("patterns/" + std::string(kPatternTableName), "number,file\n0,000.png\n");
  expect_user_error(ExitCode::usage, ".png: is no file of --patterns", [&] { write(true); });
  EXPECT_EQ(n_entries(dir()), 5u);
  EXPECT_EQ(n_entries(scratch_.path()), 1u);
}

}  // namespace
}  // namespace fringetwin::testing::pattern_files_test
