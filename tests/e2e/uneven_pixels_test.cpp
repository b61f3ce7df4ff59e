// SPDX-License-Identifier: Apache-2.0
// A camera whose pixels differ in gain and offset, and whose gray values bend at a knee, as the
// double-precision reference and formulas that are written out here see it: the twin that knows of both is
// explained; one that lacks the maps, the knee or both is not, and what it lacks is named. What each pixel
// has of its own is fitted, on three shapes, and the twin that they are put into explains the images by
// itself.
//
// | check             | tolerance | origin                                                     |
// |-------------------|-----------|------------------------------------------------------------|
// | gain, black level | 4 sigma   | two numbers, normal: one seed in 8,000                     |
// | knee, slope       | 4 sigma   | the same                                                   |
// | gain's sigma      | 1 %       | so that 4 sigma tell the knee, which moves it by 5 %       |
// | factors, offsets  | 5 %       | of their rms error over the predicted one: 8,000 pixels    |
// |                   |           | tell it to 0.8 %, the noise's own model is good to 3 %     |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "render/reference/reference.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/image/image_io.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing::uneven_pixels_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kWidth = 160, kHeight = 120;
constexpr double kGainDn = 20.0, kBlackDn = 12.0, kElectronsPerDn = 400.0, kReadDn = 0.5;
constexpr double kPrnu = 0.01, kDsnuDn = 0.7, kKneeDn = 100.0, kSlope = 0.85;

const std::string kMaps = "prnu = \"factors.exr\"\ndsnu = \"offsets.exr\"\n",
                  kKnee = "response = { knee_dn = 100, slope = 0.85 }\n";

const std::string kBall = "shape = \"sphere\"\ncenter_mm = [0, 0, 270]\nradius_mm = 19\n",
                  kPlane = "shape = \"plane\"\npoint_mm = [0, 0, 260]\nnormal = [0.2, 0.1, -1]\n",
                  kRoof = "shape = \"mesh\"\nfile = \"roof.ply\"\n";

/// A roof that fills the image, its ridge along y.
constexpr const char* kRoofPly =
    "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "-60 -60 275\n0 -60 255\n60 -60 275\n-60 60 275\n0 60 255\n60 60 275\n"
    "3 0 3 1\n3 1 3 4\n3 1 4 2\n3 2 4 5\n";

/// The rig with these keys of its sensor besides, before an object of its own.
std::string rig(const std::string& sensor, const std::string& object = kBall) {
  std::vector<std::pair<std::string, std::string>> replace{
      {"gain_dn = 20",
       "gain_dn = 20\nblack_level_dn = 12\nelectrons_per_dn = 400\nread_noise_dn = 0.5\n" + sensor},
      {"intrinsics = [260, 260", "intrinsics = [800, 800"},  // a fringe is 6 pixels wide
      {kBall, object}};
  if (object != kBall) replace.emplace_back("[[measure.fit]]\nobject = \"ball\"\n", "");
  return small_twin(replace, "[real]\ncaptures = \"real\"\n");
}

class UnevenPixels : public ::testing::Test {
 protected:
  void SetUp() override {
    FT_NEED_DEVICE();
    draw_pixels();
    write_file(dir_ / "roof.ply", kRoofPly);
    record(kBall);
  }

  void draw_pixels() {
    std::normal_distribution<double> normal;
    for (float& f : factor_.data) f = static_cast<float>(1.0 + kPrnu * normal(random_));
    for (float& o : offset_dn_.data) o = static_cast<float>(kDsnuDn * normal(random_));
    write_exr(dir_ / "factors.exr", {{"factor", &factor_}});
    write_exr(dir_ / "offsets.exr", {{"offset_dn", &offset_dn_}});
  }

  /// What a pixel says of its light.
  float gray_value(double irradiance, std::size_t i) {
    std::normal_distribution<double> normal;
    const double light_dn = kGainDn * static_cast<double>(factor_.data[i]) * irradiance;
    const bool beyond = light_dn > kKneeDn;
    const double bent_dn = beyond ? kKneeDn + kSlope * (light_dn - kKneeDn) : light_dn;
    const double shot_dn = (beyond ? kSlope : 1.0) * std::sqrt(light_dn / kElectronsPerDn);
    const double dn = bent_dn + kBlackDn + static_cast<double>(offset_dn_.data[i]) +
                      std::hypot(shot_dn, kReadDn) * normal(random_);
    return static_cast<float>(std::clamp(std::round(dn), 0.0, 255.0));
  }

