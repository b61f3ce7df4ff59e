// SPDX-License-Identifier: Apache-2.0
// What a calibrated twin takes over from the rough one. No tolerances: texts are compared.
#include "twin/file/toml_kept.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::toml_kept_test {
namespace {

using ::testing::HasSubstr;
using testing::ScratchFolder;

TEST(KeptTables, FringesSensorsAndLight) {
  const ScratchFolder scratch;
  const auto file = scratch.write("twin.toml", R"([[camera]]
name = "left"
intrinsics = [1, 2, 3, 4]
[camera.sensor]
bit_depth = 12
prnu = "maps/prnu.exr"
[[camera]]
name = "right"
[projector]
intensity = 700
blur_px = 0.8
[fringes]
directions = ["x", "y"]
images = ["a.png", "/b.png"]
[fringes.y]
pitches_px = [16.5]
)");
  const KeptTables kept = kept_tables(file);
  EXPECT_THAT(kept.fringes, HasSubstr("directions = [\"x\", \"y\"]\n"));
  EXPECT_THAT(kept.fringes, HasSubstr("images = [\"" + (scratch / "a.png").string() + "\", \"/b.png\"]\n"));
  EXPECT_THAT(kept.fringes, HasSubstr("y = { \"pitches_px\" = [16.5] }\n"));
  EXPECT_EQ(kept.projector, "intensity = 700\n");
  ASSERT_EQ(kept.of_camera.size(), 1u);
  EXPECT_EQ(kept.of_camera.at("left"),
            "sensor = { \"bit_depth\" = 12, \"prnu\" = \"" + (scratch / "maps/prnu.exr").string() + "\" }\n");
}

TEST(KeptTables, NothingWhereNothingIsStated) {
  const ScratchFolder scratch;
  const KeptTables kept = kept_tables(scratch.write("twin.toml", "name = \"a\"\n"));
  EXPECT_EQ(kept.fringes + kept.projector, "");
  EXPECT_TRUE(kept.of_camera.empty());
  EXPECT_THROW(kept_tables(scratch / "none.toml"), UserError);
}

}  // namespace
}  // namespace fringetwin::toml_kept_test
