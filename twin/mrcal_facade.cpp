// SPDX-License-Identifier: Apache-2.0
#include "twin/mrcal_facade.hpp"

#include <cmath>

#include "twin/errors.hpp"

extern "C" {  // the headers of libmrcal 2.2 do not say so themselves
#include <mrcal/mrcal.h>
}

namespace fringetwin {

struct MrcalModel::Impl {
  mrcal_lensmodel_t lensmodel = {};
  mrcal_lensmodel_metadata_t metadata = {};
};

std::optional<MrcalModel> MrcalModel::from_name(const std::string& name) {
  auto impl = std::make_shared<Impl>();
  if (!mrcal_lensmodel_from_name(&impl->lensmodel, name.c_str())) return std::nullopt;
  if (!mrcal_lensmodel_type_is_valid(impl->lensmodel.type)) return std::nullopt;
  impl->metadata = mrcal_lensmodel_metadata(&impl->lensmodel);
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

std::optional<Eigen::Vector2d> MrcalModel::spline_half_size() const {
  if (impl_->lensmodel.type != MRCAL_LENSMODEL_SPLINED_STEREOGRAPHIC) return std::nullopt;
  const auto& config = impl_->lensmodel.LENSMODEL_SPLINED_STEREOGRAPHIC__config;
  std::vector<double> ux(config.Nx), uy(config.Ny);
  FT_CHECK(mrcal_knots_for_splined_models(ux.data(), uy.data(), &impl_->lensmodel),
           "libmrcal gives no knots for a splined model");
  return Eigen::Vector2d(ux.back(), uy.back());
}

namespace {

bool project_alone(const mrcal_lensmodel_t& model, const double* intrinsics, const Eigen::Vector3d& p_cam,
                   Eigen::Vector2d* q_px) {
  mrcal_point3_t p = {};
  p.x = p_cam.x();
  p.y = p_cam.y();
  p.z = p_cam.z();
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
                         Eigen::Vector2d* q_px, Eigen::Matrix<double, 2, 3>* dq_dp) const {
  if (!has_gradients())
    return project_alone(impl_->lensmodel, intrinsics.data(), p_cam, q_px) &&
           (!dq_dp || numeric_gradient(impl_->lensmodel, intrinsics.data(), p_cam, dq_dp));
  mrcal_point3_t p = {}, gradient[2] = {};
  p.x = p_cam.x();
  p.y = p_cam.y();
  p.z = p_cam.z();
  mrcal_point2_t q = {};
  if (!mrcal_project(&q, dq_dp ? gradient : nullptr, nullptr, &p, 1, &impl_->lensmodel, intrinsics.data()))
    return false;
  *q_px = {q.x, q.y};
  if (dq_dp) {
    *dq_dp << gradient[0].x, gradient[0].y, gradient[0].z, gradient[1].x, gradient[1].y, gradient[1].z;
    if (!dq_dp->allFinite()) return false;
  }
  return q_px->allFinite();
}

bool MrcalModel::unproject(const std::vector<double>& intrinsics, const Eigen::Vector2d& q_px,
                           Eigen::Vector3d* direction_cam) const {
  if (!has_gradients()) {  // libmrcal cannot; the pinhole of the same core is near enough for Newton
    *direction_cam = {(q_px.x() - intrinsics[2]) / intrinsics[0], (q_px.y() - intrinsics[3]) / intrinsics[1],
                      1.0};
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

}  // namespace fringetwin
