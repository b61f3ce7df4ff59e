// SPDX-License-Identifier: Apache-2.0
// Steps of Gauss and Newton over all numbers of the field at once. The equations of a tile of pixels are
// summed up before they are spread over the terms, which are nearly the same all over it: what the numbers
// are worth at a pixel is told by its own terms, so that this costs no accuracy.
#include "measure/light/waveform_field.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "measure/light/light_steps.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/statistics.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::measure {
namespace {

constexpr int kFieldTilePx = 16, kMostFieldPasses = 8;
constexpr std::size_t kScatterInTiles = 7919, kMostFieldPixels = 200'000, kFewestFieldPixels = 2'000,
                      kOfMedian = 16;
constexpr double kFieldCut = 9.0;       ///< times the middle of all squared residuals: counts less
constexpr double kFieldChance = 5.0;    ///< standard deviations of chi2
constexpr double kFieldNotTold = 1e-6;  ///< of the largest eigenvalue of the scaled equations
constexpr double kFieldSettled = 1e-5;  ///< of a number over its term
constexpr int kPixelSteps = 3;          ///< towards a pixel's own fringe
constexpr std::array<Eigen::Index, 4> kTermsUpTo{1, 6, 10, 15};  ///< constant; orders 2, 3, 4

/// Returns Legendre's polynomials of the orders 0 ... 4.
std::array<double, 5> legendre(double x) {
  std::array<double, 5> out;
  for (unsigned order = 0; order < out.size(); ++order) out[order] = std::legendre(order, x);
  return out;
}

struct FieldSums {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
  double squares = 0.0, freedom = 0.0;
  std::vector<float> of_pixels = {};  ///< squares of each
};

/// A solution by the terms that were asked for, what it takes off the squares, and of how many numbers it is.
struct FieldChange {
  Eigen::VectorXd of_all;
  double fall = 0.0, told = 0.0;
};

/// Solves the first `n` equations; what they hardly tell stays as it is.
FieldChange solved_field(const FieldSums& s, Eigen::Index n) {
  const Eigen::VectorXd right = s.right.head(n),
                        scale = s.normal.diagonal().head(n).cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  const auto [values, vectors] =
      symmetric_eigen(scale.asDiagonal() * s.normal.topLeftCorner(n, n) * scale.asDiagonal());
  FieldChange out;
  Eigen::VectorXd along = vectors.transpose() * (scale.asDiagonal() * right);
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool is_told = values[i] > kFieldNotTold * values.maxCoeff();
    along[i] = is_told ? along[i] / values[i] : 0.0;
    out.told += is_told ? 1.0 : 0.0;
  }
  out.of_all = scale.asDiagonal() * (vectors * along);
  out.fall = out.of_all.dot(right);
  return out;
}

}  // namespace

/// Fits the field.
class WaveformFieldFit {
 public:
  WaveformFieldFit(WaveformField& field, const PitchImages& of, const LightOptions& options,
                   double clipped_dn)
      : field_(field),
        images_(of.image),
        options_(options),
        clipped_dn_(clipped_dn),
        steps_(of.step, of.steps_total) {
    steps_.shift_rad = Eigen::Map<const Eigen::VectorXd>(of.shift_rad.data(),
                                                         static_cast<Eigen::Index>(of.shift_rad.size()));
    steps_.move_by({});
  }

  void run() {
    find_pixels();
    if (n_pixels_ < kFewestFieldPixels) return;
    weigh_as_given();
    const Eigen::MatrixXd same_all_over = field_.of_term_;
    const Eigen::Index m = same_all_over.rows();
    Eigen::MatrixXd given = Eigen::MatrixXd::Zero(m, kTermsUpTo.back());
    given.col(0) = same_all_over;
    field_.of_term_ = given;
    FieldSums sums;
    for (int pass = 1;; ++pass) {
      throw_if_cancelled();
      sums = sum_up();
      weigh_by(std::move(sums.of_pixels));
      const FieldChange change = solved_field(sums, sums.right.size());
      field_.of_term_ += change.of_all.reshaped(m, kTermsUpTo.back());
      if (pass == kMostFieldPasses || change.of_all.cwiseAbs().maxCoeff() < kFieldSettled) break;
    }
    // of all that is told there, so many terms as tell more than chance
    sums.right = sums.normal * (field_.of_term_ - given).reshaped();
    const FieldChange told = up_to_told_order(sums, m);
    const Eigen::Index n_terms = told.of_all.size() / m;
    field_.of_term_ = given.leftCols(n_terms) + told.of_all.reshaped(m, n_terms);
  }

 private:
  int width() const { return images_.front()->width; }
  int height() const { return images_.front()->height; }
  int tiles_across() const { return (width() + kFieldTilePx - 1) / kFieldTilePx; }
  int tiles_down() const { return (height() + kFieldTilePx - 1) / kFieldTilePx; }

