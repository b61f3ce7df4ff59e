// SPDX-License-Identifier: Apache-2.0
// No tolerances: values that are stored exactly, and refusals.
#include "twin/pixel_map.hpp"

#include <limits>
#include <vector>

#include "tests/support/twin/twin_file_fixture.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::pixel_map_test {
namespace {

using ::testing::HasSubstr;

class PixelMaps : public TwinFile {
 protected:
  static constexpr int kWidth = 640, kHeight = 480;  // of kCamera

  static std::string with_sensor(const std::string& keys) {
    return kHead + kCamera + "[camera.sensor]\n" + keys + "\n" + kFringes;
  }
  static ImageF even(float value) { return {kWidth, kHeight, value}; }
  /// A map of `value` but for the pixel (3, 2).
  static ImageF but_for_one(float value, float other) {
    ImageF map = even(value);
    map(3, 2) = other;
    return map;
  }
  Twin loaded(const std::string& keys) const {
    Twin twin = load(with_sensor(keys));
    load_meshes(twin);
    return twin;
  }
  /// What is said of a map that is refused.
  std::string refusal(const std::string& keys) const {
    Twin twin = load(with_sensor(keys));
    try {
      load_meshes(twin);
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::usage) << keys;
      return e.what();
    }
    ADD_FAILURE() << keys << " is taken";
    return "";
  }
  std::string refusal_of(const std::string& key, const ImageF& map) const {
    write_exr(folder_ / "map.exr", {{"Y", &map}});
    const std::string said = refusal(key + " = \"map.exr\"");
    EXPECT_THAT(said, HasSubstr("[camera.sensor] " + key + " = \"" + (folder_ / "map.exr").string() +
                                "\" of camera \"left\": "));
    return said;
  }
};

TEST_F(PixelMaps, AreReadWithTheTwin) {
  const ImageF factors = but_for_one(1.0F, 1.25F), offsets = but_for_one(0.0F, -3.5F);
  write_exr(folder_ / "factors.exr", {{"factor", &factors}});
  write_exr(folder_ / "offsets.exr", {{"offset_dn", &offsets}});
  const Twin twin = loaded("prnu = \"factors.exr\"\ndsnu = \"offsets.exr\"");
  const Sensor& sensor = twin.cameras[0].sensor;
  ASSERT_TRUE(sensor.prnu.values && sensor.dsnu.values);
  EXPECT_EQ((*sensor.prnu.values)(3, 2), 1.25F);
  EXPECT_EQ((*sensor.dsnu.values)(3, 2), -3.5F);
  EXPECT_TRUE(sensor.has_maps());
  EXPECT_FALSE(sensor.straight());
  EXPECT_THAT(twin.input_files, ::testing::IsSupersetOf({folder_ / "factors.exr", folder_ / "offsets.exr"}));
  // what another twin has read is not read again
  Twin again = load(with_sensor("prnu = \"factors.exr\""));
  std::filesystem::remove(folder_ / "factors.exr");
  load_meshes(again, &twin);
  EXPECT_EQ(again.cameras[0].sensor.prnu.values, sensor.prnu.values);
}

TEST_F(PixelMaps, AreNoneWithoutTheirKeys) {
  const Twin twin = loaded("gain_dn = 2");
  EXPECT_FALSE(twin.cameras[0].sensor.has_maps());
  EXPECT_TRUE(twin.cameras[0].sensor.straight());
}

TEST_F(PixelMaps, ThatAreNoneAreRefusedInOneSentence) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal_of("prnu", ImageF(kWidth - 1, kHeight, 1.0F)),
              HasSubstr("has 639 x 480 px, the camera 640 x 480"));
  EXPECT_THAT(refusal_of("prnu", but_for_one(1.0F, kNan)), HasSubstr("has the value nan at pixel (3, 2)"));
  EXPECT_THAT(refusal_of("prnu", but_for_one(1.0F, 0.0F)), HasSubstr("has the value 0 at pixel (3, 2)"));
  EXPECT_THAT(refusal_of("prnu", but_for_one(1.0F, -1.0F)), HasSubstr("has the value -1 at pixel (3, 2)"));
  EXPECT_THAT(refusal_of("prnu", even(180.0F)), HasSubstr("has factors of mean 180, not 1"));
  EXPECT_THAT(refusal_of("dsnu", ImageF(kWidth, kHeight + 2, 0.0F)), HasSubstr("has 640 x 482 px"));
  EXPECT_THAT(refusal_of("dsnu", but_for_one(0.0F, -kNan)), HasSubstr("at pixel (3, 2)"));
  EXPECT_THAT(refusal_of("dsnu", but_for_one(0.0F, 256.0F)), HasSubstr("has the value 256 at pixel (3, 2)"));
  for (const char* key : {"prnu", "dsnu"})
    EXPECT_THAT(refusal(std::string(key) + " = \"none.exr\""),
                ::testing::AllOf(HasSubstr(key), HasSubstr("none.exr")));
  const ImageF map = even(1.0F);
  write_exr(folder_ / "two.exr", {{"a", &map}, {"b", &map}});
  EXPECT_THAT(refusal("prnu = \"two.exr\""), HasSubstr("has 2 channels, not one"));
}

TEST_F(PixelMaps, KeysHoldNamesOfFiles) {
  EXPECT_THAT(error(with_sensor("prnu = 1.01"), "prnu"), HasSubstr("must be a string"));
  EXPECT_THAT(error(with_sensor("dsnu_dn = \"a.exr\""), "dsnu_dn"), HasSubstr("dsnu"));
}

}  // namespace
}  // namespace fringetwin::testing::pixel_map_test
