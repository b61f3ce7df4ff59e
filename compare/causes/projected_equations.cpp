// SPDX-License-Identifier: Apache-2.0
// Sets up the sums of Sensitivity pixel by pixel: what every pixel has of its own is projected out of its
// residuals and columns first.
#include <algorithm>
#include <cmath>
#include <map>

#include "compare/causes/equation_sum.hpp"
#include "compare/causes/sensitivity.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kLightPrior = 0.3;  ///< by which the light of an image lit apart may be another
constexpr std::size_t kChunks = 32;  ///< of pixels: sums must not depend on how many threads there are
constexpr int kBlockPx = 28;         ///< side of the blocks of pixels whose errors may belong together

/// An orthonormal basis of what a pixel has of its own, offset first.
struct OwnDirections {
  Eigen::MatrixXd q;
  double factor_norm = 0.0;  ///< of the irradiance, less its mean where the offset is free; 0: none
  double offset_norm = 0.0;  ///< of what an offset does; 0: none is free

  /// `weighted_offset`: what an offset of 1 does to the weighted values of the images.
  OwnDirections(const Eigen::VectorXd& weighted_offset, const Eigen::VectorXd& weighted_e, FreePerPixel free)
      : q(weighted_e.size(), (frees_offset(free) ? 1 : 0) + (frees_factor(free) ? 1 : 0)) {
    if (frees_offset(free)) {
      q.col(0) = weighted_offset.normalized();
      offset_norm = weighted_offset.norm();
    }
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
  /// Returns the offset that the values ask for, with that factor.
  double offset(const Eigen::VectorXd& values, const Eigen::VectorXd& weighted_e) const {
    if (!(offset_norm > 0.0)) return 0.0;
    const double of_factor = q.cols() > 1 ? factor(values) * q.col(0).dot(weighted_e) : 0.0;
    return (q.col(0).dot(values) - of_factor) / offset_norm;
  }
  /// Writes what is left of v.
  void take_from(const Eigen::VectorXd& v, Eigen::Ref<Eigen::VectorXd> left) const {
    left = v;
    if (q.cols() > 0) left -= q * (q.transpose() * v);
  }
};

/// Returns which images of any pixel a column changes, 1 or 0.
std::vector<std::uint8_t> changed_images(const std::vector<float>& column, std::size_t n_images) {
  std::vector<std::uint8_t> changed(n_images, 0);
  for (std::size_t first = 0; first < column.size(); first += n_images) {
    for (std::size_t j = 0; j < n_images; ++j)
      changed[j] = static_cast<std::uint8_t>(changed[j] | (column[first + j] != 0.0F ? 1U : 0U));
    if (first % (64 * n_images) == 0 && std::ranges::count(changed, 1) == std::ssize(changed)) break;
  }
  return changed;
}

}  // namespace

Sensitivity::Unknowns Sensitivity::unknowns_of(std::size_t camera, const Columns& columns, FreePerPixel free,
                                               const NormalEquations& layout) const {
  Unknowns out;
  const std::size_t n_images = samples_[camera].images.size();
  out.of_images.resize(n_images);
  for (std::size_t c = 0; c < columns.each.size(); ++c) {
    const std::vector<float>& column = columns.each[c][camera];
    const std::vector<std::uint8_t> changes = changed_images(column, n_images);
    if (std::ranges::none_of(changes, [](std::uint8_t is) { return is != 0; })) continue;
    for (std::size_t j = 0; j < n_images; ++j)
      if (changes[j] != 0) out.of_images[j].push_back(static_cast<Eigen::Index>(out.parameters.size()));
    out.parameters.push_back(column.data());
    out.exposes.push_back(c < columns.exposes.size() && columns.exposes[c]);
    out.at.push_back(static_cast<Eigen::Index>(c));
  }
  if (!frees_factor(free)) {
    out.of_gain = columns.rough[camera].data();
    out.at.push_back(static_cast<Eigen::Index>(layout.gain_at(camera)));
  }
  out.has_black = !frees_offset(free);
  if (out.has_black) out.at.push_back(static_cast<Eigen::Index>(layout.black_at(camera)));
  out.of_lights = columns.rough[camera].data();
  for (const std::size_t at : lights_at(camera, layout.n_parameters))
    out.at.push_back(static_cast<Eigen::Index>(at));
  // what belongs to the camera may change all of them
  for (auto& of_image : out.of_images)
    for (std::size_t k = out.parameters.size(); k < out.at.size(); ++k)
      of_image.push_back(static_cast<Eigen::Index>(k));
  return out;
}

