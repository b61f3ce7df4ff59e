// SPDX-License-Identifier: Apache-2.0
#include "measure/depth_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "measure/fit/robust.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

constexpr double kJoinSigmas = 6.0;      ///< of the noise, besides
constexpr double kFilledFraction = 0.7;  ///< of the window that must be known to fill a missing pixel
constexpr double kLeastRcond = 1e-8;     ///< of normal equations that tell their solution

/// The products x^i y^j of an offset, i + j <= 4, those of a quadratic (1, x, y, xx, xy, yy) first: the sums
/// of these 15 are all that its normal equations hold. The last place is 0.
using Powers = std::array<double, 16>;

Powers powers_of(const WindowOffset& o) {
  const double x = o.dx, y = o.dy, xx = x * x, xy = x * y, yy = y * y;
  return {1.0,    x,      y,       xx,      xy,      yy,      xx * x,  xx * y,
          xy * y, yy * y, xx * xx, xx * xy, xx * yy, xy * yy, yy * yy, 0.0};
}

/// Where the product of two terms of a quadratic stands among the powers.
constexpr std::array<std::array<std::size_t, 6>, 6> kProduct = {{{0, 1, 2, 3, 4, 5},
                                                                 {1, 3, 4, 6, 7, 8},
                                                                 {2, 4, 5, 7, 8, 9},
                                                                 {3, 6, 7, 10, 11, 12},
                                                                 {4, 7, 8, 11, 12, 13},
                                                                 {5, 8, 9, 12, 13, 14}}};

/// A pixel of a window.
struct WindowPixel {
  const Powers* powers;
  double inverse_depth;
  double certainty;  ///< one over its standard error, over that of what variances are stated relative to
};

/// Normal equations of a polynomial.
template <int Terms>
struct NormalEquations {
  Eigen::Matrix<double, Terms, Terms> a;  ///< the lower triangle alone
  Eigen::Matrix<double, Terms, 1> b;

  NormalEquations(const std::vector<WindowPixel>& pixels, const std::vector<double>& weight) {
    Powers sum = {};
    std::array<double, 6> value = {};
    for (std::size_t k = 0; k < pixels.size(); ++k) {
      const Powers& powers = *pixels[k].powers;
      const double w = weight[k], wz = w * pixels[k].inverse_depth;
      for (std::size_t i = 0; i < (Terms == 6 ? 16U : 6U); ++i) sum[i] += w * powers[i];
      for (std::size_t i = 0; i < 6; ++i) value[i] += wz * powers[i];
    }
    for (int i = 0; i < Terms; ++i) {
      b[i] = value[static_cast<std::size_t>(i)];
      for (int j = 0; j <= i; ++j)
        a(i, j) = sum[kProduct[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]];
    }
  }
};

/// What a fit works in, kept from pixel to pixel.
struct FitBuffers {
  std::vector<double> weight, off, size;
};

/// Weighs each pixel by its certainty and, by Tukey, by what it is off by in its own standard errors, over
/// what most of the window is off by in theirs.
void weigh(const std::vector<WindowPixel>& pixels, const Eigen::Matrix<double, 6, 1>& polynomial,
           double smallest_scale, FitBuffers& in) {
  const std::size_t n = pixels.size();
  in.off.resize(n), in.size.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Powers& p = *pixels[k].powers;
    const double there = polynomial[0] + polynomial[1] * p[1] + polynomial[2] * p[2] + polynomial[3] * p[3] +
                         polynomial[4] * p[4] + polynomial[5] * p[5];
    in.off[k] = in.size[k] = (pixels[k].inverse_depth - there) * pixels[k].certainty;
  }
  const double per_scale = 1.0 / std::max(mad_sigma(in.size), smallest_scale);
  for (std::size_t k = 0; k < n; ++k)
    in.weight[k] = pixels[k].certainty * pixels[k].certainty * tukey_weight(in.off[k] * per_scale);
}

