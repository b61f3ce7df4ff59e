// SPDX-License-Identifier: Apache-2.0
// A lamp that drifts and flickers by 2 %, as a user meets it: rendered with the keys of a twin, told and
// taken out by `measure`, named as the cause by `cosim`, fitted by `--refine light`.
//
// | check            | tolerance | origin                                                      |
// |------------------|-----------|-------------------------------------------------------------|
// | factors, refined | 3 sigma   | required; 24 numbers: one seed in 15                        |
// | factors, measured| 4 sigma   | 12 numbers: one seed in 1300                                |
// | rms of the fit   | 10 %      | 9000 points each: 1 %, and what the factors' noise adds |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::light_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr int kImages = 12;

/// A drift over the sequence, and every third image 1 % brighter; geometric mean 1.
std::vector<double> lamp() {
  std::vector<double> out;
  double mean = 0.0;
  for (int k = 0; k < kImages; ++k) {
    out.push_back((0.98 + 0.04 * k / (kImages - 1.0)) * (k % 3 == 1 ? 1.01 : 1.0));
    mean += std::log(out.back()) / kImages;
  }
  for (double& factor : out) factor *= std::exp(-mean);
  return out;
}

std::string noisy_twin(const std::string& projector, const std::string& measure, const std::string& extra) {
  return small_twin(
      {{"gain_dn = 20", "gain_dn = 20\nblack_level_dn = 8\nelectrons_per_dn = 400\nread_noise_dn = 0.5"},
       {"intensity = 40", "intensity = 40\n" + projector},
       {"intrinsics = [260, 260", "intrinsics = [800, 800"},  // a fringe of 2 mm is 6 pixels wide
       {"triangulate = \"projector\"", "triangulate = \"projector\"\n" + measure}},
      extra);
}

