// SPDX-License-Identifier: Apache-2.0
// twin.toml: numbers of absurd size, names that cannot become file names, misspelt required keys. No
// tolerances: sentences and line numbers are compared exactly.
#include "tests/support/twin/twin_file_fixture.hpp"
#include "twin/file/cameramodel.hpp"

namespace fringetwin::testing::twin_file_limits_test {
namespace {
using ::testing::AllOf;
using ::testing::HasSubstr;

using TwinFileLimits = TwinFile;

TEST_F(TwinFileLimits, GrayCodeWithoutItsUnwrappingAddsNoImages) {
  const std::string gray = "[fringes.gray]\nbits = 6\nthreshold = \"white-black\"\n";
  ::testing::internal::CaptureStderr();
  const Twin twin = load(kMinimal + gray);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("has no effect without unwrap = \"gray\""));
  EXPECT_EQ(expand_sequence(twin.fringes).size(), 12u);
  EXPECT_FALSE(needs_white_black(twin.fringes));
}

TEST_F(TwinFileLimits, NumbersThatFloatCannotHold) {
  const std::string all =
      kHead + kCamera + kSensor + kOptics + kProjector + kFringes + kBall +
      "[object.material]\nspecular = 0.5\nshininess = 20\n[render]\nphase_error_rad = 1e-4\n";
  load(all);
  const struct {
    const char *key, *value, *says;
  } cases[] = {{"intensity", "1e300", "projector.intensity must be at most 1000000000, is 1e+300"},
               {"intensity", "1e-300", "projector.intensity must be at least 1e-09, is 1e-300"},
               {"ambient", "1e300", "must be at most"},
               {"reference_distance_mm", "1e300", "must be at most"},
               {"blur_px", "1e8", "must be at most 10000"},
               {"gain_dn", "1e300", "must be at most"},
               {"electrons_per_dn", "1e-300", "must be at least"},
               {"read_noise_dn", "1e300", "must be at most"},
               {"focal_length_mm", "1e-300", "must be at least"},
               {"pitches_px", "[13, 14, 1e-300]", "pitches_px[2] must be at least 0.001, is 1e-300"},
               {"pitches_px", "[13, 14, 1e300]", "pitches_px[2] must be at most"},
               {"center_mm", "[0, 0, -1e300]", "center_mm[2] must be at least -1000000000, is -1e+300"},
               {"radius_mm", "1e300", "must be at most"},
               {"specular", "1e300", "must be at most"},
               {"shininess", "1e300", "must be at most"},
               {"phase_error_rad", "1e-12", "render.phase_error_rad must be at least 1e-08, is 1e-12"},
               {"phase_error_rad", "10", "must be at most 1, is 10"},
               {"imagersize", "[100000, 480]", "must be >= 1 and <= 65535, is 100000"},
               {"rt_cam_world", "[0, 0, 0, 0, 0, 1e300]", "rt_cam_world[5] must be at most"},
               {"intrinsics", "[600, 600, 320, 240, 1e300, 0, 0, 0]", "must be at most"}};
  for (const auto& c : cases) {
    const std::string line = fmt::format("{} = {}", c.key, c.value);
    EXPECT_THAT(error(with(all, c.key, line), line), HasSubstr(c.says)) << line;
  }
  EXPECT_THAT(any_error(with(all, "imagersize", "imagersize = [60000, 60000]")),
              HasSubstr("imagersize must be at most 2e+08 pixels in all, is 60000 x 60000 px"));
  EXPECT_THAT(any_error(with(all, "intrinsics", "intrinsics = [1e-5, 600, 320, 240, 0, 0, 0, 0]")),
              HasSubstr("focal lengths must be at least 0.001"));
}

TEST_F(TwinFileLimits, CountsThatMultiply) {
  std::string pitches = "13", names, balls;
  for (int i = 0; i < 20; ++i) pitches += fmt::format(", {}", i + 14);
  const std::string fringes = "[fringes]\ndirections = [\"x\"]\nsteps = 1000\nunwrap = \"none\"\n";
  EXPECT_THAT(any_error(kHead + kCamera + fringes + "pitches_px = [" + pitches + "]\n"),
              HasSubstr("sequence of 21000 images, at most 10000 are possible"));
  for (int i = 0; i < 9000; ++i) names += "\"a.png\", ";
  EXPECT_THAT(any_error(kHead + kCamera + kProjector + kFringes + "images = [" + names + "]\n"),
              HasSubstr("images have 2.8e+09 pixels in all, at most 1e+09 are read"));
  for (int i = 0; i < 1001; ++i) balls += kBall;
  EXPECT_THAT(any_error(kMinimal + balls),
              HasSubstr("object is given 1001 times, at most 1000 are possible"));
}

TEST_F(TwinFileLimits, ATranslationInAFileOfTheWrongUnit) {
  CameraModelFile model;
  model.lensmodel = "LENSMODEL_PINHOLE";
  model.intrinsics = {600, 600, 319.5, 239.5};
  model.imagersize = {640, 480};
  model.rt_cam_ref = {0, 0, 0, 0, 0, 1e7};
  write_cameramodel(folder_ / "left.cameramodel", model);
  try {
    load(kHead + "[[camera]]\nname = \"left\"\nmodel = \"left.cameramodel\"\n" + kFringes);
    FAIL();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input);
    EXPECT_THAT(e.what(), AllOf(HasSubstr("left.cameramodel: has a translation above 1e9 mm"),
                                HasSubstr("cameramodel_unit")));
  }
}

