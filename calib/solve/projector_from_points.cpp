// SPDX-License-Identifier: Apache-2.0
#include "calib/solve/projector_from_points.hpp"

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <span>

#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::calib {
namespace {

using P = ProjectorParameter;
using Parameters = std::array<double, P::count>;

constexpr std::size_t kFewestPoints = 500;
constexpr std::size_t kFewestTiles = 30;
constexpr double kHuber = 1.345;        ///< 95 % efficient for normal noise (Huber 1981)
constexpr double kOutlierSigmas = 5.0;  ///< of normal noise, one in 1.7 million lies beyond
constexpr double kMostFocalSigma = 0.1;
constexpr const char* kMoreDepth =
    "capture a scene of several depths that fills the image, or smooth it ([measure] smoothing_px)";
/// Noise of the depths, which least squares takes for relief, draws the answer to one side. With 10,000
/// points of 100 times their noise by a third of the standard errors, of 20 times by two to three of them.
constexpr double kLeastReliefOverNoise = 100.0;

/// Column and row of a point of the world; false behind the projector.
template <class T>
bool project(const T* x, const Eigen::Vector3d& p_world_mm, T* q_px) {
  const T p[3] = {T(p_world_mm.x()), T(p_world_mm.y()), T(p_world_mm.z())};
  T c[3];
  ceres::AngleAxisRotatePoint(x + P::r, p, c);
  for (int i = 0; i < 3; ++i) c[i] += x[P::t + i];
  if (!(c[2] > T(0.0))) return false;
  const T a = c[0] / c[2], b = c[1] / c[2], radial = T(1.0) + x[P::k1] * (a * a + b * b);
  q_px[0] = x[P::fx] * a * radial + x[P::cx];
  q_px[1] = x[P::fy] * b * radial + x[P::cy];
  return true;
}

/// Residuals of one point, over their sigmas: column, and row where rows take part.
struct PointCost {
  const LitPoint& point;
  bool rows;
  template <class T>
  bool operator()(const T* x, T* residual) const {
    T q[2];
    if (!project(x, point.p_world_mm, q)) return false;
    for (int k = 0; k < (rows ? 2 : 1); ++k)
      residual[k] = (q[k] - T(point.q_projector_px[k])) / T(point.sigma_px[k]);
    return true;
  }
};

ceres::CostFunction* cost_of(const LitPoint& point, bool rows) {
  if (rows) return new ceres::AutoDiffCostFunction<PointCost, 2, P::count>(new PointCost{point, true});
  return new ceres::AutoDiffCostFunction<PointCost, 1, P::count>(new PointCost{point, false});
}

/// What stays as it is: without rows a shift along the columns and what only moves rows.
std::vector<int> held(bool rows, bool solve_k1) {
  std::vector<int> out;
  if (!rows) out = {P::fy, P::cy, P::t + 1};
  if (!solve_k1) out.push_back(P::k1);
  return out;
}

[[noreturn]] void refuse_flat(const std::string& where, double relative_sigma) {
  throw UserError(ExitCode::input, where,
                  std::isfinite(relative_sigma)
                      ? fmt::format("the points tell the projector's focal length to {:.0f} % only: the part "
                                    "is too flat, or seen too small",
                                    100.0 * relative_sigma)
                      : "the points lie in one plane, which leaves the projector's focal length open",
                  kMoreDepth);
}

/// Puts the four fifths of the points whose errors are least first in `order`. Returns how many they are.
std::size_t take_best(const std::vector<double>& error, std::vector<std::size_t>& order) {
  const std::size_t n = order.size() * 4 / 5;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(n), order.end(),
                   [&](std::size_t a, std::size_t b) { return error[a] < error[b]; });
  return n;
}

std::vector<std::size_t> every_index(const std::vector<LitPoint>& points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  return order;
}

/// Distances of the points from their plane, mm: the plane of the nearest four fifths, found anew five times.
std::vector<double> distances_from_plane(const std::vector<LitPoint>& points) {
  std::vector<double> distance_mm(points.size(), 0.0);
  std::vector<std::size_t> order = every_index(points);
  std::size_t used = points.size();
  for (int round = 0; round < 6; ++round) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < used; ++k) mean += points[order[k]].p_world_mm;
    mean /= static_cast<double>(used);
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < used; ++k) {
      const Eigen::Vector3d d = points[order[k]].p_world_mm - mean;
      scatter += d * d.transpose();
    }
    const Eigen::Vector3d normal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
    for (std::size_t i = 0; i < points.size(); ++i)
      distance_mm[i] = std::abs(normal.dot(points[i].p_world_mm - mean));
    used = take_best(distance_mm, order);
  }
  return distance_mm;
}

