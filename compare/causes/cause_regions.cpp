// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/cause_regions.hpp"

#include <algorithm>
#include <cmath>

#include "twin/base/constants.hpp"
#include "twin/base/parallel.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kSquare = 8;  ///< kept pixels: side of a region of the samples
constexpr int kFewestInSquare = kSquare * kSquare / 4;
constexpr double kNothingLeft = 1e-3;  ///< of a sum's weights: rounding, where a pixel's own numbers take all
constexpr double kNoLight = 1e-9;      ///< of the irradiance: rounding, where an offset takes all
constexpr double kLeastVariance = 1e-30;  ///< DN^2, of values that are not used
/// Places of the kinds of sums; from kImage on there is one per image.
constexpr int kLevel = 0, kContrast = 1, kShift = 2, kImage = 3;
constexpr const char* kRegionKinds[] = {"level", "contrast", "shift", "image"};

/// The images of one pitch. `by_phase` turns their irradiance E into dE/dphase of its first harmonic: with
/// E = m + c cos d + s sin d by least squares over the steps d, this is s cos d - c sin d.
struct PitchSteps {
  std::vector<Eigen::Index> at;  ///< among the images of the samples
  Eigen::MatrixXd by_phase;
};

std::vector<PitchSteps> pitches_of(const GridSamples& s, const Fringes& fringes) {
  std::vector<PitchSteps> out;
  for (const auto& [pitch, images] : steps_of_pitches(s, fringes)) {
    const auto n = static_cast<Eigen::Index>(images.size());
    if (n < 3) continue;
    PitchSteps of;
    Eigen::MatrixXd waves(n, 3), turned(n, 3);
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto [at, step_rad] = images[static_cast<std::size_t>(j)];
      of.at.push_back(static_cast<Eigen::Index>(at));
      waves.row(j) << 1.0, std::cos(step_rad), std::sin(step_rad);
      turned.row(j) << 0.0, -std::sin(step_rad), std::cos(step_rad);
    }
    of.by_phase = turned * least_squares(waves, Eigen::MatrixXd::Identity(n, n));
    out.push_back(std::move(of));
  }
  return out;
}

struct Sum {
  double residual = 0.0, variance = 0.0, weight = 0.0;
  double scatter = 0.0;  ///< variance besides, as if every pixel had one of its own
};
struct Square {
  std::vector<Sum> sums;  ///< level, contrast, shift, then one per image
  int pixels = 0;
};

/// The values of one pixel that are used; 0 in the places of the others.
struct PixelValues {
  Eigen::VectorXd irradiance, residual, variance, used;
};

/// Takes what a direction of the values explains out of sums whose weights are the columns of `a`: a - V^-1 d
/// (d^T a)/(d^T V^-1 d).
void project_out(const Eigen::VectorXd& direction, const Eigen::VectorXd& precision, Eigen::MatrixXd& a) {
  const Eigen::VectorXd weighted = precision.cwiseProduct(direction);
  if (const double size = direction.dot(weighted); size > 0.0)
    a -= weighted * (direction.transpose() * a) / size;
}

/// Returns the weights of the sums, a column each, without what a pixel has of its own; where that is nothing
/// those of the images are left out, 1 for each of its own value.
Eigen::MatrixXd weights_of(const PixelValues& p, const std::vector<PitchSteps>& pitches, FreePerPixel free) {
  const Eigen::Index n = p.used.size();
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, free == FreePerPixel::nothing ? kImage : kImage + n);
  a.col(kLevel) = p.used;
  a.col(kContrast) = p.used.cwiseProduct(
      p.irradiance - Eigen::VectorXd::Constant(n, p.irradiance.dot(p.used) / p.used.sum()));
  for (const PitchSteps& pitch : pitches)
    a(pitch.at, kShift) = p.used(pitch.at).cwiseProduct(pitch.by_phase * p.irradiance(pitch.at));
  if (free == FreePerPixel::nothing) return a;
  a.rightCols(n) = p.used.asDiagonal();
  const Eigen::VectorXd size = a.colwise().norm(),
                        precision = p.used.cwiseQuotient(p.variance.cwiseMax(kLeastVariance));
  Eigen::VectorXd factor = p.irradiance.cwiseProduct(p.used);
  if (frees_offset(free)) {
    project_out(p.used, precision, a);
    factor -= p.used * (precision.dot(factor) / precision.sum());  // what the offset has not taken
  }
  if (frees_factor(free) && factor.norm() > kNoLight * p.irradiance.norm()) project_out(factor, precision, a);
  for (Eigen::Index j = 0; j < a.cols(); ++j)
    if (a.col(j).norm() < kNothingLeft * size[j]) a.col(j).setZero();
  // An offset is the level and a factor beside it the contrast. What the fit leaves of them, since the noise
  // differs from image to image, is how the gray values bend: of a real relief 0.005 DN, 5 times the noise.
  if (frees_offset(free)) a.col(kLevel).setZero();
  if (free == FreePerPixel::factor_and_offset) a.col(kContrast).setZero();
  return a;
}

