// SPDX-License-Identifier: Apache-2.0
#include "twin/lens/linear.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "twin/base/errors.hpp"

namespace fringetwin {

struct SymmetricFactor::Impl {
  Eigen::LDLT<Eigen::MatrixXd> ldlt;
};

SymmetricFactor::SymmetricFactor(const MatrixRef& m) : impl_(std::make_unique<Impl>()) {
  impl_->ldlt.compute(Eigen::MatrixXd(m));
}
SymmetricFactor::~SymmetricFactor() = default;

double SymmetricFactor::rcond() const {
  // Eigen's estimate leaves zero pivots out, as if the matrix were well conditioned, and passes over NaN.
  const Eigen::VectorXd pivots = impl_->ldlt.vectorD();
  const bool definite = impl_->ldlt.info() == Eigen::Success && pivots.allFinite() && pivots.minCoeff() > 0.0;
  return definite ? impl_->ldlt.rcond() : 0.0;
}
Eigen::MatrixXd SymmetricFactor::solve(const MatrixRef& right) const {
  return impl_->ldlt.solve(Eigen::MatrixXd(right));
}
Eigen::MatrixXd SymmetricFactor::inverse() const {
  return solve(Eigen::MatrixXd::Identity(impl_->ldlt.rows(), impl_->ldlt.rows()));
}

Eigen::MatrixXd solve_symmetric(const MatrixRef& m, const MatrixRef& right) {
  return SymmetricFactor(m).solve(right);
}

SymmetricEigen symmetric_eigen(const MatrixRef& m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{Eigen::MatrixXd(m)};
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

Eigen::MatrixXd least_squares(const MatrixRef& m, const MatrixRef& right) {
  return Eigen::HouseholderQR<Eigen::MatrixXd>(Eigen::MatrixXd(m)).solve(Eigen::MatrixXd(right));
}

Eigen::MatrixXd orthonormal_basis(const MatrixRef& m) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr{Eigen::MatrixXd(m)};
  return qr.householderQ() * Eigen::MatrixXd::Identity(m.rows(), m.cols());
}

Eigen::MatrixXd orthonormal_complement(const MatrixRef& m) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr{Eigen::MatrixXd(m)};
  const Eigen::MatrixXd all = qr.householderQ();
  return all.rightCols(m.rows() - m.cols());
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Pose rigid_alignment(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to) {
  FT_CHECK(from.size() == to.size() && from.size() >= 3, "alignment needs 3 pairs");
  Eigen::Vector3d from_mean = Eigen::Vector3d::Zero(), to_mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : from) from_mean += p / static_cast<double>(from.size());
  for (const Eigen::Vector3d& p : to) to_mean += p / static_cast<double>(to.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    covariance += (to[i] - to_mean) * (from[i] - from_mean).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // a mirror image is turned back along the direction that says least
  const double sign = svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Matrix3d R =
      svd.matrixU() * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
  return {R, to_mean - R * from_mean};
}

}  // namespace fringetwin