/// Refuses points whose distances from their plane are too much noise of their depths. The nearest nine
/// tenths speak: some false matches make no relief.
void check_relief(const std::vector<LitPoint>& points, const std::string& where) {
  constexpr double kShare = 0.9, kSigmasOfShare = 1.645;  // of a normal distribution
  std::vector<double> distance_mm = distances_from_plane(points), noise_mm;
  const auto rank = static_cast<std::size_t>(kShare * static_cast<double>(points.size() - 1));
  for (const LitPoint& p : points) noise_mm.push_back(p.depth_sigma_mm);
  const double relief = nth_smallest(std::span(distance_mm), rank) / kSigmasOfShare, noise = median(noise_mm);
  if (!(relief >= kLeastReliefOverNoise * noise))
    throw UserError(
        ExitCode::input, where,
        fmt::format(
            "nine tenths of the points lie within {:.3g} mm of a plane, and the noise of their depths "
            "is {:.2g} mm: too flat a part to tell the projector's focal length",
            kSigmasOfShare * relief, noise),
        kMoreDepth);
}

/// Points moved and scaled so that the linear equations below are well conditioned.
struct Scaled {
  Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
  double scale_mm = 1.0;
  explicit Scaled(const std::vector<LitPoint>& points) {
    for (const LitPoint& p : points) mean_mm += p.p_world_mm;
    mean_mm /= static_cast<double>(points.size());
    double sum = 0.0;
    for (const LitPoint& p : points) sum += (p.p_world_mm - mean_mm).squaredNorm();
    scale_mm = std::sqrt(sum / static_cast<double>(points.size()) / 3.0);
  }
};

/// Plane pencil of the columns: u = p1 (X, 1) / p3 (X, 1), each of four numbers, by the linear equations
/// p1 (X, 1) - u p3 (X, 1) = 0 (Hartley and Zisserman 2003, 7.1), the worst fifth of the points left out
/// anew five times.
struct Pencil {
  Eigen::Vector4d p1, p3;
};
Pencil column_pencil(const std::vector<LitPoint>& points, double width_px, const std::string& where) {
  const Scaled scaled(points);
  const double half = 0.5 * width_px;
  const auto homogeneous = [&](const LitPoint& p) {
    Eigen::Vector4d h;
    h << (p.p_world_mm - scaled.mean_mm) / scaled.scale_mm, 1.0;
    return h;
  };
  const auto column = [&](const LitPoint& p) { return p.q_projector_px.x() / half - 1.0; };
  std::vector<std::size_t> order = every_index(points);
  std::size_t used = points.size();
  Eigen::Matrix<double, 8, 1> x;
  std::vector<double> error(points.size());
  for (int round = 0; round < 6; ++round) {
    Eigen::Matrix<double, 8, 8> m = Eigen::Matrix<double, 8, 8>::Zero();
    for (std::size_t k = 0; k < used; ++k) {
      const LitPoint& p = points[order[k]];
      Eigen::Matrix<double, 8, 1> row;
      row.head<4>() = homogeneous(p);
      row.tail<4>() = -column(p) * row.head<4>();
      m += row * row.transpose();
    }
    const SymmetricEigen eigen = symmetric_eigen(m);
    // the second smallest tells whether there is one answer alone: 0 for points of one plane
    if (!(eigen.values[1] > 1e-12 * eigen.values[7]))
      refuse_flat(where, std::numeric_limits<double>::quiet_NaN());
    x = eigen.vectors.col(0);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector4d h = homogeneous(points[i]);
      error[i] = std::abs(x.head<4>().dot(h) / x.tail<4>().dot(h) - column(points[i]));
    }
    used = take_best(error, order);
  }
  // back to px and mm: u = half (u' + 1)
  Pencil out;
  const auto unscaled = [&](const Eigen::Vector4d& v) {
    Eigen::Vector4d w;
    w.head<3>() = v.head<3>() / scaled.scale_mm;
    w[3] = v[3] - w.head<3>().dot(scaled.mean_mm);
    return w;
  };
  out.p3 = unscaled(x.tail<4>());
  out.p1 = half * (unscaled(x.head<4>()) + out.p3);
  // the part lies before the projector
  Eigen::Vector4d mean;
  mean << scaled.mean_mm, 1.0;
  if (out.p3.dot(mean) < 0.0) out.p1 *= -1.0, out.p3 *= -1.0;
  return out;
}

