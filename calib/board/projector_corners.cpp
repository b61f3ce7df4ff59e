// SPDX-License-Identifier: Apache-2.0
#include "calib/board/projector_corners.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::calib {
namespace {

using Row = Eigen::Matrix<double, 6, 1>;  // 1 x y xx xy yy, in window units

/// Distance to the nearest neighbour in row or column.
double nearest_corner_px(const Board& board, const std::vector<Corner>& corners, std::size_t index) {
  const auto width = static_cast<std::size_t>(board.width_n);
  double least = INFINITY;
  const auto look = [&](std::size_t other) {
    if (corners[other].seen()) least = std::min(least, (corners[other].q_px - corners[index].q_px).norm());
  };
  if (index % width > 0) look(index - 1);
  if (index % width + 1 < width) look(index + 1);
  if (index >= width) look(index - width);
  if (index + width < corners.size()) look(index + width);
  return least;
}

struct Reading {
  double value = 0.0, sigma = 0.0;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< per window unit
};

/// One direction's coordinate in the window.
struct Samples {
  std::vector<double> values, precision;  ///< precision: 1 / sigma, of any common scale
  void add(double value, double sigma) {
    values.push_back(value);
    precision.push_back(1.0 / sigma);
  }
  /// Gives every pixel the same weight unless each has a sigma.
  void settle() {
    if (!std::ranges::all_of(precision, [](double p) { return std::isfinite(p) && p > 0.0; }))
      precision.assign(precision.size(), 1.0);
  }
};

/// Robust (Tukey, 4.685 sigma) weighted least squares; value and standard error at the middle of the window.
std::optional<Reading> read_quadratic(const std::vector<Row>& rows, const Samples& samples) {
  const auto& [values, precision] = samples;
  std::vector<double> weight(rows.size(), 1.0);
  Reading reading;
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Row right = Row::Zero();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double w = weight[i] * precision[i] * precision[i];
      normal += w * rows[i] * rows[i].transpose();
      right += w * values[i] * rows[i];
    }
    const SymmetricFactor factor(normal);
    if (factor.rcond() < 1e-9) return std::nullopt;
    const Row fit = factor.solve(right);
    std::vector<double> residual(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) residual[i] = precision[i] * (values[i] - fit.dot(rows[i]));
    std::vector<double> size = residual;
    const double sigma = std::max(mad_sigma(size), 1e-9 * precision[0]);
    double n = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double t = residual[i] / (4.685 * sigma);
      weight[i] = std::abs(t) < 1.0 ? std::pow(1.0 - t * t, 2) : 0.0;
      n += weight[i];
      sum += weight[i] * residual[i] * residual[i];
    }
    if (n <= 7.0) return std::nullopt;
    reading.value = fit[0];
    reading.slope = fit.segment<2>(1);
    reading.sigma = std::sqrt(std::max(sum / (n - 6.0), 1e-18) * factor.solve(Row::Unit(0))(0));
  }
  return reading;
}

double sigma_at(const measure::DirectionDecode& direction, int x, int y) {
  const ImageF& sigma = direction.coordinate_sigma_px;
  return sigma.width == direction.coordinate_px.width ? static_cast<double>(sigma(x, y)) : 1.0;
}

}  // namespace

std::vector<ProjectorCorner> projector_corners(const measure::CameraDecode& decode, const Board& board,
                                               const std::vector<Corner>& camera_corners,
                                               const ProjectorCornerOptions& options) {
  const auto* columns = decode.direction(Axis::x);
  const auto* rows_of = decode.direction(Axis::y);
  if (!columns || !rows_of)
    throw UserError(ExitCode::usage, "projector calibration", "needs fringes in both directions",
                    "capture the board with directions = [\"x\", \"y\"]");
  std::vector<ProjectorCorner> out(camera_corners.size());
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < camera_corners.size(); ++i) {
    if (!camera_corners[i].seen()) continue;
    const Eigen::Vector2d q = camera_corners[i].q_px;
    const double nearest = nearest_corner_px(board, camera_corners, i);
    const int reach = std::min(options.largest_reach_px, static_cast<int>(options.reach * nearest));
    if (reach < 2) continue;
    std::vector<Row> rows;
    Samples column, row;
    int sides[4] = {0, 0, 0, 0};
    const int x0 = static_cast<int>(std::lround(q.x())), y0 = static_cast<int>(std::lround(q.y()));
    for (int y = std::max(0, y0 - reach); y <= std::min(decode.height() - 1, y0 + reach); ++y)
      for (int x = std::max(0, x0 - reach); x <= std::min(decode.width() - 1, x0 + reach); ++x) {
        const double c = columns->coordinate_px(x, y), r = rows_of->coordinate_px(x, y);
        if (!std::isfinite(c) || !std::isfinite(r)) continue;
        const double u = (x - q.x()) / reach, v = (y - q.y()) / reach;
        Row basis;
        basis << 1.0, u, v, u * u, u * v, v * v;
        rows.push_back(basis);
        column.add(c, sigma_at(*columns, x, y));
        row.add(r, sigma_at(*rows_of, x, y));
        ++sides[u < 0 ? 0 : 1];
        ++sides[v < 0 ? 2 : 3];
      }
    const double all = std::pow(2.0 * reach + 1.0, 2);
    const bool is_extrapolated = *std::min_element(sides, sides + 4) < 0.25 * options.least_share * all;
    if (static_cast<double>(rows.size()) < options.least_share * all || is_extrapolated) continue;
    column.settle();
    row.settle();
    const auto c = read_quadratic(rows, column), r = read_quadratic(rows, row);
    if (!c || !r) continue;
    const double slope = std::sqrt(0.5 * (c->slope.squaredNorm() + r->slope.squaredNorm())) / reach;
    out[i] = {{c->value, r->value},
              std::hypot(c->sigma, r->sigma) / std::sqrt(2.0),
              options.camera_corner_sigma_px * slope};
  }
  return out;
}

std::vector<ProjectorCorner> mean_of_cameras(const std::vector<std::vector<ProjectorCorner>>& readings) {
  std::vector<ProjectorCorner> out(readings.empty() ? 0 : readings.front().size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weight = 0.0, own = 0.0, inherited = 0.0;
    for (const auto& of_camera : readings) {
      const ProjectorCorner& c = of_camera[i];
      if (!c.seen()) continue;
      const double w = 1.0 / std::pow(c.total_sigma_px(), 2);
      sum += w * c.q_px;
      weight += w;
      own += std::pow(w * c.sigma_px, 2);
      inherited += std::pow(w * c.inherited_px, 2);
    }
    if (weight > 0.0) out[i] = {sum / weight, std::sqrt(own) / weight, std::sqrt(inherited) / weight};
  }
  return out;
}

std::vector<std::vector<Corner>> weighted_corners(const std::vector<std::vector<ProjectorCorner>>& views) {
  std::vector<double> sigmas;
  for (const auto& view : views)
    for (const ProjectorCorner& c : view)
      if (c.seen()) sigmas.push_back(c.total_sigma_px());
  const double good = nth_smallest(sigmas, sigmas.size() / 10);  // nobody asks where none is seen
  std::vector<std::vector<Corner>> out;
  for (const auto& view : views) {
    std::vector<Corner> corners(view.size());
    for (std::size_t i = 0; i < view.size(); ++i)
      if (view[i].seen()) corners[i] = {view[i].q_px, std::min(1.0, good / view[i].total_sigma_px())};
    out.push_back(std::move(corners));
  }
  return out;
}

}  // namespace fringetwin::calib
