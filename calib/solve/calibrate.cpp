// SPDX-License-Identifier: Apache-2.0
#include "calib/solve/calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/board/corner_order.hpp"
#include "calib/solve/circle_bias.hpp"
#include "calib/solve/seed.hpp"
#include "calib/solve/uncertainty.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::calib {
namespace {

/// A running sum of what FitQuality says.
struct Tally {
  double sum_sq = 0.0, weighted_sq = 0.0, worst = 0.0;
  int n = 0, outliers = 0;
  void add(const Eigen::Vector2d& weighted, double weight) {
    const double squared = weighted.squaredNorm() / (weight * weight);
    sum_sq += squared;
    weighted_sq += weighted.squaredNorm();
    worst = std::max(worst, std::sqrt(squared));
    ++n;
  }
  FitQuality quality() const {
    const double count = std::max(n, 1);
    return {std::sqrt(sum_sq / count), std::sqrt(weighted_sq / (2.0 * count)), worst, n, outliers};
  }
};

void describe(Calibration& c) {
  c.views.clear();
  c.devices.clear();
  Tally all;
  std::vector<Tally> of_device(c.observations.devices.size());
  const std::size_t per_view = c.problem.corners_per_view();
  for (std::size_t v = 0; v < c.observations.views.size(); ++v) {
    const View& view = c.observations.views[v];
    Tally of_view;
    auto& device = of_device[view.device];
    for (std::size_t i = 0; i < per_view; ++i) {
      const std::size_t corner = v * per_view + i;
      const double weight = c.problem.corners[corner].z();
      for (Tally* tally : {&all, &device, &of_view})
        if (weight > 0.0)
          tally->add(c.residuals.segment<2>(static_cast<Eigen::Index>(2 * corner)), weight);
        else if (view.corners[i].seen())
          ++tally->outliers;
    }
    c.views.push_back({view.device, view.frame, of_view.quality()});
  }
  c.fit = all.quality();
  for (std::size_t d = 0; d < of_device.size(); ++d)
    c.devices.push_back({c.observations.devices[d].name, c.problem.intrinsics[d],
                         T_device_ref(c.problem, static_cast<int>(d)), of_device[d].quality()});
  c.warp_mm = c.problem.warp_m / kMetresPerMm;
}

/// Marks corners beyond their device's threshold; returns how many are new. A corner that is nearer than the
/// floor is never one: noise-free data would be eaten up.
int reject(MrcalProblem& p, const Eigen::VectorXd& x, const CalibrateOptions& options) {
  constexpr double kFloorPx = 0.02;
  const std::size_t per_view = p.corners_per_view();
  std::vector<std::vector<double>> components(p.intrinsics.size());
  const auto each = [&](auto&& use) {
    for (std::size_t v = 0; v < p.views.size(); ++v)
      for (std::size_t i = v * per_view; i < (v + 1) * per_view; ++i)
        if (p.corners[i].z() > 0.0)
          use(static_cast<std::size_t>(p.views[v].device), p.corners[i],
              Eigen::Vector2d(x.segment<2>(static_cast<Eigen::Index>(2 * i))));
  };
  each([&](std::size_t d, const Eigen::Vector3d&, const Eigen::Vector2d& r) {
    components[d].push_back(r.x());
    components[d].push_back(r.y());
  });
  std::vector<double> threshold;
  for (std::size_t d = 0; d < components.size(); ++d)
    threshold.push_back(options.outlier_sigmas[options.outlier_sigmas.size() > 1 ? d : 0] *
                        mad_sigma(components[d]));
  int n = 0;
  each([&](std::size_t d, Eigen::Vector3d& corner, const Eigen::Vector2d& r) {
    if (r.cwiseAbs().maxCoeff() <= std::max(threshold[d], kFloorPx * corner.z())) return;
    corner.z() = -1.0;
    ++n;
  });
  return n;
}

bool is_splined(const std::string& lensmodel) { return lensmodel.starts_with("LENSMODEL_SPLINED"); }

Eigen::VectorXd solve_joint(MrcalProblem& p, const CalibrateOptions& options) {
  const bool splined = is_splined(p.lensmodel);
  p.optimize_core = p.optimize_distortion = p.optimize_warp = false;
  p.regularize = true;
  mrcal_solve(p);  // geometry
  p.optimize_core = !splined;
  p.optimize_distortion = true;
  Eigen::VectorXd x = mrcal_solve(p);
  if (options.solve_warp) {
    p.optimize_warp = true;
    x = mrcal_solve(p);
  }
  constexpr int kRounds = 20;
  for (int round = 0; options.reject_outliers && round < kRounds && x.allFinite(); ++round) {
    if (reject(p, x, options) == 0) break;
    x = mrcal_solve(p);
  }
  if (!options.regularize) {
    p.regularize = false;
    x = mrcal_solve(p);
  }
  return x;
}

void solve_and_check(Calibration& c, const CalibrateOptions& options) {
  c.residuals = solve_joint(c.problem, options);
  if (c.residuals.allFinite()) describe(c);
  check_solution(c, options);
}

/// Each device's weight from its own residuals. (Their number is much larger than that of the states, which
/// take a like part of each: no correction for that.)
void weigh_devices(Calibration& c, const CalibrateOptions& options) {
  constexpr int kRounds = 5;
  constexpr double kSettled = 0.02, kFloorPx = 1e-3;
  for (int round = 0; round < kRounds; ++round) {
    double largest = 0.0;
    const double all = std::max(c.fit.rms_component_px, kFloorPx);
    for (std::size_t d = 0; d < c.devices.size(); ++d) {
      const double factor = std::max(c.devices[d].fit.rms_component_px, kFloorPx) / all;
      c.observations.devices[d].sigma_px *= factor;
      largest = std::max(largest, std::abs(std::log(factor)));
    }
    if (largest < kSettled) break;
    c.problem.corners = solver_corners(c.observations);
    solve_and_check(c, options);
  }
}

double largest_move_px(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].z() > 0.0) largest = std::max(largest, (a[i] - b[i]).head<2>().norm());
  return largest;
}