/// Takes the centre nearest to a place, of those that the columns leave open.
void place_along_columns(const Eigen::Vector3d& near_world_mm, Parameters& x) {
  const Eigen::Matrix3d R = rotation_from_vector(Eigen::Vector3d(x[P::r], x[P::r + 1], x[P::r + 2]));
  x[P::t + 1] = -R.row(1).dot(near_world_mm);
}

/// Lens and pose of a pencil of columns. p3 = s (r3, t3), p1 = s (fx r1 + cx r3, fx t1 + cx t3).
Parameters from_pencil(Pencil pencil, const ProjectorFromOptions& options) {
  const double s = pencil.p3.head<3>().norm();
  pencil.p1 /= s;
  pencil.p3 /= s;
  const Eigen::Vector3d r3 = pencil.p3.head<3>();
  const double cx = pencil.p1.head<3>().dot(r3);
  const Eigen::Vector3d across = pencil.p1.head<3>() - cx * r3;
  const double fx = across.norm();
  const Eigen::Vector3d r1 = across / fx, r2 = r3.cross(r1);
  Eigen::Matrix3d R;
  R << r1.transpose(), r2.transpose(), r3.transpose();
  const Eigen::Vector3d rotation = vector_from_rotation(R);
  Parameters x{};
  x[P::fx] = x[P::fy] = fx;
  x[P::cx] = cx;
  x[P::cy] = 0.5 * (options.imagersize_px[1] - 1);
  std::ranges::copy(rotation, x.begin() + P::r);
  x[P::t] = (pencil.p1[3] - cx * pencil.p3[3]) / fx;
  x[P::t + 2] = pencil.p3[3];
  place_along_columns(options.near_world_mm, x);
  return x;
}

/// fy, cy and t2 by the linear equations v z = fy (r2 X) + fy t2 + cy z.
void add_rows(const std::vector<LitPoint>& points, Parameters& x, const std::string& where) {
  const Eigen::Matrix3d R = rotation_from_vector(Eigen::Vector3d(x[P::r], x[P::r + 1], x[P::r + 2]));
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const LitPoint& p : points) {
    const double z = R.row(2).dot(p.p_world_mm) + x[P::t + 2];
    const Eigen::Vector3d row(R.row(1).dot(p.p_world_mm), 1.0, z);
    m += row * row.transpose();
    b += row * (p.q_projector_px.y() * z);
  }
  const Eigen::Vector3d solution = m.ldlt().solve(b);
  if (!(solution[0] > 0.0))
    throw UserError(ExitCode::input, where,
                    "columns and rows of the projector run as in a mirror, which no projector does",
                    "one direction's phases run backwards: reverse the order of its images");
  x[P::fy] = solution[0];
  x[P::t + 1] = solution[1] / solution[0];
  x[P::cy] = solution[2];
}

std::vector<double> residuals_of(const std::vector<LitPoint>& points, bool rows, const Parameters& x) {
  std::vector<double> out;
  out.reserve(points.size() * (rows ? 2 : 1));
  for (const LitPoint& p : points) {
    double r[2] = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    PointCost{p, rows}(x.data(), r);
    out.insert(out.end(), r, r + (rows ? 2 : 1));
  }
  return out;
}

double robust_scale(std::vector<double> residuals) { return mad_sigma(residuals); }

void minimise(const std::vector<LitPoint>& points, bool rows, const std::vector<int>& constant, double huber,
              const std::string& where, Parameters& x) {
  ceres::Problem problem;
  for (const LitPoint& p : points)
    problem.AddResidualBlock(cost_of(p, rows), huber > 0.0 ? new ceres::HuberLoss(huber) : nullptr, x.data());
  problem.SetManifold(x.data(), new ceres::SubsetManifold(P::count, constant));
  ceres::Solver::Options solver;
  solver.max_num_iterations = 200;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.function_tolerance = 1e-12;
  solver.parameter_tolerance = 1e-12;
  solver.gradient_tolerance = 1e-14;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable() || summary.termination_type != ceres::CONVERGENCE)
    throw UserError(ExitCode::no_convergence, where,
                    "no projector was found that the points converge to: " + summary.message,
                    "check the cameras' calibration and [fringes]");
}

