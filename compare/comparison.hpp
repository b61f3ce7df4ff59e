// SPDX-License-Identifier: Apache-2.0
// Real against simulated: gain, gray, phase, geometry (DESIGN §4 result.json; docs/METRICS.md has
// the formula of every number).
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "measure/measurement.hpp"
#include "twin/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

struct Side {
  std::vector<CameraImages> images;  ///< order of twin.cameras; empty = published numbers only
  std::optional<measure::Measurement> measurement;
  /// Irradiance of the simulated side where known (renderer or EXR), sequence order; may be empty.
  std::vector<CameraImages> irradiance;
};

struct CompareOptions {
  /// Phase steps of the gray/phase comparison; empty = all (a measured object is built from the
  /// even steps and compared with the odd ones).
  std::vector<int> use_steps;
  std::string note;  ///< what this comparison can and cannot show, printed in the report
};

struct GainRow {
  std::string camera;
  double gain_dn = 0, gain_sigma_dn = 0, black_level_dn = 0, black_level_sigma_dn = 0;
  double rms_before_dn = 0, rms_after_dn = 0, r2 = 0;
  std::uint64_t n = 0;
};
struct GrayRow {
  std::string camera;
  std::string pattern;  ///< PatternSpec::label
  double mean_dn = 0, rms_dn = 0, p99_dn = 0;
  std::uint64_t n = 0;
};
struct PhaseRow {
  std::string camera, direction;
  double mean_rad = 0, rms_rad = 0, p99_rad = 0, mean_relative = 0;
  std::uint64_t n = 0, n_order_disagree = 0;
};
struct FitRow {
  std::string object, kind;
  std::optional<measure::ObjectFit> simulated, real;  ///< real may hold published numbers (n = 0)
  std::map<std::string, double> difference, z;        ///< simulated - real; z absent where a sigma is unknown
  std::map<std::string, Eigen::Vector3d> difference_vectors, z_vectors;
};
struct LimitRow {
  std::string name;
  double value = 0, limit = 0;
  bool pass = false;
};

struct Comparison {
  std::vector<FitRow> fits;
  std::vector<GainRow> gain;
  std::vector<GrayRow> gray;
  std::vector<PhaseRow> phase;
  std::vector<LimitRow> limits;
  bool pass = true;
  std::vector<std::string> warnings;
};

/// Pixels whose predicted value is near a clip, saturated pixels and images of another exposure are
/// left out of gain and gray.
Comparison compare(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options);

}  // namespace fringetwin::compare