  void record(const std::string& object) {
    object_ = object;
    write_file(dir_ / "light.toml", rig("", object));
    Twin light = load_twin(dir_ / "light.toml");
    load_meshes(light);
    const render::Reference reference(light);
    std::vector<ImageF> images(expand_sequence(light.fringes).size(), ImageF(kWidth, kHeight));
    irradiance_ = images;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const render::ReferencePixel pixel = reference.pixel(0, x, y, {.gauss_n = 4});
        for (std::size_t k = 0; k < images.size(); ++k) {
          irradiance_[k](x, y) = static_cast<float>(pixel.irradiance[k]);
          images[k](x, y) = gray_value(pixel.irradiance[k], images[k].index(x, y));
        }
      }
    fs::create_directories(dir_ / "real" / "left");
    for (std::size_t k = 0; k < images.size(); ++k) {
      const std::string number = std::to_string(k);
      write_gray_png(dir_ / "real" / "left" / (std::string(4 - number.size(), '0') + number + ".png"),
                     images[k], 8);
    }
    write_file(
        dir_ / "real" / "capture.toml",
        "schema = \"fringetwin-captures/1\"\n[[camera]]\nname = \"left\"\npattern = \"left/%04d.png\"\n");
  }

  /// Standard errors of a factor and an offset of a pixel that is right, from the line through its values by
  /// least squares without weights.
  struct LineSigma {
    double factor, offset_dn;
  };
  LineSigma line_sigma(std::size_t i) const {
    double xx = 0.0, of_factor = 0.0, of_offset = 0.0;
    const double n = static_cast<double>(irradiance_.size()), mean_dn = mean_light_dn(i);
    const auto from_mean_dn = [&](const ImageF& e) {
      return kGainDn * static_cast<double>(e.data[i]) - mean_dn;
    };
    for (const ImageF& e : irradiance_) xx += std::pow(from_mean_dn(e), 2);
    for (const ImageF& e : irradiance_) {
      const double light_dn = kGainDn * static_cast<double>(e.data[i]),
                   slope = light_dn > kKneeDn ? kSlope : 1.0,
                   variance = light_dn / kElectronsPerDn + (kReadDn * kReadDn + 1.0 / 12.0) / (slope * slope),
                   weight = from_mean_dn(e) / xx;
      of_factor += weight * weight * variance;
      of_offset += std::pow(1.0 / n - mean_dn * weight, 2) * variance;
    }
    return {std::sqrt(of_factor), std::sqrt(of_offset)};
  }

  double mean_light_dn(std::size_t i) const {
    double sum = 0.0;
    for (const ImageF& e : irradiance_) sum += kGainDn * static_cast<double>(e.data[i]);
    return sum / static_cast<double>(irradiance_.size());
  }
  /// Returns whether the border of light is two pixels away or more: the points of a pixel that it crosses
  /// are no exact truth.
  bool is_lit_around(int x, int y) const {
    constexpr double kLeastLightDn = 5.0;
    const ImageF& image = irradiance_.front();
    for (int v = y - 2; v <= y + 2; ++v)
      for (int u = x - 2; u <= x + 2; ++u)
        if (u < 0 || v < 0 || u >= kWidth || v >= kHeight ||
            !(mean_light_dn(image.index(u, v)) > kLeastLightDn))
          return false;
    return true;
  }

  /// Expects that the texture which was written has the pixels' factors and offsets to their noise.
  void expect_own_found(const fs::path& texture) const {
    const std::vector<std::pair<std::string, ImageF>> channels = read_exr(texture);
    const auto channel = [&](const char* name) {
      return std::ranges::find(channels, name, &std::pair<std::string, ImageF>::first)->second;
    };
    const ImageF factor = channel("factor"), offset = channel("offset");
    double factors = 0.0, offsets = 0.0, n = 0.0;
    for (std::size_t i = 0; i < factor.size(); ++i) {
      if (!is_lit_around(static_cast<int>(i) % kWidth, static_cast<int>(i) / kWidth)) continue;
      const LineSigma sigma = line_sigma(i);
      const auto at = [i](const ImageF& image) { return static_cast<double>(image.data[i]); };
      factors += std::pow((at(factor) - at(factor_)) / sigma.factor, 2);
      offsets += std::pow((kGainDn * at(offset) - at(offset_dn_)) / sigma.offset_dn, 2);
      n += 1.0;
    }
    EXPECT_GT(n, 8'000.0);
    EXPECT_NEAR(std::sqrt(factors / n), 1.0, 0.05);
    EXPECT_NEAR(std::sqrt(offsets / n), 1.0, 0.05);
  }

  json compared(const std::string& sensor, const std::vector<std::string>& more = {}) const {
    write_file(dir_ / "twin.toml", rig(sensor, object_));
    return compared_twin(dir_ / "twin.toml", dir_ / "out", more);
  }
  json compared_twin(const fs::path& twin, const fs::path& out,
                     const std::vector<std::string>& more = {}) const {
    std::vector<std::string> command{"cosim", twin.string(), "--out", out.string()};
    command.insert(command.end(), more.begin(), more.end());
    const RunResult run = run_fringetwin(command);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return read_json(out / "result.json");
  }

  std::string object_ = kBall;
  std::vector<ImageF> irradiance_;
  std::mt19937_64 random_{4};
  ImageF factor_{kWidth, kHeight}, offset_dn_{kWidth, kHeight};
  fs::path dir_ = scratch_folder("uneven-pixels");
};

