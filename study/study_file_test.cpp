// SPDX-License-Identifier: Apache-2.0
#include "study/study_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "study/kind/check_study.hpp"
#include "tests/support/twin/child_process.hpp"
#include "tests/support/twin/twin_file_fixture.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::study_file_test {
namespace {
using namespace fringetwin::study;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kHeadLines = "schema = \"fringetwin-study/1\"\ntwin = \"rig/twin.toml\"\n";
const std::string kDepth =
    "[[vary]]\nkeys = [\"camera.left.sensor.bit_depth\", \"camera.right.sensor.bit_depth\"]\nvalues = [8, "
    "10, 12]\n";
const std::string kPitch = "[[vary]]\nkey = \"fringes.phase_origin_px\"\nrange = [1, 100]\n";

const DesignPlan& design_of(const StudyFile& study) { return std::get<DesignPlan>(study.plan); }

class StudyFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "rig");
    write_twin(kHead + kCamera + kRight + kProjector + kFringes + kBall);
  }
  void write_twin(const std::string& text) const { folder_.write("rig/twin.toml", text); }
  StudyFile load(const std::string& text) const { return load_study(folder_.write("study.toml", text)); }
  StudyIdentity check(const std::string& text) const {
    const StudyFile study = load(text);
    return check_study(study.head, design_points(design_of(study)));
  }
  /// The sentence of the error, which names the file.
  std::string error(const std::string& text) const {
    try {
      check(text);
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::usage);
      EXPECT_THAT(e.what(), HasSubstr(folder_.path().string()));
      return e.what();
    }
    ADD_FAILURE() << "no UserError for\n" << text;
    return "";
  }
  testing::ScratchFolder folder_;
};

