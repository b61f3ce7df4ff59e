// SPDX-License-Identifier: Apache-2.0
// One dense Ceres problem per fit: all points in one residual block with analytic Jacobian, so that
// a million points cost no million blocks. Private to measure/ (heavy header).
#pragma once
#include <ceres/ceres.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <map>
#include <vector>

#include "measure/block_covariance.hpp"

namespace fringetwin::measure {

/// Residual k = sqrt(weight_k) * distance(point_k; parameters). Model: static constexpr int kParameters and
/// `double operator()(const double* x, const Eigen::Vector3d& p, double* dr_dx) const`, dr_dx may be null.
template <class Model>
class DistanceCost final : public ceres::CostFunction {
 public:
  DistanceCost(Model model, const std::vector<Eigen::Vector3d>& p_mm, const std::vector<std::size_t>& index,
               const std::vector<double>& weight)
      : model_(model), p_mm_(p_mm), index_(index), weight_(weight) {
    set_num_residuals(static_cast<int>(index.size()));
    mutable_parameter_block_sizes()->push_back(Model::kParameters);
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const auto n = static_cast<std::ptrdiff_t>(index_.size());
    double* jacobian = jacobians ? jacobians[0] : nullptr;
#pragma omp parallel for schedule(static) if (n > 20000)
    for (std::ptrdiff_t k = 0; k < n; ++k) {
      double* row = jacobian ? jacobian + k * Model::kParameters : nullptr;
      const double root = std::sqrt(weight_[k]);
      residuals[k] = root * model_(x[0], p_mm_[index_[k]], row);
      for (int j = 0; row && j < Model::kParameters; ++j) row[j] *= root;
    }
    return true;
  }

 private:
  Model model_;
  const std::vector<Eigen::Vector3d>& p_mm_;
  const std::vector<std::size_t>& index_;
  const std::vector<double>& weight_;
};

/// Levenberg-Marquardt from x; false when not converged.
template <class Model>
bool minimise(const Model& model, const std::vector<Eigen::Vector3d>& p_mm,
              const std::vector<std::size_t>& index, const std::vector<double>& weight, int max_iterations,
              double* x) {
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  DistanceCost<Model> cost(model, p_mm, index, weight);
  ceres::Problem problem(ownership);
  problem.AddResidualBlock(&cost, nullptr, x);
  ceres::Solver::Options options;
  options.max_num_iterations = max_iterations;
  // QR keeps small caps well conditioned; for very many points its cost matters, its digits do not.
  options.linear_solver_type = index.size() <= 50000 ? ceres::DENSE_QR : ceres::DENSE_NORMAL_CHOLESKY;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-13;
  options.gradient_tolerance = 1e-15;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.IsSolutionUsable() && summary.termination_type == ceres::CONVERGENCE;
}

/// s^2 (J^T J)^-1 at x with s^2 = sum r^2/(n - parameters), raised by block_covariance() when the points'
/// blocks are given (one per point of p_mm); NaN without redundancy. False when J^T J is singular (columns
/// scaled to unit length; reciprocal condition < 1e-13).
template <class Model>
bool covariance_at(const Model& model, const std::vector<Eigen::Vector3d>& p_mm,
                   const std::vector<std::size_t>& index, const std::vector<int>& block, const double* x,
                   Eigen::Matrix<double, Model::kParameters, Model::kParameters>& covariance,
                   double& rms_mm) {
  constexpr int m = Model::kParameters;
  using Matrix = Eigen::Matrix<double, m, m>;
  using Vector = Eigen::Matrix<double, m, 1>;
  Matrix jtj = Matrix::Zero();
  double sum_sq = 0.0;
  Vector row;
  std::map<int, BlockSum<m>> blocks;
  BlockSum<m>* sum = nullptr;
  int current = 0;
  for (const std::size_t i : index) {
    const double r = model(x, p_mm[i], row.data());
    jtj.noalias() += row * row.transpose();
    sum_sq += r * r;
    if (block.empty()) continue;
    if (!sum || block[i] != current) sum = &blocks[current = block[i]];  // neighbours share a block
    sum->jtj.noalias() += row * row.transpose();
    sum->jtr += r * row;
  }
  rms_mm = std::sqrt(sum_sq / static_cast<double>(index.size()));
  const Vector scale = jtj.diagonal().cwiseSqrt();
  if (!(scale.minCoeff() > 0.0)) return false;
  const Vector inverse_scale = scale.cwiseInverse();
  const Matrix scaled = inverse_scale.asDiagonal() * jtj * inverse_scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(scaled);
  if (!(eigen.eigenvalues()(0) > 1e-13 * eigen.eigenvalues()(m - 1))) return false;
  const Matrix inverse = eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                         eigen.eigenvectors().transpose();
  const double s_sq = sum_sq / (static_cast<double>(index.size()) - m);  // 0/0 = NaN without redundancy
  const double factor = index.size() > static_cast<std::size_t>(m) ? s_sq : std::nan("");
  covariance = factor * (inverse_scale.asDiagonal() * inverse * inverse_scale.asDiagonal());
  covariance = block_covariance<m>(blocks, Matrix(covariance));
  return true;
}

}  // namespace fringetwin::measure
