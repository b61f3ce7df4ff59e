// SPDX-License-Identifier: Apache-2.0
// A twin whose file states a pose in another way than rt_cam_world is, with refined values put in, the
// refined twin: no device is moved twice. tolerance: 1e-9 mm and 1e-12, a pose written as a rotation vector
// and read again.
#include <gtest/gtest.h>

#include <fstream>

#include "compare/refine/refine.hpp"
#include "tests/support/twin/model_in_metres.hpp"
#include "twin/merge/merge_into_twin.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare::refined_pose_test {
namespace {

/// A rig whose projector, with optical axes that do not meet, is a model or has its own lens; `pose`: what
/// else its table says.
std::filesystem::path rig(const std::string& name, bool is_model, const std::string& pose) {
  const auto folder = std::filesystem::temp_directory_path() / ("fringetwin_" + name);
  std::filesystem::create_directories(folder);
  const Pose T_proj_world = pose_from_rt((RotTrans() << -0.1, 0.35, 0.05, -120.0, 10.0, 30.0).finished());
  testing::write_model_in_metres(
      folder / "projector.cameramodel",
      Lens("LENSMODEL_PINHOLE", {1700, 1700, 639.5, 359.5}, {1280, 720}, "projector"), T_proj_world);
  const std::string own =
      "lensmodel = \"LENSMODEL_PINHOLE\"\nimagersize = [1280, 720]\nintrinsics = [1700, 1700, 639.5, "
      "359.5]\n";
  std::ofstream(folder / "twin.toml")
      << "schema = \"fringetwin-twin/1\"\n[[camera]]\nname = \"left\"\nlensmodel = \"LENSMODEL_PINHOLE\"\n"
         "imagersize = [160, 120]\nintrinsics = [260, 260, 79.5, 59.5]\n[projector]\n"
      << (is_model ? "model = \"projector.cameramodel\"\n" : own) << pose
      << "[fringes]\ndirections = [\"x\"]\npitches_px = [13, 14, 15]\nsteps = 4\n";
  return folder / "twin.toml";
}

void expect_the_same(const Twin& found, const Twin& expected, const std::string& what) {
  const Pose &a = found.projector->T_proj_world, &b = expected.projector->T_proj_world;
  EXPECT_LT((a.translation_mm - b.translation_mm).norm(), 1e-9) << what;
  EXPECT_TRUE(a.rotation.isApprox(b.rotation, 1e-12)) << what;
  EXPECT_EQ(found.projector->lens.intrinsics(), expected.projector->lens.intrinsics()) << what;
}

TEST(RefinedPose, PutIntoAFileIsThatOfTheRefinedTwin) {
  const std::string rt = "rt_cam_world = [-0.1, 0.35, 0.05, -120, 10, 30]\n",
                    looking = "position_mm = [110, 5, -20]\nlook_at_mm = [3, 4, 300]\n";
  int n = 0;
  for (const auto& [is_model, pose] : {std::pair<bool, std::string>{true, ""},
                                       {true, "angle_deg = 30\n"},
                                       {true, "baseline_mm = 150\n"},
                                       {false, rt},
                                       {false, rt + "angle_deg = 30\n"},
                                       {false, rt + "baseline_mm = 90\n"},
                                       {false, looking + "angle_deg = 40\n"}}) {
    for (const bool moves : {false, true}) {
      const auto file = rig("refined_pose_" + std::to_string(n++), is_model, pose);
      const Twin before = load_twin(file);
      Twin after = before;
      const Lens& lens = before.projector->lens;
      std::vector<double> intrinsics = lens.intrinsics();
      intrinsics[0] += 1.25, intrinsics[1] += 1.25;
      after.projector->lens = Lens(lens.model(), intrinsics, {lens.width(), lens.height()}, "refined");
      if (moves) after.projector->T_proj_world.translation_mm.x() += 0.75;
      merge_into_twin(file, refined_blocks(before, after));
      expect_the_same(load_twin(file), after, pose + (moves ? "moved" : "lens alone"));
    }
  }
}

}  // namespace
}  // namespace fringetwin::compare::refined_pose_test
