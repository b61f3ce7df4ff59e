// SPDX-License-Identifier: Apache-2.0
#include "calib/solve/uncertainty.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/solve/shared_noise.hpp"
#include "twin/base/errors.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::calib {
namespace {

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// R(r + d) = R(r) Exp(J d): the right Jacobian of SO(3) (Chirikjian, "Stochastic Models, Information Theory,
/// and Lie Groups 2", 10.86), as a series near 0.
Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& r) {
  const double t2 = r.squaredNorm(), t = std::sqrt(t2);
  const Eigen::Matrix3d K = cross(r);
  double a = 0.5 - t2 / 24.0, b = 1.0 / 6.0 - t2 / 120.0;
  if (t > 1e-3) {
    a = (1.0 - std::cos(t)) / t2;
    b = (t - std::sin(t)) / (t2 * t);
  }
  return Eigen::Matrix3d::Identity() - a * K + b * K * K;
}

/// d(R(r) p + t)/d(r, t); without the translation's part for a direction.
Eigen::Matrix<double, 3, 6> transform_gradient(const RotTrans& rt, const Eigen::Vector3d& p,
                                               bool at_infinity) {
  const Eigen::Vector3d r = rt.head<3>();
  Eigen::Matrix<double, 3, 6> g = Eigen::Matrix<double, 3, 6>::Zero();
  g.leftCols<3>() = -rotation_from_vector(r) * cross(p) * right_jacobian(r);
  if (!at_infinity) g.rightCols<3>().setIdentity();
  return g;
}

Eigen::Vector3d apply(const RotTrans& rt, const Eigen::Vector3d& p, bool at_infinity) {
  const Eigen::Vector3d turned = rotation_from_vector(rt.head<3>()) * p;
  return at_infinity ? turned : Eigen::Vector3d(turned + rt.tail<3>());
}

Eigen::Vector3d apply_inverse(const RotTrans& rt, const Eigen::Vector3d& p, bool at_infinity) {
  const Eigen::Vector3d shifted = at_infinity ? p : Eigen::Vector3d(p - rt.tail<3>());
  return rotation_from_vector(rt.head<3>()).transpose() * shifted;
}

/// Returns the standard deviation of the residuals of the corners used as numpy.std does: the mean is taken
/// out, both coordinates are pooled.
double observed_sigma(const MrcalProblem& p, const Eigen::VectorXd& residuals) {
  double sum = 0.0, sum_sq = 0.0;
  Eigen::Index n = 0;
  for (std::size_t i = 0; i < p.corners.size(); ++i) {
    if (p.corners[i].z() <= 0.0) continue;
    const Eigen::Vector2d r = residuals.segment<2>(static_cast<Eigen::Index>(2 * i));
    sum += r.sum();
    sum_sq += r.squaredNorm();
    n += 2;
  }
  const auto count = static_cast<double>(n);
  return std::sqrt(std::max(0.0, sum_sq / count - std::pow(sum / count, 2)));
}

}  // namespace

/// A projection with its derivatives.
struct Uncertainty::Projected {
  Eigen::Matrix<double, 2, 3> dq_dpref;  ///< per metre
  Eigen::MatrixXd dq_dstate;             ///< lens and pose of the device; the point at rest in the reference
};

Uncertainty::Uncertainty(const Calibration& c)
    : problem_(c.problem),
      model_(calibratable_model(c.problem.lensmodel)),
      linear_(mrcal_linearise(c.problem)),
      sigma_px_(observed_sigma(c.problem, linear_.residuals)) {
  const Eigen::SparseMatrix<double> product = linear_.Jt * linear_.Jt.transpose();
  JtJ_.compute(Eigen::MatrixXd(product));
  if (JtJ_.info() != Eigen::Success)
    throw UserError(ExitCode::no_convergence, "uncertainty of the calibration",
                    "the corners do not determine every parameter",
                    "use more views, a lens model with fewer terms, or keep the regularisation");
  const Eigen::MatrixXd rows = linear_.Jt.rightCols(linear_.Jt.cols() - linear_.n_corner_rows);
  regularisation_ = JtJ_.matrixL().solve(rows);
  const SharedNoise shared = shared_noise(c, linear_.residuals);
  share_ = shared.share;
  if (share_ > 0.0) noise_ = linear_.Jt * shared.factor;
}

Eigen::MatrixXd Uncertainty::covariance(const Eigen::MatrixXd& dF_dstate) const {
  // JtJ = L L^T. Regularisation steers the solution but is not noise: with its rows Jr the covariance is
  // JtJ^-1 (JtJ - Jr^T Jr) JtJ^-1.
  const Eigen::MatrixXd packed = linear_.state_scale.asDiagonal() * dF_dstate.transpose();
  if (share_ > 0.0) {  // JtJ^-1 (Jt V J) JtJ^-1, V = factor factor^T
    const Eigen::MatrixXd of_noises = noise_.transpose() * Eigen::MatrixXd(JtJ_.solve(packed));
    return of_noises.transpose() * of_noises;
  }
  const Eigen::MatrixXd half = JtJ_.matrixL().solve(packed);
  Eigen::MatrixXd product = half.transpose() * half;
  if (regularisation_.cols() > 0) {
    const Eigen::MatrixXd steered = regularisation_.transpose() * half;
    product -= steered.transpose() * steered;
  }
  return sigma_px_ * sigma_px_ * product;
}

