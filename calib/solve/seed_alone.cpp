// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>

#include "calib/solve/seed.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::calib {
namespace {

constexpr const char* kRough = "LENSMODEL_STEREOGRAPHIC";

Observations only_device(const Observations& o, int device) {
  Observations out{
      .board = o.board, .devices = {o.devices[device]}, .frames = o.frames, .views = {}, .file = o.file};
  for (const View& view : o.views)
    if (view.device == device && view.n_seen() >= 4) {
      out.views.push_back(view);
      out.views.back().device = 0;
    }
  out.sort();
  return out;
}

std::vector<Pose> poses_of_views(const Observations& o, const std::string& lensmodel,
                                 const std::vector<double>& intrinsics) {
  const MrcalModel model = calibratable_model(lensmodel);
  std::vector<Pose> poses(o.frames.size());
  for (const View& view : o.views) {
    const auto pose = board_pose(o.board, view.corners, model, intrinsics);
    if (!pose)
      throw UserError(ExitCode::input, o.where(view),
                      "the corners do not show a board in front of the device",
                      "are they all on one line, or is the rough focal length far off?");
    poses[view.frame] = pose->T_device_board;
  }
  return poses;
}

double largest_turn_rad(const std::vector<Pose>& before, const std::vector<Pose>& after) {
  double turn = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i)
    turn = std::max(turn, vector_from_rotation(before[i].rotation.transpose() * after[i].rotation).norm());
  return turn;
}

struct Attempt {
  MrcalProblem problem;
  double cost = INFINITY;
};

Attempt solved(MrcalProblem problem) {
  Attempt attempt;
  attempt.cost = cost_of(mrcal_solve(problem));
  attempt.problem = std::move(problem);
  return attempt;
}

/// Poses and core with a stereographic lens. A rough focal length may pick the wrong one of a view's two
/// poses, so they are picked again with the solved one until none turns any more.
MrcalProblem rough_solve(const Observations& o) {
  const Device& device = o.devices.front();
  std::vector<double> intrinsics{device.focal_px, device.focal_px, 0.5 * (device.imagersize_px[0] - 1),
                                 0.5 * (device.imagersize_px[1] - 1)};
  std::vector<Pose> poses = poses_of_views(o, kRough, intrinsics);
  MrcalProblem best;
  double best_cost = INFINITY;
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    MrcalProblem p = make_problem(o, {kRough, {intrinsics}, {Pose{}}, poses});
    p.optimize_distortion = p.optimize_warp = p.optimize_core = false;
    p.regularize = false;
    mrcal_solve(p);
    p.optimize_core = true;
    const Attempt attempt = solved(p);
    if (!std::isfinite(attempt.cost)) break;
    if (attempt.cost < best_cost) {
      best = attempt.problem;
      best_cost = attempt.cost;
    }
    const auto& k = attempt.problem.intrinsics[0];
    if (!(k[0] > 0.0 && k[1] > 0.0)) break;
    const std::vector<Pose> again = poses_of_views(o, kRough, k);
    constexpr double kSamePoseRad = 0.17;
    std::vector<Pose> solved_poses;
    for (std::size_t i = 0; i < again.size(); ++i)
      solved_poses.push_back(T_ref_board(attempt.problem, static_cast<int>(i)));
    if (largest_turn_rad(solved_poses, again) < kSamePoseRad) break;
    poses = again;
    intrinsics = k;
  }
  if (!std::isfinite(best_cost))
    throw UserError(ExitCode::no_convergence, device.name, "the first stage of its calibration diverges",
                    "check the rough focal length and the order of the corners");
  return best;
}

MrcalProblem in_model(MrcalProblem p, const std::string& lensmodel) {
  p.intrinsics[0] = convert_seed(p.intrinsics[0], p.lensmodel, lensmodel);
  p.lensmodel = lensmodel;
  p.optimize_core = !lensmodel.starts_with("LENSMODEL_SPLINED");
  p.optimize_distortion = true;
  p.optimize_warp = false;
  p.regularize = true;
  return p;
}

/// Solves the last stage of calibrate_alone() (seed.hpp): the lens model asked for, from the rough solution.
Attempt fine_solve(const MrcalProblem& rough, const std::string& lensmodel) {
  Attempt best = solved(in_model(rough, lensmodel));
  constexpr const char* kSimple = "LENSMODEL_OPENCV4";
  const bool has_more_terms = lensmodel.starts_with("LENSMODEL_OPENCV") && lensmodel != kSimple;
  if (!has_more_terms) return best;
  const Attempt simple = solved(in_model(rough, kSimple));
  if (!std::isfinite(simple.cost)) return best;
  Attempt other = solved(in_model(simple.problem, lensmodel));
  return other.cost < best.cost ? other : best;
}

/// The stages on a part of many views (which costs a tenth), then all views from there.
Attempt staged_solve(const Observations& o, const std::string& lensmodel) {
  constexpr std::size_t kManyViews = 40;
  if (o.frames.size() <= kManyViews) return fine_solve(rough_solve(o), lensmodel);
  std::vector<int> part;
  const std::size_t step = (o.frames.size() + kManyViews - 1) / kManyViews;
  for (std::size_t f = 0; f < o.frames.size(); f += step) part.push_back(static_cast<int>(f));
  const Attempt some = fine_solve(rough_solve(select_frames(o, part)), lensmodel);
  if (!std::isfinite(some.cost)) return fine_solve(rough_solve(o), lensmodel);
  const auto& lens = some.problem.intrinsics;
  MrcalProblem p = make_problem(o, {lensmodel, lens, {Pose{}}, poses_of_views(o, lensmodel, lens[0])});
  p.optimize_core = p.optimize_distortion = p.optimize_warp = false;
  mrcal_solve(p);
  p.optimize_core = some.problem.optimize_core;
  p.optimize_distortion = true;
  return solved(p);
}

}  // namespace

AloneFit calibrate_alone(const Observations& all, int device, const std::string& lensmodel) {
  const Observations o = only_device(all, device);
  const std::string& name = o.devices.front().name;
  Attempt fine = staged_solve(o, lensmodel);
  if (!std::isfinite(fine.cost))
    throw UserError(ExitCode::no_convergence, name, "its calibration alone diverges",
                    "check the rough focal length and the order of the corners");
  AloneFit fit;
  fit.intrinsics = fine.problem.intrinsics[0];
  const Eigen::VectorXd x = mrcal_linearise(fine.problem).residuals;
  double sum_all = 0.0;
  int n_all = 0;
  const auto per_view = static_cast<Eigen::Index>(o.board.corners());
  for (std::size_t v = 0; v < o.views.size(); ++v) {
    double sum = 0.0;
    int n = 0;
    for (Eigen::Index i = 0; i < per_view; ++i) {
      const Eigen::Index corner = static_cast<Eigen::Index>(v) * per_view + i;
      const double weight = fine.problem.corners[corner].z();
      if (weight <= 0.0) continue;
      sum += x.segment<2>(2 * corner).squaredNorm() / (weight * weight);
      ++n;
    }
    sum_all += sum;
    n_all += n;
    // back to the frame's number among all devices
    const std::string& frame_name = o.frames[o.views[v].frame];
    const int frame = static_cast<int>(std::ranges::find(all.frames, frame_name) - all.frames.begin());
    fit.T_device_board[frame] = T_ref_board(fine.problem, o.views[v].frame);
    fit.view_rms_px[frame] = std::sqrt(sum / std::max(n, 1));
  }
  fit.rms_px = std::sqrt(sum_all / std::max(n_all, 1));
  return fit;
}

}  // namespace fringetwin::calib
