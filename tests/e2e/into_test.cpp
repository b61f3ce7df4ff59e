// SPDX-License-Identifier: Apache-2.0
// `cosim --refine ... --into twin.toml`: the values that refined.toml has stand in a twin that someone has
// written, and nothing else has changed in it. No tolerances: texts are exact.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing::into_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// The twin of a rig with the noise of a camera, and what a hand writes into a file beside.
std::string by_hand(const std::string& radius_mm, const std::string& gain_dn) {
  return "# my rig, of May\n" +
         small_twin({{"gain_dn = 20", "gain_dn   =  " + gain_dn +
                                          "  # data sheet\nblack_level_dn = 8\n"
                                          "electrons_per_dn = 400\nread_noise_dn = 0.5"},
                     {"intrinsics = [260, 260", "intrinsics = [800, 800"},
                     {"radius_mm = 19", "\tradius_mm = " + radius_mm + "\t# micrometer screw"}},
                    "\n\n[real]\ncaptures = \"out\"   # beside\n");
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Returns the value of a key's first line.
std::string value_of(const std::string& text, const std::string& key) {
  const auto at = text.find("\n" + key + " = ");
  EXPECT_NE(at, std::string::npos) << key;
  return text.substr(at + key.size() + 4, text.find('\n', at + 1) - at - key.size() - 4);
}

TEST(Into, ATwinGetsWhatRefinedTomlHas) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("into");
  const fs::path file = dir / "twin.toml";
  write_file(file, by_hand("19", "20"));
  ASSERT_EQ(
      run_fringetwin({"render", file.string(), "--seed", "1", "--out", (dir / "out").string()}).exit_code, 0);
  const std::string before = by_hand("19.05", "24");
  write_file(file, before);
  // the twin is wrong, so causes are looked for, and none of what takes long is silent
  const std::vector<std::string> as_it_is{"cosim", dir.string(), "--out", (dir / "as-it-is").string()};
  const RunResult first = run_fringetwin(as_it_is);
  EXPECT_EQ(first.exit_code, 0) << first.err;
  for (const char* shown :
       {"compare 20 %", "compare 100 %", "causes 40 %", "causes 100 %", "page 50 %", "page 100 %"})
    EXPECT_THAT(first.err, HasSubstr("\nfringetwin: " + std::string(shown) + "\n"));
  EXPECT_EQ(read_file(file), before);
  const RunResult run = run_fringetwin({"cosim", dir.string(), "--refine", "size,gain", "--into",
                                        dir.string(), "--out", (dir / "compared").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("2 refined values put into " + file.string()));
  const std::string refined = read_file(dir / "compared" / "refined.toml");
  const std::string expected = by_hand(value_of(refined, "radius_mm"), value_of(refined, "gain_dn"));
  EXPECT_EQ(read_file(file), expected);
  EXPECT_EQ(lines_of(before).size(), lines_of(expected).size());
  const Twin twin = load_twin(file);
  EXPECT_NE(std::get<SphereShape>(twin.objects[0].shape).radius_mm, 19.05);
  EXPECT_NE(twin.cameras[0].sensor.gain_dn, 24.0);
}

TEST(Into, IsRefusedBeforeTheWork) {
  const fs::path dir = scratch_folder("into-bad");
  const std::string no_device = "VK_ICD_FILENAMES=/nonexistent.json";
  write_file(dir / "twin.toml", by_hand("19", "20"));
  fs::create_directories(dir / "out");
  const auto refused = [&](const std::vector<std::string>& more, const std::vector<std::string>& parts) {
    std::vector<std::string> args{"cosim", (dir / "twin.toml").string(), "--out",
                                  (dir / "compared").string()};
    args.insert(args.end(), more.begin(), more.end());
    expect_refused(run_fringetwin(args, {no_device}), 2, parts);
    EXPECT_FALSE(fs::exists(dir / "compared"));
  };
  refused({"--into", dir.string()},
          {"--into " + (dir / "twin.toml").string(), "name what to fit with --refine"});
  refused({"--refine", "size", "--into", (dir / "none.toml").string()}, {"none.toml", "cannot be read"});
  refused({"--refine", "size", "--into", (dir / "out").string()}, {"out: is a folder without a twin.toml"});
  std::string other = by_hand("19", "20");
  other.replace(other.find("name = \"ball\""), 13, "name = \"bell\"");
  write_file(dir / "other.toml", other);
  refused({"--refine", "size", "--into", (dir / "other.toml").string()},
          {(dir / "other.toml").string() + ": has no [[object]] with name = \"ball\""});
  EXPECT_EQ(read_file(dir / "other.toml"), other);
}

}  // namespace
}  // namespace fringetwin::testing::into_test
