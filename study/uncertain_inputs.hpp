// SPDX-License-Identifier: Apache-2.0
// What is uncertain in a virtual experiment, and draws of it: keys of the twin with a spread, the form of
// spheres, the joint covariance of the rig's calibration, the noise of the sensor.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/calibration_covariance.hpp"
#include "study/draws.hpp"
#include "study/sphere_form.hpp"
#include "study/study_point.hpp"

namespace fringetwin::study {

enum class Distribution { normal, uniform };

struct UncertainKey {
  std::string name;               ///< in results
  std::vector<std::string> keys;  ///< all off by the same deviation
  std::vector<double> values;     ///< of the keys, in the middle of the distribution
  Distribution distribution = Distribution::normal;
  double spread = 0.0;  ///< standard deviation; uniform: half width
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

/// One draw of all inputs.
struct InputDraw {
  std::vector<double> deviates;      ///< one per key: standard normal, or uniform in (-1, 1)
  std::vector<std::uint64_t> forms;  ///< seeds of SphereForm::draw, below 2^53
  std::vector<double> calibration;   ///< standard normal
  std::uint64_t noise_seed = 0;      ///< below 2^53: exact in JSON, SQLite and CSV
};
InputDraw draw_inputs(const UncertainInputs& inputs, std::uint64_t seed, DrawStream stream,
                      std::uint64_t trial);
/// `a` with one factor (order of factors()) taken from `b`.
InputDraw exchanged(const UncertainInputs& inputs, InputDraw a, const InputDraw& b, std::size_t factor);

/// The draw as a point of a study. The calibration's deviates and the forms are settings of their own, which
/// VirtualRig takes out again: no key of a twin has such a name.
StudyPoint point_of(const UncertainInputs& inputs, std::int64_t id, const InputDraw& draw);

/// A point's settings without the calibration's deviates and the forms: what load_twin takes.
Settings keys_of_twin(Settings settings);

/// The rig as calibrated, with which everything is measured, and rigs as drawn, which record.
class VirtualRig {
 public:
  /// `with_calibration`: the twin must name its calibration ([uncertainty]).
  VirtualRig(const std::filesystem::path& twin_file, bool with_calibration);

  const Twin& nominal() const { return nominal_; }
  std::size_t calibration_directions() const { return static_cast<std::size_t>(changes_.cols()); }
  Twin drawn(const Settings& settings) const;
  /// Of the nominal twin; measuring needs them.
  void load_meshes() { fringetwin::load_meshes(nominal_); }

 private:
  std::filesystem::path file_;
  Twin nominal_;
  std::optional<compare::CalibrationCovariance> covariance_;
  Eigen::MatrixXd changes_;
};

}  // namespace fringetwin::study
