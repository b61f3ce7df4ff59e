// SPDX-License-Identifier: Apache-2.0
// A twin.toml that gets values is whole under its name, or the one from before. No tolerances: texts are
// exact.
#include "twin/merge/merge_into_twin.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>

#include "tests/support/twin/expect_user_error.hpp"
#include "tests/support/twin/twin_file_fixture.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/image/image_io.hpp"
#include "twin/merge/toml_merge.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing::merge_into_twin_test {
namespace {

namespace fs = std::filesystem;

class MergeIntoTwin : public TwinFile {
 protected:
  void write(const std::string& text) { write_text_file(file(), text); }
  fs::path file() const { return folder_ / "twin.toml"; }
  std::string text() const { return read_whole_text(file(), {}); }
  std::size_t n_files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }
};

const std::vector<TomlBlock> kGain = {{.table = {"camera", "sensor"},
                                       .entry = "left",
                                       .keys = {{"gain_dn", "21.5"}, {"read_noise_dn", "0.4"}}}};

TEST_F(MergeIntoTwin, WritesATwinThatSaysIt) {
  const std::string before = kHead + kCamera + kSensor + "# ours\n" + kFringes;
  write(before);
  fs::permissions(file(), fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  check_merge_into_twin(file(), kGain);
  EXPECT_EQ(text(), before);
  EXPECT_EQ(merge_into_twin(file(), kGain), 2u);
  EXPECT_EQ(text(), with(with(before, "gain_dn", "gain_dn = 21.5"), "read_noise_dn", "read_noise_dn = 0.4"));
  EXPECT_EQ(load_twin(file()).cameras[0].sensor.gain_dn, 21.5);
  EXPECT_EQ(fs::status(file()).permissions(),
            fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  EXPECT_EQ(n_files(), 1u);
}

TEST_F(MergeIntoTwin, ALinkStaysALink) {
  write(kMinimal);
  fs::create_symlink("twin.toml", folder_ / "link.toml");
  merge_into_twin(folder_ / "link.toml", kGain);
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.toml"));
  EXPECT_EQ(text(), kHead + kCamera + "\n[camera.sensor]\ngain_dn = 21.5\nread_noise_dn = 0.4\n" + kFringes);
}

TEST_F(MergeIntoTwin, WhatWouldBeNoTwinIsNotWritten) {
  const std::vector<TomlBlock> dark = {
      {.table = {"camera", "sensor"}, .entry = "left", .keys = {{"gain_dn", "-1"}}}};
  write(kMinimal);
  expect_user_error(ExitCode::usage,
                    file().string() + ": would be no twin any more with these values (" + file().string() +
                        ":12: camera[0].sensor.gain_dn must be > 0, is -1); it stays as it was",
                    [&] { merge_into_twin(file(), dark); });
  EXPECT_EQ(text(), kMinimal);
  EXPECT_EQ(n_files(), 1u);
  expect_user_error(ExitCode::usage, "has no [[camera]] with name = \"middle\"",
                    [&] { check_merge_into_twin(file(), {{.table = {"camera"}, .entry = "middle"}}); });
  expect_user_error(ExitCode::usage, (folder_ / "none.toml").string(),
                    [&] { check_merge_into_twin(folder_ / "none.toml", kGain); });
}

// Hands have written these: of each a value of every table is changed and another one is new; all else stays.
TEST(MergeIntoShippedTwins, TakeValuesAndKeepTheirLines) {
  int n = 0;
  const char* source = std::getenv("FRINGETWIN_SOURCE");
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(source != nullptr ? source : ".") / "datasets")) {
    if (!entry.path().filename().string().starts_with("twin") || entry.path().extension() != ".toml")
      continue;
    const std::string text = read_whole_text(entry.path(), {});
    if (text.find("[[camera]]") == std::string::npos) continue;
    const Twin twin = load_twin(entry.path());
    std::vector<TomlBlock> blocks;
    for (const Camera& camera : twin.cameras) {
      blocks.push_back({.table = {"camera"}, .entry = camera.name, .keys = {{"vignetting", "[0.25, 0, 0]"}}});
      blocks.push_back(
          {.table = {"camera", "sensor"}, .entry = camera.name, .keys = {{"gain_dn", "12.625"}}});
    }
    for (const Object& object : twin.objects)
      blocks.push_back(
          {.table = {"object", "material"}, .entry = object.name, .keys = {{"diffuse", "0.625"}}});
    if (twin.projector) blocks.push_back({.table = {"projector"}, .keys = {{"blur_px", "0.0625"}}});
    const std::string after = merge_toml(text, blocks, entry.path().string());
    // without the new values, and the lines and tables that are nothing but new, it is what it was
    const auto reduced = [](const std::string& from) {
      static const std::regex values(
          "(vignetting|gain_dn|diffuse|blur_px) *=[^\n#]*|\\[(camera|object)\\.(sensor|material)\\]|\\s");
      return std::regex_replace(from, values, "");
    };
    EXPECT_EQ(reduced(after), reduced(text)) << entry.path();
    EXPECT_NE(after, text);
    ++n;
  }
  EXPECT_GE(n, 10);
}

// A camera whose lens comes from a file gets one of its own.
TEST_F(MergeIntoTwin, TheTwinsOwnLensTakesThePlaceOfAnOpenCvFile) {
  const std::string pose = "rt_cam_world = [0, 0, 0, 0, 0, 0]\n";
  write(kHead + "[[camera]]\nname = \"left\"\nimagersize = [640, 480]\n" + pose +
        "opencv = { files = [\"gone.yml\"], matrix = \"M\", distortion = \"D\" }  # of May\n" + kFringes);
  merge_into_twin(file(), {{.table = {"camera"},
                            .entry = "left",
                            .keys = {{"intrinsics", "[601, 602, 319.5, 239.5]"}},
                            .exclusions = {{{"model", "opencv"},
                                            {{"lensmodel", "\"LENSMODEL_PINHOLE\""},
                                             {"imagersize", "[640, 480]"},
                                             {"rt_cam_world", "[0, 0, 0, 0, 0, 0]"}}}}}});
  EXPECT_EQ(text(),
            kHead + "[[camera]]\nname = \"left\"\nimagersize = [640, 480]\n" + pose +
                "# opencv = { files = [\"gone.yml\"], matrix = \"M\", distortion = \"D\" }  # of May\n"
                "intrinsics = [601, 602, 319.5, 239.5]\nlensmodel = \"LENSMODEL_PINHOLE\"\n" +
                kFringes);
}

}  // namespace
}  // namespace fringetwin::testing::merge_into_twin_test
