// SPDX-License-Identifier: Apache-2.0
// Studies of a baseline, on a rig whose poses come from a calibration: what a newcomer does with an imported
// twin.
//
// | check          | tolerance | unit | origin                                                    |
// |----------------|-----------|------|-----------------------------------------------------------|
// | radius         | 1e-6      | mm   | a pose written in metres and read again: 1e-13 of 100 mm; |
// |                |           |      | in single precision some pixels tip over                  |
// | mean of trials | 4 sigma   | mm   | of six draws, wrong once in 16,000                        |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "tests/support/program/study_folder.hpp"
#include "tests/support/twin/model_in_metres.hpp"
#include "twin/lens/baseline.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing::baseline_study_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const std::string kDrawnDevice = R"(lensmodel = "LENSMODEL_PINHOLE"
imagersize = [1280, 720]
intrinsics = [1700, 1700, 639.5, 359.5]
rt_cam_world = [0, 0.35, 0, -95, 0, 12]
)";

/// A study of the small twin whose projector is a .cameramodel file, as `import` and `calibrate` leave it.
fs::path imported_rig(const std::string& name, const std::string& study) {
  const fs::path dir = study_folder(name, study);
  const Twin drawn = load_twin(dir / "twin.toml");
  write_model_in_metres(dir / "projector.cameramodel", drawn.projector->lens, drawn.projector->T_proj_world);
  write_file(dir / "twin.toml", small_twin({{kDrawnDevice, "model = \"projector.cameramodel\"\n"}}));
  return dir;
}

double radius_of(const fs::path& run) {
  return read_json(run / "result.json")["fits"][0]["measured"]["radius_mm"];
}

TEST(BaselineStudy, OfAnImportedRigIsThatOfRigsBuiltSo) {
  FT_NEED_DEVICE();
  const fs::path dir = imported_rig("baseline_study", kSmallStudy + R"([[vary]]
key = "projector.baseline_mm"
values = [60, 130]
[[record]]
result = "fits.ball.measured.radius_mm"
name = "radius_mm"
)");
  ASSERT_EQ(run_study(dir).exit_code, 0);
  const std::string table = read_file(dir / "out" / "study.csv");
  const Twin twin = load_twin(dir / "twin.toml");
  for (const double baseline : {60.0, 130.0}) {
    // built so: the pose that the closed form says, written into a twin
    const auto pose = with_baseline(twin.cameras[0].T_cam_world, twin.projector->T_proj_world, baseline);
    const RotTrans rt = rt_from_pose(pose.value());
    const std::string alone = (dir / fmt::format("alone_{}.toml", baseline)).string(),
                      images = (dir / fmt::format("images_{}", baseline)).string();
    write_file(alone, small_twin({{"[0, 0.35, 0, -95, 0, 12]", fmt::format("[{}]", fmt::join(rt, ", "))}}));
    ASSERT_EQ(run_fringetwin({"render", alone, "--out", images}).exit_code, 0);
    ASSERT_EQ(run_fringetwin({"measure", alone, "--captures", images, "--out", images}).exit_code, 0);
    const auto row = table.find(fmt::format("\n{}", baseline == 60.0 ? 0 : 1));
    ASSERT_NE(row, std::string::npos) << table;
    const std::string line = table.substr(row + 1, table.find('\n', row + 1) - row - 1);
    EXPECT_NEAR(std::stod(line.substr(line.rfind(',') + 1)), radius_of(images), 1e-6) << line;
  }
}

/// Returns the first block of a page that is marked `toml`.
std::string toml_of_page(const fs::path& page) {
  const std::string text = read_file(page);
  const auto begin = text.find("```toml\n") + 8;
  return text.substr(begin, text.find("```", begin) - begin);
}

// The page's study runs on a rig from elsewhere: without the covariance that its calibration does not have,
// and with few trials.
TEST(BaselineStudy, ThePageOnADiametersUncertaintyIsTrue) {
  FT_NEED_DEVICE();
  const char* source = std::getenv("FRINGETWIN_SOURCE");
  ASSERT_NE(source, nullptr);
  std::string study = toml_of_page(fs::path(source) / "docs" / "UNCERTAINTY_OF_A_DIAMETER.md");
  const auto twin_line = study.find("twin = ");
  ASSERT_NE(twin_line, std::string::npos);
  study.insert(twin_line, "most_trials = 6\nblock_trials = 2\n");
  const fs::path dir = imported_rig("uncertainty_page", study);
  const RunResult run = run_study(dir);
  EXPECT_EQ(run.exit_code, 5) << run.err;  // 6 trials are too few
  const Twin twin = load_twin(dir / "twin.toml");
  const double middle_mm = baseline_mm(twin.cameras[0].T_cam_world, twin.projector->T_proj_world);
  std::istringstream lines(read_file(dir / "out" / "study.csv"));
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  ASSERT_THAT(line, ::testing::StartsWith("id,projector.baseline_mm,"));
  double sum_mm = 0.0;
  int trials = 0;
  for (; std::getline(lines, line); ++trials) sum_mm += std::stod(line.substr(line.find(',') + 1));
  EXPECT_EQ(trials, 6);
  EXPECT_NEAR(sum_mm / trials, middle_mm, 4.0 * 0.035 / std::sqrt(6.0));
}

}  // namespace
}  // namespace fringetwin::testing::baseline_study_test