/// Fits a polynomial, a quadratic robustly. Returns an unknown fit when underdetermined.
template <int Terms>
DepthFit fit_polynomial(const std::vector<WindowPixel>& pixels, double smallest_scale, FitBuffers& in) {
  constexpr int kReweightings = Terms == 6 ? 2 : 0;
  in.weight.resize(pixels.size());
  for (std::size_t k = 0; k < pixels.size(); ++k) in.weight[k] = pixels[k].certainty * pixels[k].certainty;
  if constexpr (Terms == 6)
    for (int k = 0; k < kReweightings; ++k) {
      const NormalEquations<6> normal(pixels, in.weight);
      const Eigen::LLT<Eigen::Matrix<double, 6, 6>> llt(normal.a);
      if (llt.info() != Eigen::Success) return {};
      weigh(pixels, llt.solve(normal.b), smallest_scale, in);
    }
  const NormalEquations<Terms> normal(pixels, in.weight);
  const Eigen::LDLT<Eigen::Matrix<double, Terms, Terms>> ldlt(normal.a);
  if (ldlt.info() != Eigen::Success || !(ldlt.rcond() > kLeastRcond)) return {};
  const Eigen::Matrix<double, Terms, 1> solution = ldlt.solve(normal.b);
  const Eigen::Matrix<double, Terms, 3> inverse =
      ldlt.solve(Eigen::Matrix<double, Terms, 3>::Identity().eval());
  return {.inverse_depth = solution[0],
          .slope_x = solution[1],
          .slope_y = solution[2],
          .curvature = Terms == 6 ? 2.0 * (solution[Terms - 3] + solution[Terms - 1]) : 0.0,
          .leverage = static_cast<float>(inverse(0, 0)),
          .slope_xx = static_cast<float>(inverse(1, 1)),
          .slope_xy = static_cast<float>(inverse(1, 2)),
          .slope_yy = static_cast<float>(inverse(2, 2))};
}

/// Fits the surroundings of single pixels. Holds working memory: one a thread.
class WindowFit {
 public:
  WindowFit(const DepthMap& map, const InverseDepths& depths, const std::vector<WindowOffset>& offsets,
            double radius_px)
      : map_(map),
        depths_(depths),
        offsets_(offsets),
        reach_(static_cast<int>(radius_px)),
        radius_px_(static_cast<float>(radius_px)) {
    for (const WindowOffset& o : offsets) {
      powers_.push_back(powers_of(o));
      steepest_.push_back(map.steepest(std::max(o.length, 1.0)));
    }
  }

  DepthFit at(int x, int y) {
    const double measured = map_.z_mm(x, y);
    const bool missing = !std::isfinite(measured);
    const double centre = missing ? middle_of_surroundings(x, y) : measured;
    if (!std::isfinite(centre) || !(centre > 0.0)) return {};
    collect(x, y, centre, missing);
    DepthFit fit;
    if (missing &&
        static_cast<double>(pixels_.size()) < kFilledFraction * static_cast<double>(offsets_.size()))
      return fit;
    weigh_by_certainty(missing ? 0.0 : static_cast<double>(depths_.certainty(x, y)));
    const double rounding = 1e-12 / centre;
    if (pixels_.size() >= kQuadraticPoints) fit = fit_polynomial<6>(pixels_, rounding, buffers_);
    if (!fit.known() && pixels_.size() >= kPlanePoints) fit = fit_polynomial<3>(pixels_, rounding, buffers_);
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

  double stated_sigma_mm(std::size_t pixel) const {
    return depths_.certainty.data[pixel] > 0.0F ? static_cast<double>(map_.sigma_mm.data[pixel]) : 0.0;
  }

  /// Collects the pixels of the window that lie on the surface of its middle.
  void collect(int x, int y, double centre, bool missing) {
    pixels_.clear();
    const bool all_inside =
        x >= reach_ && y >= reach_ && x + reach_ < map_.z_mm.width && y + reach_ < map_.z_mm.height;
    const std::size_t middle = map_.z_mm.index(x, y);
    double sigma = stated_sigma_mm(middle);
    for (std::size_t k = 0; k < offsets_.size(); ++k) {
      const WindowOffset& o = offsets_[k];
      if (!all_inside && !inside(x + o.dx, y + o.dy)) continue;
      const std::size_t pixel = map_.z_mm.index(x + o.dx, y + o.dy);
      if (missing) sigma = stated_sigma_mm(pixel);
      // a depth that is unknown is farther than anything
      if (!(std::abs(centre - map_.z_mm.data[pixel]) <= steepest_[k] * centre + kJoinSigmas * sigma))
        continue;
      pixels_.push_back(
          {&powers_[k], depths_.value.data[pixel], static_cast<double>(depths_.certainty.data[pixel])});
    }
  }

  /// States certainties over that of the middle. A pixel whose noise nobody states counts as the window's do
  /// on average, the middle itself, too; all count 1 where none is stated.
  void weigh_by_certainty(double of_middle) {
    double sum = 0.0, known = 0.0;
    for (const WindowPixel& p : pixels_)
      if (p.certainty > 0.0) {
        sum += p.certainty * p.certainty;
        known += 1.0;
      }
    const double typical = known > 0.0 ? std::sqrt(sum / known) : 1.0;
    const double reference = of_middle > 0.0 ? of_middle : typical;
    for (WindowPixel& p : pixels_) p.certainty = (p.certainty > 0.0 ? p.certainty : typical) / reference;
  }

  const DepthMap& map_;
  const InverseDepths& depths_;
  const std::vector<WindowOffset>& offsets_;
  int reach_;
  float radius_px_;
  std::vector<Powers> powers_;    ///< of each offset
  std::vector<double> steepest_;  ///< by which the depth may differ there, over the depth
  std::vector<WindowPixel> pixels_;
  FitBuffers buffers_;
};

}  // namespace

