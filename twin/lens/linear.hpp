// SPDX-License-Identifier: Apache-2.0
// Dense linear algebra of any size, compiled once: Eigen's decompositions cost seconds of compile time in
// every file that names one. For matrices of a few rows in a loop over pixels take Eigen's own of fixed size.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "twin/lens/pose.hpp"

namespace fringetwin {

using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;

/// The factors L D L^T of a symmetric positive semidefinite matrix (normal equations, a covariance).
class SymmetricFactor {
 public:
  explicit SymmetricFactor(const MatrixRef& m);
  ~SymmetricFactor();

  /// Returns the estimated reciprocal condition number; 0 where m is singular, indefinite or not finite.
  double rcond() const;
  Eigen::MatrixXd solve(const MatrixRef& right) const;
  Eigen::MatrixXd inverse() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Returns x with m x = right, m symmetric positive semidefinite.
Eigen::MatrixXd solve_symmetric(const MatrixRef& m, const MatrixRef& right);

struct SymmetricEigen {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< unit columns
};
SymmetricEigen symmetric_eigen(const MatrixRef& m);

/// Returns x that minimises |m x - right| (Householder QR).
Eigen::MatrixXd least_squares(const MatrixRef& m, const MatrixRef& right);

/// Returns orthonormal columns that span those of m (rows >= columns).
Eigen::MatrixXd orthonormal_basis(const MatrixRef& m);
/// Returns the orthonormal columns that these lack of all of their length, perpendicular to each of them.
Eigen::MatrixXd orthonormal_complement(const MatrixRef& m);

/// Returns the rotation nearest to m in the Frobenius norm; of determinant -1 where m mirrors.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m);

/// Returns the rigid motion T that minimises sum |T from - to|^2 (Umeyama 1991); needs three pairs or more.
/// Points on one line leave the turn about it to chance.
Pose rigid_alignment(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to);

}  // namespace fringetwin
