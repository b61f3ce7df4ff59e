// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/small_twin.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace fringetwin::testing {
namespace {
using ::testing::HasSubstr;
namespace fs = std::filesystem;
}  // namespace

std::string small_twin(const std::vector<std::pair<std::string, std::string>>& replace,
                       const std::string& extra) {
  std::string text = R"(schema = "fringetwin-twin/1"
name = "small"
[[camera]]
name = "left"
lensmodel = "LENSMODEL_OPENCV4"
imagersize = [160, 120]
intrinsics = [260, 260, 79.5, 59.5, -0.1, 0.1, 0, 0]
rt_cam_world = [0, 0, 0, 0, 0, 0]
[camera.sensor]
gain_dn = 20
[projector]
lensmodel = "LENSMODEL_PINHOLE"
imagersize = [1280, 720]
intrinsics = [1700, 1700, 639.5, 359.5]
rt_cam_world = [0, 0.35, 0, -95, 0, 12]
intensity = 40
[fringes]
directions = ["x"]
pitches_px = [13, 14, 15]
steps = 4
[[object]]
name = "ball"
shape = "sphere"
center_mm = [0, 0, 270]
radius_mm = 19
[measure]
triangulate = "projector"
[[measure.fit]]
object = "ball"
)";
  for (const auto& [from, to] : replace) {
    const auto at = text.find(from);
    if (at == std::string::npos) throw std::runtime_error("no '" + from + "' in the twin");
    text.replace(at, from.size(), to);
  }
  return text + extra;
}

RunResult render_twin(const std::string& toml, const fs::path& dir) {
  write_file(dir / "twin.toml", toml);
  return run_fringetwin({"render", (dir / "twin.toml").string(), "--out", (dir / "out").string()});
}

void expect_refused(const RunResult& run, int exit_code, const std::vector<std::string>& parts) {
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  EXPECT_THAT(run.err, HasSubstr("fringetwin: error: "));
  for (const auto& part : parts) EXPECT_THAT(run.err, HasSubstr(part));
}

}  // namespace fringetwin::testing
