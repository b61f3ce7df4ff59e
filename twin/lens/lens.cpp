// SPDX-License-Identifier: Apache-2.0
#include "twin/lens/lens.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "twin/base/errors.hpp"
#include "twin/lens/lens_name.hpp"
#include "twin/lens/mrcal_facade.hpp"
#include "twin/lens/opencv_distortion.hpp"

namespace fringetwin {
namespace {

/// Newton stops below this residual; at image coordinates up to 1e5 px double rounding is 1e-11 px.
constexpr double kNewtonStopPx = 1e-11;
/// The promise of unproject() is 1e-9 px; a result must be this close to count.
constexpr double kNewtonAcceptPx = 5e-10;
constexpr int kNewtonMaxIterations = 60;

struct PerspectiveName {
  const char* name;
  int distortion_count;
};
constexpr std::array kPerspectiveNames{
    PerspectiveName{"LENSMODEL_PINHOLE", 0}, PerspectiveName{"LENSMODEL_OPENCV4", 4},
    PerspectiveName{"LENSMODEL_OPENCV5", 5}, PerspectiveName{"LENSMODEL_OPENCV8", 8},
    PerspectiveName{"LENSMODEL_OPENCV12", 12}};

std::optional<int> perspective_distortion_count(const std::string& model) {
  for (const auto& [name, count] : kPerspectiveNames)
    if (model == name) return count;
  return std::nullopt;
}

}  // namespace

struct Lens::Impl {
  std::string model;
  std::vector<double> intrinsics;
  Eigen::Vector2i imagersize_px;
  bool perspective = false;

  // perspective models
  Eigen::Vector2d focal_px, center_px;
  OpenCvDistortion k = OpenCvDistortion::Zero();
  double max_radius_sq = std::numeric_limits<double>::infinity();
  // all others
  std::optional<MrcalModel> mrcal;
  std::optional<Eigen::Vector2d> spline_half_size;

  std::optional<Eigen::Vector2d> project_perspective(const Eigen::Vector3d& p,
                                                     Eigen::Matrix<double, 2, 3>* dq_dp) const;
  std::optional<Eigen::Vector3d> unproject_perspective(const Eigen::Vector2d& q_px) const;
  std::optional<Eigen::Vector2d> project_mrcal(const Eigen::Vector3d& p,
                                               Eigen::Matrix<double, 2, 3>* dq_dp) const;
  std::optional<Eigen::Vector3d> unproject_mrcal(const Eigen::Vector2d& q_px) const;
  bool in_mrcal_domain(const Eigen::Vector3d& p) const;

  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p, Eigen::Matrix<double, 2, 3>* dq_dp) const {
    return perspective ? project_perspective(p, dq_dp) : project_mrcal(p, dq_dp);
  }
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& q) const {
    return perspective ? unproject_perspective(q) : unproject_mrcal(q);
  }

  void set_model(const std::string& where);
  void check_values(const std::string& where) const;
  void check_image_invertible(const std::string& where) const;
};

// ---------------------------------------------------------------- perspective models

