// SPDX-License-Identifier: Apache-2.0
// Which points of a study share one trace: the light of a scene does not depend on sensor, noise, number of
// phase steps or pattern.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "study/plan/study_point.hpp"
#include "twin/twin.hpp"

namespace fringetwin::study {

/// Points of equal `trace` have equal light, but for mean and amplitude (render::set_pattern); of equal
/// `form` the same irradiance images. Only settings known to leave them alone are left out: any other
/// separates.
struct ShareKeys {
  std::string trace, form;
};
ShareKeys share_keys(const Twin& twin, const StudyPoint& point);

/// How exact a shared trace must be: the adaptive trace may err by a share of the sensor's full scale, in
/// images of this mean and amplitude.
struct TraceDemand {
  struct FullScale {
    int bit_depth = 8;
    double gain_dn = 1.0;
    double irradiance() const { return static_cast<double>((1 << bit_depth) - 1) / gain_dn; }
    bool operator==(const FullScale&) const = default;
  };
  std::vector<FullScale> sensors;  ///< one per camera
  double mean = 0.0, amplitude = 0.0;

  bool operator==(const TraceDemand&) const = default;
  static TraceDemand of(const Twin& twin);
  /// Makes this the stricter of both.
  void join(const TraceDemand& other);
  /// Gives the twin the sensors, mean and amplitude for which its light must be exact enough.
  void apply(Twin* twin) const;
};

/// A point and the trace it takes its light from.
struct PlannedPoint {
  StudyPoint point;
  std::size_t group = 0;  ///< points of one number share a trace
  ShareKeys keys;
  TraceDemand demand = {};  ///< of all its points together, whichever of them are still to be done
};

/// Reads the twin of each point; one that cannot be read gets a group of its own, to fail when it is run.
/// `points`: all of the study, the finished ones included.
std::vector<PlannedPoint> plan_traces(const std::filesystem::path& twin, const PointSequence& points);

/// Returns the number of different traces.
std::size_t count_groups(const std::vector<PlannedPoint>& points);

}  // namespace fringetwin::study
