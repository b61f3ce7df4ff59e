// SPDX-License-Identifier: Apache-2.0
// Checks a pose that a file gives, before anything is computed with it.
#pragma once
#include <string>

#include "twin/lens/pose.hpp"

namespace fringetwin {

/// Returns what is wrong with a pose that was made of a file's numbers, empty where nothing is: a translation
/// that is not finite or above 1e9 mm (as in twin.toml), or no rotation, which a vector above 1e150 rad
/// leaves.
inline std::string pose_fault(const Pose& T) {
  constexpr double kLargestMm = 1e9, kTolerance = 1e-6;
  const bool good = T.translation_mm.allFinite() && T.translation_mm.cwiseAbs().maxCoeff() <= kLargestMm &&
                    (T.rotation.transpose() * T.rotation).isIdentity(kTolerance);
  return good ? "" : "has a translation above 1e9 mm or a rotation that is none";
}

}  // namespace fringetwin
