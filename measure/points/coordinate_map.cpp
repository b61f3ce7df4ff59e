// SPDX-License-Identifier: Apache-2.0
#include "measure/points/coordinate_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

/// Computes the Lagrange weights of nodes 0 1 2 3 at t, and their derivatives.
void lagrange4(double t, double w[4], double dw[4]) {
  const double a = t, b = t - 1.0, c = t - 2.0, d = t - 3.0;
  w[0] = -b * c * d / 6.0;
  w[1] = a * c * d / 2.0;
  w[2] = -a * b * d / 2.0;
  w[3] = a * b * c / 6.0;
  dw[0] = -(c * d + b * d + b * c) / 6.0;
  dw[1] = (c * d + a * d + a * c) / 2.0;
  dw[2] = -(b * d + a * d + a * b) / 2.0;
  dw[3] = (b * c + a * c + a * b) / 6.0;
}

/// Returns the square root of the sum of the squared weights.
double length(const double* w, int n) { return std::sqrt(std::inner_product(w, w + n, w, 0.0)); }

/// Computes the third difference of four neighbours. Returns false when the slope does not explain it.
bool smooth(double a, double b, double c, double d, double fraction, double noise, double& third) {
  third = std::abs(d - 3.0 * c + 3.0 * b - a);
  const double slope = (std::abs(b - a) + std::abs(c - b) + std::abs(d - c)) / 3.0;
  return third <= fraction * slope + noise;
}

// Largest |t (t-1) (t-2) (t-3)| / 24 in the middle and in an outer interval of four nodes: what a fourth
// difference does to the cubic. The third difference stands for it: they are alike where it matters (rims).
constexpr double kErrorCentred = 0.0234, kErrorShifted = 0.0417;

}  // namespace

CoordinateMap::CoordinateMap(const ImageD& map, const ImageF& sigma, bool smoothed)
    : map_(map), sigma_(sigma), smoothed_(smoothed) {
  std::vector<float> some;
  const std::size_t stride = std::max<std::size_t>(1, sigma.size() / 50000);
  for (std::size_t i = 0; i < sigma.size(); i += stride)
    if (std::isfinite(sigma.data[i]) && std::isfinite(map.data[i])) some.push_back(sigma.data[i]);
  if (!some.empty()) typical_sigma_px_ = upper_median(some);
}

/// Returns the most that noise may do to a third difference: 5 sigma of sqrt(1 + 9 + 9 + 1) of the pixel's
/// own noise.
double CoordinateMap::difference_noise_px(int x, int y) const {
  double sigma = typical_sigma_px_;
  if (!sigma_.empty()) {
    const double own = static_cast<double>(sigma_(x, y));
    if (own > sigma) sigma = own;  // NaN stays out
  }
  return 5.0 * std::sqrt(20.0) * sigma + 1e-3;
}

double CoordinateMap::mean_noise_gain_sq() {
  constexpr int kPlaces = 64;  // midpoints, of polynomials of order 6
  double along = 0.0;
  for (int k = 0; k < kPlaces; ++k) {
    double w[4], d[4];
    lagrange4(1.0 + (k + 0.5) / kPlaces, w, d);
    along += std::pow(length(w, 4), 2) / kPlaces;
  }
  return along * along;
}

double CoordinateMap::sigma_px(double x, double y) const {
  if (sigma_.empty()) return 0.0;
  const int i = std::clamp(static_cast<int>(std::lround(x)), 0, sigma_.width - 1);
  const int j = std::clamp(static_cast<int>(std::lround(y)), 0, sigma_.height - 1);
  const double s = static_cast<double>(sigma_(i, j));
  return std::isfinite(s) ? s : typical_sigma_px_;
}

