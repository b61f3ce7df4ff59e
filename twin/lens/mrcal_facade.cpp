// SPDX-License-Identifier: Apache-2.0
#include "twin/lens/mrcal_facade.hpp"

#include <cmath>

#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/lens/lens_name.hpp"
#include "twin/lens/mrcal_problem.hpp"

extern "C" {  // the headers of libmrcal 2.2 do not say so themselves
#include <mrcal/mrcal.h>
// "not for end users", but the only way to know how large the Jacobian is
#include <mrcal/mrcal-internal.h>
}
#include <suitesparse/cholmod.h>  // the Jacobian's type; nothing of the library is called

namespace fringetwin {

struct MrcalModel::Impl {
  mrcal_lensmodel_t lensmodel = {};
  mrcal_lensmodel_metadata_t metadata = {};
  std::optional<Eigen::Vector2d> spline_half_size;
};

namespace {

/// Half sizes of the knot grid; splined models only.
std::optional<Eigen::Vector2d> half_size_of_knots(const mrcal_lensmodel_t& model) {
  if (model.type != MRCAL_LENSMODEL_SPLINED_STEREOGRAPHIC) return std::nullopt;
  const auto& config = model.LENSMODEL_SPLINED_STEREOGRAPHIC__config;
  std::vector<double> ux(config.Nx), uy(config.Ny);
  FT_CHECK(mrcal_knots_for_splined_models(ux.data(), uy.data(), &model),
           "libmrcal gives no knots for a splined model");
  return Eigen::Vector2d(ux.back(), uy.back());
}

}  // namespace

std::optional<MrcalModel> MrcalModel::from_name(const std::string& name) {
  if (!lens_name_fault(name).empty()) return std::nullopt;
  auto impl = std::make_shared<Impl>();
  if (!mrcal_lensmodel_from_name(&impl->lensmodel, name.c_str())) return std::nullopt;
  if (!mrcal_lensmodel_type_is_valid(impl->lensmodel.type)) return std::nullopt;
  impl->metadata = mrcal_lensmodel_metadata(&impl->lensmodel);
  impl->spline_half_size = half_size_of_knots(impl->lensmodel);
  MrcalModel model;
  model.impl_ = std::move(impl);
  return model;
}

std::vector<std::string> MrcalModel::supported_names() {
  std::vector<std::string> names;
  for (const char* const* name = mrcal_supported_lensmodel_names(); *name != nullptr; ++name)
    names.emplace_back(*name);
  return names;
}

int MrcalModel::intrinsics_count() const { return mrcal_lensmodel_num_params(&impl_->lensmodel); }

bool MrcalModel::has_gradients() const { return impl_->metadata.has_gradients; }

bool MrcalModel::can_project_behind_camera() const { return impl_->metadata.can_project_behind_camera; }

std::optional<Eigen::Vector2d> MrcalModel::spline_half_size() const { return impl_->spline_half_size; }

namespace {

mrcal_point3_t to_mrcal(const Eigen::Vector3d& v) {
  mrcal_point3_t p = {};
  p.x = v.x();
  p.y = v.y();
  p.z = v.z();
  return p;
}

bool project_alone(const mrcal_lensmodel_t& model, const double* intrinsics, const Eigen::Vector3d& p_cam,
                   Eigen::Vector2d* q_px) {
  const mrcal_point3_t p = to_mrcal(p_cam);
  mrcal_point2_t q = {};
  if (!mrcal_project(&q, nullptr, nullptr, &p, 1, &model, intrinsics)) return false;
  *q_px = {q.x, q.y};
  return q_px->allFinite();
}

/// Central differences: 1e-5 of the distance balances rounding (1e-16 / 1e-5) and truncation (1e-10). Good to
/// 1e-9 relative, so that Newton on the exact residual still converges to it.
bool numeric_gradient(const mrcal_lensmodel_t& model, const double* intrinsics, const Eigen::Vector3d& p_cam,
                      Eigen::Matrix<double, 2, 3>* dq_dp) {
  const double step = 1e-5 * p_cam.norm();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d offset = step * Eigen::Vector3d::Unit(k);
    Eigen::Vector2d ahead, behind;
    if (!project_alone(model, intrinsics, p_cam + offset, &ahead) ||
        !project_alone(model, intrinsics, p_cam - offset, &behind))
      return false;
    dq_dp->col(k) = (ahead - behind) / (2.0 * step);
  }
  return true;
}

}  // namespace