void Sensitivity::fill_rows(const GridSamples& s, const Unknowns& unknowns, std::size_t first, double slope,
                            const float* e, const Eigen::VectorXd& own_offset, const Eigen::VectorXd& weight,
                            Eigen::Ref<Eigen::MatrixXd> rows) {
  const Eigen::Index k = weight.size();
  Eigen::Index c = 0;
  const auto put = [&](const float* column, double times) {
    for (Eigen::Index j = 0; j < k; ++j)
      rows(j, c) = weight[j] > 0.0 ? weight[j] * times * static_cast<double>(column[j]) : 0.0;
    ++c;
  };
  for (std::size_t p = 0; p < unknowns.parameters.size(); ++p) {
    const float* column = unknowns.parameters[p] + first;
    put(column, slope);
    for (const std::size_t j : s.lit_apart) rows(static_cast<Eigen::Index>(j), c - 1) *= s.light[j];
    if (!unknowns.exposes[p]) continue;
    // the same share of the pixel's own light as of the twin's
    for (Eigen::Index j = 0; j < k; ++j)
      if (e[j] > 0.0F)
        rows(j, c - 1) += own_offset[j] * static_cast<double>(column[j]) / static_cast<double>(e[j]);
  }
  if (unknowns.of_gain) {
    put(unknowns.of_gain + first, 1.0);
    for (const std::size_t j : s.lit_apart) rows(static_cast<Eigen::Index>(j), c - 1) = 0.0;
  }
  if (unknowns.has_black) rows.col(c++) = weight;
  if (!unknowns.of_lights) return;
  for (const std::size_t j : s.lit_apart) {  // their gains: each acts on its image
    const auto at = static_cast<Eigen::Index>(j);
    rows.col(c).setZero();
    if (weight[at] > 0.0)
      rows(at, c) = weight[at] * slope / s.gain_dn * static_cast<double>(unknowns.of_lights[first + j]);
    ++c;
  }
}

std::uint64_t Sensitivity::pixel_rows(std::size_t camera, std::size_t pixel, const Values& base,
                                      const Unknowns& unknowns, FreePerPixel free, PixelScratch& scratch,
                                      Eigen::Ref<Eigen::MatrixXd> rows,
                                      Eigen::Ref<Eigen::VectorXd> residuals) const {
  const GridSamples& s = samples_[camera];
  const auto k = static_cast<Eigen::Index>(s.images.size());
  const std::size_t first = pixel * s.images.size();
  auto& [weight, weighted_e, value, weighted_offset, own_directions, beyond] = scratch;
  beyond = 0.0;
  weight.resize(k), weighted_e.resize(k), value.resize(k), weighted_offset.resize(k);
  std::uint64_t used = 0;
  for (Eigen::Index j = 0; j < k; ++j) {
    const std::size_t i = first + static_cast<std::size_t>(j);
    weight[j] = static_cast<double>(s.weight[i]);
    used += s.weight[i] > 0.0F ? 1u : 0u;
    weighted_e[j] =
        weight[j] * static_cast<double>(base[camera][i]) * s.light_of(static_cast<std::size_t>(j));
    weighted_offset[j] = weight[j] * exposure_of(camera, static_cast<std::size_t>(j)) *
                         s.light_of(static_cast<std::size_t>(j));  // exposed by itself: all light
    value[j] = weight[j] > 0.0 ? weight[j] * residual(s, base[camera], i) : 0.0;
  }
  OwnDirections own(weighted_offset, weighted_e, free);
  const auto n_own = static_cast<std::uint64_t>(own.q.cols());
  if (used <= n_own) return 0;
  own.take_from(value, residuals);
  bool any_beyond = false;
  for (Eigen::Index j = 0; j < k; ++j)
    if (const double size = std::abs(residuals[j]); size > threshold_[camera]) {
      const double root = std::sqrt(threshold_[camera] / size);
      weight[j] *= root, weighted_e[j] *= root, value[j] *= root, weighted_offset[j] *= root;
      beyond += threshold_[camera] * (size - threshold_[camera]);
      any_beyond = true;
    }
  if (any_beyond) {
    own = OwnDirections(weighted_offset, weighted_e, free);
    own.take_from(value, residuals);
  }
  double slope = s.gain_dn;
  if (frees_factor(free)) slope += own.factor(value);
  // no light is negative, or fringes half a period beside would fit as well
  if (frees_factor(free) && !(slope > 0.0)) {
    slope = 0.0;
    own = OwnDirections(weighted_offset, weighted_e,
                        frees_offset(free) ? FreePerPixel::offset : FreePerPixel::nothing);
    value += s.gain_dn * weighted_e;
    own.take_from(value, residuals);
  }
  weighted_offset *= own.offset(value, weighted_e);
  fill_rows(s, unknowns, first, slope, base[camera].data() + first, weighted_offset, weight, rows);
  own_directions = own.q;
  return used - n_own;
}

