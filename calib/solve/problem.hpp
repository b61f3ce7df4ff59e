// SPDX-License-Identifier: Apache-2.0
// Converts observed corners and a starting point (mm) into the problem that libmrcal solves (m), and its
// poses back.
#pragma once
#include <string>
#include <vector>

#include "calib/board/observations.hpp"
#include "twin/lens/mrcal_facade.hpp"
#include "twin/lens/mrcal_problem.hpp"
#include "twin/lens/pose.hpp"

namespace fringetwin::calib {

inline constexpr double kMetresPerMm = 1e-3;

/// The lenses and poses that a solve starts from.
struct Seed {
  std::string lensmodel;
  std::vector<std::vector<double>> intrinsics;  ///< per device
  std::vector<Pose> T_device_ref;               ///< per device; the first is the identity
  std::vector<Pose> T_ref_board;                ///< per frame
};

/// Corners as the solver takes them, of all views: their weights are divided by the devices' sigma_px
/// relative to the best device's, -1 where not seen.
std::vector<Eigen::Vector3d> solver_corners(const Observations& observations);
MrcalProblem make_problem(const Observations& observations, const Seed& seed);

RotTrans to_metres(const Pose& T);
Pose to_mm(const RotTrans& rt_m);

/// Poses in mm out of a problem.
Pose T_device_ref(const MrcalProblem& problem, int device);
Pose T_ref_board(const MrcalProblem& problem, int frame);

/// The model, when a calibration can be solved for it: it has a core (fx fy cx cy) and gradients. Throws
/// UserError(usage).
MrcalModel calibratable_model(const std::string& lensmodel);

/// Returns the same lens in another model, as a seed: the core, as many distortion terms as both have in the
/// same meaning, and tiny ones (a rational model has no gradient in its denominator at exactly 0).
std::vector<double> convert_seed(const std::vector<double>& intrinsics, const std::string& from,
                                 const std::string& to);

/// Sum of squares of all residuals; +inf when one is not finite.
double cost_of(const Eigen::VectorXd& residuals);

}  // namespace fringetwin::calib
