// SPDX-License-Identifier: Apache-2.0
// `needs` and `pareto` as a user runs them, on a small scene whose answers are known.
//
// clang-format off
// | tolerance                       | unit   | origin                                                                |
// | ambient light: 0.002            | DN     | gain x ambient = 1 DN wherever an object fills the pixel, fp32        |
// | ambient light: 1e-5             | rad    | a constant has no phase: fp32                                         |
// | sensor rounding: 15 %           | DN rms | 1/sqrt(12) DN for values spread over many levels; shadows are not     |
// | projector blur: 1 %             | DN rms | contrast 1 - exp(-2 (pi sigma/pitch)^2); mean over the phases         |
// | gauss 4, interior: 1e-4         | rad    | the renderer's own target                                             |
// clang-format on
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::study_test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

/// The small twin with coarse fringes and a wall behind its ball; `projector` and `end` add lines.
std::string small_scene(const std::string& projector, const std::string& end = "") {
  return small_twin({{"\"small\"", "\"small scene\""},
                     {"intensity = 40\n", "intensity = 40\n" + projector},
                     {"pitches_px = [13, 14, 15]\nsteps = 4\n",
                      "pitches_px = [104, 112, 120]\nsteps = 4\nunwrap = \"heterodyne\"\n"},
                     {"[measure]\n", R"([[object]]
name = "wall"
shape = "plane"
point_mm = [0, 0, 320]
normal = [0, 0, -1]
[measure]
)"},
                     {"[[measure.fit]]\nobject = \"ball\"\n", end}});
}

struct Studied {
  RunResult run;
  fs::path out;
};
Studied study(const std::string& command, const std::string& toml,
              const std::vector<std::string>& more = {}) {
  const fs::path dir = scratch_folder("study-" + command);
  write_file(dir / "twin.toml", toml);
  std::vector<std::string> args{command, (dir / "twin.toml").string(), "--out", (dir / "out").string()};
  args.insert(args.end(), more.begin(), more.end());
  return {run_fringetwin(args), dir / "out"};
}

json row(const json& needs, const std::string& name) {
  for (const json& r : needs["effects"])
    if (r["name"] == name) return r;
  ADD_FAILURE() << "no effect \"" << name << "\"";
  return {};
}

TEST(Needs, KnownChangesAndTheSmallestModel) {
  FT_NEED_DEVICE();
  const std::string scene =
      small_scene("ambient = 0.05\nblur_px = 8.0\n", "[[measure.fit]]\nobject = \"ball\"\n");
  const auto [run, out] = study("needs", scene,
                                {"--rounds", "1", "--phase-tolerance", "0.001", "--gray-tolerance", "1.4",
                                 "--fit-tolerance", "0.1", "--windows", "16"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("ambient light"));
  EXPECT_THAT(read_file(out / "needs.html"), HasSubstr("<svg"));
  const json needs = read_json(out / "needs.json");
  EXPECT_EQ(needs["schema"].get<std::string>(), "fringetwin-needs/1");

  const json ambient = row(needs, "ambient light");
  EXPECT_NEAR(ambient["change"]["gray_interior_rms_dn"].get<double>(), 1.0, 0.002);
  EXPECT_LT(ambient["change"]["phase_interior_rms_rad"].get<double>(), 1e-5);
  EXPECT_GT(ambient["cost"].get<double>(), 0.0);
  EXPECT_NEAR(row(needs, "sensor rounding")["change"]["gray_rms_dn"].get<double>(), 1.0 / std::sqrt(12.0),
              0.15 / std::sqrt(12.0));
  const json shadow = row(needs, "shadow");
  EXPECT_EQ(shadow["state"].get<std::string>(), "on");
  EXPECT_GT(shadow["change"]["gray_rms_dn"].get<double>(), 1.4);
  EXPECT_EQ(shadow["recommendation"].get<std::string>(), "keep");
  EXPECT_EQ(ambient["recommendation"].get<std::string>(), "leave off");
  for (const char* off : {"depth of field", "specular lobe", "projector falloff", "projector response"}) {
    EXPECT_EQ(row(needs, off)["state"], "off");
    EXPECT_FALSE(row(needs, off).contains("change")) << "nothing is invented for " << off;
  }
  // what was left off stays within the tolerance as a whole
  EXPECT_LE(needs["smallest_model"]["change"]["gray_rms_dn"].get<double>(), 1.4);
  EXPECT_LE(needs["smallest_model"]["change"]["phase_rms_rad"].get<double>(), 0.001);
  EXPECT_LT(needs["renderer_error"]["phase_interior_rms_rad"].get<double>(), 1e-4);
}

// A frontal wall alone: the blur lowers the contrast of every pitch by a known factor.
TEST(Needs, BlurChangesTheGrayLevelsAsItsAttenuationSays) {
  FT_NEED_DEVICE();
  std::string scene = small_scene("blur_px = 12.0\n");
  scene.erase(scene.find("[[object]]"), scene.find("[[object]]\nname = \"wall\"") - scene.find("[[object]]"));
  const std::vector<std::string> quickly{"--rounds", "1", "--windows", "16"};
  const auto [run, out] = study("needs", scene, quickly);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("before a fit")) << "no fit is asked for, and the user is told";
  const json needs = read_json(out / "needs.json");
  const json blur = row(needs, "projector blur")["change"];
  // rms over phases and pitches of (1 - attenuation) amplitude cos, relative to the largest: the amplitude in
  // DN follows from the pixel-area row, so only the ratio of two blurs is compared here
  const auto lost = [](double sigma) {
    double sum = 0.0;
    for (const double pitch : {104.0, 112.0, 120.0})
      sum += std::pow(1.0 - std::exp(-2.0 * std::pow(M_PI * sigma / pitch, 2)), 2);
    return std::sqrt(sum);
  };
  const std::string other = std::string(scene).replace(scene.find("blur_px = 12.0"), 14, "blur_px = 6.0");
  const auto [run2, out2] = study("needs", other, quickly);
  ASSERT_EQ(run2.exit_code, 0) << run2.err;
  const json blur2 = row(read_json(out2 / "needs.json"), "projector blur")["change"];
  EXPECT_NEAR(blur["gray_interior_rms_dn"].get<double>() / blur2["gray_interior_rms_dn"].get<double>() /
                  (lost(12.0) / lost(6.0)),
              1.0, 0.01);
  EXPECT_LT(blur["phase_interior_rms_rad"].get<double>(), 1e-5);
  EXPECT_TRUE(needs["smallest_model"]["change"]["fit_mm"].is_null());
}