bool MrcalModel::project(const std::vector<double>& intrinsics, const Eigen::Vector3d& p_cam,
                         Eigen::Vector2d* q_px, Eigen::Matrix<double, 2, 3>* dq_dp,
                         Eigen::Matrix2Xd* dq_dintrinsics) const {
  FT_CHECK(has_gradients() || !dq_dintrinsics, "this lens model has no gradients");
  if (!has_gradients())
    return project_alone(impl_->lensmodel, intrinsics.data(), p_cam, q_px) &&
           (!dq_dp || numeric_gradient(impl_->lensmodel, intrinsics.data(), p_cam, dq_dp));
  const mrcal_point3_t p = to_mrcal(p_cam);
  mrcal_point3_t gradient[2] = {};
  mrcal_point2_t q = {};
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> by_row(2,
                                                                   dq_dintrinsics ? intrinsics_count() : 0);
  if (!mrcal_project(&q, dq_dp ? gradient : nullptr, dq_dintrinsics ? by_row.data() : nullptr, &p, 1,
                     &impl_->lensmodel, intrinsics.data()))
    return false;
  *q_px = {q.x, q.y};
  if (dq_dp)
    *dq_dp << gradient[0].x, gradient[0].y, gradient[0].z, gradient[1].x, gradient[1].y, gradient[1].z;
  if (dq_dintrinsics) *dq_dintrinsics = by_row;
  return q_px->allFinite() && (!dq_dp || dq_dp->allFinite()) &&
         (!dq_dintrinsics || dq_dintrinsics->allFinite());
}

bool MrcalModel::unproject(const std::vector<double>& intrinsics, const Eigen::Vector2d& q_px,
                           Eigen::Vector3d* direction_cam) const {
  // libmrcal solves for CAHVOR and splines, for ever where a projection on the way is NaN, and cannot for
  // CAHVORE. Undistorted models of the same core are near enough for Newton.
  const Eigen::Vector2d u((q_px.x() - intrinsics[2]) / intrinsics[0],
                          (q_px.y() - intrinsics[3]) / intrinsics[1]);
  if (const auto& half = impl_->spline_half_size) {
    const Eigen::Vector2d inside = u.cwiseMin(0.999999 * *half).cwiseMax(-0.999999 * *half);
    *direction_cam = {inside.x(), inside.y(), 1.0 - 0.25 * inside.squaredNorm()};
    return direction_cam->allFinite();
  }
  if (!has_gradients() || impl_->lensmodel.type == MRCAL_LENSMODEL_CAHVOR) {
    *direction_cam = {u.x(), u.y(), 1.0};
    return direction_cam->allFinite();
  }
  mrcal_point2_t q = {};
  q.x = q_px.x();
  q.y = q_px.y();
  mrcal_point3_t v = {};
  if (!mrcal_unproject(&v, &q, 1, &impl_->lensmodel, intrinsics.data())) return false;
  *direction_cam = {v.x, v.y, v.z};
  // A failure is NaN in x and y with z left as it was, and still "true".
  return direction_cam->allFinite() && direction_cam->squaredNorm() > 0.0;
}

namespace {

/// The arguments that mrcal_optimize() and mrcal_optimizer_callback() share, as libmrcal lays them out.
struct Packed {
  explicit Packed(const MrcalProblem& p);
  void unpack_into(MrcalProblem& p) const;

  int n_cameras = 0, n_extrinsics = 0, n_frames = 0, n_views = 0, width_n = 0, height_n = 0, n_params = 0;
  mrcal_lensmodel_t lensmodel = {};
  mrcal_problem_selections_t selections = {};
  mrcal_problem_constants_t constants = {};
  std::vector<double> intrinsics;
  std::vector<int> imagersizes;
  std::vector<mrcal_pose_t> extrinsics, frames;
  mrcal_calobject_warp_t warp = {};
  std::vector<mrcal_observation_board_t> views;
  std::vector<mrcal_point3_t> corners;

