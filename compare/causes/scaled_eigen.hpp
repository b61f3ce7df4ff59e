// SPDX-License-Identifier: Apache-2.0
// Inverts normal matrices whose unknowns have other units, and says which of them do the same.
#pragma once
#include <Eigen/Core>
#include <cmath>

#include "twin/lens/linear.hpp"

namespace fringetwin::compare {

/// The eigenvectors of the unknowns scaled to a unit diagonal.
struct ScaledEigen {
  static constexpr double kNull = 1e-9, kNullWithPrior = 1e-13;  ///< eigenvalues that tell nothing
  static constexpr double kInNullDirection = 0.15;  ///< share of an unknown in a direction that is left out

  Eigen::VectorXd scale;
  SymmetricEigen eigen;

  explicit ScaledEigen(const Eigen::MatrixXd& normal)
      : scale(normal.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; })),
        eigen(symmetric_eigen(scale.asDiagonal() * normal * scale.asDiagonal())) {}
  /// Returns the inverse of the normal matrix, without directions below `null`.
  Eigen::MatrixXd inverse(double null) const {
    const Eigen::MatrixXd v = scale.asDiagonal() * eigen.vectors;
    return v * powers(-1.0, null).asDiagonal() * v.transpose();
  }
  /// Returns the matrix that turns the unknowns' columns into orthonormal ones.
  Eigen::MatrixXd whitening(double null) const {
    return scale.asDiagonal() * eigen.vectors * powers(-0.5, null).asDiagonal();
  }
  int rank(double null) const { return static_cast<int>((eigen.values.array() > null).count()); }
  double smallest() const { return eigen.values[0]; }
  bool is_in_null_direction(Eigen::Index unknown, double null) const {
    for (Eigen::Index k = 0; k < eigen.values.size(); ++k)
      if (!(eigen.values[k] > null) && std::abs(eigen.vectors(unknown, k)) > kInNullDirection) return true;
    return false;
  }

 private:
  Eigen::VectorXd powers(double exponent, double null) const {
    return eigen.values.unaryExpr(
        [&](double value) { return value > null ? std::pow(value, exponent) : 0.0; });
  }
};

}  // namespace fringetwin::compare
