// SPDX-License-Identifier: Apache-2.0
// A rig that plays the physical one: POV-Ray's images of the paper's sphere before a plane, a 12-bit sensor
// of known gain, black level and noise after them, and the twin.toml of it, right or wrong in one thing.
#pragma once
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing {

/// [camera][image of the sequence], E.
using RigImages = std::vector<std::vector<ImageF>>;

/// The two projectors of the rig, by what they do to the pattern.
enum class RigLight {
  linear,  ///< gamma 1, sharp
  bent,    ///< gamma 1.2 and blur 1 px
};

/// The rig as it is, the sensor's truth included: the paper's geometry, pinhole cameras of a third of the
/// focal length cropped around the sphere, the paper's projector with its distortion, "ball" and "wall".
Twin independent_rig(RigLight light = RigLight::linear);

/// Rendered at the first call of the process, 35 s on two idle cores, and kept in FRINGETWIN_CACHE. Empty
/// without POV-Ray.
const RigImages& rig_images(RigLight light = RigLight::linear);

/// Light over the other surface (rig_indirect.hpp), RigLight::linear; kept likewise.
const RigImages& rig_indirect_images();

struct CaptureOptions {
  RigLight light = RigLight::linear;
  std::uint64_t seed = 1;
  double gain_tilt = 0.0;      ///< the gain grows by this share from the first column to the last
  bool second_bounce = false;  ///< with rig_indirect_images(); of RigLight::linear only
};
/// Returns what the sensors record of rig_images(), in the order of the cameras.
std::vector<CameraImages> captured_images(const CaptureOptions& options = {});
/// Writes the same as 16-bit PNG files with capture.toml.
void write_captures(const std::filesystem::path& folder, const CaptureOptions& options = {});

/// What the twin believes; the default is the truth about RigLight::linear.
struct TwinOptions {
  Eigen::Vector3d sphere_shift_mm = Eigen::Vector3d::Zero();
  double gamma = 1.0;
  double blur_px = 0.0;
  bool projector_k1 = true;  ///< false: 0
  int bounces = 0;
  /// n x n Gauss points a pixel; 0 = the program's choice, 4 where it cannot be adaptive (bounces, or a
  /// response with blur): too few for silhouettes, whose error would then be the rig's largest.
  int samples = 0;
  double ball_diffuse = 0.8, wall_diffuse = 0.6;
  double gain_factor = 0.9;  ///< the twin's sensor against the true one: left to the fit
};
/// twin.toml with [real] captures = `captures`.
std::string twin_toml(const std::filesystem::path& captures, const TwinOptions& options = {});

}  // namespace fringetwin::testing

#define FT_NEED_POVRAY()                                                                       \
  if (::fringetwin::testing::rig_images().empty()) {                                           \
    ASSERT_EQ(std::getenv("CI"), nullptr) << "no POV-Ray in CI";                               \
    GTEST_SKIP() << "SKIPPED: POV-Ray (Debian package povray, packages.txt) is not installed"; \
  }