  int n_states() const {
    return mrcal_num_states(n_cameras, n_extrinsics, n_frames, 0, 0, n_views, selections, &lensmodel);
  }
  int n_measurements() const {
    return mrcal_num_measurements(n_views, 0, width_n, height_n, n_cameras, n_extrinsics, n_frames, 0, 0,
                                  selections, &lensmodel);
  }
};

mrcal_pose_t to_mrcal(const RotTrans& rt) {
  mrcal_pose_t pose = {};
  pose.r.x = rt[0];
  pose.r.y = rt[1];
  pose.r.z = rt[2];
  pose.t.x = rt[3];
  pose.t.y = rt[4];
  pose.t.z = rt[5];
  return pose;
}

RotTrans from_mrcal(const mrcal_pose_t& pose) {
  RotTrans rt;
  rt << pose.r.x, pose.r.y, pose.r.z, pose.t.x, pose.t.y, pose.t.z;
  return rt;
}

Packed::Packed(const MrcalProblem& p)
    : n_cameras(static_cast<int>(p.intrinsics.size())),
      n_extrinsics(static_cast<int>(p.rt_cam_ref.size())),
      n_frames(static_cast<int>(p.rt_ref_frame.size())),
      n_views(static_cast<int>(p.views.size())),
      width_n(p.width_n),
      height_n(p.height_n) {
  FT_CHECK(mrcal_lensmodel_from_name(&lensmodel, p.lensmodel.c_str()), "unknown lens model " + p.lensmodel);
  FT_CHECK(n_extrinsics + 1 == n_cameras && p.imagersizes.size() == p.intrinsics.size() &&
               p.corners.size() == p.views.size() * p.corners_per_view(),
           "the calibration problem's parts do not fit together");
  n_params = mrcal_lensmodel_num_params(&lensmodel);
  selections.do_optimize_intrinsics_core = p.optimize_core;
  selections.do_optimize_intrinsics_distortions = p.optimize_distortion;
  selections.do_optimize_extrinsics = p.optimize_geometry;
  selections.do_optimize_frames = p.optimize_geometry;
  selections.do_optimize_calobject_warp = p.optimize_warp;
  selections.do_apply_regularization = p.regularize;
  constants.point_min_range = 1e-3;  // of discrete points, which there are none of
  constants.point_max_range = 1e6;
  for (const auto& k : p.intrinsics) {
    FT_CHECK(static_cast<int>(k.size()) == n_params, "wrong number of intrinsics");
    intrinsics.insert(intrinsics.end(), k.begin(), k.end());
  }
  for (const auto& size : p.imagersizes) imagersizes.insert(imagersizes.end(), size.begin(), size.end());
  for (const RotTrans& rt : p.rt_cam_ref) extrinsics.push_back(to_mrcal(rt));
  for (const RotTrans& rt : p.rt_ref_frame) frames.push_back(to_mrcal(rt));
  warp.x2 = p.warp_m.x();
  warp.y2 = p.warp_m.y();
  for (const auto& view : p.views) {
    mrcal_observation_board_t observation = {};
    observation.icam = {view.device, view.device - 1};
    observation.iframe = view.frame;
    views.push_back(observation);
  }
  corners.reserve(p.corners.size());
  for (const Eigen::Vector3d& c : p.corners) {  // weight 0 is written as libmrcal writes "outlier"
    corners.push_back(to_mrcal(c));
    if (!(c.z() > 0.0)) corners.back().z = -1.0;
  }
}

void Packed::unpack_into(MrcalProblem& p) const {
  for (std::size_t i = 0; i < p.intrinsics.size(); ++i)
    p.intrinsics[i].assign(intrinsics.begin() + static_cast<std::ptrdiff_t>(i) * n_params,
                           intrinsics.begin() + static_cast<std::ptrdiff_t>(i + 1) * n_params);
  for (std::size_t i = 0; i < p.rt_cam_ref.size(); ++i) p.rt_cam_ref[i] = from_mrcal(extrinsics[i]);
  for (std::size_t i = 0; i < p.rt_ref_frame.size(); ++i) p.rt_ref_frame[i] = from_mrcal(frames[i]);
  p.warp_m = {warp.x2, warp.y2};
}

int bytes_of(const Eigen::VectorXd& v) {
  return static_cast<int>(sizeof(double)) * static_cast<int>(v.size());
}

}  // namespace

