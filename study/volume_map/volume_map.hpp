// SPDX-License-Identifier: Apache-2.0
// Plans and evaluates a study of kind "volume-map": a sphere stands at each position of a lattice and is
// measured in rigs that are drawn from the uncertain inputs. The plan goes in, the points to be simulated
// come out; their outcomes go in, the errors of position, size and form at each position and of the spacing
// between any two come out (docs/metrics/study.md, "Volume map"; in the manner of VDI/VDE 2634 part 2).
#pragma once
#include <Eigen/Core>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "study/kind/kind.hpp"
#include "study/plan/study_tables.hpp"
#include "study/statistics/monte_carlo.hpp"
#include "study/uncertain/uncertain_file.hpp"

namespace fringetwin::study {

struct VolumeMapPlan : UncertainSettings {
  std::filesystem::path twin;
  std::string object;                                                        ///< a sphere of the twin
  double radius_mm = 0.0;                                                    ///< its nominal one
  Eigen::Vector3d center_mm = Eigen::Vector3d::Zero(), size_mm = center_mm;  ///< of the lattice; world
  std::array<int, 3> counts{1, 1, 1};
  std::size_t trials = 20;
  std::uint64_t seed = 1;
  double coverage = 0.95;

  /// Returns the places of the lattice, x fastest.
  std::vector<Eigen::Vector3d> positions() const;
};

/// Returns the points of every position in every trial, whose draw of the rig is common to all positions;
/// noise is each one's own. id = trial * positions + position.
PointSequence volume_map_points(const VolumeMapPlan& plan);
/// Returns which numbers of each measurement the map is made from.
std::vector<Record> volume_map_records(const std::string& object);

/// Statistics of one number over the trials.
struct MapNumber {
  double mean = 0.0, sigma = 0.0;
  Interval interval;  ///< the probabilistically symmetric coverage interval
  std::size_t n = 0;  ///< trials that have it
};

struct MapPosition {
  Eigen::Vector3d center_mm = Eigen::Vector3d::Zero();
  std::size_t n = 0, failed = 0;  ///< trials with a sphere; trials that could not be measured at all
  std::string reason;             ///< of the first failure
  /// Measured less nominal: "x_mm", "y_mm", "z_mm", "size_mm" (diameter); "form_mm", "form_95_mm" (ranges
  /// of the residuals).
  std::map<std::string, MapNumber> numbers;
};
/// What was measured of the distance between two positions.
struct MapSpacing {
  std::size_t a = 0, b = 0;  ///< a < b
  double length_mm = 0.0;    ///< nominal
  MapNumber error_mm;        ///< distance of the measured centres less the nominal one
};
/// Holds the indices at which a number's mean, and its sigma, are largest by amount. Only positions that have
/// the number in every trial count: statistics of a few trials could be those of the good or of the bad ones.
struct MapWorst {
  std::size_t mean = 0, sigma = 0;
};

struct VolumeMap {
  std::vector<MapPosition> positions;
  std::size_t measured = 0;  ///< positions with a sphere in every trial
  std::vector<MapSpacing> spacings;
  /// By name; without an entry where no position has it in every trial.
  std::map<std::string, MapWorst> worst;
  std::optional<MapWorst> worst_spacing;  ///< indices of spacings
  /// Statistics of each trial's largest spacing error by amount. Only trials that measured all pairs count:
  /// the largest of fewer pairs would be too small.
  MapNumber largest_mm;
};

/// Returns the map of the outcomes of volume_map_points, in any order; one that is missing counts as failed.
VolumeMap volume_map(const VolumeMapPlan& plan, const std::vector<PointOutcome>& outcomes);

/// Returns result.json, "fringetwin-volume-map/1".
std::string volume_map_json(const VolumeMapPlan& plan, const VolumeMap& map);

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> volume_map_keys();

/// Reads the plan of a STUDY.toml. Throws UserError(usage) with file, line and key.
VolumeMapPlan read_volume_map(const TomlTable& root, const std::filesystem::path& twin);

/// Returns what runs the study; the head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const VolumeMapPlan& plan);

/// Returns the page and its drawings. Throws Cancelled.
StudyReport volume_map_report(const StudyRecord& study, const VolumeMapPlan& plan, const VolumeMap& map);

}  // namespace fringetwin::study
