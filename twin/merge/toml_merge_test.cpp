// SPDX-License-Identifier: Apache-2.0
// Values put into a file: what changes is the value alone, byte by byte. No tolerances: texts are exact.
#include "twin/merge/toml_merge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/twin/expect_user_error.hpp"
#include "twin/merge/toml_statements.hpp"

namespace fringetwin::testing::toml_merge_test {
namespace {

std::string merged(const std::string& text, const std::vector<TomlBlock>& blocks) {
  return merge_toml(text, blocks, "rig/twin.toml");
}

void expect_refused(const std::string& text, const std::vector<TomlBlock>& blocks, const std::string& words) {
  expect_user_error(ExitCode::usage, words, [&] { (void)merged(text, blocks); });
}

TomlBlock sensor_of(const std::string& camera, std::vector<TomlKey> keys) {
  return {.table = {"camera", "sensor"}, .entry = camera, .keys = std::move(keys)};
}

// What a hand has written: comments, odd spaces, a table in the middle, strings that look like TOML.
constexpr const char* kByHand =
    "# my rig  \n"
    "schema = 'fringetwin-twin/1'   # [projector]\n"
    "name = \"a # b = [c]\"\n"
    "\n"
    "[[camera]] # the left one\n"
    "  name = \"left\"\n"
    "\tintrinsics = [ 900, 905,   # f\n"
    "    31.5, 23.5 ]  # c\n"
    "[camera.sensor]\n"
    "gain_dn=20.5 # from the data sheet\n"
    "\n"
    "# --- projector ---\n"
    "[projector]\n"
    "blur_px = 0.0\n"
    "\n"
    "[[camera]]\n"
    "name = \"right\"\n"
    "text = '''\n"
    "[projector]\n"
    "blur_px = 7\n"
    "'''\n"
    "# end";

TEST(TomlMerge, ChangesTheValueAlone) {
  const std::string text = kByHand;
  std::string expected = text;
  const auto put = [&expected](const std::string& before, const std::string& after) {
    const auto at = expected.find(before);
    ASSERT_NE(at, std::string::npos) << before;
    expected.replace(at, before.size(), after);
  };
  put("[ 900, 905,   # f\n    31.5, 23.5 ]", "[901, 906, 31.5, 23.5]");
  put("gain_dn=20.5", "gain_dn=21.25");
  put("blur_px = 0.0", "blur_px = 1.5");
  EXPECT_EQ(
      merged(text,
             {{.table = {"camera"}, .entry = "left", .keys = {{"intrinsics", "[901, 906, 31.5, 23.5]"}}},
              sensor_of("left", {{"gain_dn", "21.25", "not said: the line has its own"}}),
              {.table = {"projector"}, .keys = {{"blur_px", "1.5"}}}}),
      expected);
  EXPECT_EQ(merged(text, {{.table = {"projector"}}, sensor_of("left", {})}), text);
}

TEST(TomlMerge, NewKeysStandAtTheEndOfTheirTable) {
  const std::string text =
      "[[camera]]\nname = \"left\"\n[camera.sensor]\ngain_dn = 20\n\n# below\n[[camera]]\nname = \"right\"";
  EXPECT_EQ(
      merged(text, {sensor_of("left", {{"read_noise_dn", "0.5", "± 0.1"}}),
                    {.table = {"camera"}, .entry = "right", .keys = {{"vignetting", "[1, 0, 0]"}}},
                    sensor_of("right", {{"gain_dn", "3"}})}),
      "[[camera]]\nname = \"left\"\n[camera.sensor]\ngain_dn = 20\nread_noise_dn = 0.5             # ± "
      "0.1\n\n# below\n[[camera]]\nname = \"right\"\nvignetting = [1, 0, 0]\n\n[camera.sensor]\ngain_dn "
      "= 3\n");
}

TEST(TomlMerge, NewTablesStandBehindTheirParent) {
  const std::string text = "[fringes]\nsteps = 4\n[fringes.gray]\nbits = 6\n[measure]\nsteps = 4\n";
  EXPECT_EQ(merged(text, {{.table = {"fringes", "x"}, .keys = {{"contrast", "[1, 0.5]"}}},
                          {.table = {"render"}, .keys = {{"bounces", "1"}}, .may_be_new = true}}),
            "[fringes]\nsteps = 4\n[fringes.gray]\nbits = 6\n\n[fringes.x]\ncontrast = [1, 0.5]\n"
            "[measure]\nsteps = 4\n\n[render]\nbounces = 1\n");
}

TEST(TomlMerge, KnowsDottedKeysAndOtherLineBreaks) {
  EXPECT_EQ(
      merged("projector.blur_px = 1 # σ\r\nname = 'x'\r\n[[camera]]\r\nname = 'left'\r\nsensor.gain_dn "
             "= 2\r\n",
             {{.table = {"projector"}, .keys = {{"blur_px", "1.5"}, {"response", "{ gamma = 2 }"}}},
              sensor_of("left", {{"gain_dn", "3"}, {"black_level_dn", "4"}})}),
      "projector.blur_px = 1.5 # σ\r\nprojector.response = { gamma = 2 }\r\nname = 'x'\r\n[[camera]]\r\n"
      "name = 'left'\r\nsensor.gain_dn = 3\r\nsensor.black_level_dn = 4\r\n");
}

TEST(TomlMerge, KeysThatCannotStandBesideBecomeComments) {
  const TomlBlock lens{
      .table = {"camera"},
      .entry = "left",
      .keys = {{"intrinsics", "[1, 2, 3, 4]"}},
      .exclusions = {
          {{"model", "opencv"}, {{"lensmodel", "\"P\""}, {"intrinsics", "[0]"}, {"imagersize", "[5, 6]"}}}}};
  EXPECT_EQ(
      merged("[[camera]]\nname = \"left\"\nmodel = \"left.cameramodel\"  # of May\n[camera.sensor]\n"
             "gain_dn = 1\n",
             {lens}),
      "[[camera]]\nname = \"left\"\n# model = \"left.cameramodel\"  # of May\nintrinsics = [1, 2, 3, 4]\n"
      "lensmodel = \"P\"\nimagersize = [5, 6]\n[camera.sensor]\ngain_dn = 1\n");
  EXPECT_EQ(
      merged("[[camera]]\nname = \"left\"\nimagersize = [9, 9]\n[camera.opencv]\nfiles = [\n\"a\",\n]\n",
             {lens}),
      "[[camera]]\nname = \"left\"\nimagersize = [5, 6]\nintrinsics = [1, 2, 3, 4]\nlensmodel = \"P\"\n"
      "# [camera.opencv]\n# files = [\n# \"a\",\n# ]\n");
  EXPECT_EQ(merged("[[camera]]\nname = \"left\"\nlensmodel = \"P\"\nintrinsics = [0]\n", {lens}),
            "[[camera]]\nname = \"left\"\nlensmodel = \"P\"\nintrinsics = [1, 2, 3, 4]\n");
}

TEST(TomlMerge, RefusesWhatItCannotFindOrTellApart) {
  const TomlBlock blur{.table = {"projector"}, .keys = {{"blur_px", "1.5"}}};
  const auto left = sensor_of("left", {{"gain_dn", "3"}});
  expect_refused("[fringes]\n", {blur}, "rig/twin.toml: has no [projector]; is it the twin");
  expect_refused("[[camera]]\nname = 'right'\n", {left},
                 "rig/twin.toml: has no [[camera]] with name = \"left\"");
  expect_refused("[[camera]]\nname = 'left'\n[[camera]]\nname = \"left\"\n", {left},
                 "has 2 [[camera]] with name = \"left\", so that it cannot be told which is meant");
  expect_refused("[camera]\nname = 'left'\n", {left}, "has no [[camera]] but another camera");
  expect_refused("\ncamera = [{ name = 'left' }]\n", {left}, "rig/twin.toml:2: camera is written as a value");
  expect_refused(
      "[[camera]]\nname = 'left'\nsensor = { gain_dn = 2 }\n", {left},
      "rig/twin.toml:3: camera.sensor is written as a value, which is not changed in parts; write it "
      "as a table of its own, [camera.sensor]");
  expect_refused(
      "[projector]\nresponse.gamma = 2\n",
      {{.table = {"projector"}, .keys = {{"response", "{ gamma = 1.9 }"}}}},
      "rig/twin.toml:2: projector.response is written as a table of its own; write it as one value, as "
      "in response = { gamma = 1.9 }");
  expect_refused("[projector]\n[projector.blur_px]\n", {blur},
                 "projector.blur_px is written as a table of its own");
  expect_refused("[projector\n", {blur}, "rig/twin.toml:1: is no valid TOML");
  // a quoted name means the same, but is not looked for: nothing is written twice
  expect_refused("[projector]\n\"blur\\u005fpx\" = 1\n", {blur}, "has no place for these values");
}

TEST(TomlStatements, ReadNothingOutsideOfATextThatIsNoToml) {
  for (const std::string text :
       {"[", "[[", "[a", "a", "a =", "a = \"", "a = '''", "a = \"\\", "a = [", "\"", "'a", "\xef\xbb\xbf",
        "a = \"\"\"b\"\"\"\"\"", "= 1", "[]", "[[]]\n[[]]", "a..b = 1", "#"})
    for (std::size_t n = 0; n <= text.size(); ++n)
      for (const TomlStatement& s : toml_statements(std::string(text, 0, n))) EXPECT_LE(s.end, n);
}

}  // namespace
}  // namespace fringetwin::testing::toml_merge_test