bool CoordinateMap::sample_cubic(int x0, int y0, double x, double y, double noise_px, MapSample& out) const {
  if (x0 < 0 || y0 < 0 || x0 + 3 >= map_.width || y0 + 3 >= map_.height) return false;
  double wx[4], dx[4], wy[4], dy[4];
  lagrange4(x - x0, wx, dx);
  lagrange4(y - y0, wy, dy);
  const double* row[4];
  for (int j = 0; j < 4; ++j) row[j] = &map_.data[map_.index(x0, y0 + j)];
  out = {};
  for (int j = 0; j < 4; ++j) {
    const double* c = row[j];
    const double value = wx[0] * c[0] + wx[1] * c[1] + wx[2] * c[2] + wx[3] * c[3];
    const double slope = dx[0] * c[0] + dx[1] * c[1] + dx[2] * c[2] + dx[3] * c[3];
    out.value += wy[j] * value;
    out.d_dx += wy[j] * slope;
    out.d_dy += dy[j] * value;
  }
  if (!std::isfinite(out.d_dx + out.d_dy)) return false;  // any NaN among the 16
  double largest = 0.0;
  for (int k = 0; k < 4; ++k) {
    double along_x = 0.0, along_y = 0.0;
    if (!smooth(row[k][0], row[k][1], row[k][2], row[k][3], kSlopeFraction, noise_px, along_x)) return false;
    if (!smooth(row[0][k], row[1][k], row[2][k], row[3][k], kSlopeFraction, noise_px, along_y)) return false;
    largest = std::max({largest, along_x, along_y});
  }
  const bool centred = std::abs(x - x0 - 1.5) <= 0.5 && std::abs(y - y0 - 1.5) <= 0.5;
  out.error_px = (centred ? kErrorCentred : kErrorShifted) * largest;
  if (!smoothed_) out.noise_gain = length(wx, 4) * length(wy, 4);
  return true;
}

bool CoordinateMap::sample_linear(int x0, int y0, double x, double y, double noise_px, MapSample& out) const {
  if (x0 < 0 || y0 < 0 || x0 + 1 >= map_.width || y0 + 1 >= map_.height) return false;
  const auto at = [&](int i, int j) {
    const bool inside = i >= 0 && j >= 0 && i < map_.width && j < map_.height;
    return inside ? map_(i, j) : std::numeric_limits<double>::quiet_NaN();
  };
  // Each side of the cell must be explained by the slope beyond one of its ends: NaN compares false.
  const auto explained = [&](double before, double a, double b, double after) {
    const double d = b - a, d1 = a - before, d2 = after - b;
    return std::abs(d - d1) <= kSlopeFraction * std::abs(d1) + noise_px ||
           std::abs(d - d2) <= kSlopeFraction * std::abs(d2) + noise_px;
  };
  double bend = 0.0;
  for (int k = 0; k < 2; ++k)
    for (const bool along_x : {true, false}) {
      double c[4];
      for (int j = 0; j < 4; ++j) c[j] = along_x ? at(x0 - 1 + j, y0 + k) : at(x0 + k, y0 - 1 + j);
      if (!explained(c[0], c[1], c[2], c[3])) return false;
      const double before = std::abs(c[2] - 2 * c[1] + c[0]), after = std::abs(c[3] - 2 * c[2] + c[1]);
      bend = std::max(bend, std::fmin(before, after));  // fmin leaves out NaN
    }
  out.error_px = bend / 8.0;  // of a parabola
  const double u = x - x0, v = y - y0;
  const double a = map_(x0, y0), b = map_(x0 + 1, y0), c = map_(x0, y0 + 1), d = map_(x0 + 1, y0 + 1);
  out.value = (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d);
  out.noise_gain = smoothed_ ? 1.0 : std::hypot(1 - u, u) * std::hypot(1 - v, v);
  out.d_dx = (1 - v) * (b - a) + v * (d - c);
  out.d_dy = (1 - u) * (c - a) + u * (d - b);
  return std::isfinite(out.value);
}

bool CoordinateMap::sample(double x, double y, MapSample& out) const {
  if (!(x >= 0.0 && y >= 0.0 && x <= map_.width - 1.0 && y <= map_.height - 1.0)) return false;
  const int cx = std::min(static_cast<int>(x), map_.width - 2);
  const int cy = std::min(static_cast<int>(y), map_.height - 2);
  const double noise_px = difference_noise_px(cx, cy);
  if (sample_cubic(cx - 1, cy - 1, x, y, noise_px, out)) return true;
  // the cell itself must be valid before any shifted stencil can contain it
  const double sum = map_(cx, cy) + map_(cx + 1, cy) + map_(cx, cy + 1) + map_(cx + 1, cy + 1);
  if (!std::isfinite(sum)) return false;
  static constexpr int kShifts[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
  for (const auto& shift : kShifts)
    if (sample_cubic(cx - 1 + shift[0], cy - 1 + shift[1], x, y, noise_px, out)) return true;
  return sample_linear(cx, cy, x, y, noise_px, out);
}

}  // namespace fringetwin::measure