/// Returns the points whose residuals (residuals_of) are all within the limit.
std::vector<LitPoint> within(const std::vector<LitPoint>& points, const std::vector<double>& residuals,
                             double limit) {
  const std::size_t per_point = residuals.size() / points.size();
  std::vector<LitPoint> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto first = residuals.begin() + static_cast<std::ptrdiff_t>(i * per_point);
    if (std::all_of(first, first + static_cast<std::ptrdiff_t>(per_point),
                    [&](double r) { return std::abs(r) <= limit; }))
      out.push_back(points[i]);
  }
  return out;
}

void check_number(const std::vector<LitPoint>& points, const std::string& what, const std::string& where) {
  if (points.size() < kFewestPoints)
    throw UserError(ExitCode::input, where,
                    fmt::format("{} {} are too few to solve a projector; {} are needed", points.size(), what,
                                kFewestPoints),
                    "check light, min_modulation_dn and the cameras' calibration");
  std::set<int> tiles;
  for (const LitPoint& p : points) tiles.insert(p.tile);
  if (tiles.size() < kFewestTiles)
    throw UserError(ExitCode::input, where,
                    fmt::format("the {} fill {} tiles of the image; {} are needed for an uncertainty", what,
                                tiles.size(), kFewestTiles),
                    "capture a scene that fills the image");
}

/// Covariance of the free parameters from what the tiles say: H^-1 (sum g g^T) H^-1, g the gradient of a
/// tile.
Eigen::MatrixXd clustered_covariance(const std::vector<LitPoint>& points, bool rows,
                                     const std::vector<int>& constant, const Parameters& x) {
  std::vector<int> free;
  for (int i = 0; i < P::count; ++i)
    if (std::ranges::find(constant, i) == constant.end()) free.push_back(i);
  const auto n = static_cast<Eigen::Index>(free.size());
  // columns scaled to unit length: pixels beside radians and millimetres
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, n);
  std::map<int, Eigen::VectorXd> gradient_of_tile;
  const double* parameters[] = {x.data()};
  for (const LitPoint& p : points) {
    const std::unique_ptr<ceres::CostFunction> cost(cost_of(p, rows));
    double r[2];
    Eigen::Matrix<double, 2, P::count, Eigen::RowMajor> jacobian;
    double* jacobians[] = {jacobian.data()};
    if (!cost->Evaluate(parameters, r, jacobians)) continue;
    Eigen::VectorXd& gradient = gradient_of_tile.try_emplace(p.tile, Eigen::VectorXd::Zero(n)).first->second;
    for (int k = 0; k < (rows ? 2 : 1); ++k) {
      const Eigen::VectorXd row = jacobian.row(k)(free).transpose();
      h += row * row.transpose();
      gradient += r[k] * row;
    }
  }
  const Eigen::VectorXd scale = h.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  h = scale.asDiagonal() * h * scale.asDiagonal();
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(n, n);
  for (const auto& [tile, gradient] : gradient_of_tile) {
    const Eigen::VectorXd v = scale.cwiseProduct(gradient);
    g += v * v.transpose();
  }
  const auto tiles = static_cast<double>(gradient_of_tile.size());
  const Eigen::MatrixXd inverse = SymmetricFactor(h).inverse();
  const Eigen::MatrixXd small = scale.asDiagonal() * (inverse * g * inverse) * scale.asDiagonal();
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(P::count, P::count);
  // each tile's residuals are those of a fit that they took part in: HC1's factor
  out(free, free) = tiles / (tiles - static_cast<double>(n)) * small;
  return out;
}

/// rms over the points of the standard error of their predicted column.
double column_sigma_px(const std::vector<LitPoint>& points, const Parameters& x,
                       const Eigen::MatrixXd& covariance) {
  const double* parameters[] = {x.data()};
  double sum = 0.0;
  for (const LitPoint& p : points) {
    const std::unique_ptr<ceres::CostFunction> cost(cost_of(p, false));
    double r = 0.0;
    Eigen::Matrix<double, 1, P::count> jacobian;
    double* jacobians[] = {jacobian.data()};
    if (!cost->Evaluate(parameters, &r, jacobians)) continue;
    sum += (jacobian * covariance * jacobian.transpose())(0) * p.sigma_px.x() * p.sigma_px.x();
  }
  return std::sqrt(sum / static_cast<double>(points.size()));
}