void Uncertainty::add_board_motion(const Eigen::Vector3d& p_ref_m, bool at_infinity,
                                   const Eigen::MatrixX3d& dF_dpref, Eigen::MatrixXd& dF_dstate) const {
  const double share = 1.0 / static_cast<double>(problem_.rt_ref_frame.size());
  for (std::size_t f = 0; f < problem_.rt_ref_frame.size(); ++f) {
    const RotTrans& rt = problem_.rt_ref_frame[f];
    const Eigen::Vector3d p_board = apply_inverse(rt, p_ref_m, at_infinity);
    dF_dstate.middleCols<6>(linear_.frames_at[f]) +=
        share * dF_dpref * transform_gradient(rt, p_board, at_infinity);
  }
}

Uncertainty::Projected Uncertainty::project(int device, const Eigen::Vector3d& p_ref_m,
                                            bool at_infinity) const {
  Projected out;
  out.dq_dstate = Eigen::MatrixXd::Zero(2, linear_.Jt.rows());
  const bool is_reference = device == 0;
  const RotTrans rt = is_reference ? RotTrans(RotTrans::Zero()) : problem_.rt_cam_ref[device - 1];
  const Eigen::Vector3d p_device = apply(rt, p_ref_m, at_infinity);
  Eigen::Vector2d q;
  Eigen::Matrix<double, 2, 3> dq_dp;
  Eigen::Matrix2Xd dq_dlens;
  if (!model_.project(problem_.intrinsics[device], p_device, &q, &dq_dp, &dq_dlens))
    throw UserError(ExitCode::input, "uncertainty of the calibration", "a point cannot be projected", "");
  if (linear_.n_intrinsics > 0)
    out.dq_dstate.middleCols(linear_.intrinsics_at[device], linear_.n_intrinsics) =
        dq_dlens.middleCols(linear_.first_intrinsic, linear_.n_intrinsics);
  if (!is_reference)
    out.dq_dstate.middleCols<6>(linear_.extrinsics_at[device - 1]) =
        dq_dp * transform_gradient(rt, p_ref_m, at_infinity);
  out.dq_dpref = dq_dp * rotation_from_vector(rt.head<3>());
  return out;
}

Eigen::Matrix2d Uncertainty::projection(int device, const Eigen::Vector3d& p_device_mm) const {
  const Eigen::Vector3d p_ref_m = kMetresPerMm * (T_device_ref(problem_, device).inverse() * p_device_mm);
  Projected q = project(device, p_ref_m, false);
  add_board_motion(p_ref_m, false, q.dq_dpref, q.dq_dstate);
  return covariance(q.dq_dstate);
}

Eigen::Matrix2d Uncertainty::projection_at_infinity(int device, const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d v = T_device_ref(problem_, device).rotation.transpose() * direction;
  Projected q = project(device, v, true);
  add_board_motion(v, true, q.dq_dpref, q.dq_dstate);
  return covariance(q.dq_dstate);
}

/// Least squares sum(((q - project(p)) / sigma)^2): a change dq of the projections moves p by
/// -(A^T W A)^-1 A^T W dq.
void Uncertainty::triangulate(const Eigen::Vector3d& p_ref_mm, const std::vector<Sighting>& sightings,
                              Eigen::MatrixXd& dp_dstate, Eigen::Matrix3d& noise_m2) const {
  const Eigen::Vector3d p_m = kMetresPerMm * p_ref_mm;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(3, linear_.Jt.rows());
  for (const Sighting& s : sightings) {
    const Projected q = project(s.device, p_m, false);
    const Eigen::Vector2d w = Eigen::Vector2d(s.use_x, s.use_y) / (s.sigma_px * s.sigma_px);
    normal += q.dq_dpref.transpose() * w.asDiagonal() * q.dq_dpref;
    right += q.dq_dpref.transpose() * w.asDiagonal() * q.dq_dstate;
  }
  const SymmetricFactor factor(normal);
  if (!(factor.rcond() > 1e-14))
    throw UserError(ExitCode::usage, "uncertainty of a point", "the sightings do not determine it",
                    "name at least two devices and three coordinates");
  dp_dstate = -factor.solve(right);
  noise_m2 = factor.inverse();
}