  /// Reads a pixel's steps over black; returns whether none of them is clipped.
  bool read(std::size_t pixel, Eigen::VectorXd& values) const {
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      const auto dn = static_cast<double>((*images_[static_cast<std::size_t>(k)])[pixel]);
      if (!(dn < clipped_dn_) || !(dn > 0.0)) return false;
      values[k] = dn - options_.black_level_dn;
    }
    return true;
  }
  bool is_lit(const Eigen::VectorXd& values) const {
    return steps_.sinusoid(values).amplitude >= options_.min_amplitude;
  }

  void find_pixels() {
    tiles_.resize(static_cast<std::size_t>(tiles_across()) * static_cast<std::size_t>(tiles_down()));
#pragma omp parallel for schedule(dynamic)
    for (std::size_t t = 0; t < tiles_.size(); ++t) {
      const int x0 = static_cast<int>(t) % tiles_across() * kFieldTilePx,
                y0 = static_cast<int>(t) / tiles_across() * kFieldTilePx;
      Eigen::VectorXd values(steps_.count());
      for (int y = y0; y < std::min(y0 + kFieldTilePx, height()); ++y)
        for (int x = x0; x < std::min(x0 + kFieldTilePx, width()); ++x)
          if (const std::size_t pixel = images_.front()->index(x, y); read(pixel, values) && is_lit(values))
            tiles_[t].push_back(static_cast<std::uint32_t>(pixel));
    }
    for (const auto& tile : tiles_) n_pixels_ += tile.size();
    field_.part_ = lit_part();
    const std::size_t stride = (n_pixels_ + kMostFieldPixels - 1) / kMostFieldPixels;
    if (stride < 2) return;
    // scattered, or a column of each tile would stand for all
    std::size_t next = 0, first = 0;
    for (auto& tile : tiles_) {
      const std::size_t end = first + tile.size();
      std::vector<std::uint32_t> kept;
      for (std::size_t at; (at = next * stride + next * kScatterInTiles % stride) < end; ++next)
        kept.push_back(tile[at - first]);
      tile = std::move(kept);
      first = end;
    }
  }

  /// Returns the rectangle that holds all pixels.
  WaveformField::Part lit_part() const {
    WaveformField::Part part{width(), height(), 0, 0};
    for (const auto& tile : tiles_)
      for (const std::uint32_t pixel : tile) {
        const int x = static_cast<int>(pixel) % width(), y = static_cast<int>(pixel) / width();
        part = {std::min(part.x0, x), std::min(part.y0, y), std::max(part.x1, x + 1),
                std::max(part.y1, y + 1)};
      }
    return part;
  }

  /// What the pixels of one thread are looked at with, one after the other.
  struct Workplace {
    LightSteps steps;
    Eigen::VectorXd values, left;  ///< over black; what the pixel's own fringe leaves of them
    Eigen::MatrixXd harmonics;     ///< what it leaves of these
    PixelEquations equations = {};

    explicit Workplace(const LightSteps& of)
        : steps(of), values(of.count()), left(of.count()), harmonics(of.count(), of.of_harmonics()) {}
  };

  /// Writes what is left of a pixel's steps beside its own fringe of the form there. `fringe`: as it was
  /// last found; of no amplitude where it was not.
  void look_at(std::size_t pixel, Workplace& at, StepFringe& fringe) const {
    read(pixel, at.values);
    at.steps.waveform = field_.at(pixel);
    const bool is_new = fringe.amplitude == 0.0;
    if (is_new) fringe = at.steps.sinusoid(at.values);
    for (int i = 0; i < (is_new ? kPixelSteps : 1); ++i) {
      at.equations.set(at.steps, fringe, at.values);
      fringe = at.equations.better(fringe);
    }
    at.equations.set(at.steps, fringe, at.values);
    at.equations.contrasts(at.equations.residual, at.left);
  }

  /// Returns one over the noise variance of a pixel's values, by their mean level.
  double weight(const Eigen::VectorXd& values) const { return options_.weight(steps_.mean(values)); }

  /// Takes the squares beyond which a pixel counts less: of these fringes are most.
  void weigh_by(std::vector<float> squares) {
    const double middle = squares.empty() ? 0.0 : upper_median(squares);
    most_squares_ = middle > 0.0 ? kFieldCut * middle : std::numeric_limits<double>::infinity();
  }

  void weigh_as_given() {
    std::vector<float> squares;
    Workplace at(steps_);
    for (std::size_t t = 0; t < tiles_.size(); ++t)
      for (std::size_t i = t % kOfMedian; i < tiles_[t].size(); i += kOfMedian) {
        StepFringe fringe;
        look_at(tiles_[t][i], at, fringe);
        squares.push_back(static_cast<float>(weight(at.values) * at.left.squaredNorm()));
      }
    weigh_by(std::move(squares));
  }

  /// Returns what the pixels of a tile tell of the harmonics there, and finds their fringes.
  FieldSums sums_of_tile(const std::vector<std::uint32_t>& tile, std::vector<StepFringe>& fringes) const {
    const Eigen::Index m = field_.of_term_.rows();
    FieldSums out{Eigen::MatrixXd::Zero(m, m), Eigen::VectorXd::Zero(m)};
    Workplace at(steps_);
    fringes.resize(tile.size());
    for (std::size_t i = 0; i < tile.size(); ++i) {
      look_at(tile[i], at, fringes[i]);
      at.equations.contrasts(at.equations.harmonics, at.harmonics);
      const double noise = weight(at.values), squares = noise * at.left.squaredNorm(),
                   trust = squares > most_squares_ ? std::sqrt(most_squares_ / squares) : 1.0;  // Huber's
      out.normal.noalias() += trust * noise * at.harmonics.transpose() * at.harmonics;
      out.right.noalias() += trust * noise * at.harmonics.transpose() * at.left;
      out.squares += trust * squares;
      out.freedom += steps_.freedom();
      out.of_pixels.push_back(static_cast<float>(squares));
    }
    return out;
  }

  /// Returns the terms at the mean place of pixels.
  Eigen::VectorXd terms_in_the_middle(const std::vector<std::uint32_t>& tile) const {
    const auto across = static_cast<std::uint32_t>(width());
    double x = 0.0, y = 0.0;
    for (const std::uint32_t pixel : tile) x += pixel % across, y += pixel / across;
    const auto n = static_cast<double>(tile.size());
    return field_.terms(x / n, y / n);
  }

  FieldSums sum_up() {
    fringes_.resize(tiles_.size());
    std::vector<FieldSums> of_tile(tiles_.size());
#pragma omp parallel for schedule(dynamic)
    for (std::size_t t = 0; t < tiles_.size(); ++t)
      if (!tiles_[t].empty()) of_tile[t] = sums_of_tile(tiles_[t], fringes_[t]);
    const Eigen::Index m = field_.of_term_.rows(), n = field_.of_term_.size();
    FieldSums all{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)};
    for (std::size_t t = 0; t < tiles_.size(); ++t) {
      if (tiles_[t].empty()) continue;
      const FieldSums& one = of_tile[t];
      const Eigen::VectorXd at = terms_in_the_middle(tiles_[t]);
      for (Eigen::Index i = 0; i < at.size(); ++i) {
        for (Eigen::Index j = 0; j <= i; ++j)
          all.normal.block(i * m, j * m, m, m) += at[i] * at[j] * one.normal;
        all.right.segment(i * m, m) += at[i] * one.right;
      }
      all.of_pixels.insert(all.of_pixels.end(), one.of_pixels.begin(), one.of_pixels.end());
      all.squares += one.squares;
      all.freedom += one.freedom;
    }
    all.normal.triangularView<Eigen::StrictlyUpper>() = all.normal.transpose();
    return all;
  }

  /// Returns the solution up to the highest order that tells more than chance beyond the last that did;
  /// `s.squares`: what all orders leave.
  static FieldChange up_to_told_order(const FieldSums& s, Eigen::Index m) {
    const double noise2 = s.squares / std::max(1.0, s.freedom);
    FieldChange best = solved_field(s, m);
    for (const Eigen::Index n_terms : kTermsUpTo) {
      FieldChange next = solved_field(s, n_terms * m);
      const double more = next.told - best.told, by_chance = more + kFieldChance * std::sqrt(2.0 * more);
      if (more > 0.0 && next.fall - best.fall > noise2 * by_chance) best = std::move(next);
    }
    return best;
  }

  WaveformField& field_;
  const std::vector<const GrayImage*>& images_;
  const LightOptions& options_;
  double clipped_dn_;
  LightSteps steps_;
  std::vector<std::vector<std::uint32_t>> tiles_;  ///< the pixels of each that take part
  std::vector<std::vector<StepFringe>> fringes_;   ///< of these pixels, as they were last found
  std::size_t n_pixels_ = 0;                       ///< that could
  double most_squares_ = std::numeric_limits<double>::infinity();
};

WaveformField::WaveformField(const PitchImages& steps, const std::vector<double>& waveform,
                             const LightOptions& options, double clipped_dn)
    : width_(steps.image.front()->width),
      part_{0, 0, steps.image.front()->width, steps.image.front()->height},
      of_term_(
          Eigen::Map<const Eigen::VectorXd>(waveform.data(), static_cast<Eigen::Index>(waveform.size()))) {
  WaveformFieldFit(*this, steps, options, clipped_dn).run();
}

Eigen::VectorXd WaveformField::terms(double x, double y) const {
  const auto across = [](double at, int from, int to) {
    return std::clamp(2.0 * (at + 0.5 - from) / std::max(1, to - from) - 1.0, -1.0, 1.0);
  };
  const auto u = legendre(across(x, part_.x0, part_.x1)), v = legendre(across(y, part_.y0, part_.y1));
  Eigen::VectorXd out(of_term_.cols());
  Eigen::Index k = 0;
  for (std::size_t order = 0; k < out.size(); ++order)
    for (std::size_t j = 0; j <= order; ++j) out[k++] = u[order - j] * v[j];
  return out;
}

}  // namespace fringetwin::measure
