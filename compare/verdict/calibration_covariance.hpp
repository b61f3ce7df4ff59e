// SPDX-License-Identifier: Apache-2.0
// Reads the covariance of a calibration (calibration.json) and changes a twin by a change of its parameters.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::compare {

/// A covariance with the names of its parameters.
struct CalibrationCovariance {
  std::filesystem::path file;
  std::vector<std::string> parameters;  ///< "left.fx" ... "right.r1" ... "right.t3"; px, rad, mm
  Eigen::MatrixXd matrix;
};

/// Reads twin.calibration_uncertainty, which must be set. Throws UserError(input) naming file and key for
/// what cannot be read, is no covariance, or is one of another rig.
CalibrationCovariance read_calibration_covariance(const Twin& twin);

/// Returns the twin with these changes (order of `parameters`) added to its lenses and to rt_device_ref of
/// its devices; the reference is the first camera.
Twin with_rig_change(const Twin& twin, const CalibrationCovariance& covariance,
                     const Eigen::VectorXd& change);

/// Returns columns c_i with sum c_i c_i^T = a covariance: its principal directions, one standard uncertainty
/// long, after every parameter was divided by its own.
Eigen::MatrixXd one_sigma_changes(const Eigen::MatrixXd& covariance);

/// Returns the twin changed by each of them.
std::vector<Twin> one_sigma_away(const Twin& twin, const CalibrationCovariance& covariance);

}  // namespace fringetwin::compare