TEST_F(StudyFileTest, CountsThatMultiply) {
  std::string keys;
  for (int i = 0; i < 1001; ++i) keys += fmt::format("\"a{}\", ", i);
  EXPECT_THAT(
      error(kHeadLines + "[[vary]]\nkeys = [" + keys + "]\nvalues = [1]\n"),
      HasSubstr("study.toml:4: vary[0].keys brings the study to 1001 keys, at most 1000 are possible"));
  std::string hundred;
  for (int i = 0; i < 100; ++i) hundred += fmt::format("\"a{}\", ", i);
  EXPECT_THAT(error(kHeadLines + "design = \"latin-hypercube\"\npoints = 1000000\n[[vary]]\nkeys = [" +
                    hundred + "]\nvalues = [1]\n"),
              HasSubstr("asks for 1000000 runs with 100 keys each, at most 1e+07 values are possible"));
  write_twin(kHead);  // took a second for each 10,000 points
  EXPECT_THAT(error(kHeadLines + "[[vary]]\nkey = \"fringes.mean\"\nrange = [0.3, 0.4]\ncount = 200000\n"),
              HasSubstr("twin.toml"));
  std::string parts;
  for (int i = 0; i < 100'000; ++i) parts += "a.";
  for (const std::string& text : {parts + "b = 1\n", "[[vary]]\nkey = \"" + parts + "b\"\nvalues = [1]\n"})
    EXPECT_THAT(error(kHeadLines + text), HasSubstr("more than 32 parts"));
}

TEST_F(StudyFileTest, EveryKey) {
  const StudyFile study =
      load(kHeadLines + "name = \"bit depth\"\ndesign = \"grid\"\nnoise_seeds = 4\nfirst_noise_seed = 5\n" +
           kDepth + kPitch + "count = 3\nscale = \"log\"\n" +
           "[[record]]\nresult = \"fits.ball.measured.radius_mm\"\nname = \"radius_mm\"\n"
           "[[record]]\nresult = \"fits.0.measured.rms_mm\"\n");
  const DesignPlan& design = design_of(study);
  EXPECT_EQ(study.head.name, "bit depth");
  EXPECT_EQ(study.head.twin, folder_ / "rig/twin.toml");
  EXPECT_EQ(study.head.file, folder_ / "study.toml");
  EXPECT_EQ(design.design, Design::grid);
  EXPECT_EQ(design.noise_seeds, 4);
  EXPECT_EQ(design.first_noise_seed, 5u);
  ASSERT_EQ(design.vary.size(), 2u);
  EXPECT_THAT(design.vary[0].keys,
              ElementsAre("camera.left.sensor.bit_depth", "camera.right.sensor.bit_depth"));
  EXPECT_THAT(design.vary[0].values, ElementsAre("8", "10", "12"));
  EXPECT_EQ(design.vary[1].range->count, 3);
  EXPECT_TRUE(design.vary[1].range->log);
  ASSERT_EQ(study.head.records.size(), 2u);
  EXPECT_EQ(study.head.records[0].result, "fits.ball.measured.radius_mm");
  EXPECT_EQ(study.head.records[0].name, "radius_mm");
  EXPECT_EQ(study.head.records[1].name, "fits.0.measured.rms_mm");
  EXPECT_EQ(design_points(design).size(), 3u * 3u * 4u);
  const StudyFile sobol = load(kHeadLines + "design = \"sobol\"\npoints = 64\nseed = 9\n" + kDepth + kPitch);
  EXPECT_EQ(design_of(sobol).design, Design::sobol);
  EXPECT_EQ(design_of(sobol).points, 64);
  EXPECT_EQ(design_of(sobol).seed, 9u);
  EXPECT_EQ(sobol.head.name, "study");
}

TEST_F(StudyFileTest, AFolderStandsForItsTwin) {
  const std::string schema = "schema = \"fringetwin-study/1\"\n";
  EXPECT_EQ(load(schema + "twin = \"rig\"\n" + kDepth).head.twin, folder_ / "rig/twin.toml");
  EXPECT_THAT(error(schema + "twin = \".\"\n" + kDepth), HasSubstr("is a folder without a twin.toml"));
  const auto digest = [&](const std::string& twin) {
    return check(schema + "twin = \"" + twin + "\"\n" + kDepth).digest();
  };
  EXPECT_EQ(digest("rig"), digest("rig/twin.toml")) << "the same study";
}

TEST_F(StudyFileTest, Faults) {
  const auto line = [&](int n) { return fmt::format("study.toml:{}: ", n); };
  EXPECT_THAT(error("schema = \"fringetwin-twin/1\"\n"), HasSubstr("must be \"fringetwin-study/1\""));
  EXPECT_THAT(error(kHeadLines + "desing = \"grid\"\n"), HasSubstr("did you mean \"design\"?"));
  EXPECT_THAT(error("schema = \"fringetwin-study/1\"\n" + kDepth), HasSubstr("twin is missing"));
  EXPECT_THAT(error(kHeadLines + "design = \"gird\"\n" + kDepth), HasSubstr("did you mean \"grid\"?"));
  EXPECT_THAT(error(kHeadLines + "design = \"sobol\"\n" + kDepth), HasSubstr("points is missing"));
  EXPECT_THAT(error(kHeadLines + "points = 8\n" + kDepth), HasSubstr(line(3) + "points has no effect"));
  EXPECT_THAT(error(kHeadLines + "[[vary]]\nkey = \"a\"\nvalues = []\n"),
              HasSubstr(line(5) + "vary[0].values is empty"));
  EXPECT_THAT(error(kHeadLines), HasSubstr("vary is missing: the design is empty"));
  EXPECT_THAT(error(kHeadLines + "design = \"sobol\"\npoints = 8\nnoise_seeds = 3\n"),
              HasSubstr("the design is empty"));
  EXPECT_THAT(error(kHeadLines + kPitch), HasSubstr("vary[0].count is missing"));
  EXPECT_THAT(error(kHeadLines + "design = \"sobol\"\npoints = 8\n" + kPitch + "count = 3\n"),
              HasSubstr("count has no effect"));
  EXPECT_THAT(error(kHeadLines + "[[vary]]\nkey = \"a\"\nrange = [2, 1]\ncount = 2\n"),
              HasSubstr("range must rise"));
  EXPECT_THAT(error(kHeadLines + "[[vary]]\nkey = \"a\"\nrange = [0, 1]\ncount = 2\nscale = \"log\"\n"),
              HasSubstr("range must be > 0"));
  EXPECT_THAT(error(kHeadLines + "[[vary]]\nkey = \"a\"\nvalues = [1]\nscale = \"log\"\n"),
              HasSubstr("without range"));
  EXPECT_THAT(error(kHeadLines + "[[vary]]\nvalues = [1]\n"), HasSubstr("needs either key or keys"));
  EXPECT_THAT(error(kHeadLines + "[[vary]]\nkey = \"a\"\n"), HasSubstr("needs either values, rows or range"));
  EXPECT_THAT(error(kHeadLines + "[[vary]]\nkeys = [\"a\", \"b\"]\nrows = [[1, 2], [3]]\n"),
              HasSubstr("vary[0].rows must hold arrays of 2, rows[1] has 1"));
  EXPECT_THAT(error(kHeadLines + "[[vary]]\nkey = \"a\"\nrows = [1]\n"), HasSubstr("must hold arrays"));
  EXPECT_THAT(error(kHeadLines + "[[vary]]\nkey = \"a\"\nrows = []\n"), HasSubstr("rows is empty"));
  EXPECT_THAT(error(kHeadLines + "[[vary]]\nkeys = []\nvalues = [1]\n"), HasSubstr("one key or more"));
  EXPECT_THAT(error(kHeadLines + kDepth + kDepth), HasSubstr("a second time"));
  EXPECT_THAT(error(kHeadLines + "design = \"list\"\n" + kDepth + kPitch + "count = 4\n"),
              HasSubstr("vary[1] has 4 values, the first [[vary]] has 3"));
  EXPECT_THAT(error(kHeadLines + "noise_seeds = 500000\n" + kDepth), HasSubstr("asks for 1500000 runs"));
  const std::string record = "[[record]]\nresult = \"fits.ball.n\"\n";
  EXPECT_THAT(error(kHeadLines + kDepth + record + record), HasSubstr("the name of another record"));
}

TEST_F(StudyFileTest, ExpectedValuesAreColumnsOfTheirOwn) {
  const StudyFile study = load(kHeadLines + kDepth +
                               "[[record]]\nresult = \"fits.ball.rms_mm\"\nname = \"rms\"\n"
                               "expected_mean = \"theory.ball.rms_mm\"\n");
  ASSERT_EQ(study.head.records.size(), 2u);
  EXPECT_EQ(study.head.records[1].result, "theory.ball.rms_mm");
  EXPECT_EQ(study.head.records[1].name, "rms.expected_mean");
}

TEST_F(StudyFileTest, PathsAndTwinsAreCheckedBeforeAnythingRuns) {
  const auto vary = [](const std::string& key, const std::string& values) {
    return kHeadLines + "[[vary]]\nkey = \"" + key + "\"\nvalues = " + values + "\n";
  };
  EXPECT_THAT(error(vary("camera.left.sensor.bit_dept", "[8]")),
              ::testing::AllOf(HasSubstr("camera.left.sensor.bit_dept = 8"),
                               HasSubstr("did you mean \"bit_depth\"?")));
  EXPECT_THAT(
      error(vary("limits.phase_rms", "[0.1]")),
      ::testing::AllOf(HasSubstr("limits.phase_rms = 0.1"), HasSubstr("did you mean \"phase_rms_rad\"?")));
  EXPECT_THAT(error(vary("camera.lft.psf_px", "[8]")), HasSubstr("did you mean \"left\"?"));
  EXPECT_THAT(error(vary("camera.left.sensor.bit_depth", "[7, 99]")), HasSubstr("must be 8 ... 16, is 7"))
      << "no point can be read";
  EXPECT_EQ(check(vary("camera.left.sensor.bit_depth", "[7, 8]")).inputs.size(), 1u) << "one point can";
  EXPECT_THAT(error("schema = \"fringetwin-study/1\"\ntwin = \"none.toml\"\n" + kDepth),
              HasSubstr("none.toml: no such file"));
}

TEST_F(StudyFileTest, IdentityIsWhatTheResultsComeFrom) {
  const StudyIdentity first = check(kHeadLines + kDepth);
  EXPECT_EQ(first.inputs.size(), 1u);
  EXPECT_EQ(check(kHeadLines + "name = \"other\" # a comment\n" + kDepth).digest(), first.digest());
  EXPECT_NE(check(kHeadLines + "noise_seeds = 2\n" + kDepth).digest(), first.digest());
  write_twin(kHead + kCamera + kRight + kProjector + kFringes + kBall + "# changed\n");
  const StudyIdentity second = check(kHeadLines + kDepth);
  EXPECT_EQ(second.study, first.study);
  EXPECT_NE(second.digest(), first.digest());
}

TEST_F(StudyFileTest, FilesNamedByPointsAreInputs) {
  write_twin(kMinimal + "[[object]]\nname = \"part\"\nshape = \"mesh\"\nfile = \"a.obj\"\n");
  for (const char* name : {"rig/a.obj", "rig/b.obj"})
    folder_.write(name, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const StudyIdentity identity = check(
      kHeadLines + "[[vary]]\nkey = \"object.part.file\"\nvalues = [\"a.obj\", \"b.obj\", \"none.obj\"]\n");
  EXPECT_EQ(identity.inputs.size(), 3u);
  EXPECT_TRUE(identity.inputs.contains((folder_ / "rig/b.obj").string()));
}

}  // namespace
}  // namespace fringetwin::testing::study_file_test
