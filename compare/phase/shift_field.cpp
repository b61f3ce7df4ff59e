// SPDX-License-Identifier: Apache-2.0
#include "compare/phase/shift_field.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "compare/gray/gray_rows.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kStencil = 3;                        // reach of the gradient
constexpr std::size_t kFewestPixelsOfBlock = 100;  // of a block's 1024
constexpr double kWeakDirection = 0.1;   // gradient along the fringes below a third of that across them
constexpr double kLargestTilt = 0.5;     // sine of the angle up to which fringes along y still tell x
constexpr double kLargestSigmaPx = 0.1;  // what is known less well is no diagnosis
constexpr double kOutlier = 9.0;         // a pixel's chi2 over the block's median
constexpr float kNoShift = std::numeric_limits<float>::quiet_NaN();

/// One pixel's normal equations for (dx, dy), its brightness taken out.
struct PixelSums {
  Eigen::Matrix2d h = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  double c = 0.0;
  int freedom = 0;
  double chi2(const Eigen::Vector2d& s) const { return c - 2.0 * s.dot(b) + s.dot(h * s); }
};

struct BlockShift {
  bool x = false, y = false;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero(), sigma = Eigen::Vector2d::Zero();
  double chi2_before = 0.0, chi2_after = 0.0, freedom = 0.0;
};

class ShiftField {
 public:
  ShiftField(const GrayPair& pair, const GainFit& fit, const NoiseLine& noise)
      : pair_(pair), fit_(fit), noise_(noise), per_e_(fit.row.gain_dn * pair.e_scale) {}

