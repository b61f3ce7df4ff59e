// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/smooth_coordinates.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

namespace fringetwin::measure {
namespace {

constexpr int kTerms = 6;
constexpr std::size_t kFewestInWindow = 10;
constexpr double kExplainedSigmas = 5.0;
using Terms = Eigen::Matrix<double, kTerms, 1>;
using Normal = Eigen::Matrix<double, kTerms, kTerms>;

struct WindowSample {
  Terms terms;
  double value, sigma;
};

struct Window {
  std::vector<Eigen::Vector2i> offsets;
  std::vector<Terms> terms;
  Normal full_inverse;  ///< of the normal equations when every pixel is valid
};

Window make_window(double radius_px) {
  Window window;
  const int r = static_cast<int>(std::floor(radius_px));
  Normal normal = Normal::Zero();
  for (int y = -r; y <= r; ++y)
    for (int x = -r; x <= r; ++x) {
      if (x * x + y * y > radius_px * radius_px) continue;
      Terms t;
      t << 1.0, x, y, x * x, x * y, y * y;
      window.offsets.push_back({x, y});
      window.terms.push_back(t);
      normal += t * t.transpose();
    }
  window.full_inverse = normal.ldlt().solve(Normal::Identity());
  return window;
}

/// Fits the window about (x, y) and gives the smoothed value and its sigma. Returns false where the raw value
/// must stay.
bool smooth_pixel(const Window& window, const DirectionDecode& d, int x, int y,
                  std::vector<WindowSample>& samples, double& value, double& sigma) {
  const ImageD& map = d.coordinate_px;
  samples.clear();
  for (std::size_t k = 0; k < window.offsets.size(); ++k) {
    const int i = x + window.offsets[k].x(), j = y + window.offsets[k].y();
    if (i < 0 || j < 0 || i >= map.width || j >= map.height || !std::isfinite(map(i, j))) continue;
    samples.push_back(
        {window.terms[k], map(i, j) - map(x, y), static_cast<double>(d.coordinate_sigma_px(i, j))});
  }
  if (samples.size() < kFewestInWindow) return false;
  Normal inverse = window.full_inverse;
  if (samples.size() < window.offsets.size()) {
    Normal normal = Normal::Zero();
    for (const WindowSample& s : samples) normal.noalias() += s.terms * s.terms.transpose();
    const Eigen::LDLT<Normal> ldlt(normal);
    if (!(ldlt.rcond() > 1e-6)) return false;
    inverse = ldlt.solve(Normal::Identity());
  }
  Terms right = Terms::Zero();
  for (const WindowSample& s : samples) right += s.value * s.terms;
  const Terms fit = inverse * right;
  for (const WindowSample& s : samples)
    if (!(std::abs(s.value - fit.dot(s.terms)) <= kExplainedSigmas * s.sigma)) return false;
  value = map(x, y) + fit[0];
  sigma = static_cast<double>(d.coordinate_sigma_px(x, y)) * std::sqrt(inverse(0, 0));
  return true;
}

void smooth_direction(const Window& window, DirectionDecode& d) {
  ImageD coordinate = d.coordinate_px;
  ImageF sigma = d.coordinate_sigma_px;
#pragma omp parallel
  {
    std::vector<WindowSample> samples;
#pragma omp for schedule(dynamic, 8)
    for (int y = 0; y < coordinate.height; ++y)
      for (int x = 0; x < coordinate.width; ++x) {
        double value = 0.0, noise = 0.0;
        if (!std::isfinite(coordinate(x, y)) || !smooth_pixel(window, d, x, y, samples, value, noise))
          continue;
        coordinate(x, y) = value;
        sigma(x, y) = static_cast<float>(noise);
      }
  }
  d.coordinate_px = std::move(coordinate);
  d.coordinate_sigma_px = std::move(sigma);
  d.smoothed = true;
}

}  // namespace

void smooth_coordinates(CameraDecode& decode, double radius_px) {
  const Window window = make_window(radius_px);
  if (window.offsets.size() < kFewestInWindow) return;
  for (DirectionDecode& d : decode.directions)
    if (!d.coordinate_sigma_px.empty()) smooth_direction(window, d);
}

}  // namespace fringetwin::measure
