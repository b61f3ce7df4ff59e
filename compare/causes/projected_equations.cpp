// SPDX-License-Identifier: Apache-2.0
// Sets up the sums of Sensitivity pixel by pixel: what every pixel has of its own is projected out of its
// residuals and columns first.
#include <algorithm>
#include <cmath>

#include "compare/causes/sensitivity.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

constexpr Eigen::Index kPixelsAtOnce = 32;
constexpr int kBlockPx = 28;  ///< side of the blocks of pixels whose errors may belong together

FreePerPixel with_factor(FreePerPixel f) {
  return frees_offset(f) ? FreePerPixel::factor_and_offset : FreePerPixel::factor;
}

/// An orthonormal basis of what a pixel has of its own, offset first.
struct OwnDirections {
  Eigen::MatrixXd q;
  double factor_norm = 0.0;  ///< of the irradiance, less its mean where the offset is free; 0: none

  OwnDirections(const Eigen::VectorXd& weight, const Eigen::VectorXd& weighted_e, FreePerPixel free)
      : q(weight.size(), (frees_offset(free) ? 1 : 0) + (frees_factor(free) ? 1 : 0)) {
    if (frees_offset(free)) q.col(0) = weight.normalized();
    if (!frees_factor(free)) return;
    Eigen::VectorXd e = weighted_e;
    if (frees_offset(free)) e -= q.col(0) * q.col(0).dot(e);
    if (e.norm() > 1e-9 * weighted_e.norm()) factor_norm = e.norm();
    q.rightCols(1) = factor_norm > 0.0 ? Eigen::VectorXd(e / factor_norm) : Eigen::VectorXd(0.0 * e);
  }
  /// Returns the factor that the values ask for, in the units of value over irradiance.
  double factor(const Eigen::VectorXd& values) const {
    return factor_norm > 0.0 ? q.rightCols(1).col(0).dot(values) / factor_norm : 0.0;
  }
  void take_from(Eigen::MatrixXd& m) const { m -= q * (q.transpose() * m); }
  Eigen::VectorXd without(const Eigen::VectorXd& v) const { return v - q * (q.transpose() * v); }
};

}  // namespace

Sensitivity::PixelRows Sensitivity::pixel_rows(std::size_t camera, std::size_t pixel, const Values& base,
                                               const Columns& columns, FreePerPixel free,
                                               const NormalEquations& layout) const {
  const GridSamples& s = samples_[camera];
  const auto k = static_cast<Eigen::Index>(s.images.size());
  const std::size_t first = pixel * s.images.size();
  PixelRows out{Eigen::MatrixXd::Zero(k, layout.right.size()), Eigen::VectorXd::Zero(k), 0};
  Eigen::VectorXd weight(k), weighted_e(k), value(k);
  std::uint64_t used = 0;
  for (Eigen::Index j = 0; j < k; ++j) {
    const std::size_t i = first + static_cast<std::size_t>(j);
    weight[j] = static_cast<double>(s.weight[i]);
    used += s.weight[i] > 0.0F ? 1u : 0u;
    weighted_e[j] = weight[j] * static_cast<double>(base[camera][i]);
    value[j] = weight[j] > 0.0 ? weight[j] * residual(s, base[camera], i) : 0.0;
  }
  OwnDirections own(weight, weighted_e, free);
  const auto n_own = static_cast<std::uint64_t>(own.q.cols());
  if (used <= n_own) return out;
  out.used = used - n_own;
  out.residual = own.without(value);
  bool any_beyond = false;
  for (Eigen::Index j = 0; j < k; ++j)
    if (const double size = std::abs(out.residual[j]); size > threshold_[camera]) {
      const double root = std::sqrt(threshold_[camera] / size);
      weight[j] *= root, weighted_e[j] *= root, value[j] *= root;
      any_beyond = true;
    }
  if (any_beyond) {
    own = OwnDirections(weight, weighted_e, free);
    out.residual = own.without(value);
  }
  double slope = s.gain_dn;
  if (frees_factor(free)) slope += own.factor(value);
  // no light is negative, or fringes half a period beside would fit as well
  if (frees_factor(free) && !(slope > 0.0)) {
    slope = 0.0;
    own =
        OwnDirections(weight, weighted_e, frees_offset(free) ? FreePerPixel::offset : FreePerPixel::nothing);
    out.residual = own.without(value + s.gain_dn * weighted_e);
  }
  for (Eigen::Index j = 0; j < k; ++j) {
    if (weight[j] == 0.0) continue;
    const std::size_t i = first + static_cast<std::size_t>(j);
    for (std::size_t c = 0; c < columns.each.size(); ++c)
      out.rows(j, c) = weight[j] * slope * static_cast<double>(columns.each[c][camera][i]);
    if (!frees_factor(free))
      out.rows(j, layout.gain_at(camera)) = weight[j] * static_cast<double>(columns.rough[camera][i]);
    if (!frees_offset(free)) out.rows(j, layout.black_at(camera)) = weight[j];
  }
  own.take_from(out.rows);
  return out;
}

NormalEquations Sensitivity::empty_equations(std::size_t n_parameters) const {
  const auto size = static_cast<Eigen::Index>(n_parameters + 2 * samples_.size());
  return {Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size), 0.0, 0, n_parameters};
}