  ShiftRow run() {
    const int nx = (pair_.width() + kShiftBlock - 1) / kShiftBlock,
              ny = (pair_.height() + kShiftBlock - 1) / kShiftBlock;
    std::vector<BlockShift> blocks(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny));
#pragma omp parallel for schedule(dynamic)
    for (std::size_t i = 0; i < blocks.size(); ++i)
      blocks[i] = block(static_cast<int>(i) % nx * kShiftBlock, static_cast<int>(i) / nx * kShiftBlock);
    ShiftRow row;
    row.camera = pair_.camera->name;
    row.dx_px = row.dy_px = ImageF(nx, ny, kNoShift);
    double before = 0.0, after = 0.0, freedom = 0.0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const BlockShift& b = blocks[i];
      if (b.x) row.dx_px.data[i] = static_cast<float>(b.shift.x());
      if (b.y) row.dy_px.data[i] = static_cast<float>(b.shift.y());
      if (!b.x && !b.y) continue;
      before += b.chi2_before, after += b.chi2_after, freedom += b.freedom;
    }
    row.dx = component(blocks, 0);
    row.dy = component(blocks, 1);
    row.chi2_before = freedom > 0.0 ? before / freedom : kNaN;
    row.chi2_after = freedom > 0.0 ? after / freedom : kNaN;
    row.n = static_cast<std::uint64_t>(freedom);
    return row;
  }

 private:
  /// DN per pixel; sixth order: a fringe of 6 px loses 1 % of its slope, of 8 px 0.2 %.
  double slope(const GrayImage& image, std::size_t i, std::size_t step) const {
    const auto odd = [&](std::size_t k) {
      return static_cast<double>(image[i + k * step]) - static_cast<double>(image[i - k * step]);
    };
    return per_e_ * (45.0 * odd(1) - 9.0 * odd(2) + odd(3)) / 60.0;
  }

  bool stencil_valid(int x, int y) const {
    for (int k = -kStencil; k <= kStencil; ++k)
      if (pair_.mask(x + k, y) == 0 || pair_.mask(x, y + k) == 0) return false;
    return true;
  }

  /// Returns what is left of residual and gradient once the part along the pixel's own brightness is gone.
  PixelSums pixel(int x, int y) const {
    PixelSums out;
    const std::size_t i = pair_.mask.index(x, y), down = static_cast<std::size_t>(pair_.width());
    Eigen::Vector2d brightness_h = Eigen::Vector2d::Zero();
    double uu = 0.0, ud = 0.0;
    for (const int image : pair_.gain_images) {
      const auto d = static_cast<double>(gray_difference(pair_, fit_, image, i));
      if (!std::isfinite(d)) continue;
      const GrayImage& e = pair_.irradiance->images[image];
      const double u = fit_.row.gain_dn * pair_.irradiance_at(image, i);
      const double w = 1.0 / noise_.variance_dn2(u + fit_.row.black_level_dn);
      const Eigen::Vector2d g(slope(e, i, 1), slope(e, i, down));
      out.h += w * g * g.transpose();
      out.b += w * d * g;
      out.c += w * d * d;
      brightness_h += w * u * g;
      ud += w * u * d;
      uu += w * u * u;
      ++out.freedom;
    }
    if (out.freedom < 3 || !(uu > 0.0)) return {};
    out.h -= brightness_h * brightness_h.transpose() / uu;
    out.b -= brightness_h * (ud / uu);
    out.c -= ud * ud / uu;
    --out.freedom;
    return out;
  }

  /// Returns the shift at which chi2 is least; along fringes of one direction nothing is known and 0 stands.
  static BlockShift solve(const std::vector<PixelSums>& pixels) {
    PixelSums all;
    for (const PixelSums& p : pixels) all.h += p.h, all.b += p.b, all.c += p.c, all.freedom += p.freedom;
    BlockShift out;
    out.freedom = all.freedom;
    out.chi2_before = out.chi2_after = all.c;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(all.h);
    if (!(eigen.eigenvalues()[1] > 0.0)) return out;
    if (eigen.eigenvalues()[0] >= kWeakDirection * eigen.eigenvalues()[1]) {
      const Eigen::Matrix2d covariance = all.h.inverse();
      out.shift = covariance * all.b;
      out.sigma = covariance.diagonal().cwiseSqrt();
      out.x = out.y = true;
    } else {
      const Eigen::Vector2d along = eigen.eigenvectors().col(0);
      const int c = std::abs(along.x()) < std::abs(along.y()) ? 0 : 1;
      if (std::abs(along[c]) > kLargestTilt) return out;
      out.shift[c] = all.b[c] / all.h(c, c);
      out.sigma[c] = 1.0 / std::sqrt(all.h(c, c));
      (c == 0 ? out.x : out.y) = true;
    }
    out.chi2_after = all.chi2(out.shift);
    out.sigma *= std::sqrt(std::max(1.0, out.chi2_after / out.freedom));
    return out;
  }

  BlockShift block(int x0, int y0) const {
    std::vector<PixelSums> pixels;
    for (int y = std::max(y0, kStencil); y < std::min(y0 + kShiftBlock, pair_.height() - kStencil);
         y += row_step(pair_.width(), pair_.height()))
      for (int x = std::max(x0, kStencil); x < std::min(x0 + kShiftBlock, pair_.width() - kStencil); ++x)
        if (stencil_valid(x, y))
          if (const PixelSums p = pixel(x, y); p.freedom > 0) pixels.push_back(p);
    if (pixels.size() < kFewestPixelsOfBlock) return {};
    BlockShift out = solve(pixels);
    // edges and shadows that the twin has elsewhere
    std::vector<double> reduced;
    for (const PixelSums& p : pixels) reduced.push_back(p.chi2(out.shift) / p.freedom);
    std::vector<double> sorted = reduced;
    const double limit = kOutlier * upper_median(sorted);
    std::vector<PixelSums> kept;
    for (std::size_t k = 0; k < pixels.size(); ++k)
      if (reduced[k] <= limit) kept.push_back(pixels[k]);
    if (kept.size() < kFewestPixelsOfBlock) return {};
    out = solve(kept);
    out.x = out.x && out.sigma.x() <= kLargestSigmaPx;
    out.y = out.y && out.sigma.y() <= kLargestSigmaPx;
    return out;
  }

  /// Returns the mean over blocks; its sigma from their scatter, never below their own.
  static ShiftComponent component(const std::vector<BlockShift>& blocks, int c) {
    ShiftComponent out;
    double sum = 0.0, square = 0.0, variance = 0.0, n = 0.0;
    for (const BlockShift& b : blocks) {
      if (!(c == 0 ? b.x : b.y)) continue;
      const double s = b.shift[c];
      sum += s, square += s * s, variance += b.sigma[c] * b.sigma[c], n += 1.0;
      out.largest_px = std::max(out.largest_px, std::abs(s));
    }
    out.n_blocks = static_cast<std::uint64_t>(n);
    if (n == 0.0) {
      out.mean_px = out.mean_sigma_px = out.rms_px = out.largest_px = kNaN;
      return out;
    }
    out.mean_px = sum / n;
    out.rms_px = std::sqrt(square / n);
    const double scatter =
        n > 1.0 ? std::max(0.0, square - n * out.mean_px * out.mean_px) / (n * (n - 1.0)) : 0.0;
    out.mean_sigma_px = std::sqrt(std::max(scatter, variance / (n * n)));
    return out;
  }

  const GrayPair& pair_;
  const GainFit& fit_;
  NoiseLine noise_;
  double per_e_;
};

}  // namespace

NoiseLine noise_line(const GrayPair& pair, const GainFit& fit, const std::optional<GrayBudget>& budget) {
  if (pair.real->radiance) {
    const double v = fit.row.robust_scale_dn * fit.row.robust_scale_dn;
    return {v, 0.0, std::max(1e-12 * v, std::numeric_limits<double>::min())};
  }
  if (budget) return {budget->noise_offset_dn2, budget->noise_per_dn, kRoundingVariance};
  const Sensor& sensor = pair.camera->sensor;
  const double per_dn = sensor.electrons_per_dn ? 1.0 / *sensor.electrons_per_dn : 0.0;
  const double read = std::pow(sensor.read_noise_dn.value_or(0.0), 2) + kRoundingVariance;
  return {read - per_dn * sensor.black_level_dn, per_dn, read};
}

ShiftRow shift_field(const GrayPair& pair, const GainFit& fit, const NoiseLine& noise) {
  return ShiftField(pair, fit, noise).run();
}

}  // namespace fringetwin::compare