/// `scatter_dn2`: covariance of the pixel's values besides their own variance; may be empty.
void add_pixel(const PixelValues& p, const Eigen::MatrixXd& weights, const Eigen::MatrixXd& scatter_dn2,
               Square& square) {
  const bool scatters = scatter_dn2.size() > 0;
  square.sums.resize(static_cast<std::size_t>(kImage + p.used.size()));
  ++square.pixels;
  for (Eigen::Index k = 0; weights.cols() == kImage && k < p.used.size(); ++k)
    if (p.used[k] > 0.0) {
      Sum& sum = square.sums[static_cast<std::size_t>(kImage + k)];
      sum.residual += p.residual[k], sum.variance += p.variance[k], sum.weight += 1.0;
      if (scatters) sum.scatter += scatter_dn2(k, k);
    }
  for (Eigen::Index j = 0; j < weights.cols(); ++j) {
    Sum& sum = square.sums[static_cast<std::size_t>(j)];
    sum.residual += weights.col(j).dot(p.residual);
    sum.variance += weights.col(j).cwiseAbs2().dot(p.variance);
    if (scatters) sum.scatter += weights.col(j).dot(scatter_dn2 * weights.col(j));
    sum.weight += weights.col(j).cwiseAbs().sum();
  }
}

std::vector<Square> squares_of(const GridSamples& s, const std::vector<float>& irradiance,
                               const Fringes& fringes, FreePerPixel free) {
  const auto width = static_cast<std::size_t>(s.grid.width), n = s.images.size(),
             side = static_cast<std::size_t>(kSquare * s.grid.keep), across = width / side + 1;
  const std::vector<PitchSteps> pitches = pitches_of(s, fringes);
  std::vector<Square> squares(across * (static_cast<std::size_t>(s.grid.height) / side + 1));
  const auto size = static_cast<Eigen::Index>(n);
  PixelValues p{Eigen::VectorXd(size), Eigen::VectorXd(size), Eigen::VectorXd(size), Eigen::VectorXd(size)};
  for (std::size_t pixel = 0; pixel < s.n_pixels(); ++pixel) {
    for (Eigen::Index k = 0; k < size; ++k) {
      const std::size_t i = pixel * n + static_cast<std::size_t>(k);
      const auto w = static_cast<double>(s.weight[i]), e = static_cast<double>(irradiance[i]);
      p.irradiance[k] = s.light_of(static_cast<std::size_t>(k)) * e;  // what a pixel's own factor acts on
      p.used[k] = w > 0.0 ? 1.0 : 0.0;
      p.variance[k] = w > 0.0 ? 1.0 / (w * w) - s.scatter_of(static_cast<std::size_t>(k)) : 0.0;
      p.residual[k] = Sensitivity::residual(s, irradiance, i);
    }
    if (p.used.sum() > 0.0)
      add_pixel(p, weights_of(p, pitches, free), s.scatter_dn2,
                squares[s.cell[pixel] / width / side * across + s.cell[pixel] % width / side]);
  }
  return squares;
}

}  // namespace

std::vector<CauseRegion> cause_regions(const Sensitivity& sensitivity, const Fringes& fringes,
                                       const Sensitivity::Values& predicted, FreePerPixel free) {
  free = sensitivity.with_own(free);
  std::vector<CauseRegion> out;
  for (const char* name : kRegionKinds) out.push_back({name, 0.0});
  std::vector<std::vector<Square>> of_camera(predicted.size());
  for_each_parallel(static_cast<int>(of_camera.size()), [&](int c) {
    of_camera[c] = squares_of(sensitivity.samples()[c], predicted[c], fringes, free);
  });
  for (std::size_t c = 0; c < predicted.size(); ++c) {
    const GridSamples& s = sensitivity.samples()[c];
    for (const Square& square : of_camera[c]) {
      if (square.pixels < kFewestInSquare) continue;
      const double alike = std::min(s.scatters_alike, static_cast<double>(square.pixels));
      for (std::size_t j = 0; j < square.sums.size(); ++j) {
        const Sum& sum = square.sums[j];
        if (!(sum.variance > 0.0)) continue;
        const double together = sum.weight * s.rendering_dn, variance = sum.variance + alike * sum.scatter;
        CauseRegion& kind = out[std::min<std::size_t>(j, kImage)];
        kind.chi2 += sum.residual * sum.residual / (variance + together * together);
        ++kind.n;
      }
    }
  }
  for (CauseRegion& kind : out) {
    const auto n = static_cast<double>(kind.n);
    kind.chi2 = kind.n > 0 ? kind.chi2 / n : kNaN;
    kind.limit = kind.n > 0 ? sensitivity.regional_limit(n) : kNaN;
  }
  return out;
}

}  // namespace fringetwin::compare
