// SPDX-License-Identifier: Apache-2.0
#include "calib/solve/calibration.hpp"

namespace fringetwin::calib {

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

}  // namespace fringetwin::calib