std::optional<Eigen::Vector2d> Lens::Impl::project_perspective(const Eigen::Vector3d& p,
                                                               Eigen::Matrix<double, 2, 3>* dq_dp) const {
  if (!(p.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d x(p.x() / p.z(), p.y() / p.z());
  if (!(x.squaredNorm() < max_radius_sq)) return std::nullopt;
  if (!dq_dp) return focal_px.cwiseProduct(distort(k, x)) + center_px;

  Eigen::Matrix2d jacobian;
  const Eigen::Vector2d distorted = distort(k, x, &jacobian);
  Eigen::Matrix<double, 2, 3> dx_dp;
  dx_dp << 1.0, 0.0, -x.x(), 0.0, 1.0, -x.y();
  *dq_dp = focal_px.asDiagonal() * (jacobian * dx_dp / p.z());
  return focal_px.cwiseProduct(distorted) + center_px;
}

/// Newton on the 2x2 system with step halving, kept inside the disk where the map is one-to-one with
/// a positive determinant: there the root is unique, and a step that shrinks the residual exists
/// unless the root lies outside.
std::optional<Eigen::Vector3d> Lens::Impl::unproject_perspective(const Eigen::Vector2d& q_px) const {
  if (!q_px.allFinite()) return std::nullopt;
  const Eigen::Vector2d target = (q_px - center_px).cwiseQuotient(focal_px);
  Eigen::Vector2d x = target;
  if (!(x.squaredNorm() < max_radius_sq)) x *= 0.9 * std::sqrt(max_radius_sq) / x.norm();

  Eigen::Matrix2d jacobian;
  const auto residual_px = [&](const Eigen::Vector2d& at, Eigen::Matrix2d* J) {
    return Eigen::Vector2d(focal_px.cwiseProduct(target - distort(k, at, J)));
  };
  Eigen::Vector2d residual = residual_px(x, &jacobian);
  double error_px = residual.norm();
  for (int i = 0; i < kNewtonMaxIterations && error_px > kNewtonStopPx; ++i) {
    if (!(jacobian.determinant() > 0.0)) return std::nullopt;
    Eigen::Vector2d step = jacobian.inverse() * residual.cwiseQuotient(focal_px);
    bool improved = false;
    for (int halving = 0; halving < 40 && !improved; ++halving, step *= 0.5) {
      const Eigen::Vector2d candidate = x + step;
      if (!(candidate.squaredNorm() < max_radius_sq)) continue;
      Eigen::Matrix2d candidate_jacobian;
      const Eigen::Vector2d candidate_residual = residual_px(candidate, &candidate_jacobian);
      if (!(candidate_residual.norm() < error_px)) continue;
      x = candidate;
      residual = candidate_residual;
      jacobian = candidate_jacobian;
      error_px = residual.norm();
      improved = true;
    }
    if (!improved) break;
  }
  if (!(error_px <= kNewtonAcceptPx)) return std::nullopt;
  return x.homogeneous().normalized();
}

// ---------------------------------------------------------------- models through libmrcal

bool Lens::Impl::in_mrcal_domain(const Eigen::Vector3d& p) const {
  if (!p.allFinite() || !(p.squaredNorm() > 0.0)) return false;
  if (!mrcal->can_project_behind_camera() && !(p.z() > 0.0)) return false;
  if (!spline_half_size) return true;
  // Outside the knot grid mrcal extrapolates the last polynomial.
  const double norm_plus_z = p.norm() + p.z();
  if (!(norm_plus_z > 0.0)) return false;
  const Eigen::Vector2d u = p.head<2>() * (2.0 / norm_plus_z);
  return std::abs(u.x()) <= spline_half_size->x() && std::abs(u.y()) <= spline_half_size->y();
}

std::optional<Eigen::Vector2d> Lens::Impl::project_mrcal(const Eigen::Vector3d& p,
                                                         Eigen::Matrix<double, 2, 3>* dq_dp) const {
  if (!in_mrcal_domain(p)) return std::nullopt;
  Eigen::Vector2d q;
  Eigen::Matrix<double, 2, 3> gradient;
  if (!mrcal->project(intrinsics, p, &q, &gradient)) return std::nullopt;
  // Folded where the map of directions to pixels turns its orientation: det [dq/dp; p] <= 0. (x right,
  // y down, z forward and q = (right, down) make it positive in every regular place.)
  const Eigen::Vector3d row_x = gradient.row(0), row_y = gradient.row(1);
  if (!(row_x.cross(row_y).dot(p) > 0.0)) return std::nullopt;
  if (dq_dp) *dq_dp = gradient;
  return q;
}

/// Newton on the sphere of directions, from libmrcal's answer or a first guess (mrcal_facade.hpp).
std::optional<Eigen::Vector3d> Lens::Impl::unproject_mrcal(const Eigen::Vector2d& q_px) const {
  Eigen::Vector3d v;
  if (!q_px.allFinite() || !mrcal->unproject(intrinsics, q_px, &v)) return std::nullopt;
  v.normalize();
  Eigen::Matrix<double, 2, 3> dq_dp;
  std::optional<Eigen::Vector2d> q = project_mrcal(v, &dq_dp);
  double error_px = q ? (q_px - *q).norm() : std::numeric_limits<double>::infinity();
  for (int i = 0; i < kNewtonMaxIterations && q && error_px > kNewtonStopPx; ++i) {
    Eigen::Matrix<double, 3, 2> tangent;
    tangent.col(0) = v.unitOrthogonal();
    tangent.col(1) = v.cross(tangent.col(0));
    const Eigen::Matrix2d jacobian = dq_dp * tangent;
    const Eigen::Vector2d step = jacobian.inverse() * (q_px - *q);
    bool improved = false;
    for (double part = 1.0; part > 1e-3 && !improved; part *= 0.5) {
      const Eigen::Vector3d candidate = (v + tangent * (part * step)).normalized();
      Eigen::Matrix<double, 2, 3> candidate_gradient;
      const auto candidate_q = project_mrcal(candidate, &candidate_gradient);
      if (!candidate_q || !((q_px - *candidate_q).norm() < error_px)) continue;
      v = candidate;
      q = candidate_q;
      dq_dp = candidate_gradient;
      error_px = (q_px - *q).norm();
      improved = true;
    }
    if (!improved) break;
  }
  if (!(error_px <= kNewtonAcceptPx)) return std::nullopt;
  return v;
}

// ---------------------------------------------------------------- construction and its checks

void Lens::Impl::set_model(const std::string& where) {
  if (const std::string fault = lens_name_fault(model); !fault.empty())
    throw UserError(ExitCode::usage, where,
                    fmt::format("lens model '{}': {}", shown_lens_name(model), fault));
  mrcal = MrcalModel::from_name(model);
  if (!mrcal)
    throw UserError(ExitCode::usage, where, fmt::format("unknown lens model '{}'", shown_lens_name(model)),
                    fmt::format("known are {} (\"...\" stands for the configuration)",
                                fmt::join(MrcalModel::supported_names(), ", ")));
  const auto count = static_cast<std::size_t>(mrcal->intrinsics_count());
  if (intrinsics.size() != count)
    throw UserError(ExitCode::usage, where,
                    fmt::format("{} takes {} intrinsics, {} given", model, count, intrinsics.size()));
}

void Lens::Impl::check_values(const std::string& where) const {
  constexpr double kLargest = 1e9, kSmallestFocalPx = 1e-3, kMostPixels = 2e8;  // of sense, see NumberRange
  for (std::size_t i = 0; i < intrinsics.size(); ++i) {
    if (!std::isfinite(intrinsics[i]))
      throw UserError(ExitCode::usage, where, fmt::format("intrinsics[{}] is not finite", i));
    if (std::abs(intrinsics[i]) > kLargest)
      throw UserError(
          ExitCode::usage, where,
          fmt::format("intrinsics[{}] must be at most {} in size, is {}", i, kLargest, intrinsics[i]));
  }
  if (!(intrinsics[0] > 0.0 && intrinsics[1] > 0.0))
    throw UserError(
        ExitCode::usage, where,
        fmt::format("focal lengths must be positive, are {} and {} px", intrinsics[0], intrinsics[1]));
  if (std::min(intrinsics[0], intrinsics[1]) < kSmallestFocalPx)
    throw UserError(ExitCode::usage, where,
                    fmt::format("focal lengths must be at least {}, are {} and {} px", kSmallestFocalPx,
                                intrinsics[0], intrinsics[1]));
  if (imagersize_px.minCoeff() <= 0)
    throw UserError(
        ExitCode::usage, where,
        fmt::format("imagersize must be positive, is {} x {} px", imagersize_px.x(), imagersize_px.y()));
  if (imagersize_px.cast<double>().prod() > kMostPixels)
    throw UserError(ExitCode::usage, where,
                    fmt::format("imagersize must be at most {:g} pixels in all, is {} x {} px", kMostPixels,
                                imagersize_px.x(), imagersize_px.y()));
}

/// The whole border of the image must have a pre-image (the corners of pixels, half a pixel out), for
/// models without a closed-form domain also a grid of the inside.
void Lens::Impl::check_image_invertible(const std::string& where) const {
  constexpr int kIntervals = 16;
  for (int i = 0; i <= kIntervals; ++i) {
    for (int j = 0; j <= kIntervals; ++j) {
      const bool border = i == 0 || i == kIntervals || j == 0 || j == kIntervals;
      if (perspective && !border) continue;
      const Eigen::Vector2d q(-0.5 + imagersize_px.x() * static_cast<double>(i) / kIntervals,
                              -0.5 + imagersize_px.y() * static_cast<double>(j) / kIntervals);
      if (unproject(q)) continue;
      std::string domain = "the projection folds or ends before";
      std::string hint = "recalibrate with fewer distortion terms or state a smaller imagersize";
      if (spline_half_size) {
        domain = "the spline's knots cover less than the image";
        hint = "recalibrate with a larger fov_x_deg";
      } else if (perspective) {
        domain = fmt::format("the distortion is one-to-one only up to {:.4g} deg off axis",
                             std::atan(std::sqrt(max_radius_sq)) * 180.0 / std::numbers::pi);
      }
      throw UserError(ExitCode::usage, where,
                      fmt::format("{} cannot be inverted at image point ({:g}, {:g}) px: {}", model, q.x(),
                                  q.y(), domain),
                      hint);
    }
  }
}

Lens::Lens(const std::string& model, const std::vector<double>& intrinsics,
           const Eigen::Vector2i& imagersize_px, const std::string& where) {
  auto impl = std::make_shared<Impl>();
  impl->model = model;
  impl->intrinsics = intrinsics;
  impl->imagersize_px = imagersize_px;
  impl->set_model(where);
  impl->check_values(where);
  if (const auto count = perspective_distortion_count(model)) {
    impl->perspective = true;
    impl->focal_px = {intrinsics[0], intrinsics[1]};
    impl->center_px = {intrinsics[2], intrinsics[3]};
    std::copy_n(intrinsics.begin() + 4, *count, impl->k.data());
    const double shrunk = max_invertible_radius(impl->k) * (1.0 - 1e-6);  // keeps the Jacobian regular
    impl->max_radius_sq = shrunk * shrunk;
  } else {
    impl->spline_half_size = impl->mrcal->spline_half_size();
  }
  impl->check_image_invertible(where);
  impl_ = std::move(impl);
}

const std::string& Lens::model() const { return impl_->model; }
const std::vector<double>& Lens::intrinsics() const { return impl_->intrinsics; }
int Lens::width() const { return impl_->imagersize_px.x(); }
int Lens::height() const { return impl_->imagersize_px.y(); }
bool Lens::is_perspective() const { return impl_->perspective; }

const Eigen::Matrix<double, 12, 1>& Lens::opencv_distortion() const {
  FT_CHECK(impl_->perspective, "only perspective models have OpenCV distortion");
  return impl_->k;
}

double Lens::max_invertible_radius_sq() const {
  FT_CHECK(impl_->perspective, "only perspective models have an invertible radius");
  return impl_->max_radius_sq;
}

std::optional<Eigen::Vector2d> Lens::project(const Eigen::Vector3d& p_cam,
                                             Eigen::Matrix<double, 2, 3>* dq_dp) const {
  return impl_->project(p_cam, dq_dp);
}

std::optional<Eigen::Vector3d> Lens::unproject(const Eigen::Vector2d& q_px) const {
  return impl_->unproject(q_px);
}

}  // namespace fringetwin
