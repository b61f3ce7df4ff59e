// SPDX-License-Identifier: Apache-2.0
// Which points of a study share one trace: the light of a scene does not depend on sensor, noise, number of
// phase steps or pattern.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "study/study_point.hpp"
#include "twin/twin.hpp"

namespace fringetwin::study {

/// Points of equal `trace` have equal light, but for mean and amplitude (render::set_pattern); of equal `form`
/// the same irradiance images. Only settings known to leave them alone are left out: any other separates.
struct ShareKeys {
  std::string trace, form;
};
ShareKeys share_keys(const Twin& twin, const StudyPoint& point);

/// What the adaptive trace needs of a sensor: its full scale in irradiance sets the error allowed.
struct FullScale {
  int bit_depth = 8;
  double gain_dn = 1.0;
  double irradiance() const { return static_cast<double>((1 << bit_depth) - 1) / gain_dn; }
};

/// A point and the trace it takes its light from.
struct PlannedPoint {
  StudyPoint point;
  std::size_t group = 0;  ///< points of one number share a trace
  ShareKeys keys;
  /// Per camera, the most demanding sensor of the group: the trace is made for it. The same whichever of the
  /// points are still to be done.
  std::vector<FullScale> full_scales;
};

/// Reads the twin of each point; one that cannot be read gets a group of its own, to fail when it is run.
/// `points`: all of the study, the finished ones included.
std::vector<PlannedPoint> plan_traces(const std::filesystem::path& twin, std::vector<StudyPoint> points);

/// Groups among the points.
std::size_t count_groups(const std::vector<PlannedPoint>& points);

}  // namespace fringetwin::study