Eigen::VectorXd mrcal_solve(MrcalProblem& problem) {
  Packed p(problem);
  Eigen::VectorXd b(p.n_states()), x(p.n_measurements());
  x.setConstant(std::nan(""));
  const EndsOnCancel no_iteration_asks;
  mrcal_optimize(b.data(), bytes_of(b), x.data(), bytes_of(x), p.intrinsics.data(), p.extrinsics.data(),
                 p.frames.data(), nullptr, &p.warp, p.n_cameras, p.n_extrinsics, p.n_frames, 0, 0,
                 p.views.data(), nullptr, p.n_views, 0, p.corners.data(), &p.lensmodel, p.imagersizes.data(),
                 p.selections, &p.constants, problem.spacing_m, p.width_n, p.height_n, false, false);
  p.unpack_into(problem);
  return x;
}

MrcalLinearisation mrcal_linearise(const MrcalProblem& problem) {
  const Packed p(problem);
  MrcalLinearisation out;
  const int n_states = p.n_states(), n_measurements = p.n_measurements();
  const int n_nonzero =
      _mrcal_num_j_nonzero(p.n_views, 0, p.width_n, p.height_n, p.n_cameras, p.n_extrinsics, p.n_frames, 0, 0,
                           p.views.data(), nullptr, p.selections, &p.lensmodel);
  std::vector<int> column(static_cast<std::size_t>(n_measurements) + 1);
  std::vector<int> row(n_nonzero);
  std::vector<double> value(n_nonzero);
  cholmod_sparse Jt = {};
  Jt.nrow = static_cast<std::size_t>(n_states);
  Jt.ncol = static_cast<std::size_t>(n_measurements);
  Jt.nzmax = static_cast<std::size_t>(n_nonzero);
  Jt.p = column.data();
  Jt.i = row.data();
  Jt.x = value.data();
  Jt.itype = CHOLMOD_INT;
  Jt.xtype = CHOLMOD_REAL;
  Jt.dtype = CHOLMOD_DOUBLE;
  Jt.sorted = 1;
  Jt.packed = 1;
  Eigen::VectorXd b(n_states);
  out.residuals.resize(n_measurements);
  const bool ok = mrcal_optimizer_callback(
      b.data(), bytes_of(b), out.residuals.data(), bytes_of(out.residuals), &Jt, p.intrinsics.data(),
      p.extrinsics.data(), p.frames.data(), nullptr, &p.warp, p.n_cameras, p.n_extrinsics, p.n_frames, 0, 0,
      p.views.data(), nullptr, p.n_views, 0, p.corners.data(), &p.lensmodel, p.imagersizes.data(),
      p.selections, &p.constants, problem.spacing_m, p.width_n, p.height_n, false);
  FT_CHECK(ok, "libmrcal cannot linearise the calibration problem");
  out.Jt = Eigen::Map<const Eigen::SparseMatrix<double>>(n_states, n_measurements, n_nonzero, column.data(),
                                                         row.data(), value.data());
  out.state_scale = Eigen::VectorXd::Ones(n_states);
  mrcal_unpack_solver_state_vector(out.state_scale.data(), p.n_cameras, p.n_extrinsics, p.n_frames, 0, 0,
                                   p.selections, &p.lensmodel);
  out.n_corner_rows = mrcal_num_measurements_boards(p.n_views, p.width_n, p.height_n);
  out.n_intrinsics = mrcal_num_intrinsics_optimization_params(p.selections, &p.lensmodel);
  out.first_intrinsic = problem.optimize_core ? 0 : 4;
  for (int i = 0; i < p.n_cameras; ++i)
    out.intrinsics_at.push_back(mrcal_state_index_intrinsics(i, p.n_cameras, p.n_extrinsics, p.n_frames, 0, 0,
                                                             p.n_views, p.selections, &p.lensmodel));
  for (int i = 0; i < p.n_extrinsics; ++i)
    out.extrinsics_at.push_back(mrcal_state_index_extrinsics(i, p.n_cameras, p.n_extrinsics, p.n_frames, 0, 0,
                                                             p.n_views, p.selections, &p.lensmodel));
  for (int i = 0; i < p.n_frames; ++i)
    out.frames_at.push_back(mrcal_state_index_frames(i, p.n_cameras, p.n_extrinsics, p.n_frames, 0, 0,
                                                     p.n_views, p.selections, &p.lensmodel));
  if (problem.optimize_warp)
    out.warp_at = mrcal_state_index_calobject_warp(p.n_cameras, p.n_extrinsics, p.n_frames, 0, 0, p.n_views,
                                                   p.selections, &p.lensmodel);
  return out;
}

}  // namespace fringetwin
