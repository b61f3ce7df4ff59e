// SPDX-License-Identifier: Apache-2.0
// A surface that is measured from the real capture before anything is rendered.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "twin/shape/motion.hpp"

namespace fringetwin {

/// Built from the real capture's own depth map (measure/surface.hpp turns it into a MeshShape).
struct MeasuredShape {
  static constexpr const char* kKind = "measured";
  static constexpr bool kHasFiles = false, kLightsItself = false;
  std::string steps = "even";  ///< "even" | "odd" | "all": phase steps the surface is built from
  double smoothing_px = 3.0;   ///< radius of the local fit that removes pixel noise
  /// Radius up to which the window of a pixel may grow, as far as its surface is a quadratic within the
  /// noise; not above smoothing_px: it does not grow.
  double most_smoothing_px = 0.0;
  /// Light that differs from image to image, and the harmonics of the fringes, are taken out of the images
  /// first, as all phase steps together tell them: they would stand in the surface as ripples.
  bool correct_fringes = false;
};

// It has no place of its own before it is built, so nothing moves it.
inline std::vector<Motion<MeasuredShape>> motions(const MeasuredShape&) { return {}; }
inline std::vector<PlaceKey> place_keys(const MeasuredShape&) { return {}; }
inline void make_units(MeasuredShape&) {}
inline std::optional<Eigen::Vector3d> place_mm(const MeasuredShape&) { return std::nullopt; }
inline bool shades_itself(const MeasuredShape&) { return true; }

}  // namespace fringetwin
