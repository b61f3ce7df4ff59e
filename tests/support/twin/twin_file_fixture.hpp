// SPDX-License-Identifier: Apache-2.0
// Parts of a valid twin.toml and a fixture that loads variations of it, for the tests of twin_file*.cpp.
#pragma once
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "twin/base/errors.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing {

// The parts of a valid file, each with every key that fits beside the others.
inline const std::string kHead =
    "schema = \"fringetwin-twin/1\"\nname = \"test\"\ncameramodel_unit = \"m\"\n";
inline const std::string kLens =
    "lensmodel = \"LENSMODEL_OPENCV4\"\nimagersize = [640, 480]\n"
    "intrinsics = [600, 601.5, 319.5, 239.5, -0.1, 0.05, 0, 0]\n";
inline const std::string kCamera =
    "[[camera]]\nname = \"left\"\n" + kLens + "rt_cam_world = [0, 0, 0, 0, 0, 0]\n";
inline const std::string kSensor =
    "[camera.sensor]\nbit_depth = 12\nexposure_ms = 30.0\ngain_dn = 20\nblack_level_dn = 16\n"
    "electrons_per_dn = 40.2\nread_noise_dn = 0.1\n";
inline const std::string kOptics =
    "[camera.optics]\nf_number = 8\nfocal_length_mm = 10\nfocus_distance_mm = 270\n";
inline const std::string kRight =
    "[[camera]]\nname = \"right\"\n" + kLens + "rt_cam_world = [0, 0.5, 0, -100, 0, 20]\n";
inline const std::string kProjectorLens =
    "[projector]\n" + kLens + "rt_cam_world = [0, 0.25, 0, -50, 0, 5]\n";
inline const std::string kProjector =
    kProjectorLens +
    "intensity = 40\nfalloff = \"inverse-square\"\nreference_distance_mm = 250\n"
    "blur_px = 0.5\nresponse = { gamma = 2.2 }\nambient = 0.25\n";
inline const std::string kFringes =
    "[fringes]\ndirections = [\"x\"]\npitches_px = [13, 14, 15]\nsteps = 4\nunwrap = \"heterodyne\"\n";
inline const std::string kGray =
    "[fringes]\ndirections = [\"x\", \"y\"]\npitches_px = [60]\nsteps = 12\nunwrap = \"gray\"\nmean = 0.4\n"
    "amplitude = 0.3\nphase_origin_px = 30\n[fringes.gray]\nbits = 5\norder = \"lsb-first\"\ncomplementary = "
    "true\n"
    "offset_periods = -0.5\nthreshold = \"inverse\"\n";
inline const std::string kBall =
    "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter_mm = [0, 1, 250]\nradius_mm = 5\n";
inline const std::string kMinimal = kHead + kCamera + kFringes;

class TwinFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              fmt::format("fringetwin_twin_{}_{}", info->name(), ::getpid());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Twin load(const std::string& text) const {
    std::ofstream(folder_ / "twin.toml") << text;
    return load_twin(folder_ / "twin.toml");
  }
  /// The sentence of the error; `line_text` is the (first) line that must be named.
  std::string error(const std::string& text, const std::string& line_text) const {
    const auto at = text.find(line_text);
    EXPECT_NE(at, std::string::npos) << line_text;
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    const std::string message = any_error(text);
    EXPECT_THAT(message, ::testing::HasSubstr(fmt::format("twin.toml:{}: ", line)));
    return message;
  }
  std::string any_error(const std::string& text) const {
    try {
      load(text);
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::usage) << e.what();
      EXPECT_THAT(e.what(), ::testing::HasSubstr((folder_ / "twin.toml").string()));
      return e.what();
    }
    ADD_FAILURE() << "no UserError for\n" << text;
    return "";
  }
  /// `text` with the line that starts with `key = ` replaced.
  static std::string with(const std::string& text, const std::string& key, const std::string& line) {
    const auto at = text.find("\n" + key + " = ");
    EXPECT_NE(at, std::string::npos) << key;
    const auto end = text.find('\n', at + 1);
    return text.substr(0, at + 1) + line + text.substr(end);
  }
  std::filesystem::path folder_;
};

}  // namespace fringetwin::testing
