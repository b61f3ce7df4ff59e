// SPDX-License-Identifier: Apache-2.0
// Writes the blocks that every twin.toml to start from has: sensor, light, fringes, a ball to measure.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>

namespace fringetwin::cli {

/// Returns [camera.sensor] of an 8-bit camera with usual noise; the comment says what a number is for.
std::string sensor_block(bool with_comment);

/// Returns the projector's intensity that makes white paper about 80 % of full scale.
std::string intensity_lines();

inline constexpr int kUsualWidth_px = 1280;  ///< of a projector that is not there

/// Returns [fringes]: three pitches that are unambiguous over a projector of this width.
std::string fringes_block(int projector_width_px);

/// Returns a ball of paper and its fit. Its nearest point to a camera at `stand_mm` that looks along `axis`
/// (of length 1) is at `distance_mm`. Its diameter is `ball_mm`; where none is given it fills half of a field
/// of this width and height.
std::string ball_block(const Eigen::Vector3d& stand_mm, const Eigen::Vector3d& axis, double distance_mm,
                       double field_mm, double field_height_mm, std::optional<double> ball_mm);

}  // namespace fringetwin::cli
