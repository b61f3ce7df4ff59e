// SPDX-License-Identifier: Apache-2.0
#include "calib/photometry/photon_transfer.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::calib {
namespace {

constexpr int kBins = 48;
constexpr std::size_t kMinPerBin = 400;

/// Sums of the samples of one bin within the cut, per image block, so that a block can be left out.
struct BinCell {
  double n = 0.0, level = 0.0, square = 0.0;
};
using BinCells = std::array<BinCell, kBlocks>;

struct Bin {
  std::vector<const NoiseSample*> samples;
  BinCells cells{};
  BinCell sum;
};

/// Returns the standard deviation of the samples that are no rougher than the limit: the rms of those within
/// kCutSigmas, corrected for the cut, iterated from a start (MAD) that outliers cannot move.
double cut_sigma(const std::vector<const NoiseSample*>& samples, double rough_limit) {
  std::vector<float> size;
  for (const NoiseSample* s : samples)
    if (static_cast<double>(s->roughness_dn) <= rough_limit) size.push_back(std::abs(s->noise_dn));
  if (size.empty()) return 0.0;
  // Coarse gray levels move a median by up to one of their steps; the first cut is wide for that.
  double sigma = kMadToSigma * upper_median(size) + 0.2;
  for (int i = 0; i < 50; ++i) {
    double sum = 0.0, n = 0.0;
    for (const float v : size)
      if (static_cast<double>(v) <= kCutSigmas * sigma) {
        sum += static_cast<double>(v) * static_cast<double>(v);
        n += 1.0;
      }
    const double next = std::sqrt(sum / (n * kKeptVariance));
    if (std::abs(next - sigma) <= 1e-6 * sigma) return next;
    sigma = next;
  }
  return sigma;
}

/// Sums the samples of a bin that are neither outliers nor rough, block by block and in all.
void fill_cells(Bin& bin) {
  const double all = cut_sigma(bin.samples, std::numeric_limits<double>::infinity());
  const double rough = measure::kRoughSigmas * all;
  const double cut = kCutSigmas * cut_sigma(bin.samples, rough);
  for (const NoiseSample* s : bin.samples) {
    const auto v = static_cast<double>(s->noise_dn);
    if (std::abs(v) > cut || static_cast<double>(s->roughness_dn) > rough) continue;
    BinCell& cell = bin.cells[s->block];
    cell.n += 1.0;
    cell.level += static_cast<double>(s->level_dn);
    cell.square += v * v;
  }
  for (const BinCell& c : bin.cells) {
    bin.sum.n += c.n;
    bin.sum.level += c.level;
    bin.sum.square += c.square;
  }
}

/// Sorts the samples into bins of equal width between the 0.1 % and 99.9 % quantiles of the levels; drops
/// bins with too few samples.
std::vector<Bin> make_bins(const std::vector<NoiseSample>& samples) {
  std::vector<float> levels;
  const std::size_t step = std::max<std::size_t>(1, samples.size() / 100000);
  for (std::size_t i = 0; i < samples.size(); i += step) levels.push_back(samples[i].level_dn);
  const std::size_t outside = levels.size() / 1000;
  const double low = nth_smallest(levels, outside);
  const double high = nth_smallest(levels, levels.size() - 1 - outside);
  std::vector<Bin> bins(kBins);
  const double per_dn = high > low ? kBins / (high - low) : 0.0;
  for (const NoiseSample& s : samples) {
    const double at = (static_cast<double>(s.level_dn) - low) * per_dn;
    if (at < 0.0 || at > kBins) continue;
    bins[std::min<std::size_t>(kBins - 1, static_cast<std::size_t>(at))].samples.push_back(&s);
  }
  std::erase_if(bins, [](const Bin& b) { return b.samples.size() < kMinPerBin; });
#pragma omp parallel for schedule(dynamic)
  for (std::size_t b = 0; b < bins.size(); ++b) fill_cells(bins[b]);
  std::erase_if(bins, [](const Bin& b) { return b.sum.n < kMinPerBin / 2; });
  return bins;
}

/// Holds mean level, variance and number of samples of every bin: the points through which the line is
/// fitted.
struct Points {
  Eigen::VectorXd level, variance, n;
};

/// Returns the points from the sums of all blocks, or of all but one when without_block >= 0.
Points points_of(const std::vector<Bin>& bins, int without_block) {
  const auto m = static_cast<Eigen::Index>(bins.size());
  Points p{Eigen::VectorXd(m), Eigen::VectorXd(m), Eigen::VectorXd(m)};
  for (Eigen::Index i = 0; i < m; ++i) {
    BinCell c = bins[i].sum;
    if (without_block >= 0) {
      const BinCell& out = bins[i].cells[without_block];
      c.n -= out.n, c.level -= out.level, c.square -= out.square;
    }
    p.n[i] = std::max(c.n, 0.0);
    p.level[i] = c.n > 0.0 ? c.level / c.n : 0.0;
    p.variance[i] = c.n > 0.0 ? c.square / c.n / kKeptVariance : 0.0;
  }
  return p;
}

struct Fit {
  Eigen::VectorXd coefficients;  // of powers of (level - centre)
  Eigen::MatrixXd covariance;    // of the bins' own scatter
};

/// Fits a polynomial in (level - centre) with `terms` coefficients to the variances. The weight of a bin, n /
/// (2 variance^2), takes the variance from the fit itself and is iterated with it.
Fit fit_polynomial(const Points& p, double centre, int terms, double samples_per_independent) {
  Eigen::MatrixXd A(p.level.size(), terms);
  for (int k = 0; k < terms; ++k) A.col(k) = (p.level.array() - centre).pow(k);
  Eigen::VectorXd model = p.variance;
  Fit fit;
  const double least = 1e-3 * std::max(1e-12, p.variance.maxCoeff());
  for (int i = 0; i < 12; ++i) {
    const Eigen::VectorXd w =
        p.n.array() / (2.0 * samples_per_independent * model.array().max(least).square());
    const Eigen::MatrixXd N = A.transpose() * w.asDiagonal() * A;
    fit.covariance = SymmetricFactor(N).inverse();
    fit.coefficients = fit.covariance * (A.transpose() * (w.asDiagonal() * p.variance));
    model = A * fit.coefficients;
  }
  return fit;
}

/// Returns the covariance of the coefficients by the delete-a-block jackknife (Efron 1982); empty blocks do
/// not count.
Eigen::MatrixXd jackknife(const std::vector<Bin>& bins, const Fit& all, double centre, int terms,
                          double samples_per_independent) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(terms, terms);
  int groups = 0;
  for (int b = 0; b < kBlocks; ++b) {
    double n = 0.0;
    for (const Bin& bin : bins) n += bin.cells[b].n;
    if (n == 0.0) continue;
    const Fit part = fit_polynomial(points_of(bins, b), centre, terms, samples_per_independent);
    const Eigen::VectorXd d = part.coefficients - all.coefficients;
    sum += d * d.transpose();
    ++groups;
  }
  if (groups < 12) return Eigen::MatrixXd::Zero(terms, terms);  // too few to speak of correlation
  return sum * (groups - 1.0) / groups;
}