NormalEquations Sensitivity::equations_at(const Values& base, const Columns& columns, FreePerPixel free,
                                          std::size_t every) const {
  if (free_factors_) free = with_factor(free);
  const NormalEquations empty = empty_equations(columns.each.size());
  NormalEquations out = empty;
  constexpr std::size_t kChunks = 32;  // a fixed number: sums that do not depend on the threads
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    const std::size_t n_pixels = samples_[c].n_pixels();
    std::vector<NormalEquations> parts(kChunks, empty);
#pragma omp parallel for schedule(dynamic)
    for (std::size_t chunk = 0; chunk < kChunks; ++chunk) {
      NormalEquations& part = parts[chunk];
      const auto k = static_cast<Eigen::Index>(samples_[c].images.size());
      Eigen::MatrixXd rows(kPixelsAtOnce * k, empty.right.size());  // of several pixels: one product for all
      Eigen::VectorXd residual(kPixelsAtOnce * k);
      Eigen::Index filled = 0;
      const auto add = [&] {
        if (filled == 0) return;  // Eigen divides by the length of a product
        const auto some = rows.topRows(filled).transpose();
        part.normal.selfadjointView<Eigen::Lower>().rankUpdate(some);
        part.right += some * residual.head(filled);
        part.chi2 += residual.head(filled).squaredNorm();
        filled = 0;
      };
      const std::size_t first = (chunk * n_pixels / kChunks + every - 1) / every * every;
      for (std::size_t p = first; p < (chunk + 1) * n_pixels / kChunks; p += every) {
        const PixelRows pixel = pixel_rows(c, p, base, columns, free, empty);
        if (pixel.used == 0) continue;
        rows.middleRows(filled, k) = pixel.rows;
        residual.segment(filled, k) = pixel.residual;
        filled += k;
        part.n += pixel.used;
        if (filled == rows.rows()) add();
      }
      add();
    }
    for (const NormalEquations& part : parts) {
      out.normal += part.normal;
      out.right += part.right;
      out.chi2 += part.chi2;
      out.n += part.n;
    }
  }
  const auto as_often = static_cast<double>(every);
  out.normal = as_often * Eigen::MatrixXd(out.normal.selfadjointView<Eigen::Lower>());
  out.right *= as_often;
  out.chi2 *= as_often;
  out.n *= every;
  return out;
}

void Sensitivity::choose_scale(const Values& base, FreePerPixel free) {
  if (free_factors_) free = with_factor(free);
  const NormalEquations layout = empty_equations(0);
  const Columns none{base, {}};
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    threshold_[c] = 1e300;
    std::vector<float> size;
    const std::size_t k = samples_[c].images.size();
    for (std::size_t p = 0; p < samples_[c].n_pixels(); ++p) {
      const PixelRows pixel = pixel_rows(c, p, base, none, free, layout);
      for (std::size_t j = 0; pixel.used > 0 && j < k; ++j)
        if (samples_[c].weight[p * k + j] > 0.0F)
          size.push_back(static_cast<float>(std::abs(pixel.residual[static_cast<Eigen::Index>(j)])));
    }
    threshold_[c] = kHuberSigmas * std::max(1.0, kMadToSigma * upper_median(size));  // 1 when there is none
  }
}

Sensitivity::Scatter Sensitivity::scatter_at(const Values& base, const Columns& columns,
                                             FreePerPixel free) const {
  if (free_factors_) free = with_factor(free);
  const NormalEquations layout = empty_equations(columns.each.size());
  const Eigen::Index size = layout.right.size();
  Scatter out{Eigen::MatrixXd::Zero(size, size), Eigen::MatrixXd::Zero(size, size)};
  std::vector<Eigen::VectorXd> image_scores;
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    const GridSamples& s = samples_[c];
    const int side = std::max(1, kBlockPx / s.grid.stride), across = s.grid.width / side + 1;
    std::vector<Eigen::VectorXd> blocks(static_cast<std::size_t>(across) *
                                        static_cast<std::size_t>(s.grid.height / side + 1));
    for (std::size_t p = 0; p < s.n_pixels(); ++p) {
      const PixelRows pixel = pixel_rows(c, p, base, columns, free, layout);
      if (pixel.used == 0) continue;
      const auto cell = static_cast<int>(s.cell[p]);
      Eigen::VectorXd& block = blocks[cell / s.grid.width / side * across + cell % s.grid.width / side];
      if (block.size() == 0) block = Eigen::VectorXd::Zero(size);
      const Eigen::MatrixXd scores = pixel.rows.transpose() * pixel.residual.asDiagonal();
      block += scores.rowwise().sum();
      for (std::size_t j = 0; j < s.images.size(); ++j) {
        const auto image = static_cast<std::size_t>(s.images[j]);
        if (image_scores.size() <= image) image_scores.resize(image + 1);
        if (image_scores[image].size() == 0) image_scores[image] = Eigen::VectorXd::Zero(size);
        image_scores[image] += scores.col(static_cast<Eigen::Index>(j));
      }
    }
    for (const Eigen::VectorXd& block : blocks)
      if (block.size() > 0) out.blocks += block * block.transpose(), ++out.n_blocks;
  }
  for (const Eigen::VectorXd& score : image_scores)
    if (score.size() > 0) out.images += score * score.transpose(), ++out.n_images;
  return out;
}

}  // namespace fringetwin::compare
