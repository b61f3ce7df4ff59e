// SPDX-License-Identifier: Apache-2.0
#include "calib/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/gates.hpp"
#include "calib/seed.hpp"
#include "twin/errors.hpp"

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
  Tally all;
  std::vector<Tally> of_device(c.observations.devices.size());
  const std::size_t per_view = c.problem.corners_per_view();
  for (std::size_t v = 0; v < c.observations.views.size(); ++v) {
    const View& view = c.observations.views[v];
    Tally of_view;
    auto& device = of_device[static_cast<std::size_t>(view.device)];
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

double robust_sigma(std::vector<double> values) {
  if (values.empty()) return 0.0;
  for (double& v : values) v = std::abs(v);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return 1.4826 * *middle;  // of a normal distribution
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
                        robust_sigma(components[d]));
  int n = 0;
  each([&](std::size_t d, Eigen::Vector3d& corner, const Eigen::Vector2d& r) {
    if (r.cwiseAbs().maxCoeff() <= std::max(threshold[d], kFloorPx * corner.z())) return;
    corner.z() = -1.0;
    ++n;
  });
  return n;
}

Eigen::VectorXd solve_joint(MrcalProblem& p, const CalibrateOptions& options) {
  const bool splined = p.lensmodel.starts_with("LENSMODEL_SPLINED");
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

void check_options(const Observations& o, const CalibrateOptions& options) {
  (void)calibratable_model(options.lensmodel);
  if (options.outlier_sigmas.size() != 1 && options.outlier_sigmas.size() != o.devices.size())
    throw UserError(ExitCode::usage, "--outlier-sigma", "takes one value or one per device", "");
}

}  // namespace

Lens Calibration::lens(int device) const {
  const auto d = static_cast<std::size_t>(device);
  return Lens(problem.lensmodel, problem.intrinsics[d],
              {problem.imagersizes[d][0], problem.imagersizes[d][1]}, observations.devices[d].name);
}

bool Calibration::is_outlier(std::size_t view, std::size_t index) const {
  return observations.views[view].corners[index].seen() &&
         problem.corners[view * problem.corners_per_view() + index].z() <= 0.0;
}

Eigen::Vector2d Calibration::residual_px(std::size_t view, std::size_t index) const {
  const std::size_t corner = view * problem.corners_per_view() + index;
  const double weight = problem.corners[corner].z();
  if (weight <= 0.0) return Eigen::Vector2d::Constant(std::nan(""));
  return residuals.segment<2>(static_cast<Eigen::Index>(2 * corner)) / weight;
}

double Calibration::working_distance_mm(int device) const {
  double sum = 0.0;
  int n = 0;
  const Eigen::Vector3d middle(0.5 * observations.board.width_mm(), 0.5 * observations.board.height_mm(),
                               0.0);
  for (const View& view : observations.views) {
    if (view.device != device) continue;
    sum += (T_device_ref(problem, device) * T_ref_board(problem, view.frame) * middle).z();
    ++n;
  }
  return sum / n;
}

Calibration calibrate(const Observations& given, const CalibrateOptions& options) {
  Calibration c;
  c.observations = given;
  c.observations.sort();
  check_options(c.observations, options);
  check_observations(c.observations);
  std::vector<AloneFit> alone;
  for (std::size_t d = 0; d < c.observations.devices.size(); ++d)
    alone.push_back(calibrate_alone(c.observations, static_cast<int>(d), options.lensmodel));
  c.problem = make_problem(c.observations, seed_rig(c.observations, options.lensmodel, alone));
  c.residuals = solve_joint(c.problem, options);
  if (c.residuals.allFinite()) describe(c);
  check_solution(c, options);
  return c;
}

}  // namespace fringetwin::calib