TEST_F(TwinFileLimits, ADirectionMayHaveAnyLength) {
  const auto plane = [](const std::string& normal) {
    return kMinimal +
           "[[object]]\nname = \"wall\"\nshape = \"plane\"\npoint_mm = [0, 0, 300]\nnormal = " + normal +
           "\n";
  };
  for (const char* normal : {"[0, 0, 1e200]", "[0, 0, 1e-200]", "[0, 0, 1]"})
    EXPECT_EQ(std::get<PlaneShape>(load(plane(normal)).objects[0].shape).normal, Eigen::Vector3d(0, 0, 1))
        << normal;
  EXPECT_THAT(error(plane("[0, 0, 0]"), "normal"), HasSubstr("must not be [0, 0, 0]"));
}

TEST_F(TwinFileLimits, NamesBecomeFileNames) {
  for (const char* name : {"a/b", "../../etc", ".x", "50%", "a\\\\b"}) {
    const std::string line = fmt::format("name = \"{}\"", name);
    EXPECT_THAT(error(kMinimal + with(kBall, "name", line), line), HasSubstr("object[0].name \"")) << name;
    EXPECT_THAT(error(kHead + with(kCamera, "name", line) + kFringes, line),
                AllOf(HasSubstr("camera[0].name \""), HasSubstr("cannot become part of a file name"),
                      HasSubstr("use letters, digits")))
        << name;
  }
  load(kMinimal + with(kBall, "name", "name = \"ball No. 2\""));
}

TEST_F(TwinFileLimits, MisspeltRequiredKeysAreNamed) {
  EXPECT_THAT(
      error(kMinimal + "[[object]]\nname = \"o\"\nshpae = \"sphere\"\ncenter_mm = [0, 0, 1]\nradius_mm = 1\n",
            "shpae"),
      AllOf(HasSubstr("unknown key \"shpae\""), HasSubstr("did you mean \"shape\"?")));
  EXPECT_THAT(error("shema = \"fringetwin-twin/1\"\n" + kCamera + kFringes, "shema"),
              AllOf(HasSubstr("unknown key \"shema\""), HasSubstr("did you mean \"schema\"?")));
}

TEST_F(TwinFileLimits, TheCapturesVariableMayHoldItself) {
  ASSERT_EQ(::setenv("FRINGETWIN_CAPTURES", "/x/${FRINGETWIN_CAPTURES}", 1), 0);
  const Twin twin = load(kMinimal + "[real]\ncaptures = \"${FRINGETWIN_CAPTURES}/set\"\n");
  ::unsetenv("FRINGETWIN_CAPTURES");
  EXPECT_EQ(twin.real.captures, "/x/${FRINGETWIN_CAPTURES}/set");
}

}  // namespace
}  // namespace fringetwin::testing::twin_file_limits_test
