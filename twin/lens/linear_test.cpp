// SPDX-License-Identifier: Apache-2.0
// | tolerance   | origin                                                          |
// |-------------|-----------------------------------------------------------------|
// | 1e-12       | double rounding times the condition of the matrices used (< 30) |
// | 2 in rcond  | Eigen's is an estimate of the 1-norm condition                  |
#include "twin/lens/linear.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "twin/base/errors.hpp"

namespace fringetwin::linear_test {
namespace {

constexpr double kRounding = 1e-12;

double largest(const Eigen::MatrixXd& m) { return m.cwiseAbs().maxCoeff(); }

/// V diag(values) V^T with V a rotation by 0.4 rad about (2, 3, 6)/7.
Eigen::Matrix3d with_eigenvalues(const Eigen::Vector3d& values) {
  const Eigen::Matrix3d V = rotation_from_vector(0.4 / 7.0 * Eigen::Vector3d(2, 3, 6));
  return V * values.asDiagonal() * V.transpose();
}

TEST(Linear, SymmetricSystems) {
  const Eigen::Matrix3d m = with_eigenvalues({1, 4, 20});
  const Eigen::Vector3d x(3, -2, 0.5);
  EXPECT_LT(largest(solve_symmetric(m, m * x) - x), kRounding);
  const SymmetricFactor factor(m);
  EXPECT_LT(largest(factor.inverse() - with_eigenvalues({1, 0.25, 0.05})), kRounding);
  const double norm = m.cwiseAbs().colwise().sum().maxCoeff();
  const double inverse_norm = factor.inverse().cwiseAbs().colwise().sum().maxCoeff();
  EXPECT_GT(factor.rcond() * norm * inverse_norm, 0.5);
  EXPECT_LT(factor.rcond() * norm * inverse_norm, 2.0);
}

// A zero pivot is no good condition, whether rounding leaves it at 0 or beside it.
TEST(Linear, SingularMatricesAreNoticed) {
  for (const Eigen::Matrix3d& m :
       {with_eigenvalues({0, 4, 20}), with_eigenvalues({-1e-3, 4, 20}),
        Eigen::Matrix3d(Eigen::Matrix3d::Zero()), Eigen::Matrix3d(Eigen::Vector3d(1, 0, 2).asDiagonal()),
        Eigen::Matrix3d(Eigen::Matrix3d::Ones())}) {
    EXPECT_LT(SymmetricFactor(m).rcond(), 1e-13) << m;
  }
  EXPECT_EQ(SymmetricFactor(with_eigenvalues({NAN, 1, 1})).rcond(), 0.0);
  EXPECT_EQ(SymmetricFactor(Eigen::Matrix2d(Eigen::Vector2d(1, NAN).asDiagonal())).rcond(), 0.0);
}

TEST(Linear, EigenvaluesAscend) {
  const Eigen::Matrix3d m = with_eigenvalues({20, 1, 4});
  const SymmetricEigen eigen = symmetric_eigen(m);
  EXPECT_LT(largest(eigen.values - Eigen::Vector3d(1, 4, 20)), kRounding);
  EXPECT_LT(largest(eigen.vectors.transpose() * eigen.vectors - Eigen::Matrix3d::Identity()), kRounding);
  EXPECT_LT(largest(m * eigen.vectors - eigen.vectors * eigen.values.asDiagonal()), 20 * kRounding);
}

TEST(Linear, LeastSquaresLeavesAnOrthogonalRest) {
  Eigen::MatrixXd m(5, 2), right(5, 1);
  m << 1, 0, 1, 1, 1, 2, 1, 3, 1, 4;
  right << 1, 2, 4, 4, 6;
  const Eigen::MatrixXd x = least_squares(m, right);
  EXPECT_NEAR(x(0), 1.0, kRounding);  // the line through (i, right_i): 1 + 1.2 i
  EXPECT_NEAR(x(1), 1.2, kRounding);
  const Eigen::MatrixXd basis = orthonormal_basis(m);
  ASSERT_EQ(basis.cols(), 2);
  EXPECT_LT(largest(basis.transpose() * basis - Eigen::Matrix2d::Identity()), kRounding);
  EXPECT_LT(largest(m - basis * (basis.transpose() * m)), 10 * kRounding);
}

TEST(Linear, TheComplementHasWhatTheColumnsLack) {
  const Eigen::MatrixXd m = Eigen::MatrixXd::Random(7, 3), own = orthonormal_basis(m),
                        other = orthonormal_complement(m);
  ASSERT_EQ(other.cols(), 4);
  EXPECT_LT((other.transpose() * m).norm(), 1e-14);  // rounding of sums of seven products
  Eigen::MatrixXd both(7, 7);
  both << own, other;
  EXPECT_LT((both.transpose() * both - Eigen::MatrixXd::Identity(7, 7)).norm(), 1e-14);
  EXPECT_EQ(orthonormal_complement(Eigen::MatrixXd::Identity(4, 4)).cols(), 0);
}

TEST(Linear, NearestRotation) {
  const Eigen::Matrix3d R = rotation_from_vector({0.3, -1.2, 0.7});
  EXPECT_LT(largest(nearest_rotation(R) - R), kRounding);
  // stretched along its own axes: the polar factor is R
  EXPECT_LT(largest(nearest_rotation(R * with_eigenvalues({0.9, 1.0, 1.2})) - R), kRounding);
  EXPECT_NEAR(nearest_rotation(-R).determinant(), -1.0, kRounding);
}

TEST(Linear, RigidAlignment) {
  const Pose T{rotation_from_vector({0.3, -1.2, 0.7}), {100, -20, 7}};
  std::vector<Eigen::Vector3d> from{{0, 0, 250}, {30, 0, 250}, {0, 20, 260}, {5, 5, 240}}, to;
  for (const auto& p : from) to.push_back(T * p);
  const Pose found = rigid_alignment(from, to);
  EXPECT_LT(largest(found.rotation - T.rotation), kRounding);
  EXPECT_LT(largest(found.translation_mm - T.translation_mm), 300 * kRounding);
  // Mirrored points have no motion that meets them: still a rotation, never the mirror.
  std::vector<Eigen::Vector3d> mirrored;
  for (const auto& p : from) mirrored.push_back(p.cwiseProduct(Eigen::Vector3d(-1, 1, 1)));
  EXPECT_NEAR(rigid_alignment(from, mirrored).rotation.determinant(), 1.0, kRounding);
  for (auto& p : from) p.z() = 2.0 * p.x();  // in a plane, on a line
  for (std::size_t i = 0; i < from.size(); ++i) to[i] = T * from[i];
  EXPECT_LT(largest(rigid_alignment(from, to).rotation - T.rotation), 10 * kRounding);
  for (std::size_t i = 0; i < from.size(); ++i) from[i] = {1.0 * static_cast<double>(i), 0, 0};
  for (std::size_t i = 0; i < from.size(); ++i) to[i] = T * from[i];
  const Pose on_line = rigid_alignment(from, to);
  EXPECT_NEAR(on_line.rotation.determinant(), 1.0, kRounding);
  EXPECT_LT(largest(on_line * from.back() - to.back()), 300 * kRounding);
  from.resize(2);
  to.resize(2);
  EXPECT_ANY_THROW(rigid_alignment(from, to));
}

}  // namespace
}  // namespace fringetwin::linear_test