TEST_F(UnevenPixels, AreExplainedByTheTwinThatHasThem) {
  const json result = compared(kMaps + kKnee);
  for (const char* quantity : {"gray", "phase", "geometry"})
    EXPECT_EQ(result["budget_verdict"][quantity], "explained") << result["explained"].dump(1);
  const json& gain = result["gain"][0];
  EXPECT_NEAR(gain["gain_dn"].get<double>(), kGainDn, 4.0 * gain["gain_sigma_dn"].get<double>());
  EXPECT_LT(gain["gain_sigma_dn"].get<double>(), 0.01 * kGainDn);
  EXPECT_NEAR(gain["black_level_dn"].get<double>(), kBlackDn,
              4.0 * gain["black_level_sigma_dn"].get<double>());
}

// A factor and an offset of each pixel: what a sensor's pixels have of their own cannot be told from the
// texture of the surface by one capture. They move no phase.
TEST_F(UnevenPixels, WithoutTheirMapsAreNamed) {
  const json result = compared(kKnee);
  EXPECT_EQ(result["budget_verdict"]["gray"], "not explained") << result["explained"].dump(1);
  EXPECT_EQ(result["budget_verdict"]["phase"], "explained") << result["explained"].dump(1);
  EXPECT_EQ(result["causes"]["named"], "texture and offset") << result["causes"].dump(1);
}

// On a ball, a plane and a mesh: planted factors of 1 % and offsets of 0.7 DN are found in every pixel to its
// noise, and the twin that they are put into says the same of the images as the run that found them.
TEST_F(UnevenPixels, AreRefinedBackAndStayWithTheTwin) {
  for (const std::string& object : {kBall, kPlane, kRoof}) {
    SCOPED_TRACE(object);
    record(object);
    fs::remove_all(dir_ / "out");
    write_file(dir_ / "mended.toml", rig(kKnee, object));
    const json refined =
        compared(kKnee, {"--refine", "texture,offset", "--into", (dir_ / "mended.toml").string()});
    expect_own_found(dir_ / "out/texture_left.exr");
    const json alone = compared_twin(dir_ / "mended.toml", dir_ / "alone");
    fs::remove_all(dir_ / "alone");
    ASSERT_EQ(alone["gray"].size(), refined["gray"].size());
    for (std::size_t k = 0; k < alone["gray"].size(); ++k)
      EXPECT_NEAR(alone["gray"][k]["rms_dn"].get<double>() / refined["gray"][k]["rms_dn"].get<double>(), 1.0,
                  1e-4)
          << k;
    for (const char* quantity : {"gray", "phase"})
      EXPECT_NE(alone["budget_verdict"][quantity], "not explained") << alone["explained"].dump(1);
    EXPECT_TRUE(alone["causes"]["named"].is_null()) << alone["causes"].dump(1);
  }
}

// The gain of the line below the knee comes with it; `--refine` writes it, and the twin is explained.
TEST_F(UnevenPixels, WithoutTheKneeNameIt) {
  const json result = compared(kMaps);
  for (const char* quantity : {"gray", "phase"})
    EXPECT_EQ(result["budget_verdict"][quantity], "not explained") << result["explained"].dump(1);
  EXPECT_EQ(result["causes"]["named"], "camera_knee") << result["causes"].dump(1);
  ASSERT_EQ(result["causes"]["gain"].size(), 1u) << result["causes"].dump(1);
  const json& gain = result["causes"]["gain"][0];
  EXPECT_NEAR(gain["gain_dn"].get<double>(), kGainDn, 4.0 * gain["gain_sigma_dn"].get<double>());

  const json refined = compared(kMaps, {"--refine", "camera_knee"});
  for (const char* quantity : {"gray", "phase", "geometry"})
    EXPECT_EQ(refined["budget_verdict"][quantity], "explained") << refined["explained"].dump(1);
  const json& found = refined["refinement"]["parameters"];
  ASSERT_EQ(found.size(), 2u) << found.dump(1);
  const std::pair<std::string, double> planted[] = {{"left.response.slope", kSlope},
                                                    {"left.response.knee_dn", kKneeDn}};
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(found[k]["name"], planted[k].first);
    EXPECT_NEAR(found[k]["after"].get<double>(), planted[k].second,
                4.0 * found[k]["after_sigma"].get<double>());
  }
  EXPECT_THAT(read_file(dir_ / "out" / "refined.toml"), ::testing::HasSubstr("response = { knee_dn = "));
}

/// Returns what the differences follow first.
std::vector<std::string> followed(const json& causes) {
  std::vector<std::string> out;
  for (const json& row : causes["pattern"])
    if (row["order"] == 1) out.push_back(row["coordinate"]);
  return out;
}

// Three errors at once, two of them in every pixel by itself: nothing is named, and what is left follows the
// gray level.
TEST_F(UnevenPixels, WithoutAllThreeHaveNoCauseThatIsWrong) {
  const json result = compared("");
  for (const char* quantity : {"gray", "phase"})
    EXPECT_EQ(result["budget_verdict"][quantity], "not explained") << result["explained"].dump(1);
  EXPECT_TRUE(result["causes"]["named"].is_null()) << result["causes"].dump(1);
  EXPECT_THAT(followed(result["causes"]), ::testing::Contains("gray_level"))
      << result["causes"]["pattern"].dump(1);
}

}  // namespace
}  // namespace fringetwin::testing::uneven_pixels_test