TEST(Pareto, ErrorsFallAndTheDefaultIsMarked) {
  FT_NEED_DEVICE();
  const auto [run, out] =
      study("pareto", small_scene("", "[[measure.fit]]\nobject = \"wall\"\n"), {"--quick"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("DEFAULT"));
  EXPECT_THAT(read_file(out / "pareto.html"), HasSubstr("Pareto front"));
  const json pareto = read_json(out / "pareto.json");
  EXPECT_EQ(pareto["schema"].get<std::string>(), "fringetwin-pareto/1");
  int n_default = 0, n_front = 0;
  double gauss1 = 0.0, gauss4 = 1.0, mj16 = 1.0, mj64 = 1.0;
  for (const json& p : pareto["points"]) {
    n_default += p["default"].get<bool>();
    n_front += p["phase_front"].get<bool>();
    EXPECT_GT(p["frame_ms"].get<double>(), 0.0);
    EXPECT_GT(p["error"]["n_interior"].get<int>(), 300);
    if (p["precision"] != "fp32") continue;
    const double rad = p["error"]["phase_interior_rms_rad"].get<double>();
    if (p["scheme"] == "gauss" && p["samples"] == 1) gauss1 = rad;
    if (p["scheme"] == "gauss" && p["samples"] == 4) gauss4 = rad;
    if (p["scheme"] == "multi-jittered" && p["samples"] == 16) mj16 = rad;
    if (p["scheme"] == "multi-jittered" && p["samples"] == 64) mj64 = rad;
  }
  EXPECT_EQ(n_default, 1);
  EXPECT_GE(n_front, 1);
  EXPECT_LT(gauss4, 1e-4);
  EXPECT_LT(gauss4, gauss1);
  EXPECT_LT(mj64, mj16);
}

TEST(Studies, RefuseWhatTheyCannotRender) {
  std::string no_projector = small_scene("");
  const auto from = no_projector.find("[projector]"), to = no_projector.find("[fringes]");
  no_projector.erase(from, to - from);
  no_projector.erase(no_projector.find("triangulate = \"projector\"\n"), 26);
  FT_NEED_DEVICE();
  for (const char* command : {"needs", "pareto"}) {
    const auto [run, out] = study(command, no_projector);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_THAT(run.err, HasSubstr("[projector]"));
    EXPECT_FALSE(fs::exists(out / (std::string(command) + ".json")));
  }
  EXPECT_EQ(study("needs", small_scene(""), {"--gray-tolerance", "-1"}).run.exit_code, 2);
}

// Ctrl-C in the middle of a long study: exit code 130, no file that looks complete.
TEST(Studies, CtrlCLeavesNothingThatLooksComplete) {
  FT_NEED_DEVICE();
  const fs::path out = scratch_folder("study-cancelled"), err = out / "err";
  // interrupted as soon as the work has begun, however slow the machine is
  const std::string script = R"("$FRINGETWIN_BINARY" pareto "$TWIN" --out "$OUT" >/dev/null 2>"$ERR" & pid=$!
for i in $(seq 600); do grep -q pixels: "$ERR" && break; sleep 0.1; done
kill -INT $pid; wait $pid)";
  const std::string command = "TWIN='" + dataset_twin("paper-sphere").string() + "' OUT='" +
                              (out / "out").string() + "' ERR='" + err.string() + "' sh -c '" + script + "'";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 130) << read_file(err);
  EXPECT_THAT(read_file(err), HasSubstr("cancelled"));
  EXPECT_FALSE(fs::exists(out / "out" / "pareto.json"));
  EXPECT_FALSE(fs::exists(out / "out" / "pareto.html"));
}

}  // namespace
}  // namespace fringetwin::testing::study_test