/// Before anything is judged: a strongly tilted board does not fit with the others until it is corrected.
void correct_roughly(Calibration& c, CalibrateOptions options) {
  options.reject_outliers = false;
  constexpr int kRounds = 2;
  for (int round = 0; round < kRounds; ++round) {
    if (!solve_joint(c.problem, options).allFinite()) return;
    try {
      c.problem.corners = circle_centres(c.problem, c.observations, options.circle_diameter_mm);
    } catch (const UserError&) {
      return;  // a lens that cannot be: the gates have a sentence for it
    }
  }
}

/// The corrections follow from the poses and these from the corrections: each round takes off about the
/// square of the circle's size over its distance, so two or three will do.
void solve_for_centres(Calibration& c, const CalibrateOptions& options) {
  constexpr int kRounds = 6;
  constexpr double kSettledPx = 1e-4;
  const std::vector<Eigen::Vector3d> as_seen = solver_corners(c.observations);
  for (int round = 0; round < kRounds; ++round) {
    auto centres = circle_centres(c.problem, c.observations, options.circle_diameter_mm);
    c.circle_correction_px = largest_move_px(centres, as_seen);
    if (largest_move_px(centres, c.problem.corners) < kSettledPx) break;
    c.problem.corners = std::move(centres);  // outliers are let in again
    solve_and_check(c, options);
  }
}

void check_options(const Observations& o, const CalibrateOptions& options) {
  (void)calibratable_model(options.lensmodel);
  if (options.outlier_sigmas.size() != 1 && options.outlier_sigmas.size() != o.devices.size())
    throw UserError(ExitCode::usage, "--outlier-sigma", "takes one value or one per device", "");
  // Neighbours of an asymmetric grid are sqrt(2) spacings of its lattice apart.
  const double largest_mm = std::sqrt(2.0) * o.board.spacing_mm;
  if (!(options.circle_diameter_mm >= 0.0 && options.circle_diameter_mm < largest_mm))
    throw UserError(ExitCode::usage, "--circle-diameter",
                    fmt::format("circles of {:.6g} m do not fit on a board with a spacing of {:.6g} m",
                                kMetresPerMm * options.circle_diameter_mm, kMetresPerMm * o.board.spacing_mm),
                    "both are in metres");
}

Calibration solve(const Observations& given, const CalibrateOptions& options) {
  Calibration c;
  c.observations = given;
  c.observations.sort();
  check_options(c.observations, options);
  check_observations(c.observations);
  check_not_mirrored(c.observations);
  std::vector<AloneFit> alone;
  for (std::size_t d = 0; d < c.observations.devices.size(); ++d)
    alone.push_back(calibrate_alone(c.observations, static_cast<int>(d), options.lensmodel));
  c.problem = make_problem(c.observations, seed_rig(c.observations, options.lensmodel, alone));
  if (options.circle_diameter_mm > 0.0) correct_roughly(c, options);
  solve_and_check(c, options);
  if (options.estimate_sigmas) weigh_devices(c, options);
  if (options.circle_diameter_mm > 0.0) solve_for_centres(c, options);
  return c;
}

}  // namespace

Calibration calibrate(const Observations& given, const CalibrateOptions& options) {
  const bool may_drop = options.regularize && options.drop_regularization && !is_splined(options.lensmodel);
  if (!may_drop) return solve(given, options);
  std::string why;
  try {
    CalibrateOptions without = options;
    without.regularize = false;
    Calibration c = solve(given, without);
    (void)Uncertainty(c);  // throws where a parameter is left open
    return c;
  } catch (const UserError& e) {
    if (e.code() != ExitCode::no_convergence) throw;
    why = e.what();
  }
  Calibration c = solve(given, options);
  c.warnings.push_back("the regularisation of the lenses was kept; without it: " + why);
  return c;
}

}  // namespace fringetwin::calib
