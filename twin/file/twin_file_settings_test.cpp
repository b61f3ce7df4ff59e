// SPDX-License-Identifier: Apache-2.0
// Values put into a twin by the path of their key. No tolerances: the values are those written.
#include <fmt/ranges.h>

#include "tests/support/twin/child_process.hpp"
#include "tests/support/twin/twin_file_fixture.hpp"
#include "twin/file/toml_reader.hpp"

namespace fringetwin::testing::twin_file_settings_test {
namespace {
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Settings = std::map<std::string, std::string>;

class TwinFileSettings : public TwinFile {
 protected:
  void SetUp() override {
    TwinFile::SetUp();
    text_ = kHead + kCamera + kSensor + kRight + kProjector + kFringes + kBall +
            "[[object]]\nname = \"ball.2\"\nshape = \"sphere\"\ncenter_mm = [0, 1, 260]\nradius_mm = 6\n"
            "[[measure.fit]]\nobject = \"ball\"\ngate_mm = 1.5\n";
    std::ofstream(file()) << text_;
  }
  std::filesystem::path file() const { return folder_ / "twin.toml"; }
  Twin set(const Settings& settings) const { return load_twin(file(), settings); }
  /// The sentence about a path that leads nowhere; `what` is the setting it names.
  std::string unknown(const std::string& key, const std::string& value = "1") const {
    try {
      set({{key, value}});
    } catch (const UnknownKey& e) {
      EXPECT_EQ(e.code(), ExitCode::usage);
      EXPECT_THAT(e.what(), HasSubstr(file().string() + " with " + key + " = " + value + ": "));
      return e.what();
    }
    ADD_FAILURE() << "no UnknownKey for " << key;
    return "";
  }
  /// The sentence about a value or a path that is none.
  std::string wrong(const std::string& key, const std::string& value) const {
    try {
      set({{key, value}});
    } catch (const UnknownKey& e) {
      ADD_FAILURE() << "the key is known: " << e.what();
    } catch (const UserError& e) {
      EXPECT_THAT(e.what(), HasSubstr(file().string() + " with " + key + " = " + value + ": "));
      return e.what();
    }
    return "";
  }
  std::string text_;
};

TEST_F(TwinFileSettings, ValuesTakeTheirPlaces) {
  const Twin twin = set({{"camera.left.sensor.bit_depth", "10"},
                         {"camera[1].sensor.gain_dn", "3.5"},
                         {"fringes.pitches_px[1]", "14.5"},
                         {"object.ball.center_mm", "[1, 2, 300]"},
                         {"object.ball.material.diffuse", "0.5"},
                         {"object.ball.2.radius_mm", "7"},
                         {"object[1].center_mm[2]", "280"},
                         {"projector.response", "{ gamma = 1.5 }"},
                         {"measure.fit.ball.gate_mm", "0.5"},
                         {"render.sampler", "\"gauss\""}});
  EXPECT_EQ(twin.cameras[0].sensor.bit_depth, 10);
  EXPECT_EQ(twin.cameras[0].sensor.gain_dn, 20.0);
  EXPECT_EQ(twin.cameras[1].sensor.gain_dn, 3.5);
  EXPECT_THAT(twin.fringes.directions[0].pitches_px, ElementsAre(13, 14.5, 15));
  EXPECT_EQ(std::get<SphereShape>(twin.objects[0].shape).center_mm, Eigen::Vector3d(1, 2, 300));
  EXPECT_EQ(twin.objects[0].material.diffuse, 0.5);
  EXPECT_EQ(std::get<SphereShape>(twin.objects[1].shape).radius_mm, 7.0);
  EXPECT_EQ(std::get<SphereShape>(twin.objects[1].shape).center_mm, Eigen::Vector3d(0, 1, 280));
  EXPECT_EQ(twin.projector->response.gamma, 1.5);
  EXPECT_EQ(twin.measure.fits[0].gate_mm, 0.5);
  EXPECT_EQ(twin.render.sampler, Sampler::gauss);
  EXPECT_EQ(twin.file, file());
  EXPECT_EQ(testing::read_file(file()), text_) << "the file itself stays";
}

TEST_F(TwinFileSettings, AWholeArrayComesBeforeItsEntries) {
  const Twin twin = set({{"fringes.pitches_px[0]", "20"}, {"fringes.pitches_px", "[21, 22, 23]"}});
  EXPECT_THAT(twin.fringes.directions[0].pitches_px, ElementsAre(20, 22, 23));
}

TEST_F(TwinFileSettings, PathsThatLeadNowhere) {
  EXPECT_THAT(unknown("camera.left.sensor.bit_dept"), HasSubstr("did you mean \"bit_depth\"?"));
  EXPECT_THAT(unknown("camera.right.sensr.gain_dn"), HasSubstr("did you mean \"sensor\"?"));
  EXPECT_THAT(unknown("camra.left.sensor.bit_depth"), HasSubstr("did you mean \"camera\"?"));
  EXPECT_THAT(unknown("camera.lft.sensor.bit_depth"),
              AllOf(HasSubstr("no camera is named \"lft\""), HasSubstr("did you mean \"left\"?")));
  EXPECT_THAT(unknown("object.cube.radius_mm"), HasSubstr("there are: ball, ball.2"));
  EXPECT_THAT(unknown("object..radius_mm"), HasSubstr("no object is named \"\""));
  EXPECT_THAT(unknown("camera[2].psf_px"), HasSubstr("camera has 2 entries, counted from 0"));
  EXPECT_THAT(unknown("fringes.pitches_px[3]"), HasSubstr("fringes.pitches_px has 3 entries"));
  EXPECT_THAT(unknown("fringes.steps.x"), HasSubstr("fringes.steps is an integer, no table"));
  EXPECT_THAT(unknown("fringes.steps[0]"), HasSubstr("fringes.steps is no list"));
  EXPECT_THAT(unknown("fringes.phase_origin_px[0]"), HasSubstr("it is not in the file"));
  EXPECT_THAT(unknown("fringes.pitches_px[0].x"), HasSubstr("fringes.pitches_px[0] is no table"));
}

TEST_F(TwinFileSettings, WrongValuesNameTheirSetting) {
  EXPECT_THAT(wrong("camera.left.sensor.bit_depth", "99"), HasSubstr("must be 8 ... 16, is 99"));
  EXPECT_THAT(wrong("fringes.pitches_px", "[13, -1, 15]"), HasSubstr("fringes.pitches_px[1] must be"));
  EXPECT_THAT(wrong("fringes.pitches_px[1]", "-1"), HasSubstr("fringes.pitches_px[1] must be"));
  EXPECT_THAT(wrong("camera.right.optics.f_number", "8"), HasSubstr("focal_length_mm is missing"));
  EXPECT_THAT(wrong("object.ball.radius_mm", "[1"), HasSubstr("is no TOML"));
  EXPECT_THAT(wrong("object.ball.radius_mm", ""), HasSubstr("is no TOML"));
  EXPECT_THAT(wrong("object.ball.radius_mm", "1\nx = 2"), HasSubstr("one value on one line"));
  for (const char* path : {"", ".", "a.", ".a", "object[", "object[x].y", "object[0", "object[-1].x"})
    EXPECT_THAT(wrong(path, "1"), HasSubstr("is no path of a key")) << path;
  EXPECT_THAT(wrong("object.ball", "1"), HasSubstr("ends at an entry of a list"));
}

TEST_F(TwinFileSettings, FaultsOfTheFileKeepTheirLines) {
  std::ofstream(file()) << with(text_, "radius_mm", "radius_mm = -5");
  const auto line =
      1 +
      std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(text_.find("radius_mm")), '\n');
  try {
    set({{"fringes.steps", "5"}});
    FAIL();
  } catch (const UserError& e) {
    EXPECT_THAT(e.what(), HasSubstr(fmt::format("twin.toml:{}: object[0].radius_mm", line)));
  }
}

TEST_F(TwinFileSettings, TextsReadBackAsTheSameValues) {
  std::ofstream(folder_ / "values.toml")
      << "v = [1, 1.0, 0.1, 1e300, -2.5e-7, true, \"a \\\"b\\\" \\\\ \\n\", [1, [2.5]], { x = 1, y = \"z\" "
         "}, 1979-05-27, 12345678901.5]\n";
  const auto texts = TomlTable::parse_file(folder_ / "values.toml", ExitCode::usage).toml_texts("v");
  ASSERT_TRUE(texts);
  EXPECT_THAT(*texts, ElementsAre("1", "1", "0.1", "1e+300", "-2.5e-07", "true", R"("a \"b\" \\ \u000a")",
                                  "[1, [2.5]]", R"({ "x" = 1, "y" = "z" })", "1979-05-27", "12345678901.5"));
  std::ofstream(folder_ / "again.toml") << fmt::format("v = [{}]\n", fmt::join(*texts, ", "));
  EXPECT_EQ(TomlTable::parse_file(folder_ / "again.toml", ExitCode::usage).flattened(),
            TomlTable::parse_file(folder_ / "values.toml", ExitCode::usage).flattened());
}

}  // namespace
}  // namespace fringetwin::testing::twin_file_settings_test
