// SPDX-License-Identifier: Apache-2.0
#include "calib/solve/problem.hpp"

#include <algorithm>
#include <cmath>

#include "twin/base/errors.hpp"
#include "twin/lens/lens_name.hpp"

namespace fringetwin::calib {

RotTrans to_metres(const Pose& T) {
  RotTrans rt = rt_from_pose(T);
  rt.tail<3>() *= kMetresPerMm;
  return rt;
}

Pose to_mm(const RotTrans& rt_m) {
  RotTrans rt = rt_m;
  rt.tail<3>() /= kMetresPerMm;
  return pose_from_rt(rt);
}

Pose T_device_ref(const MrcalProblem& problem, int device) {
  return device == 0 ? Pose{} : to_mm(problem.rt_cam_ref[device - 1]);
}

Pose T_ref_board(const MrcalProblem& problem, int frame) { return to_mm(problem.rt_ref_frame[frame]); }

std::vector<Eigen::Vector3d> solver_corners(const Observations& o) {
  double least_sigma = o.devices.front().sigma_px;
  for (const Device& d : o.devices) least_sigma = std::min(least_sigma, d.sigma_px);
  std::vector<Eigen::Vector3d> corners;
  for (const View& view : o.views) {
    const double factor = least_sigma / o.devices[view.device].sigma_px;
    for (const Corner& c : view.corners)
      corners.push_back(c.seen() ? Eigen::Vector3d(c.q_px.x(), c.q_px.y(), c.weight * factor)
                                 : Eigen::Vector3d(0.0, 0.0, -1.0));
  }
  return corners;
}

MrcalProblem make_problem(const Observations& o, const Seed& seed) {
  MrcalProblem p;
  p.lensmodel = seed.lensmodel;
  p.intrinsics = seed.intrinsics;
  for (const Device& d : o.devices) p.imagersizes.push_back(d.imagersize_px);
  for (std::size_t i = 1; i < seed.T_device_ref.size(); ++i)
    p.rt_cam_ref.push_back(to_metres(seed.T_device_ref[i]));
  for (const Pose& T : seed.T_ref_board) p.rt_ref_frame.push_back(to_metres(T));
  p.spacing_m = kMetresPerMm * o.board.spacing_mm;
  p.width_n = o.board.width_n;
  p.height_n = o.board.height_n;
  for (const View& view : o.views) p.views.push_back({view.device, view.frame});
  p.corners = solver_corners(o);
  return p;
}

MrcalModel calibratable_model(const std::string& lensmodel) {
  if (const std::string fault = lens_name_fault(lensmodel); !fault.empty())
    throw UserError(ExitCode::usage, "--lensmodel " + shown_lens_name(lensmodel), fault);
  const auto model = MrcalModel::from_name(lensmodel);
  const bool known = lensmodel.starts_with("LENSMODEL_OPENCV") || lensmodel == "LENSMODEL_PINHOLE" ||
                     lensmodel == "LENSMODEL_STEREOGRAPHIC" ||
                     lensmodel.starts_with("LENSMODEL_SPLINED_STEREOGRAPHIC");
  if (!model || !known)
    throw UserError(ExitCode::usage, "--lensmodel " + shown_lens_name(lensmodel),
                    "is not a lens model that can be calibrated",
                    "use LENSMODEL_OPENCV4, _OPENCV5, _OPENCV8 or "
                    "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=11_Ny=8_fov_x_deg=44");
  return *model;
}

std::vector<double> convert_seed(const std::vector<double>& intrinsics, const std::string& from,
                                 const std::string& to) {
  const auto is_opencv = [](const std::string& name) { return name.starts_with("LENSMODEL_OPENCV"); };
  std::vector<double> out(static_cast<std::size_t>(calibratable_model(to).intrinsics_count()), 0.0);
  const std::size_t shared = is_opencv(from) && is_opencv(to) ? std::min(intrinsics.size(), out.size()) : 4;
  std::copy_n(intrinsics.begin(), shared, out.begin());
  constexpr double kTiny = 1e-7;
  if (is_opencv(to))
    for (std::size_t i = 4; i < out.size(); ++i)
      if (out[i] == 0.0) out[i] = i % 2 == 0 ? kTiny : -kTiny;
  return out;
}

double cost_of(const Eigen::VectorXd& residuals) {
  return residuals.allFinite() ? residuals.squaredNorm() : INFINITY;
}

}  // namespace fringetwin::calib