class Light : public ::testing::Test {
 protected:
  void SetUp() override {
    FT_NEED_DEVICE();
    std::string factors;
    for (const double factor : lamp()) factors += (factors.empty() ? "" : ", ") + std::to_string(factor);
    recorded(noisy_twin("light_factors = [" + factors + "]", "", ""), dir_, "1");
    recorded(noisy_twin("", "", ""), dir_ / "steady", "2");
  }
  /// Renders a twin's images with noise of another seed than that of cosim's own: into the folder's `out`.
  static void recorded(const std::string& twin, const fs::path& folder, const std::string& seed) {
    write_file(folder / "twin.toml", twin);
    const RunResult run = run_fringetwin(
        {"render", (folder / "twin.toml").string(), "--seed", seed, "--out", (folder / "out").string()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  json measured(const fs::path& captures, const std::string& measure, std::string* told = nullptr) const {
    write_file(dir_ / "measured.toml", noisy_twin("", measure, ""));
    const RunResult run = run_fringetwin({"measure", (dir_ / "measured.toml").string(), "--captures",
                                          captures.string(), "--out", (dir_ / "measured").string()});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    if (told) *told = run.err;
    return json::parse(read_file(dir_ / "measured" / "result.json"));
  }
  json compared(const std::string& measure, const std::vector<std::string>& more) const {
    write_file(dir_ / "compared.toml", noisy_twin("", measure, "[real]\ncaptures = \"out\"\n"));
    std::vector<std::string> args{"cosim", (dir_ / "compared.toml").string(), "--out",
                                  (dir_ / "compared").string()};
    args.insert(args.end(), more.begin(), more.end());
    const RunResult run = run_fringetwin(args);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(read_file(dir_ / "compared" / "result.json"));
  }
  static double rms_mm(const json& result) { return result["fits"][0]["measured"]["rms_mm"].get<double>(); }

  fs::path dir_ = scratch_folder("light");
};

TEST_F(Light, IsTakenOut) {
  std::string told;
  const json as_it_is = measured(dir_ / "out", "", &told),
             taken_out = measured(dir_ / "out", "light = \"corrected\"", &told),
             steady = measured(dir_ / "steady" / "out", "");
  EXPECT_FALSE(as_it_is.contains("light"));
  ASSERT_EQ(taken_out["light"].size(), 1u);
  const json& row = taken_out["light"][0];
  EXPECT_TRUE(row["corrected"].get<bool>());
  for (std::size_t k = 0; k < kImages; ++k)
    EXPECT_NEAR(row["factor"][k].get<double>(), lamp()[k], 4.0 * row["factor_sigma"][k].get<double>()) << k;
  EXPECT_THAT(told, HasSubstr("taken out, it moved the phase by"));
  EXPECT_GT(rms_mm(as_it_is), 1.2 * rms_mm(steady));
  EXPECT_NEAR(rms_mm(taken_out) / rms_mm(steady), 1.0, 0.1);
}

TEST_F(Light, ThatIsSteadyIsLeftAsItIs) {
  std::string told;
  json as_it_is = measured(dir_ / "steady" / "out", ""),
       asked = measured(dir_ / "steady" / "out", "light = \"corrected\"", &told);
  ASSERT_EQ(asked["light"].size(), 1u);
  EXPECT_FALSE(asked["light"][0]["corrected"].get<bool>());
  EXPECT_THAT(told, HasSubstr("nothing is taken out"));
  EXPECT_EQ(asked["fits"], as_it_is["fits"]);
  EXPECT_EQ(asked["decode"], as_it_is["decode"]);
}

// An object that is measured from these captures has no ripple of the lamp: rendered under a steady lamp it
// is as smooth as one measured under a steady lamp.
TEST_F(Light, IsTakenOutOfAMeasuredObject) {
  const auto relief_rms_mm = [&](const std::string& captures, const std::string& measure) {
    std::string twin = noisy_twin("", measure, "[real]\ncaptures = \"" + captures + "\"\n");
    for (const auto& [from, to] :
         {std::pair<std::string, std::string>{"shape = \"sphere\"", "shape = \"measured\"\nsmoothing_px = 1"},
          {"center_mm = [0, 0, 270]\n", "steps = \"all\"\n"},
          {"radius_mm = 19\n", ""},
          {"[[measure.fit]]\nobject = \"ball\"\n", ""},
          {"electrons_per_dn = 400\nread_noise_dn = 0.5\n", ""}})
      twin.replace(twin.find(from), from.size(), to);
    EXPECT_EQ(render_twin(twin, dir_).exit_code, 0);
    return rms_mm(measured(dir_ / "out", ""));
  };
  fs::rename(dir_ / "out", dir_ / "flickering");
  const double as_it_is = relief_rms_mm("flickering", ""),
               taken_out = relief_rms_mm("flickering", "light = \"corrected\""),
               steady = relief_rms_mm("steady/out", "");
  EXPECT_GT(as_it_is, 1.2 * steady);
  EXPECT_NEAR(taken_out / steady, 1.0, 0.1);
}

TEST_F(Light, IsNamedAndRefined) {
  const json plain = compared("", {});
  EXPECT_THAT(plain["budget_verdict"], Contains("not explained"));
  EXPECT_EQ(plain["causes"]["together"], json({"light"})) << plain["causes"].dump(1);
  const json& budget = plain["phase_budget"][0];
  ASSERT_TRUE(budget.contains("light_rad2")) << budget.dump(1);
  EXPECT_NEAR(budget["light_rad2"].get<double>() / budget["brightness_rad2"].get<double>(), 1.0, 0.2)
      << budget.dump(1);
  const json refined = compared("", {"--refine", "light"});
  ASSERT_EQ(refined["refinement"]["parameters"].size(), kImages - 1u) << refined["refinement"].dump(1);
  for (const json& row : refined["refinement"]["parameters"]) {
    const int image = std::stoi(row["name"].get<std::string>().substr(6));
    EXPECT_NEAR(row["after"].get<double>(), std::log(lamp()[static_cast<std::size_t>(image)]),
                3.0 * row["after_sigma"].get<double>())
        << row.dump();
  }
  EXPECT_THAT(refined["budget_verdict"], ::testing::Not(Contains("not explained")))
      << refined["explained"].dump(1);
  // what was written is a key that the twin reads, and with it the twin is right
  const std::string text = read_file(dir_ / "compared" / "refined.toml");
  const auto at = text.find("light_factors = ");
  ASSERT_NE(at, std::string::npos) << text;
  write_file(dir_ / "mended.toml",
             noisy_twin(text.substr(at, text.find('\n', at) - at), "", "[real]\ncaptures = \"out\"\n"));
  const RunResult run =
      run_fringetwin({"cosim", (dir_ / "mended.toml").string(), "--out", (dir_ / "mended").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const json mended = json::parse(read_file(dir_ / "mended" / "result.json"));
  EXPECT_THAT(mended["budget_verdict"], ::testing::Not(Contains("not explained")));
}

TEST_F(Light, ATextureIsNotWrittenOverOneThatWasRead) {
  write_file(dir_ / "compared.toml", noisy_twin("", "", "[real]\ncaptures = \"out\"\n"));
  const auto refined = [&](const std::string& twin) {
    return run_fringetwin(
        {"cosim", (dir_ / twin).string(), "--refine", "texture", "--out", (dir_ / "first").string()});
  };
  EXPECT_EQ(refined("compared.toml").exit_code, 0);
  fs::path texture;
  for (const auto& entry : fs::directory_iterator(dir_ / "first"))
    if (entry.path().extension() == ".exr") texture = entry.path();
  ASSERT_FALSE(texture.empty());
  const std::string before = read_file(texture), result = read_file(dir_ / "first" / "result.json");
  std::string again = read_file(dir_ / "compared.toml");
  again.insert(again.find("imagersize"), "texture = \"first/" + texture.filename().string() + "\"\n");
  write_file(dir_ / "again.toml", again);
  expect_refused(refined("again.toml"), 2,
                 {texture.filename().string(), "is an input of this run", "choose another folder"});
  EXPECT_EQ(read_file(texture), before);
  EXPECT_EQ(read_file(dir_ / "first" / "result.json"), result);
}

}  // namespace
}  // namespace fringetwin::testing::light_test
