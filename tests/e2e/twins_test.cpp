// SPDX-License-Identifier: Apache-2.0
// The shipped twins, end to end, against what was put in. README prints these figures
// (tests/house/readme_figures.txt).
//
// clang-format off
// | tolerance                          | value                       | origin                                              |
// | ideal plane / sphere, 8 bit        | 0.0008 / 0.00065 mm rms     | 1.4 times what is measured: 0.00056, 0.00046        |
// | ideal, float images                | 0.0001 mm rms               | pixel-average residual 0.00002 mm + matching + fp32 |
// | ideal sphere centre, radius, float | 0.001 mm                    | the pixel-square average shifts both by < 0.0005 mm |
// | Table 5: centre, radius, rms       | 0.00015, 0.00007, 0.0007 mm | 1.5 times what is measured: 0.00011, 0.00005, 0.00047 |
// | images of another renderer         | 4 sigma                     | four numbers, one seed: 1 in 4,000                  |
// | free-form                          | 0.00065 mm rms, 99.9 % < 10 um | 1.4 times what is measured: 0.00045, 100 %        |
// clang-format on
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::twins_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A page that can be mailed.
void expect_small_page(const fs::path& report) {
  ASSERT_TRUE(fs::exists(report));
  EXPECT_LE(fs::file_size(report), 8'000'000u);
}

json cosim(const std::string& dataset, int expected_exit = 0) {
  const fs::path out = scratch_folder("cosim-" + dataset);
  const RunResult run = run_fringetwin({"cosim", dataset_twin(dataset).string(), "--out", out.string()});
  EXPECT_EQ(run.exit_code, expected_exit) << run.err;
  expect_small_page(out / "report.html");
  return read_json(out / "result.json");
}

struct Fits {
  json eight_bit, radiance;
};

