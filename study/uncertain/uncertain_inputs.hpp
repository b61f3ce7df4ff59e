// SPDX-License-Identifier: Apache-2.0
// What is uncertain in a virtual experiment, and draws of it: keys of the twin with a spread, the form of
// spheres, the joint covariance of the rig's calibration, the noise of the sensor.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/verdict/calibration_covariance.hpp"
#include "study/plan/random_draws.hpp"
#include "study/plan/study_point.hpp"
#include "study/uncertain/sphere_form.hpp"

namespace fringetwin::study {

enum class Distribution { normal, uniform };

struct UncertainKey {
  std::string name;               ///< in results
  std::vector<std::string> keys;  ///< all off by the same deviation
  std::vector<double> values;     ///< of the keys, in the middle of the distribution
  Distribution distribution = Distribution::normal;
  double spread = 0.0;  ///< standard deviation; uniform: half width
  bool stated = false;  ///< the values stand in the study, whatever the twin has
};

/// A sphere of the twin that is not quite one.
struct UncertainForm {
  std::string name, object;
  FormSpread spread;
};

struct UncertainInputs {
  std::vector<UncertainKey> keys;
  std::vector<UncertainForm> forms;
  std::size_t calibration = 0;  ///< principal directions of the rig's covariance (one_sigma_changes)
  bool noise = true;

  /// What the spread can come from, all of them independent: the keys' names, the forms', "calibration",
  /// "noise".
  std::vector<std::string> factors() const;
};

/// One draw of all inputs from their distributions.
struct InputDraw {
  std::vector<double> deviates;      ///< one per key: standard normal, or uniform in (-1, 1)
  std::vector<std::uint64_t> forms;  ///< seeds of SphereForm::draw, below 2^53
  std::vector<double> calibration;   ///< standard normal
  std::uint64_t noise_seed = 0;      ///< below 2^53: exact in JSON, SQLite and CSV
};
/// Returns the draw of a trial; an input more leaves the draws of the others as they are.
InputDraw draw_inputs(const UncertainInputs& inputs, std::uint64_t seed, DrawStream stream,
                      std::uint64_t trial);
/// Returns `a` with one factor (order of factors()) taken from `b`.
InputDraw exchanged(const UncertainInputs& inputs, InputDraw a, const InputDraw& b, std::size_t factor);

/// Returns the seed of the noise of one of several measurements with the same draw; of the first it is the
/// draw's.
std::uint64_t repeated_noise(const UncertainInputs& inputs, std::uint64_t seed, std::uint64_t trial,
                             std::uint32_t repetition);

/// Returns the inputs about a twin with these settings: middles that are the twin's own values are taken
/// anew.
UncertainInputs about(UncertainInputs inputs, const std::filesystem::path& twin, const Settings& nominal);

/// Returns the draw as a point of a study. `nominal`: settings of the rig that records and of the one that
/// measures. They, the calibration's deviates and the forms get names that no key of a twin has; VirtualRig
/// takes them out again.
StudyPoint point_of(const UncertainInputs& inputs, std::int64_t id, const InputDraw& draw,
                    const Settings& nominal = {});

/// Returns a point's settings with the nominal ones under their keys, unless the draw has its own value
/// there.
Settings recording_settings(const Settings& settings);
/// Returns these settings without the calibration's deviates and the forms: what load_twin takes.
Settings keys_of_twin(const Settings& settings);
/// Returns whether the draw gives the object a form of its own.
bool has_drawn_form(const Settings& settings, const std::string& object);

/// The rig as calibrated, with which everything is measured, and rigs as drawn, which record. The covariance
/// is the calibrated rig's, whatever a point's nominal settings are.
class VirtualRig {
 public:
  /// `with_calibration`: the twin must name its calibration ([uncertainty]).
  VirtualRig(const std::filesystem::path& twin_file, bool with_calibration);

  const Twin& nominal() const { return nominal_; }
  /// Returns the nominal twin with the nominal settings of a point, its meshes loaded; valid until the next
  /// call.
  const Twin& measuring(const Settings& settings);
  std::size_t calibration_directions() const { return static_cast<std::size_t>(changes_.cols()); }
  /// Returns the rig that records a point with these settings.
  Twin drawn(const Settings& settings) const;

 private:
  std::filesystem::path file_;
  Twin nominal_;
  std::optional<Twin> measuring_;
  Settings measuring_settings_;
  std::optional<compare::CalibrationCovariance> covariance_;
  Eigen::MatrixXd changes_;
};

}  // namespace fringetwin::study