/// Returns the larger of the standard errors, by two covariances of the parameters, of a quantity with this
/// gradient.
double sigma_of(const Eigen::VectorXd& gradient, const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return std::sqrt(std::max(gradient.dot(a * gradient), gradient.dot(b * gradient)));
}

/// Writes the bins, and how far they lie from the fitted line, into the result.
void put_bins(const std::vector<Bin>& bins, const Points& p, const Fit& line, double centre,
              const TransferOptions& options, PhotonTransfer& out) {
  double relative_sq = 0.0, chi2 = 0.0;
  for (Eigen::Index i = 0; i < p.level.size(); ++i) {
    TransferBin bin{.level_dn = p.level[i],
                    .variance_dn2 = p.variance[i],
                    .line_dn2 = line.coefficients[0] + line.coefficients[1] * (p.level[i] - centre)};
    bin.sigma_dn2 = std::abs(bin.line_dn2) * std::sqrt(2.0 * options.samples_per_independent / p.n[i]);
    bin.n = static_cast<std::size_t>(p.n[i]);
    const double off = bin.variance_dn2 - bin.line_dn2, relative = off / bin.line_dn2;
    chi2 += std::pow(off / bin.sigma_dn2, 2);
    relative_sq += relative * relative;
    if (std::abs(relative) > std::abs(out.residual_worst)) out.residual_worst = relative;
    out.n += bin.n;
    out.bins.push_back(bin);
  }
  out.residual_rms = std::sqrt(relative_sq / static_cast<double>(bins.size()));
  out.chi2_per_dof = chi2 / static_cast<double>(std::max<std::size_t>(1, bins.size() - 2));
  out.low_dn = out.bins.front().level_dn;
  out.high_dn = out.bins.back().level_dn;
}

}  // namespace