Eigen::MatrixXd Uncertainty::points(const std::vector<Eigen::Vector3d>& p_ref_mm,
                                    const std::vector<Sighting>& sightings) const {
  Eigen::MatrixXd all(3 * p_ref_mm.size(), linear_.Jt.rows());
  for (std::size_t i = 0; i < p_ref_mm.size(); ++i) {
    Eigen::MatrixXd g;
    Eigen::Matrix3d noise;
    triangulate(p_ref_mm[i], sightings, g, noise);
    add_board_motion(kMetresPerMm * p_ref_mm[i], false, -Eigen::Matrix3d::Identity(), g);
    all.middleRows<3>(static_cast<Eigen::Index>(3 * i)) = g / kMetresPerMm;
  }
  return covariance(all);
}

Eigen::Matrix3d Uncertainty::point_noise(const Eigen::Vector3d& p_ref_mm,
                                         const std::vector<Sighting>& sightings) const {
  Eigen::MatrixXd g;
  Eigen::Matrix3d noise;
  triangulate(p_ref_mm, sightings, g, noise);
  return noise / (kMetresPerMm * kMetresPerMm);
}

Eigen::MatrixXd Uncertainty::intrinsics(int device) const {
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(linear_.n_intrinsics, linear_.Jt.rows());
  g.middleCols(linear_.intrinsics_at[device], linear_.n_intrinsics).setIdentity();
  return covariance(g);
}

Eigen::Matrix<double, 6, 6> Uncertainty::extrinsics(int device) const {
  FT_CHECK(device > 0, "the first device is the reference");
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(6, linear_.Jt.rows());
  g.middleCols<6>(linear_.extrinsics_at[device - 1]).setIdentity();
  g.bottomRows<3>() /= kMetresPerMm;
  return covariance(g);
}

double Uncertainty::baseline_sigma_mm(int first, int second) const {
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(1, linear_.Jt.rows());
  const auto center_m = [this](int device) {
    return Eigen::Vector3d(kMetresPerMm * T_device_ref(problem_, device).inverse().translation_mm);
  };
  const Eigen::Vector3d along = (center_m(first) - center_m(second)).normalized();
  for (const auto& [device, sign] : {std::pair{first, 1.0}, std::pair{second, -1.0}}) {
    if (device == 0) continue;  // the reference
    const RotTrans rt = rt_from_pose(T_device_ref(problem_, device));
    constexpr double kStep = 1e-6;  // rad, m: central differences are exact to 1e-12 of the values
    for (Eigen::Index k = 0; k < 6; ++k) {
      const auto moved_m = [&](double step) {
        RotTrans near = rt;
        near[k] += k < 3 ? step : step / kMetresPerMm;
        return Eigen::Vector3d(kMetresPerMm * pose_from_rt(near).inverse().translation_mm);
      };
      g(0, linear_.extrinsics_at[device - 1] + k) +=
          sign * along.dot(moved_m(kStep) - moved_m(-kStep)) / (2.0 * kStep);
    }
  }
  return std::sqrt(covariance(g / kMetresPerMm)(0, 0));
}

Eigen::Matrix2d Uncertainty::warp() const {
  if (linear_.warp_at < 0) return Eigen::Matrix2d::Zero();
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(2, linear_.Jt.rows());
  g.middleCols<2>(linear_.warp_at).setIdentity();
  return covariance(g / kMetresPerMm);
}

Eigen::MatrixXd Uncertainty::rig() const {
  const auto n = static_cast<Eigen::Index>(problem_.intrinsics.size());
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(n * linear_.n_intrinsics + 6 * (n - 1), linear_.Jt.rows());
  Eigen::Index row = 0;
  for (Eigen::Index d = 0; d < n; ++d) {
    g.block(row, linear_.intrinsics_at[d], linear_.n_intrinsics, linear_.n_intrinsics).setIdentity();
    row += linear_.n_intrinsics;
    if (d == 0) continue;
    g.block<6, 6>(row, linear_.extrinsics_at[d - 1]).setIdentity();
    g.middleRows<3>(row + 3) /= kMetresPerMm;
    row += 6;
  }
  return covariance(g);
}

double worst_direction_sigma(const Eigen::Matrix2d& m) {
  return std::sqrt(0.5 * (m(0, 0) + m(1, 1)) + std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1)));
}

double aligned_shape_sigma_mm(const std::vector<Eigen::Vector3d>& p_mm,
                              const Eigen::MatrixXd& covariance_mm2) {
  const auto n = static_cast<Eigen::Index>(p_mm.size());
  FT_CHECK(n >= 3 && covariance_mm2.rows() == 3 * n, "one 3x3 block per point");
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : p_mm) mean += p / static_cast<double>(n);
  Eigen::MatrixXd motion(3 * n, 6);  // of a small turn and shift
  for (Eigen::Index i = 0; i < n; ++i) {
    motion.block<3, 3>(3 * i, 0) = -cross(p_mm[i] - mean);
    motion.block<3, 3>(3 * i, 3).setIdentity();
  }
  const Eigen::MatrixXd Q = orthonormal_basis(motion);
  const double left = covariance_mm2.trace() - (covariance_mm2 * Q).cwiseProduct(Q).sum();
  return std::sqrt(std::max(0.0, left) / static_cast<double>(n));
}

}  // namespace fringetwin::calib