double DepthMap::steepest(double pixels) const { return kSteepest * pixels * step; }

bool DepthMap::joined(double z0, double z1, double pixels, double sigma) const {
  return std::abs(z0 - z1) <= steepest(pixels) * z0 + kJoinSigmas * sigma;
}

std::vector<WindowOffset> window_of(double radius_px) {
  std::vector<WindowOffset> offsets;
  const int r = static_cast<int>(std::floor(radius_px));
  for (int dy = -r; dy <= r; ++dy)
    for (int dx = -r; dx <= r; ++dx)
      if (dx * dx + dy * dy <= radius_px * radius_px) offsets.push_back({dx, dy, std::hypot(dx, dy)});
  return offsets;
}

InverseDepths::InverseDepths(const DepthMap& map)
    : value(map.z_mm.width, map.z_mm.height, DepthFit::kUnknown),
      certainty(map.z_mm.width, map.z_mm.height, 0.0F) {
  constexpr double kMost = std::numeric_limits<float>::max();
  const auto n = static_cast<std::ptrdiff_t>(value.size());
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const auto pixel = static_cast<std::size_t>(i);
    const double z = map.z_mm.data[pixel], sigma = static_cast<double>(map.sigma_mm.data[pixel]);
    if (!std::isfinite(z) || !(z > 0.0)) continue;
    value.data[pixel] = 1.0 / z;
    const double known = z * z / sigma;
    if (sigma > 0.0 && std::isfinite(sigma) && known < kMost)
      certainty.data[pixel] = static_cast<float>(known);
  }
}

Image<DepthFit> fit_depths(const DepthMap& map, double smoothing_px, double most_smoothing_px) {
  Image<DepthFit> fits(map.z_mm.width, map.z_mm.height, DepthFit{});
  const std::vector<WindowOffset> offsets = window_of(smoothing_px);
  if (offsets.size() < 2) {  // nothing to fit, and no slopes to grow from
    for (std::size_t i = 0; i < fits.size(); ++i)
      if (std::isfinite(map.z_mm.data[i])) fits.data[i].inverse_depth = 1.0 / map.z_mm.data[i];
    return fits;
  }
  const InverseDepths depths(map);
#pragma omp parallel
  {
    WindowFit window(map, depths, offsets, smoothing_px);
#pragma omp for schedule(dynamic, 8)
    for (int y = 0; y < fits.height; ++y)
      for (int x = 0; x < fits.width; ++x) fits(x, y) = window.at(x, y);
  }
  if (most_smoothing_px > smoothing_px) grow_windows(depths, smoothing_px, most_smoothing_px, fits);
  return fits;
}

}  // namespace fringetwin::measure