Estimate noise_variance(const std::vector<NoiseSample>& samples) {
  Bin bin;
  for (const NoiseSample& s : samples) bin.samples.push_back(&s);
  fill_cells(bin);
  if (!(bin.sum.n > 0.0)) return {};
  const double variance = bin.sum.square / bin.sum.n / kKeptVariance;
  return {variance, variance * std::sqrt(2.0 / bin.sum.n)};
}

PhotonTransfer photon_transfer(const std::vector<NoiseSample>& samples, const TransferOptions& options,
                               const std::string& where) {
  const std::string hint = "photon transfer needs a scene of dark and bright parts, not clipped";
  if (samples.size() < 10 * kMinPerBin)
    throw UserError(ExitCode::input, where,
                    fmt::format("only {} usable gray values to tell the noise from", samples.size()), hint);
  const std::vector<Bin> bins = make_bins(samples);
  if (bins.size() < 3)
    throw UserError(
        ExitCode::input, where,
        fmt::format("the usable gray values cover {} of {} intervals of the gray scale", bins.size(), kBins),
        hint);
  const Points p = points_of(bins, -1);
  const double centre = p.level.dot(p.n) / p.n.sum(), per = options.samples_per_independent;
  const Fit line = fit_polynomial(p, centre, 2, per);
  PhotonTransfer out;
  put_bins(bins, p, line, centre, options, out);

  const Eigen::MatrixXd own = line.covariance * std::max(1.0, out.chi2_per_dof);
  const Eigen::MatrixXd blocks = jackknife(bins, line, centre, 2, per);
  const auto at_level = [&](double level) -> Estimate {
    const Eigen::Vector2d g(1.0, level - centre);
    return {g.dot(line.coefficients), sigma_of(g, own, blocks)};
  };
  out.dn_per_electron = {line.coefficients[1], sigma_of(Eigen::Vector2d(0.0, 1.0), own, blocks)};
  const double K = out.dn_per_electron.value;
  if (!(K > 0.0) || K < 2.0 * out.dn_per_electron.sigma)
    throw UserError(ExitCode::input, where,
                    fmt::format("the noise does not grow with the light ({:.4g} ± {:.2g} DN per electron "
                                "over {:.0f}...{:.0f} DN)",
                                K, out.dn_per_electron.sigma, out.low_dn, out.high_dn),
                    "are the images averaged, filtered or simulated without shot noise?");
  const double highest = at_level(out.high_dn).value;
  if (highest < 1.5 * options.rounding_dn2)
    throw UserError(
        ExitCode::input, where,
        fmt::format("the noise, {:.2g} DN^2 at {:.0f} DN, is not above the rounding of gray values", highest,
                    out.high_dn),
        "are the images averaged, filtered or simulated without shot noise?");
  out.electrons_per_dn = {1.0 / K, out.dn_per_electron.sigma / (K * K)};
  out.offset_dn2 = at_level(0.0);
  out.black_level_dn = options.black_level_dn;
  out.read_variance_dn2 = at_level(options.black_level_dn);
  out.read_variance_dn2.value -= options.rounding_dn2;
  const double variance = out.read_variance_dn2.value, spread = out.read_variance_dn2.sigma;
  out.read_noise_dn.value = std::sqrt(std::max(0.0, variance));
  // First-order propagation through the root where the variance is well above 0, else an upper limit.
  out.read_noise_dn.sigma = variance > spread
                                ? 0.5 * spread / out.read_noise_dn.value
                                : std::sqrt(std::max(0.0, variance) + spread) - out.read_noise_dn.value;
  out.read_noise_electrons = {out.read_noise_dn.value / K, out.read_noise_dn.sigma / K};

  if (bins.size() >= 5) {
    const Fit curve = fit_polynomial(p, centre, 3, per);
    const Eigen::Vector3d g(0.0, 0.0, 2.0 * (out.high_dn - out.low_dn) / K);
    out.slope_change = {g.dot(curve.coefficients),
                        sigma_of(g, curve.covariance * std::max(1.0, out.chi2_per_dof),
                                 jackknife(bins, curve, centre, 3, per))};
  }
  return out;
}

}  // namespace fringetwin::calib
