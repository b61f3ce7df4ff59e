// SPDX-License-Identifier: Apache-2.0
#include "measure/depth_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "measure/fit/robust.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

constexpr double kSteepest = 6.0;        ///< depth over lateral step of neighbours on one surface
constexpr double kFilledFraction = 0.7;  ///< of the window that must be known to fill a missing pixel

/// Fits a weighted polynomial to (dx, dy, value). Returns an unknown fit when underdetermined.
template <int Terms>
DepthFit fit_polynomial(const std::vector<WindowOffset>& at, const std::vector<double>& value,
                        RobustLoss loss, double smallest_scale) {
  using Vector = Eigen::Matrix<double, Terms, 1>;
  using Matrix = Eigen::Matrix<double, Terms, Terms>;
  const auto row = [](const WindowOffset& o) {
    Vector v;
    const double x = o.dx, y = o.dy;
    if constexpr (Terms == 6)
      v << 1.0, x, y, x * x, x * y, y * y;
    else
      v << 1.0, x, y;
    return v;
  };
  std::vector<double> weight(at.size(), 1.0), residual(at.size());
  Vector solution = Vector::Zero();
  Matrix inverse = Matrix::Zero();
  const int passes = loss == RobustLoss::none ? 1 : 3;
  for (int pass = 0; pass < passes; ++pass) {
    Matrix a = Matrix::Zero();
    Vector b = Vector::Zero();
    for (std::size_t k = 0; k < at.size(); ++k) {
      const Vector v = row(at[k]);
      a.noalias() += weight[k] * v * v.transpose();
      b += weight[k] * value[k] * v;
    }
    const Eigen::LDLT<Matrix> ldlt(a);
    if (ldlt.info() != Eigen::Success || !(ldlt.rcond() > 1e-8)) return {};
    solution = ldlt.solve(b);
    if (pass == passes - 1) {
      inverse = ldlt.solve(Matrix::Identity());
      break;
    }
    for (std::size_t k = 0; k < at.size(); ++k) residual[k] = value[k] - row(at[k]).dot(solution);
    std::vector<double> size = residual;
    const double scale = std::max(mad_sigma(size), smallest_scale);
    for (std::size_t k = 0; k < at.size(); ++k) weight[k] = robust_weight(loss, residual[k] / scale);
  }
  return {.inverse_depth = solution[0],
          .slope_x = solution[1],
          .slope_y = solution[2],
          .leverage = static_cast<float>(inverse(0, 0)),
          .slope_xx = static_cast<float>(inverse(1, 1)),
          .slope_xy = static_cast<float>(inverse(1, 2)),
          .slope_yy = static_cast<float>(inverse(2, 2))};
}

/// Fits the surroundings of single pixels. Holds working memory: one a thread.
class WindowFit {
 public:
  WindowFit(const DepthMap& map, const std::vector<WindowOffset>& offsets, double radius_px)
      : map_(map), offsets_(offsets), radius_px_(static_cast<float>(radius_px)) {}

  DepthFit at(int x, int y) {
    const double measured = map_.z_mm(x, y);
    const bool missing = !std::isfinite(measured);
    const double centre = missing ? middle_of_surroundings(x, y) : measured;
    if (!std::isfinite(centre)) return {};
    collect(x, y, centre, missing);
    const double rounding = 1e-12 / centre;
    DepthFit fit;
    if (missing && static_cast<double>(at_.size()) < kFilledFraction * static_cast<double>(offsets_.size()))
      return fit;
    if (at_.size() >= kQuadraticPoints)
      fit = fit_polynomial<6>(at_, inverse_depth_, RobustLoss::tukey, rounding);
    if (!fit.known() && at_.size() >= kPlanePoints)
      fit = fit_polynomial<3>(at_, inverse_depth_, RobustLoss::none, rounding);
    fit.radius_px = radius_px_;
    if (fit.known() && fit.inverse_depth > 0.0) return fit;
    // With too few neighbours to smooth, the depth stays as measured.
    return missing ? DepthFit{} : DepthFit{.inverse_depth = 1.0 / centre};
  }

 private:
  bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < map_.z_mm.width && y < map_.z_mm.height; }

  /// Returns a depth for a pixel that has none; NaN where too few around it have one.
  double middle_of_surroundings(int x, int y) {
    std::vector<double> around;
    for (const WindowOffset& o : offsets_)
      if (inside(x + o.dx, y + o.dy) && std::isfinite(map_.z_mm(x + o.dx, y + o.dy)))
        around.push_back(map_.z_mm(x + o.dx, y + o.dy));
    if (static_cast<double>(around.size()) < kFilledFraction * static_cast<double>(offsets_.size()))
      return DepthFit::kUnknown;
    return upper_median(around);
  }

  /// Collects the pixels of the window that lie on the surface of its middle.
  void collect(int x, int y, double centre, bool missing) {
    at_.clear();
    inverse_depth_.clear();
    auto sigma = static_cast<double>(map_.sigma_mm(x, y));
    for (const WindowOffset& o : offsets_) {
      const int i = x + o.dx, j = y + o.dy;
      if (!inside(i, j)) continue;
      const double z = map_.z_mm(i, j);
      if (missing) sigma = static_cast<double>(map_.sigma_mm(i, j));
      if (!std::isfinite(z) || !map_.joined(centre, z, std::max(o.length, 1.0), sigma)) continue;
      at_.push_back(o);
      inverse_depth_.push_back(1.0 / z);
    }
  }

  const DepthMap& map_;
  const std::vector<WindowOffset>& offsets_;
  float radius_px_;
  std::vector<WindowOffset> at_;
  std::vector<double> inverse_depth_;
};

}  // namespace

bool DepthMap::joined(double z0, double z1, double pixels, double sigma) const {
  return std::abs(z0 - z1) <= kSteepest * pixels * step * z0 + 6.0 * sigma;
}

std::vector<WindowOffset> window_of(double radius_px) {
  std::vector<WindowOffset> offsets;
  const int r = static_cast<int>(std::floor(radius_px));
  for (int dy = -r; dy <= r; ++dy)
    for (int dx = -r; dx <= r; ++dx)
      if (dx * dx + dy * dy <= radius_px * radius_px) offsets.push_back({dx, dy, std::hypot(dx, dy)});
  return offsets;
}

Image<DepthFit> fit_depths(const DepthMap& map, double smoothing_px, double most_smoothing_px) {
  Image<DepthFit> fits(map.z_mm.width, map.z_mm.height, DepthFit{});
  const std::vector<WindowOffset> offsets = window_of(smoothing_px);
  if (offsets.size() < 2) {
    for (std::size_t i = 0; i < fits.size(); ++i)
      if (std::isfinite(map.z_mm.data[i])) fits.data[i].inverse_depth = 1.0 / map.z_mm.data[i];
  } else {
#pragma omp parallel
    {
      WindowFit window(map, offsets, smoothing_px);
#pragma omp for schedule(dynamic, 8)
      for (int y = 0; y < fits.height; ++y)
        for (int x = 0; x < fits.width; ++x) fits(x, y) = window.at(x, y);
    }
  }
  if (most_smoothing_px > smoothing_px) grow_windows(map, smoothing_px, most_smoothing_px, fits);
  return fits;
}

}  // namespace fringetwin::measure
