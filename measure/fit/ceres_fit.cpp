// SPDX-License-Identifier: Apache-2.0
#include "measure/fit/ceres_fit.hpp"

#include <ceres/ceres.h>

#include <array>
#include <cmath>
#include <map>

#include "measure/fit/block_covariance.hpp"
#include "measure/fit/robust.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::measure {
namespace {

/// All points in one residual block with analytic Jacobian, so that a million points cost no million blocks.
class DistanceCost final : public ceres::CostFunction {
 public:
  DistanceCost(const DistanceModel& model, const std::vector<Eigen::Vector3d>& p_mm,
               const std::vector<std::size_t>& index, const std::vector<double>& weight)
      : model_(model), p_mm_(p_mm), index_(index), weight_(weight) {
    set_num_residuals(static_cast<int>(index.size()));
    mutable_parameter_block_sizes()->push_back(model.parameters());
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const auto n = static_cast<std::ptrdiff_t>(index_.size());
    const int m = model_.parameters();
    double* jacobian = jacobians ? jacobians[0] : nullptr;
#pragma omp parallel for schedule(static) if (n > 20000)
    for (std::ptrdiff_t k = 0; k < n; ++k) {
      double* row = jacobian ? jacobian + k * m : nullptr;
      const double root = std::sqrt(weight_[k]);
      residuals[k] = root * model_.distance(x[0], p_mm_[index_[k]], row);
      for (int j = 0; row && j < m; ++j) row[j] *= root;
    }
    return true;
  }

 private:
  const DistanceModel& model_;
  const std::vector<Eigen::Vector3d>& p_mm_;
  const std::vector<std::size_t>& index_;
  const std::vector<double>& weight_;
};

}  // namespace

bool minimise(const DistanceModel& model, const std::vector<Eigen::Vector3d>& p_mm,
              const std::vector<std::size_t>& index, const std::vector<double>& weight, int max_iterations,
              double* x) {
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  DistanceCost cost(model, p_mm, index, weight);
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

std::optional<FitCovariance> covariance_at(const DistanceModel& model,
                                           const std::vector<Eigen::Vector3d>& p_mm,
                                           const std::vector<std::size_t>& index,
                                           const std::vector<int>& block, const double* x) {
  const int m = model.parameters();
  FT_CHECK(m <= DistanceModel::kMostParameters, "a shape with that many parameters");
  BlockSum all(m);
  std::map<int, BlockSum> blocks;
  BlockSum* sum = nullptr;
  int current = 0;
  double sum_sq = 0.0;
  std::array<double, DistanceModel::kMostParameters> row{};
  for (const std::size_t i : index) {
    const double r = model.distance(x, p_mm[i], row.data());
    all.add(row.data(), r);
    sum_sq += r * r;
    if (block.empty()) continue;
    if (!sum || block[i] != current)  // neighbours share a block
      sum = &blocks.try_emplace(current = block[i], m).first->second;
    sum->add(row.data(), r);
  }
  FitCovariance out;
  out.rms_mm = std::sqrt(sum_sq / static_cast<double>(index.size()));
  const Eigen::VectorXd scale = all.jtj.diagonal().cwiseSqrt();
  if (!(scale.minCoeff() > 0.0)) return std::nullopt;
  const Eigen::VectorXd unit = scale.cwiseInverse();
  const SymmetricEigen eigen = symmetric_eigen(scaled_both_sides(all.jtj, unit));
  if (!(eigen.values(0) > 1e-13 * eigen.values(m - 1))) return std::nullopt;
  const bool redundant = index.size() > static_cast<std::size_t>(m);
  const double s_sq = redundant ? sum_sq / (static_cast<double>(index.size()) - m) : kNaN;
  out.covariance = Eigen::MatrixXd::Zero(m, m);
  for (int k = 0; k < m; ++k)
    for (int i = 0; i < m; ++i)
      for (int j = 0; j < m; ++j)
        out.covariance(i, j) +=
            s_sq * unit[i] * unit[j] * eigen.vectors(i, k) * eigen.vectors(j, k) / eigen.values(k);
  out.covariance = block_covariance(blocks, out.covariance);
  return out;
}

std::optional<Eigen::MatrixXd> fit_robustly(const DistanceModel& model, const CentredPoints& points,
                                            const FitOptions& options, const std::string& shape,
                                            const SolveWeighted& solve, const double* x, FitSummary& fit) {
  RobustModel robust;
  robust.n = points.p_mm.size();
  robust.min_points = static_cast<std::size_t>(model.parameters());
  robust.smallest_scale = points.smallest_scale_mm();
  robust.distance = [&](std::size_t i) { return model.distance(x, points.p_mm[i], nullptr); };
  robust.solve = solve;
  const RobustResult result = robust_fit(robust, options);
  fit.n = result.ok ? result.index.size() : robust.n;  // enough points and no fit is no lack of points
  fit.message = result.message;
  if (!result.ok) return std::nullopt;
  const auto found = covariance_at(model, points.p_mm, result.index, options.block, x);
  if (!found) {
    fit.message = "the points do not determine " + shape + " (they lie on a plane, a circle or a line)";
    return std::nullopt;
  }
  fit.rms_mm = found->rms_mm;
  fit.usable = true;
  if (fit.n == robust.min_points) fit.message = "as many points as parameters: no uncertainty";
  return found->covariance;
}

}  // namespace fringetwin::measure