/// Renders with --radiance; the one fit to the points from the 8-bit images and from the float images.
Fits fits_of_both(const std::string& dataset) {
  const fs::path out = scratch_folder("both-" + dataset);
  const std::string twin = dataset_twin(dataset).string();
  const RunResult run = run_fringetwin({"render", twin, "--out", (out / "sim").string(), "--radiance"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto fit_to = [&](const fs::path& captures, const fs::path& to) {
    const RunResult measured =
        run_fringetwin({"measure", twin, "--captures", captures.string(), "--out", to.string()});
    EXPECT_EQ(measured.exit_code, 0) << measured.err;
    return read_json(to / "result.json")["fits"][0]["measured"];
  };
  return {fit_to(out / "sim", out / "m8"), fit_to(out / "sim" / "radiance", out / "mf")};
}

/// One run of the paper's sphere for all tests that read its results.
const fs::path& sphere_run() {
  static const fs::path out = [] {
    const fs::path folder = scratch_folder("cosim-paper-sphere");
    const RunResult run =
        run_fringetwin({"cosim", dataset_twin("paper-sphere").string(), "--out", folder.string()});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return folder;
  }();
  return out;
}

// POV-Ray's images of a true gain of 301.519 DN and a ball at (3, -2, 292):
// datasets/povray-ball-wall/make.py.
TEST(ForeignImages, TheGainIsFoundAndAMovedBallIsPutBack) {
  FT_NEED_DEVICE();
  const json right = cosim("povray-ball-wall");
  for (const char* quantity : {"gray", "phase", "geometry", "coverage"})
    EXPECT_EQ(right["budget_verdict"][quantity], "explained") << right["explained"].dump(1);
  const json& gain = right["gain"][0];
  EXPECT_NEAR(gain["gain_dn"].get<double>(), 301.519, 4.0 * gain["gain_sigma_dn"].get<double>());

  const fs::path out = scratch_folder("cosim-moved"), twin = dataset_twin("povray-ball-wall").parent_path();
  const RunResult run = run_fringetwin(
      {"cosim", (twin / "twin-moved.toml").string(), "--out", out.string(), "--refine", "pose"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const json refined = read_json(out / "result.json");
  EXPECT_EQ(refined["budget_verdict"]["gray"], "explained");
  const std::map<std::string, double> truth{
      {"ball.center_mm.x", 3.0}, {"ball.center_mm.y", -2.0}, {"ball.center_mm.z", 292.0}};
  std::size_t found = 0;
  for (const json& p : refined["refinement"]["parameters"])
    if (const auto at = truth.find(p["name"]); at != truth.end()) {
      EXPECT_NEAR(p["after"].get<double>(), at->second, 4.0 * p["after_sigma"].get<double>()) << p.dump();
      ++found;
    }
  EXPECT_EQ(found, truth.size());
}

// Three pitches, each predicted from the two others; what only a held-out image itself would tell is refused.
TEST(ForeignImages, PitchesArePredictedFromTheOthers) {
  FT_NEED_DEVICE();
  const fs::path out = scratch_folder("cosim-pitches");
  std::vector<std::string> args{"cosim",         dataset_twin("povray-ball-wall").string(),
                                "--out",         out.string(),
                                "--hold-out",    "3",
                                "--hold-out-by", "pitches"};
  const RunResult run = run_fringetwin(args);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json rows = read_json(out / "result.json")["held_out"];
  ASSERT_EQ(rows.size(), 12u);
  for (const json& row : rows)
    EXPECT_NEAR(row["ratio"].get<double>(), 1.0, 4.0 * row["ratio_sigma"].get<double>()) << row.dump();
  EXPECT_TRUE(fs::exists(out / ("held_out_" + rows[0]["camera"].get<std::string>() + ".png")));
  EXPECT_THAT(read_file(out / "report.html"), ::testing::HasSubstr("predicted worst"));
  args.insert(args.end(), {"--refine", "exposure"});
  const RunResult refused = run_fringetwin(args);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, ::testing::HasSubstr("single images"));
  const RunResult without_folds = run_fringetwin({"cosim", dataset_twin("povray-ball-wall").string(), "--out",
                                                  out.string(), "--hold-out-by", "pitches"});
  EXPECT_EQ(without_folds.exit_code, 2);
  EXPECT_THAT(without_folds.err, ::testing::HasSubstr("--hold-out K"));
}

TEST(PaperSphere, SimulatedColumnOfTable5) {
  FT_NEED_DEVICE();
  const json result = read_json(sphere_run() / "result.json");
  ASSERT_EQ(result["fits"].size(), 1u);
  const json& fit = result["fits"][0];
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_LE(std::abs(fit["difference"]["center_mm"][axis].get<double>()), 0.00015);
  EXPECT_LE(std::abs(fit["difference"]["radius_mm"].get<double>()), 0.00007);
  EXPECT_LE(fit["simulated"]["rms_mm"].get<double>(), 0.0007);
  EXPECT_DOUBLE_EQ(fit["real"]["rms_mm"].get<double>(), 0.013);
  EXPECT_GT(fit["simulated"]["n"].get<int>(), 20000);
  EXPECT_EQ(result["verdict"].get<std::string>(), "pass");
}

TEST(PaperSphere, TheBudgetOfTable5) {
  FT_NEED_DEVICE();
  const json result = read_json(sphere_run() / "result.json");
  const json& fit = result["fits"][0];
  EXPECT_TRUE(fit["z"]["radius_mm"].is_null());  // the paper states no uncertainty
  EXPECT_TRUE(fit["z"]["center_mm"].is_null());
  // The object is the published sphere: what is left is what rendering and measuring do, within 3 of what
  // 0.013 mm rms would leave to a fit of as many points.
  EXPECT_LE(std::abs(fit["z_estimated"]["radius_mm"].get<double>()), 3.0);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_LE(std::abs(fit["z_estimated"]["center_mm"][axis].get<double>()), 3.0);
  // 0.013 mm / sqrt(n) is the least that a radius could be known to; a cap makes it several times that.
  const double least_mm = 0.013 / std::sqrt(fit["simulated"]["n"].get<double>());
  const double sigma_mm = fit["real_estimated"]["radius_sigma_mm"].get<double>();
  EXPECT_GT(sigma_mm, least_mm);
  EXPECT_LT(sigma_mm, 10.0 * least_mm);
  ASSERT_EQ(result["explained"].size(), 1u);  // no real images: no gray values, no phase
  EXPECT_EQ(result["explained"][0]["budget"][1]["name"].get<std::string>(),
            "fit of the real points, estimated from the published rms");
  EXPECT_EQ(result["budget_verdict"]["geometry"].get<std::string>(), "explained");
  EXPECT_THAT(read_file(sphere_run() / "report.html"),
              ::testing::HasSubstr("z (σ of the real side estimated from its rms)"));
}

TEST(PaperSphere, ReportSaysThatTheObjectIsThePublishedResult) {
  FT_NEED_DEVICE();
  EXPECT_THAT(read_file(sphere_run() / "report.html"),
              ::testing::HasSubstr("IS the published result, so its place and size agree by construction"));
}

TEST(PaperSphere, NoiseThatMeetsThePhysicalRmse) {
  FT_NEED_DEVICE();
  const fs::path out = scratch_folder("noisy");
  const fs::path twin = dataset_twin("paper-sphere").parent_path() / "twin-noisy.toml";
  const RunResult run = run_fringetwin({"cosim", twin.string(), "--out", out.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  // 0.013 mm is printed to 1 um in Table 5.
  EXPECT_NEAR(read_json(out / "result.json")["fits"][0]["simulated"]["rms_mm"].get<double>(), 0.013, 0.0005);
}

TEST(IdealPlane, EightBitAndFloat) {
  FT_NEED_DEVICE();
  const json result = cosim("paper-ideal-plane");
  EXPECT_EQ(result["verdict"].get<std::string>(), "pass");  // its own limit is the published 0.0013 mm
  const json simulated = result["fits"][0]["simulated"];
  EXPECT_LE(simulated["rms_mm"].get<double>(), 0.0008);
  EXPECT_GT(simulated["n"].get<int>(), 100000);
  const auto [eight_bit, radiance] = fits_of_both("paper-ideal-plane");
  EXPECT_EQ(eight_bit["n"].get<int>(), simulated["n"].get<int>());  // `measure` sees what `cosim` saw
  EXPECT_LE(radiance["rms_mm"].get<double>(), 0.0001);
  EXPECT_GT(radiance["n"].get<int>(), 100000);
}

TEST(IdealSphere, EightBitAndFloat) {
  FT_NEED_DEVICE();
  const auto [eight_bit, radiance] = fits_of_both("paper-ideal-sphere");
  EXPECT_LE(eight_bit["rms_mm"].get<double>(), 0.00065);
  EXPECT_GT(eight_bit["n"].get<int>(), 2000);
  EXPECT_LE(radiance["rms_mm"].get<double>(), 0.0001);
  const double truth[3] = {0, 0, 250};
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(radiance["center_mm"][axis].get<double>(), truth[axis], 0.001);
  EXPECT_NEAR(radiance["radius_mm"].get<double>(), 5.0, 0.001);
}

TEST(Freeform, RegistersToItsCad) {
  FT_NEED_DEVICE();
  const json fit = cosim("paper-freeform")["fits"][0]["simulated"];
  EXPECT_LE(fit["rms_mm"].get<double>(), 0.00065);
  EXPECT_GE(fit["within_10um"].get<double>(), 0.999);
  EXPECT_GT(fit["n"].get<int>(), 50000);
}

TEST(Determinism, SameSeedSameBytes) {
  FT_NEED_DEVICE();
  const fs::path a = scratch_folder("det-a"), b = scratch_folder("det-b"), c = scratch_folder("det-c");
  const fs::path twin_file = scratch_folder("det") / "twin.toml";
  write_file(twin_file, small_twin({{"[projector]", R"([[camera]]
name = "right"
lensmodel = "LENSMODEL_OPENCV4"
imagersize = [160, 120]
intrinsics = [260, 260, 79.5, 59.5, -0.1, 0.1, 0, 0]
rt_cam_world = [0, -0.3, 0, -80, 0, 10]
[camera.sensor]
gain_dn = 20
electrons_per_dn = 40
[projector])"}}));
  const std::string twin = twin_file.string();
  for (const auto& [dir, seed] : {std::pair{a, "7"}, std::pair{b, "7"}, std::pair{c, "8"}}) {
    const RunResult run = run_fringetwin({"render", twin, "--out", dir.string(), "--seed", seed, "--sampler",
                                          "multi-jittered", "--samples", "4", "--radiance"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  bool other_seed_differs = false;
  int compared = 0;
  for (const auto& entry : fs::recursive_directory_iterator(a)) {
    if (!entry.is_regular_file() || entry.path().extension() == ".toml") continue;
    const fs::path name = fs::relative(entry.path(), a);
    EXPECT_EQ(read_file(entry.path()), read_file(b / name)) << name;
    other_seed_differs = other_seed_differs || read_file(entry.path()) != read_file(c / name);
    ++compared;
  }
  EXPECT_EQ(compared, 2 * 12 * 2);
  EXPECT_TRUE(other_seed_differs);
}

TEST(Bunny, RendersAndRegisters) {
  FT_NEED_DEVICE();
  FT_NEED_CAPTURES("mesh-stanford-bunny");
  const json fit = cosim("bunny")["fits"][0]["simulated"];
  EXPECT_GT(fit["n"].get<int>(), 50000);
  EXPECT_LE(fit["rms_mm"].get<double>(),
            0.05);  // facets of 1-2 mm and self-shadowed folds: looked at, see docs
}

TEST(Diff, OfARunWithItselfIsZero) {
  FT_NEED_DEVICE();
  const std::string out = sphere_run().string();
  const RunResult run = run_fringetwin({"diff", out, out});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  // "name  A  B  B - A  z": every difference is 0, every z is 0 or unknown
  std::istringstream lines(run.out);
  int compared = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto name_end = line.find("  ");
    if (!line.starts_with("fit ") && !line.starts_with("phase ") && !line.starts_with("gray ")) continue;
    ASSERT_NE(name_end, std::string::npos) << line;
    std::istringstream fields(line.substr(name_end));
    std::string a, b, difference, z;
    fields >> a >> b >> difference >> z;
    EXPECT_EQ(a, b) << line;
    EXPECT_EQ(difference, "0") << line;
    EXPECT_TRUE(z == "0.00" || z == "-") << line;
    ++compared;
  }
  EXPECT_GE(compared, 10);  // centre, radius, rms ... of the sphere on each side and their differences
  EXPECT_THAT(run.out, ::testing::HasSubstr("fit sphere simulated radius_mm"));
  EXPECT_THAT(run.out, ::testing::Not(::testing::HasSubstr("only in")));
}

/// result.json without what may differ between two runs of one command: wall times.
json without_times(const fs::path& file) {
  json result = read_json(file);
  result.erase("timing_s");
  return result;
}

TEST(Determinism, CosimAndMeasureWriteTheSameResult) {
  FT_NEED_DEVICE();
  const fs::path out = scratch_folder("det-result");
  const std::string twin = dataset_twin("paper-ideal-sphere").string();
  const auto run_all = [&] {
    RunResult run = run_fringetwin({"cosim", twin, "--out", (out / "c").string(), "--seed", "3"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    run = run_fringetwin(
        {"measure", twin, "--captures", (out / "c" / "simulated").string(), "--out", (out / "m").string()});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return std::array{without_times(out / "c" / "result.json"), without_times(out / "m" / "result.json")};
  };
  const auto read_files = [&] {
    std::map<std::string, std::string> bytes;
    for (const auto& entry : fs::recursive_directory_iterator(out))
      if (entry.is_regular_file() && entry.path().extension() != ".json" &&
          entry.path().extension() != ".html")
        bytes[fs::relative(entry.path(), out).string()] = read_file(entry.path());
    return bytes;
  };
  const auto first = run_all();
  const auto first_files = read_files();
  const auto second = run_all();
  EXPECT_EQ(first[0].dump(), second[0].dump());
  EXPECT_EQ(first[1].dump(), second[1].dump());
  EXPECT_EQ(first_files, read_files());  // points.ply, phase_*.exr, images, maps
  EXPECT_GT(first_files.size(), 30u);
}

TEST(NoConvergence, IsExitCode5) {
  FT_NEED_DEVICE();
  // A plane is rendered and measured; the fit is asked for a sphere that touches it.
  const fs::path dir = scratch_folder("no-convergence");
  const std::string ball = "shape = \"sphere\"\ncenter_mm = [0, 0, 270]\nradius_mm = 19\n";
  write_file(dir / "wall.toml",
             small_twin({{ball, "shape = \"plane\"\npoint_mm = [0, 0, 270]\nnormal = [0, 0, -1]\n"}}));
  RunResult run = run_fringetwin({"render", (dir / "wall.toml").string(), "--out", (dir / "sim").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  write_file(dir / "ball.toml",
             small_twin({{ball, "shape = \"sphere\"\ncenter_mm = [0, 0, 1270]\nradius_mm = 1000\n"}}));
  run = run_fringetwin({"measure", (dir / "ball.toml").string(), "--captures", (dir / "sim").string(),
                        "--out", (dir / "m").string()});
  EXPECT_EQ(run.exit_code, 5) << run.err;
  EXPECT_THAT(run.err, ::testing::HasSubstr("did not converge"));
  const json fit = read_json(dir / "m" / "result.json")["fits"][0]["measured"];
  EXPECT_GT(fit["n"].get<int>(), 20);
  EXPECT_TRUE(fit["radius_mm"].is_null());
}

TEST(CosimAgainstOwnRender, VerdictPassAndGainRecovered) {
  FT_NEED_DEVICE();
  // The twin's own noisy render plays the rig: gain and geometry must come back.
  const fs::path dir = scratch_folder("self");
  std::string toml = read_file(dataset_twin("paper-ideal-sphere"));
  toml += "\n[real]\ncaptures = \"real\"\n";
  const auto at = toml.find("gain_dn = 22.0");
  ASSERT_NE(at, std::string::npos);
  std::string rig = toml;
  rig.replace(at, 14, "gain_dn = 20.5\nblack_level_dn = 3\nelectrons_per_dn = 40\nread_noise_dn = 0.3");
  write_file(dir / "rig.toml", rig);
  write_file(dir / "twin.toml", toml);
  RunResult run = run_fringetwin(
      {"render", (dir / "rig.toml").string(), "--out", (dir / "real").string(), "--seed", "5"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  run = run_fringetwin({"cosim", (dir / "twin.toml").string(), "--out", (dir / "out").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const json result = read_json(dir / "out" / "result.json");
  EXPECT_EQ(result["verdict"].get<std::string>(), "pass");
  // Geometry: the two sides see one sphere; noise on one of them. 5 standard errors of the difference, and an
  // absolute bound from the noise: 0.002 mm.
  const json& fit = result["fits"][0];
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(std::abs(fit["z"]["center_mm"][axis].get<double>()), 5.0);
    EXPECT_LE(std::abs(fit["difference"]["center_mm"][axis].get<double>()), 0.002);
  }
  EXPECT_LE(std::abs(fit["z"]["radius_mm"].get<double>()), 5.0);
  EXPECT_LE(std::abs(fit["difference"]["radius_mm"].get<double>()), 0.002);
  for (const json& phase : result["phase"]) {
    EXPECT_EQ(phase["n_order_disagree"].get<int>(), 0);
    EXPECT_LE(std::abs(phase["mean_rad"].get<double>()), 1e-3);
  }
  ASSERT_EQ(result["gain"].size(), 2u);
  // 5 standard errors: 1 in 2 million per test; only the left camera's gain differs from the twin's.
  EXPECT_NEAR(result["gain"][0]["gain_dn"].get<double>(), 20.5,
              5 * result["gain"][0]["gain_sigma_dn"].get<double>());
  EXPECT_NEAR(result["gain"][1]["gain_dn"].get<double>(), 22.0,
              5 * result["gain"][1]["gain_sigma_dn"].get<double>());
  EXPECT_LT(result["gain"][0]["rms_after_dn"].get<double>(),
            result["gain"][0]["rms_before_dn"].get<double>());
}

}  // namespace
}  // namespace fringetwin::testing::twins_test
