// SPDX-License-Identifier: Apache-2.0
// twin.toml: every key is read. Its faults: twin_file_errors_test.cpp.
//
// | check                     | tolerance | unit | origin                                             |
// |---------------------------|-----------|------|----------------------------------------------------|
// | numbers                   | 0         |      | parsed decimals, nothing computed                  |
// | poses from files          | 1e-12     | mm   | metres times 1000, one rounding                    |
// | unit vectors              | 1e-15     |      | one normalisation                                  |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <locale>

#include "tests/support/twin/twin_file_fixture.hpp"
#include "twin/file/cameramodel.hpp"
#include "twin/file/toml_reader.hpp"
#include "twin/image/image_io.hpp"
#include "twin/moving.hpp"

namespace fringetwin::testing::twin_file_test {
namespace {
namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST_F(TwinFile, DefaultsOfAMinimalFile) {
  const Twin twin = load(kMinimal);
  EXPECT_EQ(twin.name, "test");
  EXPECT_EQ(twin.file, folder_ / "twin.toml");
  EXPECT_THAT(twin.input_files, ElementsAre(folder_ / "twin.toml"));
  const Sensor& sensor = twin.cameras.at(0).sensor;
  EXPECT_EQ(sensor.bit_depth, 8);
  EXPECT_EQ(sensor.gain_dn, 1.0);
  EXPECT_EQ(sensor.black_level_dn, 0.0);
  EXPECT_FALSE(sensor.black_level_is_stated);
  EXPECT_FALSE(sensor.has_noise() || sensor.exposure_ms || twin.cameras[0].optics || twin.projector);
  EXPECT_EQ(twin.fringes.mean, 0.5);
  EXPECT_EQ(twin.fringes.amplitude, 0.5);
  EXPECT_THAT(twin.fringes.directions.at(0).phase_origin_px, ElementsAre(0, 0, 0));
  EXPECT_TRUE(twin.objects.empty() && twin.limits.empty() && !twin.real.captures);
  EXPECT_EQ(twin.render.pixel_fill, 1.0);
  EXPECT_TRUE(twin.render.shadow);
  EXPECT_EQ(twin.render.phase_error_rad, 1e-4);
  EXPECT_EQ(twin.measure.min_modulation_dn, 5.0);
  EXPECT_EQ(twin.triangulate(), Triangulate::projector);
}

TEST_F(TwinFile, AFolderStandsForItsTwin) {
  const Twin twin = load(kMinimal);
  EXPECT_EQ(load_twin(folder_).file, twin.file);
  EXPECT_EQ(load_twin(folder_).name, "test");
  EXPECT_EQ(twin_file_of(twin.file), twin.file);
  EXPECT_EQ(twin_file_of(folder_ / "none.toml"), folder_ / "none.toml") << "who reads it says so";
  fs::create_directories(folder_ / "empty" / "twin.toml");
  try {
    load_twin(folder_ / "empty");
    ADD_FAILURE() << "a folder without a twin was taken";
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
    EXPECT_THAT(e.what(), HasSubstr("empty: is a folder without a twin.toml; give a twin.toml, or"));
  }
}

// A level of 0 that is written down is known; one that nothing says is not.
TEST_F(TwinFile, ABlackLevelOfZeroIsStatedWhereItIsWritten) {
  const auto sensor = [&](const std::string& key) {
    return load(std::string(kHead) + kCamera + "[camera.sensor]\n" + key +
                "[fringes]\ndirections = [\"x\"]\npitches_px = [16, 17, 18]\nsteps = 4\n")
        .cameras.at(0)
        .sensor;
  };
  EXPECT_TRUE(sensor("black_level_dn = 0\n").black_level_is_stated);
  EXPECT_FALSE(sensor("gain_dn = 2\n").black_level_is_stated);
}

// Six standard deviations of an amplitude of N steps at its own darkest level, by hand: 8 bits and read noise
// 0.8 need no more than the 5 DN of a twin without noise.
TEST_F(TwinFile, ModulationIsAskedForByTheNoiseThatIsStated) {
  const auto least = [&](const std::string& sensor, int steps) {
    const std::string camera = std::string(kCamera) + "[camera.sensor]\n" + sensor;
    return load(std::string(kHead) + camera +
                "[fringes]\ndirections = [\"x\"]\npitches_px = [16, 17, 18]\nsteps = " +
                std::to_string(steps) + "\n")
        .measure.min_modulation_dn;
  };
  EXPECT_EQ(least("read_noise_dn = 0.8\n", 4), 5.0);
  EXPECT_NEAR(least("bit_depth = 12\nread_noise_dn = 6\n", 3), std::sqrt(24.0 * (36.0 + 1.0 / 12.0)), 1e-9);
  const double a = least("bit_depth = 12\nread_noise_dn = 6\nelectrons_per_dn = 2\n", 8);
  EXPECT_NEAR(a * a, 9.0 * (36.0 + 1.0 / 12.0 + 0.5 * a), 1e-9);
  EXPECT_EQ(least("bit_depth = 16\n", 3), 5.0);
  EXPECT_NEAR(least("bit_depth = 12\nread_noise_dn = 60\n", 3), 0.02 * 4095.0, 1e-9);
  EXPECT_NEAR(least("read_noise_dn = 60\n", 3), 0.02 * 255.0, 1e-9);
}

TEST_F(TwinFile, EveryCameraAndProjectorKey) {
  const Twin twin = load(kHead + kCamera + kSensor + kOptics + kRight + kProjector + kFringes);
  ASSERT_EQ(twin.cameras.size(), 2u);
  const Camera& left = twin.cameras[0];
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(left.lens.model(), "LENSMODEL_OPENCV4");
  EXPECT_THAT(left.lens.intrinsics(), ElementsAre(600, 601.5, 319.5, 239.5, -0.1, 0.05, 0, 0));
  EXPECT_EQ(left.lens.width(), 640);
  EXPECT_EQ(left.sensor.bit_depth, 12);
  EXPECT_EQ(left.sensor.exposure_ms, 30.0);
  EXPECT_EQ(left.sensor.gain_dn, 20.0);
  EXPECT_EQ(left.sensor.black_level_dn, 16.0);
  EXPECT_TRUE(left.sensor.black_level_is_stated);
  EXPECT_EQ(left.sensor.electrons_per_dn, 40.2);
  EXPECT_EQ(left.sensor.read_noise_dn, 0.1);
  EXPECT_EQ(left.optics->f_number, 8.0);
  EXPECT_EQ(left.optics->focal_length_mm, 10.0);
  EXPECT_EQ(left.optics->focus_distance_mm, 270.0);
  EXPECT_EQ(twin.cameras[1].T_cam_world.translation_mm, Eigen::Vector3d(-100, 0, 20));
  EXPECT_NEAR(vector_from_rotation(twin.cameras[1].T_cam_world.rotation).y(), 0.5, 1e-15);
  EXPECT_EQ(twin.triangulate(), Triangulate::stereo);
  const Projector& projector = *twin.projector;
  EXPECT_EQ(projector.T_proj_world.translation_mm, Eigen::Vector3d(-50, 0, 5));
  EXPECT_EQ(projector.intensity, 40.0);
  EXPECT_TRUE(projector.inverse_square);
  EXPECT_EQ(projector.reference_distance_mm, 250.0);
  EXPECT_EQ(projector.blur_px, 0.5);
  EXPECT_EQ(projector.ambient, 0.25);
  EXPECT_EQ(projector.response.kind, ProjectorResponse::Kind::gamma);
  EXPECT_EQ(projector.response(0.5), std::pow(0.5, 2.2));
}

TEST_F(TwinFile, ProjectorResponses) {
  const std::string start = kHead + kCamera + kProjectorLens;
  EXPECT_EQ(load(start + "response = \"linear\"\n" + kFringes).projector->response(0.3), 0.3);
  const ProjectorResponse table =
      load(start + "response = { table = [0, 0.1, 1] }\n" + kFringes).projector->response;
  EXPECT_EQ(table(0.0), 0.0);
  EXPECT_DOUBLE_EQ(table(0.25), 0.05);
  EXPECT_DOUBLE_EQ(table(0.75), 0.55);
  EXPECT_EQ(table(1.0), 1.0);
}

TEST_F(TwinFile, OneColourOfAColourSensor) {
  const std::string start = kHead + kCamera + "[camera.sensor]\n", end = "\n" + kFringes;
  const auto image = [&](const std::string& keys) { return load(start + keys + end).cameras[0]; };
  EXPECT_FALSE(image("bit_depth = 8").channel);
  const Camera blue = image("mosaic = \"RGGB\"\nchannel = \"blue\"");
  ASSERT_TRUE(blue.channel);
  EXPECT_EQ(blue.channel->sensor_px, Eigen::Vector2i(640, 480));
  EXPECT_EQ(blue.lens.width(), 320);
  EXPECT_EQ(blue.lens.height(), 240);
  EXPECT_EQ(blue.lens.intrinsics(), (std::vector<double>{300, 300.75, 159.25, 119.25, -0.1, 0.05, 0, 0}));
  EXPECT_EQ(blue.whole_lens().intrinsics(),
            (std::vector<double>{600, 601.5, 319.5, 239.5, -0.1, 0.05, 0, 0}));
  EXPECT_EQ(blue.pixel_side_px(), 0.5);
  const auto wrong = [&](const std::string& keys, const std::string& line) {
    return error(start + keys + end, line);
  };
  EXPECT_THAT(wrong("mosaic = \"RGGB\"", "[camera.sensor]"), HasSubstr("channel is missing"));
  EXPECT_THAT(wrong("channel = \"green\"", "[camera.sensor]"), HasSubstr("mosaic is missing"));
  EXPECT_THAT(wrong("mosaic = \"RGBG\"\nchannel = \"green\"", "mosaic ="),
              HasSubstr("must be one of \"RGGB\", \"BGGR\", \"GRBG\", \"GBRG\", is \"RGBG\""));
  EXPECT_THAT(wrong("mosaic = \"RGGB\"\nchannel = \"gren\"", "channel ="),
              HasSubstr("did you mean \"green\""));
}

TEST_F(TwinFile, ProjectorOpticsAndPixels) {
  const std::string start = kHead + kCamera + kProjectorLens;
  const Projector plain = *load(start + kFringes).projector;
  EXPECT_FALSE(plain.optics || plain.pixel_structure || plain.quantise_bits);
  const Projector rich =
      *load(start + "pixel_structure = true\nquantise_bits = 8\npixel_fill = 0.9\n" + kFringes).projector;
  EXPECT_TRUE(rich.pixel_structure);
  EXPECT_EQ(rich.pixel_fill, 0.9);
  EXPECT_EQ(rich.quantise_bits, 8);
  const std::string optics =
      "[projector.optics]\nf_number = 2\nfocal_length_mm = 12\nfocus_distance_mm = 300\n";
  const Projector thick = *load(start + optics + kFringes).projector;
  EXPECT_EQ(thick.optics->f_number, 2.0);
  EXPECT_EQ(thick.optics->focal_length_mm, 12.0);
  EXPECT_EQ(thick.optics->focus_distance_mm, 300.0);
  for (const char* key : {"pixel_fill = 0.9", "quantise_bits = 8"})
    EXPECT_THAT(error(start + key + "\n" + kFringes, key),
                HasSubstr("has no effect without pixel_structure"));
  EXPECT_THAT(error(start + "pixel_structure = true\npixel_fill = 0.9\n" + optics + kFringes, "pixel_fill"),
              HasSubstr("cannot be combined with [projector.optics]"));
  EXPECT_THAT(error(start + "pixel_structur = true\n" + kFringes, "pixel_structur ="),
              HasSubstr("did you mean \"pixel_structure\"?"));
}

TEST_F(TwinFile, CameraLens) {
  const auto lens = [&](const std::string& keys) {
    return load(kHead + kCamera + keys + kFringes).cameras[0];
  };
  EXPECT_EQ(lens("").psf_px, 0.0);
  EXPECT_EQ(lens("vignetting = \"none\"\n").vignetting.kind, Vignetting::Kind::none);
  EXPECT_EQ(lens("psf_px = 0.7\n").psf_px, 0.7);
  EXPECT_EQ(lens("vignetting = \"cos4\"\n").vignetting.kind, Vignetting::Kind::cos4);
  const Vignetting v = lens("vignetting = [-0.3, 0.1, 0]\n").vignetting;
  EXPECT_EQ(v.kind, Vignetting::Kind::polynomial);
  const Vignetting tilted = lens("vignetting_tilt = [0.02, -0.01]\n").vignetting;
  EXPECT_EQ(tilted.kind, Vignetting::Kind::polynomial);
  EXPECT_EQ(tilted.tilt[1], -0.01);
  EXPECT_THAT(v.a, ElementsAre(-0.3, 0.1, 0.0));
  const auto wrong = [&](const std::string& line) { return error(kHead + kCamera + line + kFringes, line); };
  EXPECT_THAT(wrong("vignetting_tilt = [0.9, 0.9]\n"), HasSubstr("is not positive at r = "));
  EXPECT_THAT(wrong("vignetting_tilt = [0.1]\n"), HasSubstr("must have 2 numbers"));
  EXPECT_THAT(error(kHead + kCamera + "vignetting = \"cos4\"\nvignetting_tilt = [0.1, 0]\n" + kFringes,
                    "vignetting_tilt ="),
              HasSubstr("not with a word"));
  EXPECT_THAT(wrong("vignetting = [-0.6, -0.6, 0]\n"), HasSubstr("is not positive at r = "));
  EXPECT_THAT(wrong("vignetting = [0.1, 0]\n"), HasSubstr("vignetting must have 3 numbers, has 2"));
  EXPECT_THAT(wrong("vignetting = \"cos\"\n"), HasSubstr("cos4"));
  EXPECT_THAT(wrong("vignetting = 4\n"), HasSubstr("must be \"none\", \"cos4\" or three coefficients"));
  EXPECT_THAT(wrong("psf_px = -1\n"), HasSubstr("must be >= 0 and <= 20, is -1"));
}

TEST_F(TwinFile, LightOfImages) {
  const std::string kSteps = with(kFringes, "steps", "steps = 3"), ten = "[1, 1, 1, 1, 1, 1, 1, 1, 0.9, 1.1]",
                    nine = "[1, 1, 1, 1.02, 1, 1, 0.98, 1, 1]";
  const auto text = [&](const std::string& camera, const std::string& projector) {
    return kHead + kCamera + camera + kProjector + projector + kSteps;
  };
  const Twin none = load(text("", ""));
  EXPECT_TRUE(none.cameras[0].exposure_factors.empty() && none.projector->light_factors.empty() &&
              none.projector->ambient_factors.empty());
  const Twin twin =
      load(text("exposure_factors = " + nine + "\n",
                "light_factors = " + nine + "\nambient_factors = [1, 0, 1, 1, 1, 1, 1, 1, 2]\n"));
  EXPECT_EQ(twin.cameras[0].exposure_factors[6], 0.98);
  EXPECT_EQ(twin.projector->light_factors[3], 1.02);
  EXPECT_EQ(twin.projector->ambient_factors[1], 0.0);
  for (const std::string key : {"light_factors", "ambient_factors"}) {
    EXPECT_THAT(error(text("", key + " = " + ten + "\n"), key),
                HasSubstr(key + " has 10 numbers, the sequence has 9 images"));
    EXPECT_THAT(error(text("", key + " = [1, 1, 1, 1, -1, 1, 1, 1, 1]\n"), key), HasSubstr("must be >= 0"));
  }
  EXPECT_FALSE(none.projector->has_image_shifts());
  const std::string shifts = "image_shifts_px = [0, 0.5, 0, 0, -1.25, 0, 0, 0, 0]\n";
  EXPECT_EQ(load(text("", shifts)).projector->image_shift_px(4), -1.25);
  EXPECT_THAT(error(text("", "image_shifts_px = " + ten + "\n"), "image_shifts_px"),
              HasSubstr("give a shift for each image"));
  EXPECT_THAT(error(text("", "pixel_structure = true\n" + shifts), "image_shifts_px"),
              HasSubstr("cannot be combined with pixel_structure"));
  EXPECT_THAT(error(text("exposure_factors = " + ten + "\n", ""), "exposure_factors"),
              HasSubstr("exposure_factors has 10 numbers, the sequence has 9 images"));
  EXPECT_FALSE(load(kMinimal).measure.correct_light);
  EXPECT_FALSE(load(kMinimal + "[measure]\nlight = \"as_is\"\n").measure.correct_light);
  EXPECT_TRUE(load(kMinimal + "[measure]\nlight = \"corrected\"\n").measure.correct_light);
  EXPECT_THAT(error(kMinimal + "[measure]\nlight = \"correct\"\n", "light"), HasSubstr("corrected"));
  EXPECT_THAT(error(text("exposure_factors = 1.0\n", ""), "exposure_factors"), HasSubstr("exposure_factors"));
  EXPECT_THAT(error(kHead + kCamera + kProjectorLens + "ambient_factors = " + nine + "\n" + kSteps,
                    "ambient_factors"),
              HasSubstr("has no effect without ambient > 0 or [room] lamp"));
}

TEST_F(TwinFile, MotionOfObjects) {
  const auto motion = [&](const std::string& keys) { return load(kMinimal + keys).objects.at(0); };
  EXPECT_TRUE(motion(kBall).motion.empty());
  const Object ball = motion(kBall + "motion = { center_mm = [0.05, 0, -0.01] }\n");
  EXPECT_THAT(ball.motion, ElementsAre(0.05, 0.0, -0.01));
  EXPECT_EQ(motion_text(ball), "{ center_mm = [0.05, 0, -0.01] }");
  const std::string pole =
      "[[object]]\nname = \"pole\"\nshape = \"cylinder\"\npoint_mm = [0, 0, 300]\naxis = [0, 1, "
      "0]\nradius_mm = 5\n";
  const Object turned = motion(pole + "motion = { tilt_rad = [0.001, 0.002], shift_mm = [3, 4] }\n");
  EXPECT_THAT(turned.motion, ElementsAre(3.0, 0.001, 4.0, 0.002));  // in the order of the shape's motions()
  EXPECT_EQ(motion_text(turned), "{ shift_mm = [3, 4], tilt_rad = [0.001, 0.002] }");
  const std::string wall =
      "[[object]]\nname = \"wall\"\nshape = \"plane\"\npoint_mm = [0, 0, 300]\nnormal = [0, 0, -1]\n";
  const Object pushed = motion(wall + "motion = { offset_mm = 0.2 }\n");
  EXPECT_THAT(pushed.motion, ElementsAre(0.2, 0.0, 0.0));
  EXPECT_EQ(motion_text(pushed), "{ offset_mm = 0.2 }");
  EXPECT_EQ(motion_text(motion(kBall)), "{}");
  const auto wrong = [&](const std::string& object, const std::string& line) {
    return error(kMinimal + object + line, line);
  };
  EXPECT_THAT(wrong(kBall, "motion = { centre_mm = [1, 2, 3] }\n"), HasSubstr("did you mean \"center_mm\"?"));
  EXPECT_THAT(wrong(kBall, "motion = { center_mm = [1, 2] }\n"), HasSubstr("must have 3 numbers, has 2"));
  EXPECT_THAT(wrong(kBall, "motion = { center_mm = [1, 2, 3000] }\n"),
              HasSubstr("must be >= -1000 and <= 1000"));
  EXPECT_THAT(wrong(wall, "motion = { offset_mm = [1] }\n"), HasSubstr("must be a number"));
  EXPECT_THAT(
      wrong("[[object]]\nname = \"o\"\nshape = \"measured\"\n", "motion = { shift_mm = [1, 2, 3] }\n"),
      HasSubstr("is not possible for a measured shape"));
}

TEST_F(TwinFile, GgxMaterial) {
  const auto material = [&](const std::string& keys) {
    return load(kMinimal + kBall + "[object.material]\n" + keys).objects[0].material;
  };
  EXPECT_EQ(material("").specular_model, Material::Specular::phong);
  const Material m = material("specular_model = \"ggx\"\nspecular = 0.04\nroughness = 0.3\n");
  EXPECT_EQ(m.specular_model, Material::Specular::ggx);
  EXPECT_EQ(m.specular, 0.04);
  EXPECT_EQ(m.roughness, 0.3);
  const auto wrong = [&](const std::string& keys, const std::string& line) {
    return error(kMinimal + kBall + "[object.material]\n" + keys, line);
  };
  EXPECT_THAT(wrong("roughness = 0.3\n", "roughness"),
              HasSubstr("has no effect with specular_model = \"phong\""));
  EXPECT_THAT(wrong("specular_model = \"ggx\"\nshininess = 3\n", "shininess"), HasSubstr("use roughness"));
  EXPECT_THAT(wrong("specular_model = \"ggx\"\nspecular = 1.5\n", "specular = 1.5"),
              HasSubstr("must be >= 0 and <= 1, is 1.5"));
  EXPECT_THAT(wrong("specular_model = \"ggx\"\nroughness = 0\n", "roughness"),
              HasSubstr("must be > 0 and <= 1"));
}

TEST_F(TwinFile, AlbedoMap) {
  ImageF map(2, 1);
  map.data = {51.0F, 255.0F};
  write_gray_png(folder_ / "map.png", map, 8);
  const std::string plane =
      "[[object]]\nname = \"p\"\nshape = \"plane\"\npoint_mm = [0, 0, 300]\nnormal = [0, 0, -1]\n";
  Twin twin = load(kMinimal + plane + "size_mm = [20, 10]\nalbedo_map = \"map.png\"\n");
  load_meshes(twin);
  const auto& shape = std::get<PlaneShape>(twin.objects[0].shape);
  ASSERT_TRUE(shape.albedo_map);
  EXPECT_THAT(shape.albedo_map->data, ElementsAre(0.2F, 1.0F));
  EXPECT_EQ(twin.input_files.back(), folder_ / "map.png");
  EXPECT_THAT(error(kMinimal + plane + "albedo_map = \"map.png\"\n", "albedo_map"),
              HasSubstr("needs size_mm"));
}

TEST_F(TwinFile, TextureOfACamera) {
  const auto with = [](const std::string& file) {
    std::string text = kMinimal;
    const std::string head = "[[camera]]\n";
    return text.insert(text.find(head) + head.size(), "texture = \"" + file + "\"\n");
  };
  const Twin plain = load(kMinimal);
  EXPECT_TRUE(plain.cameras[0].texture_file.empty());
  const int width = plain.cameras[0].lens.width(), height = plain.cameras[0].lens.height();
  const ImageF factor(width, height, 0.5F), offset(width, height, -0.25F), small(width - 1, height, 1.0F);
  write_exr(folder_ / "both.exr", {{"factor", &factor}, {"offset", &offset}});
  write_exr(folder_ / "small.exr", {{"factor", &small}});
  write_exr(folder_ / "other.exr", {{"phase", &factor}});
  write_exr(folder_ / "negative.exr", {{"factor", &offset}});
  Twin twin = load(with("both.exr"));
  load_meshes(twin);
  ASSERT_TRUE(twin.cameras[0].texture);
  EXPECT_EQ(twin.cameras[0].texture->of(2.0F, 7, 1.0), 0.75F);
  EXPECT_EQ(twin.input_files.back(), folder_ / "both.exr");
  for (const auto& [file, says] : {std::pair{"small.exr", "the camera"},
                                   {"other.exr", "phase"},
                                   {"negative.exr", "factor"},
                                   {"none.exr", "none.exr"}}) {
    Twin bad = load(with(file));
    try {
      load_meshes(bad);
      ADD_FAILURE() << file << " is taken";
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::input) << file;
      EXPECT_THAT(e.what(), HasSubstr(says)) << file;
    }
  }
}

TEST_F(TwinFile, Bounces) {
  EXPECT_EQ(load(kMinimal).render.bounces, 0);
  const RenderOptions r = load(kMinimal + "[render]\nbounces = 1\nbounce_samples = 16\n").render;
  EXPECT_EQ(r.bounces, 1);
  EXPECT_EQ(r.bounce_samples, 16);
  EXPECT_FALSE(r.glossy_bounces);
  EXPECT_TRUE(load(kMinimal + "[render]\nbounces = 1\nglossy_bounces = true\n").render.glossy_bounces);
  EXPECT_THAT(error(kMinimal + "[render]\nglossy_bounces = true\n", "glossy_bounces"),
              HasSubstr("has no effect without bounces"));
  // as `--refine bounce` leaves it where it takes them away
  const auto warning = [&](const std::string& keys) {
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(load(kMinimal + "[render]\nbounces = 0\nbounce_samples = 16\n" + keys).render.bounces, 0);
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_THAT(warning("glossy_bounces = true\n"),
              HasSubstr("[render] glossy_bounces has no effect with bounces = 0"));
  EXPECT_EQ(warning("glossy_bounces = false\n"), "");
  EXPECT_EQ(load(kMinimal + "[render]\nbounces = 5\n").render.bounces, 5);
  EXPECT_EQ(load(kMinimal + "[render]\nbounces = \"all\"\n").render.bounces, kAllBounces);
  EXPECT_THAT(error(kMinimal + "[render]\nbounces = 101\n", "bounces"),
              HasSubstr("must be 0 ... 100, is 101"));
  EXPECT_THAT(error(kMinimal + "[render]\nbounces = \"al\"\n", "bounces"), HasSubstr("\"all\""));
  EXPECT_THAT(error(kMinimal + "[render]\nbounce_samples = 9\n", "bounce_samples"),
              HasSubstr("has no effect without bounces"));
}

TEST_F(TwinFile, CameraModelFilesInMetresAndMillimetres) {
  CameraModelFile model;
  model.lensmodel = "LENSMODEL_PINHOLE";
  model.intrinsics = {600, 600, 319.5, 239.5};
  model.imagersize = {640, 480};
  model.rt_cam_ref = {0, 0.25, 0, -0.1, 0.002, 0.02};
  fs::create_directories(folder_ / "rig");
  write_cameramodel(folder_ / "rig" / "left.cameramodel", model);
  const std::string camera = "[[camera]]\nname = \"left\"\nmodel = \"rig/left.cameramodel\"\n";
  const Twin metres = load(kHead + camera + kFringes);
  const Eigen::Vector3d t_mm(-100, 2, 20);
  EXPECT_LT((metres.cameras[0].T_cam_world.translation_mm - t_mm).norm(), 1e-12);
  EXPECT_THAT(metres.input_files, ElementsAre(folder_ / "twin.toml", folder_ / "rig" / "left.cameramodel"));
  const Twin plain = load("schema = \"fringetwin-twin/1\"\n" + camera + kFringes);  // "m" is the default
  EXPECT_EQ(plain.cameras[0].T_cam_world.translation_mm, metres.cameras[0].T_cam_world.translation_mm);
  const Twin mm = load(with(kHead, "cameramodel_unit", "cameramodel_unit = \"mm\"") + camera + kFringes);
  EXPECT_EQ(mm.cameras[0].T_cam_world.translation_mm, Eigen::Vector3d(-0.1, 0.002, 0.02));
}

TEST_F(TwinFile, OpenCvCalibrationInPlace) {
  std::ofstream(folder_ / "cali.yml")
      << "%YAML:1.0\n---\n"
         "M1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 600., 0., 319.5, 0., 600., "
         "239.5, 0., 0., 1. ]\n"
         "D1: !!opencv-matrix\n   rows: 1\n   cols: 4\n   dt: d\n   data: [ -0.1, 0., 0., 0. ]\n"
         "R: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1., 0., 0., 0., 1., 0., 0., 0., "
         "1. ]\n"
         "T: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ -100., 1., 2. ]\n";
  const std::string camera =
      "[[camera]]\nname = \"left\"\nimagersize = [640, 480]\n"
      "opencv = { files = [\"cali.yml\"], matrix = \"M1\", distortion = \"D1\" }\n";
  const std::string projector =
      "[projector]\nimagersize = [640, 480]\n"
      "opencv = { files = [\"cali.yml\"], matrix = \"M1\", distortion = \"D1\", rotation = \"R\", "
      "translation = "
      "\"T\" }\n";
  const Twin twin = load(kHead + camera + projector + kFringes);
  EXPECT_EQ(twin.cameras[0].T_cam_world.translation_mm, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(twin.projector->T_proj_world.translation_mm, Eigen::Vector3d(-100, 1, 2));
  EXPECT_EQ(twin.projector->lens.intrinsics().at(4), -0.1);
  EXPECT_EQ(twin.input_files.size(), 3u);
  EXPECT_THAT(error(kHead + camera +
                        with(projector, "opencv",
                             "opencv = { files = [\"cali.yml\"], matrix = \"M1\", distortion = \"D1\", "
                             "rotation = \"R\" }") +
                        kFringes,
                    "opencv = { files = [\"cali.yml\"], matrix = \"M1\", distortion = \"D1\", rotation"),
              HasSubstr("projector.opencv.translation is missing"));
}

TEST_F(TwinFile, GrayFringesWithOverridesPerDirection) {
  const Twin twin =
      load(kHead + kCamera + kGray +
           "[fringes.y]\npitches_px = [40.5]\nphase_origin_px = [-0.5]\n[fringes.y.gray]\nbits = 6\n"
           "order = \"msb-first\"\n");
  const Fringes& fringes = twin.fringes;
  EXPECT_EQ(fringes.steps, 12);
  EXPECT_EQ(fringes.unwrap, Unwrap::gray);
  EXPECT_EQ(fringes.mean, 0.4);
  EXPECT_EQ(fringes.amplitude, 0.3);
  ASSERT_EQ(fringes.directions.size(), 2u);
  const DirectionFringes &x = fringes.directions[0], &y = fringes.directions[1];
  EXPECT_EQ(x.axis, Axis::x);
  EXPECT_THAT(x.pitches_px, ElementsAre(60));
  EXPECT_THAT(x.phase_origin_px, ElementsAre(30));
  EXPECT_EQ(x.gray->bits, 5);
  EXPECT_TRUE(x.gray->lsb_first && x.gray->complementary);
  EXPECT_EQ(x.gray->offset_periods, -0.5);
  EXPECT_EQ(x.gray->threshold, GrayCode::Threshold::inverse);
  EXPECT_EQ(y.axis, Axis::y);
  EXPECT_THAT(y.pitches_px, ElementsAre(40.5));
  EXPECT_THAT(y.phase_origin_px, ElementsAre(-0.5));
  EXPECT_EQ(y.gray->bits, 6);
  EXPECT_FALSE(y.gray->lsb_first);
  EXPECT_TRUE(y.gray->complementary) << "what [fringes.y.gray] leaves out comes from [fringes.gray]";
  // 2 directions x (12 steps + bits in pairs + one complementary pair)
  EXPECT_EQ(expand_sequence(fringes).size(), static_cast<std::size_t>(12 + 2 * 6 + 12 + 2 * 7));
}

TEST_F(TwinFile, PhaseOriginPerPitchAndOtherUnwrapping) {
  const Twin twin = load(kHead + kCamera +
                         "[fringes]\ndirections = [\"y\"]\npitches_px = [64, 16, 4, 1]\nsteps = 3\n"
                         "unwrap = \"hierarchical\"\nphase_origin_px = [32, 8, 2, 0.5]\n");
  EXPECT_EQ(twin.fringes.unwrap, Unwrap::hierarchical);
  EXPECT_THAT(twin.fringes.directions[0].phase_origin_px, ElementsAre(32, 8, 2, 0.5));
  EXPECT_EQ(load(kHead + kCamera +
                 "[fringes]\ndirections = [\"x\"]\npitches_px = [8]\nsteps = 3\nunwrap = \"none\"\n")
                .fringes.unwrap,
            Unwrap::none);
  const Twin gray_only =
      load(kHead + kCamera +
           "[fringes]\ndirections = [\"x\"]\npitches_px = [1]\nsteps = 0\nunwrap = \"gray\"\n"
           "[fringes.gray]\nbits = 10\nthreshold = \"white-black\"\n");
  EXPECT_EQ(gray_only.fringes.steps, 0);
  EXPECT_EQ(gray_only.fringes.directions[0].gray->threshold, GrayCode::Threshold::white_black);
}

TEST_F(TwinFile, EveryShapeAndMaterialKey) {
  const Twin twin =
      load(kMinimal + kBall + "[object.material]\ndiffuse = 0.5\nspecular = 0.25\nshininess = 20\n" +
           "[[object]]\nname = \"wall\"\nshape = \"plane\"\npoint_mm = [0, 0, 300]\nnormal = [0, 0, -2]\n"
           "size_mm = [100, 50]\nu_axis = [1, 1, 1]\n"
           "[[object]]\nname = \"floor\"\nshape = \"plane\"\npoint_mm = [0, 50, 300]\nnormal = [1, 0, 0]\n"
           "[[object]]\nname = \"tube\"\nshape = \"cylinder\"\npoint_mm = [1, 2, 3]\naxis = [0, 3, "
           "4]\nradius_mm = 7\n"
           "length_mm = 20\n"
           "[[object]]\nname = \"part\"\nshape = \"mesh\"\nfile = \"cad/../part.stl\"\nunit = \"m\"\n"
           "rt_world_object = [0, 0, 0, 1, 2, 3]\nshading = \"smooth\"\n"
           "[[object]]\nname = \"relief\"\nshape = \"measured\"\nsteps = \"odd\"\nsmoothing_px = 2.5\n");
  ASSERT_EQ(twin.objects.size(), 6u);
  const auto& ball = std::get<SphereShape>(twin.find_object("ball")->shape);
  EXPECT_EQ(ball.center_mm, Eigen::Vector3d(0, 1, 250));
  EXPECT_EQ(ball.radius_mm, 5.0);
  EXPECT_EQ(twin.objects[0].material.diffuse, 0.5);
  EXPECT_EQ(twin.objects[0].material.specular, 0.25);
  EXPECT_EQ(twin.objects[0].material.shininess, 20.0);
  const auto& wall = std::get<PlaneShape>(twin.find_object("wall")->shape);
  EXPECT_EQ(wall.normal, Eigen::Vector3d(0, 0, -1));
  EXPECT_EQ(*wall.size_mm, Eigen::Vector2d(100, 50));
  EXPECT_LT((wall.u_axis - Eigen::Vector3d(std::sqrt(0.5), std::sqrt(0.5), 0)).norm(), 1e-15);
  EXPECT_EQ(twin.objects[1].material.diffuse, 0.8);
  const auto& floor = std::get<PlaneShape>(twin.find_object("floor")->shape);
  EXPECT_FALSE(floor.size_mm);
  EXPECT_EQ(floor.u_axis.dot(floor.normal), 0.0);
  const auto& tube = std::get<CylinderShape>(twin.find_object("tube")->shape);
  EXPECT_LT((tube.axis - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 1e-15);
  EXPECT_EQ(tube.length_mm, 20.0);
  const auto& part = std::get<MeshShape>(twin.find_object("part")->shape);
  EXPECT_EQ(part.file, folder_ / "part.stl");
  EXPECT_EQ(part.unit, "m");
  EXPECT_TRUE(part.smooth);
  EXPECT_EQ(part.T_world_object.translation_mm, Eigen::Vector3d(1, 2, 3));
  const auto& relief = std::get<MeasuredShape>(twin.find_object("relief")->shape);
  EXPECT_EQ(relief.steps, "odd");
  EXPECT_EQ(relief.smoothing_px, 2.5);
  EXPECT_STREQ(shape_kind(twin.objects[5].shape), "measured");
  EXPECT_EQ(twin.find_object("nobody"), nullptr);
}

TEST_F(TwinFile, OptionsResultsAndLimits) {
  const std::string text =
      kHead + kCamera + kRight + kFringes + kBall +
      "[render]\npixel_fill = 0.5\nphase_error_rad = 1e-5\nsamples = 16\n"
      "sampler = \"multi-jittered\"\nshadow = false\n"
      "[compare]\nhold_out = 4\nhold_out_by = \"pitches\"\n"
      "[measure]\ntriangulate = \"stereo\"\nmin_modulation_dn = 8\ncorrect_pixel_area = true\n"
      "[[measure.fit]]\nobject = \"ball\"\ngate_mm = 1.5\n";
  const Twin twin =
      load(text +
           "[real.results]\nsource = \"Table 5\"\n[[real.results.fit]]\nobject = \"ball\"\n"
           "center_mm = [1, 2, 3]\nradius_mm = 19.065\nrms_mm = 0.013\n"
           "[uncertainty]\ncalibration = \"twin.toml\"\n"
           "[limits]\ncenter_mm = 0.001\nradius_mm = 0.002\nrms_mm = 0.004\nphase_rms_rad = 0.05\n"
           "phase_mean_relative = 0.001\ngray_rms_dn = 3\ngain_r2 = 0.9\n");
  EXPECT_EQ(twin.render.pixel_fill, 0.5);
  EXPECT_EQ(twin.render.phase_error_rad, 1e-5);
  EXPECT_EQ(twin.render.samples, 16);
  EXPECT_EQ(twin.render.sampler, Sampler::multi_jittered);
  EXPECT_FALSE(twin.render.shadow);
  EXPECT_EQ(twin.measure.triangulate, Triangulate::stereo);
  EXPECT_EQ(twin.measure.min_modulation_dn, 8.0);
  EXPECT_TRUE(twin.measure.correct_pixel_area);
  EXPECT_EQ(twin.compare.hold_out, 4);
  EXPECT_EQ(twin.compare.hold_out_by, HeldOutBy::pitches);
  EXPECT_EQ(twin.measure.fits.at(0).object, "ball");
  EXPECT_EQ(twin.measure.fits.at(0).gate_mm, 1.5);
  EXPECT_EQ(twin.real.results_source, "Table 5");
  EXPECT_EQ(twin.real.results.at(0).numbers.at("radius_mm"), 19.065);
  EXPECT_EQ(twin.real.results.at(0).vectors.at("center_mm"), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(twin.calibration_uncertainty, twin.file);  // any file that is there
  EXPECT_EQ(twin.input_files.back(), twin.file);
  EXPECT_EQ(twin.limits.size(), 7u);
  EXPECT_EQ(twin.limits.at("gray_rms_dn"), 3.0);
  EXPECT_EQ(load(text + "[real]\ncaptures = \"real/\"\n").real.captures->lexically_relative(folder_).string(),
            "real/");
}

TEST_F(TwinFile, CapturesVariable) {
  ASSERT_EQ(::setenv("FRINGETWIN_CAPTURES", "/some/where", 1), 0);
  EXPECT_EQ(captures_root(), "/some/where");
  const Twin twin = load(kMinimal + "[real]\ncaptures = \"${FRINGETWIN_CAPTURES}/set\"\n");
  EXPECT_EQ(twin.real.captures, "/some/where/set");
  ::unsetenv("FRINGETWIN_CAPTURES");
  EXPECT_TRUE(captures_root().is_absolute());
  EXPECT_EQ(captures_root().filename(), "captures");
  EXPECT_THAT(error(kMinimal + "[real]\ncaptures = \"${HOME}/set\"\n", "captures ="),
              HasSubstr("${HOME}/set"));
}

TEST_F(TwinFile, MeshesAreReadOnceAndShared) {
  std::ofstream(folder_ / "a.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const auto object = [](const std::string& name, const std::string& unit) {
    return "[[object]]\nname = \"" + name + "\"\nshape = \"mesh\"\nfile = \"a.obj\"\nunit = \"" + unit +
           "\"\n";
  };
  Twin twin = load(kMinimal + object("one", "mm") + object("two", "mm") + object("big", "m"));
  load_meshes(twin);
  const auto mesh = [&](std::size_t k) { return std::get<MeshShape>(twin.objects[k].shape).mesh; };
  EXPECT_EQ(mesh(0), mesh(1));
  EXPECT_EQ(mesh(2)->vertices_mm[1].x(), 1000.0f);
  EXPECT_THAT(twin.input_files, ::testing::Contains(folder_ / "a.obj"));
}

/// As in Germany: 601,5 and 1.000.
class CommaDecimals : public std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST_F(TwinFile, ACommaLocaleChangesNothing) {
  const std::locale saved = std::locale::global(std::locale(std::locale::classic(), new CommaDecimals));
  const Twin twin = load(kMinimal + "[render]\nsamples = 1024\nphase_error_rad = 2.5e-3\n");
  const std::string message = any_error(kMinimal + "[render]\npixel_fill = 1234.5\n");
  std::locale::global(saved);
  EXPECT_EQ(twin.cameras[0].lens.intrinsics()[1], 601.5);
  EXPECT_EQ(twin.render.phase_error_rad, 2.5e-3);
  EXPECT_EQ(twin.render.samples, 1024);
  EXPECT_THAT(message, HasSubstr("is 1234.5"));
}

TEST_F(TwinFile, PatternImages) {
  ImageF small(4, 3);
  small.data = {0, 51, 102, 153, 204, 255, 0, 0, 0, 0, 0, 255};
  write_gray_png(folder_ / "small.png", small, 8);
  ImageF image(640, 480);
  image(7, 5) = 65535;
  image(8, 5) = 13107;
  write_gray_png(folder_ / "deep.png", image, 16);
  const std::string key = "images = [\"deep.png\", \"deep.png\"]\n";
  const Twin twin = load(kHead + kCamera + kProjector + kFringes + key);
  ASSERT_EQ(twin.fringes.images.size(), 2u);
  const auto sequence = expand_sequence(twin.fringes);
  ASSERT_EQ(sequence.size(), 14u);
  EXPECT_TRUE(sequence[13].is_image());
  EXPECT_FALSE(sequence[13].is_gray());
  EXPECT_EQ(sequence[13].image, 1);
  EXPECT_EQ(sequence[13].label(twin.fringes), "image deep.png");
  EXPECT_EQ(image_level(*twin.fringes.images[0].levels, 7.4, 4.6), 1.0);
  EXPECT_NEAR(image_level(*twin.fringes.images[0].levels, 7.6, 5.4), 0.2, 1e-6);
  EXPECT_EQ(image_level(*twin.fringes.images[0].levels, 6.4, 5.0), 0.0);
  EXPECT_THROW(load(kHead + kCamera + kProjector + kFringes + "images = [\"small.png\"]\n"), UserError);
  EXPECT_THROW(load(kHead + kCamera + kProjector + kFringes + "images = [\"none.png\"]\n"), UserError);
  EXPECT_THROW(load(kHead + kCamera + kFringes + key), UserError);
}

}  // namespace
}  // namespace fringetwin::testing::twin_file_test
