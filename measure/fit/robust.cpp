// SPDX-License-Identifier: Apache-2.0
#include "measure/fit/robust.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

constexpr std::size_t kSubset = 20000;
constexpr int kReweightings = 40;
constexpr int kRefits = 15;
constexpr double kScaleChange = 1e-4;  ///< relative change that ends the reweighting

std::vector<std::size_t> pick_subset(std::size_t n) {
  std::vector<std::size_t> index;
  if (n <= kSubset) {
    index.resize(n);
    std::iota(index.begin(), index.end(), std::size_t{0});
    return index;
  }
  // one draw per stratum: spread over the cloud, no aliasing with the pixel grid
  std::mt19937_64 random(20);
  index.reserve(kSubset);
  for (std::size_t k = 0; k < kSubset; ++k) {
    const std::size_t first = k * n / kSubset, last = (k + 1) * n / kSubset;
    index.push_back(first + random() % (last - first));
  }
  return index;
}

std::vector<double> distances(const RobustModel& model, const std::vector<std::size_t>& index) {
  std::vector<double> r(index.size());
  const auto n = static_cast<std::ptrdiff_t>(index.size());
#pragma omp parallel for schedule(static) if (n > 20000)
  for (std::ptrdiff_t k = 0; k < n; ++k) r[k] = model.distance(index[k]);
  return r;
}

double scale_of(const RobustModel& model, const FitOptions& options, std::vector<double> r) {
  const double scale = options.loss_scale_mm > 0.0 ? options.loss_scale_mm : mad_sigma(r);
  return std::max(scale, model.smallest_scale);
}

bool reweight(const RobustModel& model, const FitOptions& options, RobustLoss loss,
              const std::vector<std::size_t>& subset) {
  double previous = 0.0;
  std::vector<double> weight(subset.size());
  for (int k = 0; k < kReweightings; ++k) {
    const std::vector<double> r = distances(model, subset);
    const double scale = scale_of(model, options, r);
    if (!std::isfinite(scale)) return false;
    for (std::size_t i = 0; i < r.size(); ++i) weight[i] = robust_weight(loss, r[i] / scale);
    if (!model.solve(subset, weight)) return false;
    if (k > 0 && std::abs(scale - previous) <= kScaleChange * scale) break;
    previous = scale;
  }
  return true;
}

std::vector<std::size_t> inliers(const RobustModel& model, double limit) {
  std::vector<unsigned char> inside(model.n);
  const auto n = static_cast<std::ptrdiff_t>(model.n);
#pragma omp parallel for schedule(static) if (n > 20000)
  for (std::ptrdiff_t i = 0; i < n; ++i)
    inside[i] = std::abs(model.distance(static_cast<std::size_t>(i))) <= limit;
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < model.n; ++i)
    if (inside[i]) index.push_back(i);
  return index;
}

RobustResult refit_inliers(const RobustModel& model, const FitOptions& options,
                           const std::vector<std::size_t>& subset) {
  RobustResult result;
  double scale = scale_of(model, options, distances(model, subset));
  for (int k = 0; k < kRefits; ++k) {
    std::vector<std::size_t> index = inliers(model, kInlierSigmas * scale);
    if (index.size() < model.min_points) {
      result.message = "too few points agree with one surface";
      return result;
    }
    const bool stable = k > 0 && index == result.index;
    result.index = std::move(index);
    if (stable) break;
    if (!model.solve(result.index, std::vector<double>(result.index.size(), 1.0))) {
      result.message = "the points do not determine the surface";
      return result;
    }
    // the median of the inliers forgets the outliers that widened the first scale
    if (options.loss_scale_mm <= 0.0) scale = scale_of(model, options, distances(model, result.index));
  }
  result.ok = true;
  return result;
}

}  // namespace

double robust_weight(RobustLoss loss, double u) {
  const double a = std::abs(u);
  if (loss == RobustLoss::huber) return a <= 1.345 ? 1.0 : 1.345 / a;
  if (loss == RobustLoss::tukey) return tukey_weight(u);
  return 1.0;
}

RobustResult robust_fit(const RobustModel& model, const FitOptions& options) {
  RobustResult result;
  if (options.loss == RobustLoss::none) {
    result.index.resize(model.n);
    std::iota(result.index.begin(), result.index.end(), std::size_t{0});
    result.ok = model.solve(result.index, std::vector<double>(model.n, 1.0));
    if (!result.ok) result.message = "the points do not determine the surface";
    return result;
  }
  const std::vector<std::size_t> subset = pick_subset(model.n);
  const bool ok = reweight(model, options, RobustLoss::huber, subset) &&
                  (options.loss != RobustLoss::tukey || reweight(model, options, RobustLoss::tukey, subset));
  if (!ok) {
    result.message = "the points do not determine the surface";
    return result;
  }
  return refit_inliers(model, options, subset);
}

}  // namespace fringetwin::measure
