// SPDX-License-Identifier: Apache-2.0
// Every fault in a twin.toml is named with file, line and key. No tolerances: sentences and line
// numbers are compared exactly.
#include "tests/support/twin/twin_file_fixture.hpp"
#include "twin/base/nearest_word.hpp"
#include "twin/file/toml_reader.hpp"

namespace fringetwin::testing::twin_file_errors_test {
namespace {
using ::testing::AllOf;
using ::testing::HasSubstr;

using TwinFileErrors = TwinFile;

TEST_F(TwinFileErrors, NearestKnownWord) {
  const std::vector<std::string> words = {"radius_mm", "center_mm", "gain_dn"};
  EXPECT_EQ(*nearest("radus_mm", words), "radius_mm");
  EXPECT_EQ(*nearest("centre_mm", words), "center_mm");
  EXPECT_EQ(nearest("temperature", words), nullptr);
  const std::string page(1 << 16, 'a');  // took a minute
  EXPECT_EQ(nearest(page, std::vector<std::string>(10, page)), nullptr);
}

TEST_F(TwinFileErrors, SchemaAndSyntax) {
  EXPECT_THAT(any_error("name = \"x\"\n"), HasSubstr("schema is missing"));
  EXPECT_THAT(error("schema = \"fringetwin-twin/9\"\n", "schema"),
              HasSubstr("must be \"fringetwin-twin/1\""));
  EXPECT_THAT(error(kMinimal + "[render\n", "[render"), HasSubstr("is no valid TOML"));
  EXPECT_THAT(error(with(kMinimal, "name", "name = \"a\"\nname = \"b\""), "name = \"b\""),
              HasSubstr("is no valid TOML"));
  try {
    load_twin(folder_ / "none.toml");
    FAIL();
  } catch (const UserError& e) {
    EXPECT_THAT(e.what(), HasSubstr("none.toml: no such file"));
  }
}

// In every table of the file one misspelt key.
TEST_F(TwinFileErrors, UnknownKeysNameTheNearest) {
  const std::string all =
      kHead + kCamera + kSensor + kOptics + kProjector +
      with(kGray, "phase_origin_px", "phase_origin_px = 30\nharmonics = [[0, 0]]\nwaveform = \"sine\"") +
      kBall +
      "[object.material]\ndiffuse = 0.5\n[render]\nsamples = 4\n[measure]\nmin_modulation_dn = 5\n"
      "[[measure.fit]]\nobject = \"ball\"\n[real.results]\nsource = \"s\"\n"
      "[[real.results.fit]]\nobject = \"ball\"\nrms_mm = 1\n[uncertainty]\ncalibration = \"twin.toml\"\n"
      "[limits]\ngain_r2 = 0.9\n";
  load(all);
  const struct {
    const char *after, *wrong, *right, *table;
  } cases[] = {{"schema = \"fringetwin-twin/1\"", "nam", "name", "this file"},
               {"[[camera]]", "intrinsic", "intrinsics", "[camera[0]]"},
               {"[camera.sensor]", "gain", "gain_dn", "[camera[0].sensor]"},
               {"[camera.optics]", "f_numbr", "f_number", "[camera[0].optics]"},
               {"[projector]", "intensty", "intensity", "[projector]"},
               {"[fringes]", "pitch_px", "pitches_px", "[fringes]"},
               {"[fringes.gray]", "bit", "bits", "[fringes.gray]"},
               {"[[object]]", "radius", "radius_mm", "[object[0]]"},
               {"[object.material]", "difuse", "diffuse", "[object[0].material]"},
               {"[render]", "sample", "samples", "[render]"},
               {"[measure]", "triangulation", "triangulate", "[measure]"},
               {"[[measure.fit]]", "gate", "gate_mm", "[measure.fit[0]]"},
               {"[real.results]", "sorce", "source", "[real.results]"},
               {"[[real.results.fit]]", "centre_mm", "center_mm", "[real.results.fit[0]]"},
               {"[uncertainty]", "calibraton", "calibration", "[uncertainty]"}};
  for (const auto& c : cases) {
    const auto at = all.find(c.after) + std::string(c.after).size() + 1;
    const std::string line = fmt::format("{} = 1\n", c.wrong);
    EXPECT_THAT(error(all.substr(0, at) + line + all.substr(at), line),
                AllOf(HasSubstr(fmt::format("unknown key \"{}\" in {}", c.wrong, c.table)),
                      HasSubstr(fmt::format("did you mean \"{}\"?", c.right))));
  }
  EXPECT_THAT(
      error(kMinimal + "[render]\ntemperature = 3\n", "temperature"),
      HasSubstr("known keys: pixel_fill, phase_error_rad, gray_error, samples, sampler, shadow, bounces, "
                "bounce_samples, glossy_bounces"));
}

TEST_F(TwinFileErrors, TypesAndRangesOfEveryNumber) {
  const std::string all =
      kHead + kCamera + kSensor + kOptics + kProjector +
      with(kGray, "phase_origin_px", "phase_origin_px = 30\nharmonics = [[0, 0]]\nwaveform = \"sine\"") +
      kBall +
      "[object.material]\ndiffuse = 0.5\nspecular = 0\nshininess = 3\nmean_free_path_mm = 0\n"
      "[render]\nsamples = 4\npixel_fill = 1\nphase_error_rad = 1e-4\n"
      "[measure]\nmin_modulation_dn = 5\n[[measure.fit]]\nobject = \"ball\"\ngate_mm = 2\n";
  load(all);
  const struct {
    const char *key, *value, *says;
  } cases[] = {
      {"bit_depth", "7", "camera[0].sensor.bit_depth must be 8 ... 16, is 7"},
      {"bit_depth", "17", "must be 8 ... 16, is 17"},
      {"bit_depth", "8.0", "must be an integer, is a number"},
      {"exposure_ms", "0", "must be > 0, is 0"},
      {"gain_dn", "0", "must be > 0, is 0"},
      {"gain_dn", "\"20\"", "must be a number, is a string"},
      {"gain_dn", "nan", "must be a finite number, is nan"},
      {"gain_dn", "inf", "must be a finite number, is inf"},
      {"black_level_dn", "-1", "must be >= 0 and <= 4095, is -1"},
      {"black_level_dn", "4096", "must be >= 0 and <= 4095, is 4096"},
      {"electrons_per_dn", "0.0", "must be > 0, is 0"},
      {"read_noise_dn", "-0.1", "must be >= 0, is -0.1"},
      {"f_number", "0", "must be > 0, is 0"},
      {"focal_length_mm", "-1", "must be > 0, is -1"},
      {"focus_distance_mm", "9", "must be > focal_length_mm = 10, is 9"},
      {"intensity", "0", "projector.intensity must be > 0, is 0"},
      {"reference_distance_mm", "0", "must be > 0, is 0"},
      {"blur_px", "-1", "must be >= 0, is -1"},
      {"ambient", "true", "must be a number, is true or false"},
      {"response", "{ gamma = 0 }", "projector.response.gamma must be > 0, is 0"},
      {"response", "{ table = [0.5] }", "must have 2 levels or more"},
      {"response", "{ table = [0, 1.5] }", "table[1] must be >= 0 and <= 1, is 1.5"},
      {"response", "{ gamma = 2, table = [0, 1] }", "must have either gamma or table"},
      {"response", "2.2", "must be \"linear\", { gamma = ... } or { table = [...] }"},
      {"response", "\"linaer\"", "did you mean \"linear\"?"},
      {"falloff", "\"square\"", "must be one of \"none\", \"inverse-square\", is \"square\""},
      {"falloff", "3", "must be a string, is an integer"},
      {"steps", "2", "fringes.steps must be >= 3 (or 0: Gray code only), is 2"},
      {"steps", "-1", "must be 0 ... 1000, is -1"},
      {"steps", "4.0", "must be an integer, is a number"},
      {"mean", "1.5", "must be >= 0 and <= 1, is 1.5"},
      {"amplitude", "0", "must be > 0 and <= 1, is 0"},
      {"amplitude", "0.41", "mean 0.4 +- amplitude 0.41 must lie within 0 ... 1"},
      {"pitches_px", "[0]", "fringes.pitches_px[0] must be > 0, is 0"},
      {"pitches_px", "[nan]", "must be a finite number"},
      {"pitches_px", "[]", "must have one pitch or more"},
      {"pitches_px", "60", "must be an array of numbers, is an integer"},
      {"pitches_px", "[60, 61]", "must be one pitch with unwrap = \"gray\", are 2"},
      {"phase_origin_px", "[1, 2]", "2 values for 1 pitches"},
      {"harmonics", "0.1", "must be an array of arrays of numbers, is a number"},
      {"harmonics", "[0.1, 0.2]", "fringes.harmonics[0] must be an array, is a number"},
      {"harmonics", "[[0.1, 0, 0]]", "fringes.harmonics[0] must have 2 numbers, has 3"},
      {"harmonics", "[[0, 0.1], [0, 1.1]]", "fringes.harmonics[1][1] must be >= -1 and <= 1, is 1.1"},
      {"harmonics", "[[[0, 0]], [[0, \"1\"]]]", "fringes.harmonics[1][0][1] must be a number"},
      {"harmonics", "[[[0, 0]], [[0, 0]]]", "2 lists for 1 pitches"},
      {"harmonics", "[[0.8, 0], [0, 0.8]]", "add up to 1.6 of the full scale"},
      {"harmonics",
       "[[0,0],[0,0],[0,0],[0,0],[0,0],[0,0],[0,0],[0,0],[0,0],[0,0],[0,0],[0,0],[0,0],[0,0],[0,0],[0,0]]",
       "has 16 pairs: the harmonics 2 ... 16 are 15"},
      {"waveform", "\"square\"", "must be one of \"sine\", \"binary\", is \"square\""},
      {"waveform", "[0, 1]", "must be \"sine\", \"binary\", { table = [...] } or { levels = [...] }"},
      {"waveform", "{ table = [0, 1], levels = [0, 1] }", "must have either table or levels"},
      {"waveform", "{ table = [1] }", "must have 2 ... 4096 values, has 1"},
      {"waveform", "{ levels = [1, 0, 1, 0] }", "has no first harmonic"},
      {"waveform", "{ levels = [0, 1.5] }", "levels[1] must be >= 0 and <= 1, is 1.5"},
      {"phase_origin_px", "\"0\"", "must be a number, is a string"},
      {"bits", "0", "fringes.gray.bits must be 1 ... 16, is 0"},
      {"order", "\"msb\"", "must be one of \"msb-first\", \"lsb-first\", is \"msb\""},
      {"complementary", "1", "must be true or false, is an integer"},
      {"threshold", "\"average\"", "must be one of \"mean\", \"inverse\", \"white-black\""},
      {"radius_mm", "0", "object[0].radius_mm must be > 0, is 0"},
      {"center_mm", "[0, 1]", "must have 3 numbers, has 2"},
      {"center_mm", "[0, 1, \"2\"]", "center_mm[2] must be a number, is a string"},
      {"shape", "\"spheer\"", "did you mean \"sphere\"?"},
      {"diffuse", "1.1", "must be >= 0 and <= 1, is 1.1"},
      {"specular", "-1", "must be >= 0, is -1"},
      {"shininess", "0", "must be > 0, is 0"},
      {"mean_free_path_mm", "-0.5", "must be >= 0 and <= 100, is -0.5"},
      {"samples", "0", "must be 1 ... 65536, is 0"},
      {"pixel_fill", "2.5", "must be > 0 and <= 2, is 2.5"},
      {"phase_error_rad", "0", "must be > 0, is 0"},
      {"min_modulation_dn", "-1", "must be >= 0, is -1"},
      {"gate_mm", "0", "measure.fit[0].gate_mm must be > 0, is 0"},
      {"imagersize", "[640]", "must have 2 numbers, has 1"},
      {"imagersize", "[640, 0]", "must be >= 1"},
      {"imagersize", "[640.5, 480]", "must be two whole numbers"},
      {"rt_cam_world", "[0, 0, 0]", "must have 6 numbers, has 3"},
      {"intrinsics", "[600, 601]", "takes 8 intrinsics, 2 given"},
      {"intrinsics", "\"600\"", "must be an array of numbers, is a string"},
      {"intrinsics", "[600, 600, 320, 240, -5, 0, 0, 0]", "cannot be inverted"},
      {"lensmodel", "\"LENSMODEL_FISH\"", "unknown lens model 'LENSMODEL_FISH'"}};
  for (const auto& c : cases) {
    const std::string line = fmt::format("{} = {}", c.key, c.value);
    const std::string text = with(all, c.key, line);
    if (std::string(c.key) == "lensmodel")  // the lens reports the line of its intrinsics
      EXPECT_THAT(error(text, "intrinsics = "), HasSubstr(c.says));
    else
      EXPECT_THAT(error(text, line), HasSubstr(c.says)) << line;
  }
}

TEST_F(TwinFileErrors, TheLineInsideAnArrayIsNamed) {
  const std::string text =
      kHead + kCamera + with(kFringes, "pitches_px", "pitches_px = [\n 13,\n 14,\n -15 ]");
  EXPECT_THAT(error(text, " -15"), HasSubstr("fringes.pitches_px[2] must be > 0, is -15"));
}

TEST_F(TwinFileErrors, MissingKeysNameTheirTable) {
  const std::string all = kHead + kCamera + kOptics + kRight + kProjector + kGray + kBall;
  const struct {
    const char *key, *table;
  } cases[] = {{"lensmodel", "[[camera]]"},
               {"imagersize", "[[camera]]"},
               {"intrinsics", "[[camera]]"},
               {"f_number", "[camera.optics]"},
               {"focal_length_mm", "[camera.optics]"},
               {"focus_distance_mm", "[camera.optics]"},
               {"reference_distance_mm", "[projector]"},
               {"directions", "[fringes]"},
               {"pitches_px", "[fringes]"},
               {"steps", "[fringes]"},
               {"bits", "[fringes.gray]"},
               {"shape", "[[object]]"},
               {"center_mm", "[[object]]"},
               {"radius_mm", "[[object]]"}};
  for (const auto& c : cases)
    EXPECT_THAT(error(with(all, c.key, ""), c.table), HasSubstr(fmt::format("{} is missing", c.key)))
        << c.key;
  EXPECT_THAT(error(kHead + "[[camera]]\n" + kLens + kFringes, "[[camera]]"),
              HasSubstr("camera[0].name is missing"));
  EXPECT_THAT(error(kMinimal + "[[object]]\nshape = \"sphere\"\ncenter_mm = [0, 0, 1]\nradius_mm = 1\n",
                    "[[object]]"),
              HasSubstr("object[0].name is missing"));
  EXPECT_THAT(any_error(kHead + kFringes), HasSubstr("camera is missing"));
  EXPECT_THAT(any_error(kHead + kCamera), HasSubstr("fringes is missing"));
}

TEST_F(TwinFileErrors, CamerasAndProjector) {
  EXPECT_THAT(
      error(kHead + kCamera + kRight + kRight + kFringes,
            "[[camera]]\nname = \"right\"\n" + kLens + "rt_cam_world = [0, 0.5, 0, -100, 0, 20]\n[fringes]"),
      HasSubstr("one camera too many: 3 are given"));
  EXPECT_THAT(any_error(kHead + kCamera + kCamera + kFringes), HasSubstr("name of the first camera, too"));
  EXPECT_THAT(error(kHead + with(kCamera, "name", "name = \"a/b\"") + kFringes, "name = \"a/b\""),
              HasSubstr("cannot become part of a file name"));
  // only the first camera may be the world
  load(kHead + "[[camera]]\nname = \"left\"\n" + kLens + kFringes);
  const std::string second = "[[camera]]\nname = \"second\"\n" + kLens;
  EXPECT_THAT(any_error(kHead + kCamera + second + kFringes), HasSubstr("camera[1].rt_cam_world is missing"));
  EXPECT_THAT(error(kHead + kCamera + "[projector]\n" + kLens + kFringes, "[projector]"),
              HasSubstr("projector.rt_cam_world is missing"));
  EXPECT_THAT(error(kHead + "[[camera]]\nname = \"left\"\n" + kFringes, "[[camera]]"),
              HasSubstr("needs model = \"FILE.cameramodel\""));
  EXPECT_THAT(error(kHead + kCamera + "model = \"x.cameramodel\"\n" + kFringes, "lensmodel = "),
              HasSubstr("camera[0].lensmodel is given beside model"));
  EXPECT_THAT(error(kHead + kCamera + with(kProjector, "falloff", "falloff = \"none\"") + kFringes,
                    "reference_distance_mm"),
              HasSubstr("has no effect without falloff = \"inverse-square\""));
  EXPECT_THAT(error(kHead + "camera = 3\n" + kFringes, "camera = 3"), HasSubstr("write [[camera]]"));
  EXPECT_THAT(any_error(kHead + "projector = 3\n" + kCamera + kFringes), HasSubstr("write [projector]"));
}

TEST_F(TwinFileErrors, AMissingCameraModelIsAnInputError) {
  try {
    load(kHead + "[[camera]]\nname = \"left\"\nmodel = \"none.cameramodel\"\n" + kFringes);
    FAIL();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input);
    EXPECT_THAT(e.what(), HasSubstr((folder_ / "none.cameramodel").string()));
  }
}

TEST_F(TwinFileErrors, FringesThatDoNotFitTogether) {
  const std::string start = kHead + kCamera;
  const auto fringes = [&](const std::string& pitches, int steps, const std::string& unwrap,
                           const std::string& more = "") {
    return start +
           fmt::format("[fringes]\ndirections = [\"x\"]\npitches_px = {}\nsteps = {}\nunwrap = \"{}\"\n{}",
                       pitches, steps, unwrap, more);
  };
  EXPECT_THAT(error(fringes("[13, 14]", 4, "heterodyne"), "pitches_px"),
              HasSubstr("must be 3 pitches with unwrap = \"heterodyne\", are 2"));
  EXPECT_THAT(error(fringes("[13, 14, 13]", 4, "heterodyne"), "pitches_px"),
              HasSubstr("has the same pitch twice"));
  EXPECT_THAT(error(fringes("[13]", 4, "hierarchical"), "pitches_px"),
              HasSubstr("must be 2 pitches or more"));
  EXPECT_THAT(error(fringes("[13]", 4, "gray"), "unwrap"),
              HasSubstr("fringes.unwrap = \"gray\" needs [fringes.gray]"));
  EXPECT_THAT(error(fringes("[13]", 0, "none"), "steps"),
              HasSubstr("Gray code only and needs unwrap = \"gray\""));
  EXPECT_THAT(error(fringes("[1]", 0, "gray", "[fringes.gray]\nbits = 3\n"), "[fringes.gray]"),
              AllOf(HasSubstr("threshold = \"mean\""), HasSubstr("steps = 0")));
  EXPECT_THAT(error(fringes("[13]", 4, "heterodine"), "unwrap"), HasSubstr("did you mean \"heterodyne\"?"));
  EXPECT_THAT(error(fringes("[13]", 4, "none", "[fringes.y]\npitches_px = [3]\n"), "[fringes.y]"),
              HasSubstr("\"y\" is not in directions"));
  EXPECT_THAT(error(fringes("[13]", 4, "none", "[fringes.x]\npitches = [3]\n"), "pitches = [3]"),
              HasSubstr("unknown key \"pitches\" in [fringes.x]"));
  EXPECT_THAT(error(fringes("[13]", 4, "none", "phase_origin_px = [1]\n[fringes.x]\npitches_px = [3, 4]\n"),
                    "phase_origin_px"),
              HasSubstr("1 values for 2 pitches"));
  for (const auto& [value, says] :
       {std::pair{"[]", "must not be empty"}, std::pair{"[\"z\"]", "has \"z\""},
        std::pair{"[\"x\", \"x\"]", "has \"x\" twice"}, std::pair{"\"x\"", "must be an array of strings"},
        std::pair{"[1]", "directions[0] must be a string"}})
    EXPECT_THAT(
        error(start + with(kFringes, "directions", fmt::format("directions = {}", value)), "directions ="),
        HasSubstr(says));
}

TEST_F(TwinFileErrors, Objects) {
  EXPECT_THAT(any_error(kMinimal + kBall + kBall),
              HasSubstr("object[1].name \"ball\" is the name of an earlier object"));
  const auto object = [](const std::string& rest) { return kMinimal + "[[object]]\nname = \"o\"\n" + rest; };
  const std::string plane = "shape = \"plane\"\npoint_mm = [0, 0, 1]\n";
  EXPECT_THAT(error(object(plane + "normal = [0, 0, 0]\n"), "normal"), HasSubstr("must not be [0, 0, 0]"));
  EXPECT_THAT(error(object(plane + "normal = [0, 0, 1]\nu_axis = [1, 0, 0]\n"), "u_axis"),
              HasSubstr("has no effect without size_mm"));
  EXPECT_THAT(error(object(plane + "normal = [0, 0, 1]\nsize_mm = [1, 2]\nu_axis = [0, 0, 3]\n"), "u_axis"),
              HasSubstr("must not be parallel to the normal"));
  EXPECT_THAT(error(object(plane + "normal = [0, 0, 1]\nsize_mm = [1, -2]\n"), "size_mm"),
              HasSubstr("size_mm[1] must be > 0"));
  EXPECT_THAT(error(object(plane + "normal = [0, 0, 1]\nradius_mm = 3\n"), "radius_mm"),
              HasSubstr("unknown key \"radius_mm\" in [object[0]]"));
  EXPECT_THAT(
      error(
          object(
              "shape = \"cylinder\"\npoint_mm = [0, 0, 1]\naxis = [0, 1, 0]\nradius_mm = 1\nlength_mm = 0\n"),
          "length_mm"),
      HasSubstr("must be > 0, is 0"));
  EXPECT_THAT(error(object("shape = \"mesh\"\n"), "[[object]]"), HasSubstr("object[0].file is missing"));
  EXPECT_THAT(error(object("shape = \"mesh\"\nfile = \"a.ply\"\nunit = \"cm\"\n"), "unit = \"cm\""),
              HasSubstr("must be one of \"mm\", \"m\""));
  EXPECT_THAT(error(object("shape = \"mesh\"\nfile = \"a.ply\"\nshading = \"flat\"\n"), "shading"),
              HasSubstr("must be one of \"facet\", \"smooth\""));
  EXPECT_THAT(error(object("shape = \"measured\"\nsteps = 7\n"), "steps = 7"), HasSubstr("must be a string"));
}

TEST_F(TwinFileErrors, MeasureRealAndLimits) {
  EXPECT_THAT(error(kMinimal + "[measure]\ntriangulate = \"stereo\"\n", "triangulate"),
              HasSubstr("needs two cameras"));
  EXPECT_THAT(error(kMinimal + "[measure]\ntriangulate = \"projector\"\n", "triangulate"),
              HasSubstr("needs a [projector]"));
  EXPECT_THAT(error(kMinimal + kBall + "[[measure.fit]]\nobject = \"bal\"\n", "object = \"bal\""),
              AllOf(HasSubstr("there is no such [[object]]"), HasSubstr("did you mean \"ball\"?")));
  const std::string fit = "[[measure.fit]]\nobject = \"ball\"\n";
  EXPECT_THAT(any_error(kMinimal + kBall + fit + fit), HasSubstr("fitted by an earlier [[measure.fit]]"));
  const std::string results = "[real.results]\n[[real.results.fit]]\nobject = \"ball\"\n";
  EXPECT_THAT(any_error(kMinimal + kBall + "[real]\ncaptures = \"x\"\n" + results),
              HasSubstr("either captures or [real.results]"));
  EXPECT_THAT(error(kMinimal + "[real]\n", "[real]"), HasSubstr("either captures or [real.results]"));
  EXPECT_THAT(error(kMinimal + kBall + results, "[[real.results.fit]]"),
              HasSubstr("real.results.fit[0] has no number"));
  EXPECT_THAT(error(kMinimal + kBall + results + "radius_mm = [1]\n", "radius_mm = [1]"),
              HasSubstr("must be a number, is an array"));
  EXPECT_THAT(error(kMinimal + "[real.results]\nsource = \"s\"\n", "[real.results]"),
              HasSubstr("real.results.fit is missing"));
  EXPECT_THAT(error(kMinimal + "[uncertainty]\n", "[uncertainty]"), HasSubstr("calibration is missing"));
  try {
    load(kMinimal + "[uncertainty]\ncalibration = \"none.json\"\n");
    ADD_FAILURE() << "a missing calibration was accepted";
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input);
    EXPECT_THAT(e.what(), HasSubstr("uncertainty.calibration = "));
    EXPECT_THAT(e.what(), HasSubstr("none.json\": there is no such file"));
  }
  EXPECT_THAT(error(kMinimal + "[limits]\nrms_mm = -1\n", "rms_mm"),
              HasSubstr("limits.rms_mm must be >= 0, is -1"));
  EXPECT_THAT(error(kMinimal + "[limits]\nrms_mm = \"tight\"\n", "rms_mm"),
              HasSubstr("must be a number, is a string"));
}

}  // namespace
}  // namespace fringetwin::testing::twin_file_errors_test