NormalEquations Sensitivity::empty_equations(std::size_t n_parameters) const {
  std::size_t n_lights = 0;
  for (const GridSamples& s : samples_) n_lights += s.lit_apart.size();
  const auto size = static_cast<Eigen::Index>(n_parameters + 2 * samples_.size() + n_lights);
  return {Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size), 0.0, 0, n_parameters};
}

/// The light of an image that is dark wherever it is seen is told by nothing else.
void Sensitivity::add_prior_of_lights(NormalEquations& e) const {
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    const GridSamples& s = samples_[c];
    const std::vector<std::size_t> at = lights_at(c, e.n_parameters);
    for (std::size_t j = 0; j < at.size(); ++j) {
      const double off = (s.light[s.lit_apart[j]] - 1.0) / kLightPrior,
                   per_dn = 1.0 / (kLightPrior * s.gain_dn);
      e.normal(at[j], at[j]) += per_dn * per_dn;
      e.right[at[j]] -= off * per_dn;
      e.chi2 += off * off;
    }
  }
}

std::size_t Sensitivity::begin_of(std::size_t chunk, std::size_t camera) const {
  return chunk * samples_[camera].n_pixels() / kChunks;
}

NormalEquations Sensitivity::equations_at(const Values& base, const Columns& columns, FreePerPixel free,
                                          std::size_t every) const {
  free = with_own(free);
  NormalEquations out = empty_equations(columns.each.size());
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    const Unknowns unknowns = unknowns_of(c, columns, free, out);
    const auto size = static_cast<Eigen::Index>(unknowns.at.size());
    std::vector<NormalEquations> parts(kChunks);
#pragma omp parallel for schedule(dynamic)
    for (std::size_t chunk = 0; chunk < kChunks; ++chunk) {
      EquationSum sum(size, unknowns.of_images);
      PixelScratch scratch;
      double beyond = 0.0;
      const std::size_t first = (begin_of(chunk, c) + every - 1) / every * every;
      for (std::size_t p = first; p < begin_of(chunk + 1, c); p += every) {
        const std::uint64_t used =
            pixel_rows(c, p, base, unknowns, free, scratch, sum.rows(), sum.residual());
        if (used == 0) continue;
        sum.take(scratch.own, used);
        beyond += scratch.beyond;
      }
      parts[chunk] = sum.finish();
      parts[chunk].beyond = beyond;
    }
    for (const NormalEquations& part : parts) {
      for (Eigen::Index i = 0; i < size; ++i) {
        for (Eigen::Index j = 0; j <= i; ++j) out.normal(unknowns.at[i], unknowns.at[j]) += part.normal(i, j);
        out.right[unknowns.at[i]] += part.right[i];
      }
      out.chi2 += part.chi2;
      out.beyond += part.beyond;
      out.n += part.n;
    }
  }
  const auto as_often = static_cast<double>(every);
  out.normal = as_often * Eigen::MatrixXd(out.normal.selfadjointView<Eigen::Lower>());
  out.right *= as_often;
  out.chi2 *= as_often;
  out.beyond *= as_often;
  out.n *= every;
  add_prior_of_lights(out);
  return out;
}