void describe(const std::vector<LitPoint>& points, ProjectorFromPoints& s) {
  const int per_point = s.rows ? 2 : 1;
  const std::vector<double> residuals = residuals_of(points, s.rows, s.parameters);
  struct Sum {
    double residual = 0.0, variance = 0.0, n = 0.0;
  };
  std::map<int, Sum> tiles;
  double square = 0.0, chi2 = 0.0;
  s.rows_px = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int k = 0; k < per_point; ++k) {
      const double over_sigma = residuals[i * per_point + k], sigma = points[i].sigma_px[k];
      square += over_sigma * over_sigma * sigma * sigma;
      chi2 += over_sigma * over_sigma;
      Sum& sum = tiles[2 * points[i].tile + k];
      sum.residual += over_sigma * sigma;
      sum.variance += sigma * sigma;
      sum.n += 1.0;
    }
    double q[2];
    if (!project(s.parameters.data(), points[i].p_world_mm, q)) continue;
    s.rows_px = {std::min(s.rows_px[0], q[1]), std::max(s.rows_px[1], q[1])};
  }
  const auto n = static_cast<double>(residuals.size());
  s.rms_px = std::sqrt(square / n);
  s.chi2 = chi2 / n;
  double found = 0.0, expected = 0.0;
  for (const auto& [tile, sum] : tiles) {
    // the residual of the fit is predicted minus found
    if (tile % 2 == 0) s.tile_mean_px[tile / 2] = -sum.residual / sum.n;
    found += std::pow(sum.residual / sum.n, 2);
    expected += sum.variance / (sum.n * sum.n);
  }
  s.tile_rms_px = std::sqrt(found / static_cast<double>(tiles.size()));
  s.tile_expected_px = std::sqrt(expected / static_cast<double>(tiles.size()));
}

}  // namespace

const std::array<const char*, P::count>& ProjectorParameter::names() {
  static const std::array<const char*, count> kNames{"fx", "fy", "cx", "cy", "r1", "r2",
                                                     "r3", "t1", "t2", "t3", "k1"};
  return kNames;
}

Pose ProjectorFromPoints::T_projector_world() const {
  RotTrans rt;
  std::copy_n(parameters.begin() + P::r, 6, rt.begin());
  return pose_from_rt(rt);
}

std::vector<double> ProjectorFromPoints::intrinsics() const {
  std::vector<double> out(parameters.begin(), parameters.begin() + 4);
  if (lensmodel == "LENSMODEL_OPENCV4") out.insert(out.end(), {parameters[P::k1], 0.0, 0.0, 0.0});
  return out;
}

ProjectorFromPoints projector_from_points(const std::vector<LitPoint>& points,
                                          const ProjectorFromOptions& options, const std::string& where) {
  check_number(points, "lit points", where);
  check_relief(points, where);
  ProjectorFromPoints s;
  s.rows = std::ranges::all_of(points, [](const LitPoint& p) { return std::isfinite(p.q_projector_px.y()); });
  s.lensmodel = options.solve_k1 ? "LENSMODEL_OPENCV4" : "LENSMODEL_PINHOLE";
  s.parameters = from_pencil(column_pencil(points, options.imagersize_px[0], where), options);
  if (s.rows) add_rows(points, s.parameters, where);

  // first all free parameters but the distortion, which a poor start could lead astray; what a false match
  // puts behind the projector has no residual
  std::vector<double> residuals = residuals_of(points, s.rows, s.parameters);
  minimise(within(points, residuals, std::numeric_limits<double>::max()), s.rows, held(s.rows, false),
           kHuber * std::max(robust_scale(residuals), 1.0), where, s.parameters);
  const std::vector<int> constant = held(s.rows, options.solve_k1);
  std::vector<LitPoint> inliers;
  for (int round = 0; round < 3; ++round) {
    residuals = residuals_of(points, s.rows, s.parameters);
    inliers = within(points, residuals, kOutlierSigmas * robust_scale(residuals));
    check_number(inliers, "points that one projector can have lit", where);
    if (!s.rows) place_along_columns(options.near_world_mm, s.parameters);
    minimise(inliers, s.rows, constant, 0.0, where, s.parameters);
  }
  if (!s.rows) s.parameters[P::fy] = s.parameters[P::fx];  // square pixels
  const Eigen::MatrixXd covariance = clustered_covariance(inliers, s.rows, constant, s.parameters);
  for (int i = 0; i < P::count; ++i) s.sigma[i] = std::sqrt(covariance(i, i));
  const double relative = s.sigma[P::fx] / std::abs(s.parameters[P::fx]);
  if (!(relative < kMostFocalSigma)) refuse_flat(where, relative);
  s.n_points = inliers.size();
  s.n_outliers = points.size() - inliers.size();
  s.column_sigma_px = column_sigma_px(inliers, s.parameters, covariance);
  describe(inliers, s);
  return s;
}

}  // namespace fringetwin::calib