void Sensitivity::choose_scale(const Values& base, FreePerPixel free) {
  free = with_own(free);
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    threshold_[c] = 1e300;
    const std::size_t k = samples_[c].images.size();
    std::vector<std::vector<float>> parts(kChunks);
#pragma omp parallel for schedule(dynamic)
    for (std::size_t chunk = 0; chunk < kChunks; ++chunk) {
      PixelScratch scratch;
      Eigen::MatrixXd no_rows(static_cast<Eigen::Index>(k), 0);
      Eigen::VectorXd residual(static_cast<Eigen::Index>(k));
      for (std::size_t p = begin_of(chunk, c); p < begin_of(chunk + 1, c); ++p) {
        const std::uint64_t used = pixel_rows(c, p, base, {}, free, scratch, no_rows, residual);
        for (std::size_t j = 0; used > 0 && j < k; ++j)
          if (samples_[c].weight[p * k + j] > 0.0F)
            parts[chunk].push_back(static_cast<float>(std::abs(residual[static_cast<Eigen::Index>(j)])));
      }
    }
    std::vector<float> size;
    for (const std::vector<float>& part : parts) size.insert(size.end(), part.begin(), part.end());
    threshold_[c] = kHuberSigmas * std::max(1.0, kMadToSigma * upper_median(size));  // 1 when there is none
  }
}

namespace {
/// Scores of the unknowns of one camera: of blocks, by their places, and of images, one column each.
struct Scores {
  std::map<int, Eigen::VectorXd> of_blocks;
  Eigen::MatrixXd of_images;

  void add(const Scores& other) {
    of_images += other.of_images;
    for (const auto& [at, score] : other.of_blocks)
      if (const auto [it, is_new] = of_blocks.try_emplace(at, score); !is_new) it->second += score;
  }
};
}  // namespace

Sensitivity::Scatter Sensitivity::scatter_at(const Values& base, const Columns& columns,
                                             FreePerPixel free) const {
  free = with_own(free);
  const NormalEquations layout = empty_equations(columns.each.size());
  const Eigen::Index size = layout.right.size();
  Scatter out{Eigen::MatrixXd::Zero(size, size), Eigen::MatrixXd::Zero(size, size)};
  std::map<int, Eigen::VectorXd> of_images;  // of all cameras
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    const GridSamples& s = samples_[c];
    const Unknowns unknowns = unknowns_of(c, columns, free, layout);
    const auto k = static_cast<Eigen::Index>(s.images.size()),
               n_unknowns = static_cast<Eigen::Index>(unknowns.at.size());
    const int side = std::max(1, kBlockPx / s.grid.stride), across = s.grid.width / side + 1;
    std::vector<Scores> parts(kChunks);
#pragma omp parallel for schedule(dynamic)
    for (std::size_t chunk = 0; chunk < kChunks; ++chunk) {
      PixelScratch scratch;
      Eigen::MatrixXd rows(k, n_unknowns);
      Eigen::VectorXd residual(k);
      parts[chunk].of_images = Eigen::MatrixXd::Zero(n_unknowns, k);
      for (std::size_t p = begin_of(chunk, c); p < begin_of(chunk + 1, c); ++p) {
        if (pixel_rows(c, p, base, unknowns, free, scratch, rows, residual) == 0) continue;
        take_off(scratch.own, rows);
        const auto cell = static_cast<int>(s.cell[p]);
        Eigen::VectorXd& block =
            parts[chunk].of_blocks[cell / s.grid.width / side * across + cell % s.grid.width / side];
        if (block.size() == 0) block = Eigen::VectorXd::Zero(n_unknowns);
        block.noalias() += rows.transpose() * residual;
        parts[chunk].of_images += rows.transpose() * residual.asDiagonal();
      }
    }
    for (std::size_t chunk = 1; chunk < kChunks; ++chunk) parts.front().add(parts[chunk]);
    for (const auto& [at, score] : parts.front().of_blocks) {
      Eigen::VectorXd block = Eigen::VectorXd::Zero(size);
      block(unknowns.at) = score;
      out.blocks += block * block.transpose(), ++out.n_blocks;
    }
    for (Eigen::Index j = 0; j < k && !parts.front().of_blocks.empty(); ++j) {
      Eigen::VectorXd& score = of_images[s.images[static_cast<std::size_t>(j)]];
      if (score.size() == 0) score = Eigen::VectorXd::Zero(size);
      score(unknowns.at) += parts.front().of_images.col(j);
    }
  }
  for (const auto& [image, score] : of_images) out.images += score * score.transpose(), ++out.n_images;
  return out;
}

}  // namespace fringetwin::compare
