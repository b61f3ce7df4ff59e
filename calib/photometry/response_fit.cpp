// SPDX-License-Identifier: Apache-2.0
#include "calib/photometry/response_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "twin/base/errors.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::calib {
namespace {

constexpr int kBlock = 32, kGroups = 8, kIterations = 25;
constexpr std::size_t kFewestExposures = 16, kImagesPerPiece = 3, kKneePlaces = 48;
constexpr double kKneeSigmas = 4.0;

using Images = std::vector<ExposedBlocks>;

/// The curve over x = (exposure - delay) times the block's light, with corners at fixed x; level 0 at x = 0.
struct Model {
  std::vector<double> x, level;  // [0] = 0
  double delay_ms = 0.0;
  std::vector<double> light;  // of the blocks; mean 1
  double squares = 0.0;

  std::size_t piece(double at) const {
    const auto above = std::upper_bound(x.begin() + 1, x.end() - 1, at);
    return static_cast<std::size_t>(above - x.begin()) - 1;
  }
  double slope(std::size_t p) const { return (level[p + 1] - level[p]) / (x[p + 1] - x[p]); }
  double operator()(double at) const {
    const std::size_t p = piece(at);
    return level[p] + slope(p) * (at - x[p]);
  }
};

/// Lets the corners and the delay follow the residuals, the light of the blocks held.
void step_curve(const Images& images, double black_dn, Model& m) {
  const auto n = static_cast<Eigen::Index>(m.x.size());  // levels 1 ... n - 1 and the delay
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  m.squares = 0.0;
  for (const ExposedBlocks& image : images)
    for (std::size_t b = 0; b < m.light.size(); ++b) {
      if (std::isnan(image.level_dn[b])) continue;
      const double at = m.light[b] * (image.exposure_ms - m.delay_ms);
      const std::size_t p = m.piece(at);
      const double s = m.slope(p), residual = image.level_dn[b] - black_dn - m.level[p] - s * (at - m.x[p]),
                   t = (at - m.x[p]) / (m.x[p + 1] - m.x[p]);
      // unknowns: index p is level p; 0, whose level is fixed, stands for the delay
      const std::array<std::pair<Eigen::Index, double>, 3> row{
          {{0, -s * m.light[b]},
           {static_cast<Eigen::Index>(p), p == 0 ? 0.0 : 1.0 - t},
           {static_cast<Eigen::Index>(p + 1), t}}};
      for (const auto& [i, a] : row) {
        right[i] += a * residual;
        for (const auto& [j, c] : row) normal(i, j) += a * c;
      }
      m.squares += residual * residual;
    }
  const Eigen::VectorXd by = solve_symmetric(normal, right);
  m.delay_ms += by[0];
  for (Eigen::Index i = 1; i < n; ++i) m.level[static_cast<std::size_t>(i)] += by[i];
}

/// Lets the light of each block follow its residuals.
void step_light(const Images& images, double black_dn, Model& m) {
  for (std::size_t b = 0; b < m.light.size(); ++b) {
    double change = 0.0, weight = 0.0;
    for (const ExposedBlocks& image : images) {
      if (std::isnan(image.level_dn[b])) continue;
      const double t = image.exposure_ms - m.delay_ms, at = m.light[b] * t, s = m.slope(m.piece(at)) * t;
      change += s * (image.level_dn[b] - black_dn - m(at)), weight += s * s;
    }
    if (weight > 0.0) m.light[b] += change / weight;
  }
  const double mean =
      std::accumulate(m.light.begin(), m.light.end(), 0.0) / static_cast<double>(m.light.size());
  for (double& light : m.light) light /= mean;
}

/// Returns the corners: one after every few images, and one at the knee instead of those near it.
std::vector<double> corners(const Images& images, double knee) {
  std::vector<double> x{0.0};
  for (std::size_t k = kImagesPerPiece; k + kImagesPerPiece <= images.size(); k += kImagesPerPiece)
    x.push_back(images[k].exposure_ms);
  x.push_back(images.back().exposure_ms);
  const double near = 0.6 * (x.back() - x[1]) / static_cast<double>(x.size() - 2);
  std::erase_if(
      x, [&](double at) { return at > 0.0 && at < images.back().exposure_ms && std::abs(at - knee) < near; });
  x.insert(std::ranges::upper_bound(x, knee), knee);
  return x;
}

/// `all`: the series that the corners follow.
Model fit_model(const Images& images, double black_dn, double knee, const Images& all) {
  Model m;
  m.x = corners(all, knee);
  const std::size_t n_blocks = images[0].level_dn.size();
  m.light.assign(n_blocks, 1.0);
  const ExposedBlocks& longest = images.back();
  double mean = 0.0, n = 0.0;
  for (const double level : longest.level_dn)
    if (!std::isnan(level)) mean += level - black_dn, n += 1.0;
  for (const double x : m.x) m.level.push_back(x * mean / n / longest.exposure_ms);
  for (int i = 0; i < kIterations; ++i) {
    step_curve(images, black_dn, m);
    step_light(images, black_dn, m);
  }
  step_curve(images, black_dn, m);
  return m;
}

struct Kneed {
  Model model;
  double knee = 0.0;
};

double knee_ratio(const Kneed& k) {
  const auto at = static_cast<std::size_t>(std::ranges::find(k.model.x, k.knee) - k.model.x.begin());
  return k.model.slope(at) / k.model.slope(at - 1);
}

/// Returns the fit whose slopes before and behind the knee differ most, between places by a parabola.
Kneed fit_kneed(const Images& images, double black_dn, const Images& all) {
  const double low = all[2 * kImagesPerPiece].exposure_ms,
               high = all[all.size() - 1 - kImagesPerPiece].exposure_ms,
               step = (high - low) / (kKneePlaces - 1);
  std::array<double, kKneePlaces> bends{};
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < kKneePlaces; ++i) {
    const double at = low + step * static_cast<double>(i);
    bends[i] = std::abs(std::log(knee_ratio({fit_model(images, black_dn, at, all), at})));
  }
  const auto best = static_cast<std::size_t>(std::ranges::max_element(bends) - bends.begin());
  double at = low + step * static_cast<double>(best);
  if (best > 0 && best + 1 < kKneePlaces) {
    const double a = bends[best - 1], b = bends[best], c = bends[best + 1], bend = a - 2.0 * b + c;
    if (bend < 0.0) at += 0.5 * step * (a - c) / bend;
  }
  return {fit_model(images, black_dn, at, all), at};
}

CameraResponse response_of(const Model& m) {
  CameraResponse out;
  const double origin = m.slope(0);
  for (std::size_t p = 1; p + 1 < m.x.size(); ++p) out.corners.push_back({origin * m.x[p], m.level[p]});
  out.corners.push_back({origin * m.x.back(), m.level.back()});
  out.last_slope = m.slope(m.x.size() - 2) / origin;
  return out;
}

/// What every jackknife group is asked for, in a row: origin's slope, delay, knee level, ratio, curve at
/// inputs.
std::vector<double> numbers_of(const Kneed& k, double black_dn, const CameraResponse& at) {
  std::vector<double> out{k.model.slope(0), k.model.delay_ms, k.model(k.knee) + black_dn, knee_ratio(k)};
  const CameraResponse own = response_of(k.model);
  for (const CameraResponse::Corner& c : at.corners) out.push_back(own(c.in_dn));
  return out;
}

/// Returns the standard errors by leaving out every eighth image in turn. The corners stay where all images
/// have them: moved with the images that are left, they alone scatter the numbers more than noise does.
std::vector<double> jackknife(const Images& images, double black_dn, const CameraResponse& at) {
  std::vector<std::vector<double>> rows;
  for (int g = 0; g < kGroups; ++g) {
    Images some;
    for (std::size_t k = 0; k < images.size(); ++k)
      if (static_cast<int>(k % kGroups) != g) some.push_back(images[k]);
    rows.push_back(numbers_of(fit_kneed(some, black_dn, images), black_dn, at));
  }
  std::vector<double> sigma;
  for (std::size_t i = 0; i < rows[0].size(); ++i) {
    double mean = 0.0, squares = 0.0;
    for (const auto& row : rows) mean += row[i] / kGroups;
    for (const auto& row : rows) squares += std::pow(row[i] - mean, 2);
    sigma.push_back(std::sqrt(squares * (kGroups - 1.0) / kGroups));
  }
  return sigma;
}

/// Predicts one image; with `factor`, at so much of its light.
double squares_of(const ExposedBlocks& image, const Model& m, double black_dn, double factor, double& n) {
  double squares = 0.0;
  n = 0.0;
  for (std::size_t b = 0; b < m.light.size(); ++b) {
    if (std::isnan(image.level_dn[b])) continue;
    const double at = factor * m.light[b] * (image.exposure_ms - m.delay_ms);
    squares += std::pow(image.level_dn[b] - black_dn - m(at), 2), n += 1.0;
  }
  return squares;
}

double own_factor(const ExposedBlocks& image, const Model& m, double black_dn) {
  double factor = 1.0;
  for (int i = 0; i < 5; ++i) {
    double change = 0.0, weight = 0.0;
    for (std::size_t b = 0; b < m.light.size(); ++b) {
      if (std::isnan(image.level_dn[b])) continue;
      const double x = m.light[b] * (image.exposure_ms - m.delay_ms), s = m.slope(m.piece(factor * x)) * x;
      change += s * (image.level_dn[b] - black_dn - m(factor * x)), weight += s * s;
    }
    factor += change / weight;
  }
  return factor;
}

void predict_held_out(const Images& images, double black_dn, ResponseFit& out) {
  Images fitted, others;
  for (std::size_t k = 0; k < images.size(); ++k) (k % 2 == 0 ? fitted : others).push_back(images[k]);
  const Model m = fit_kneed(fitted, black_dn, fitted).model;
  double squares = 0.0, own = 0.0, n_all = 0.0, n = 0.0;
  for (const ExposedBlocks& image : others) {
    const double factor = own_factor(image, m, black_dn);
    own += squares_of(image, m, black_dn, factor, n);
    const double plain = squares_of(image, m, black_dn, 1.0, n);
    squares += plain, n_all += n;
    out.held_out_ms.push_back(image.exposure_ms);
    out.held_out_image_dn.push_back(std::sqrt(plain / n));
    out.own_light.push_back(factor);
  }
  out.held_out_rms_dn = std::sqrt(squares / n_all);
  out.held_out_rms_own_light_dn = std::sqrt(own / n_all);
}

}  // namespace

ExposedBlocks exposed_blocks(const std::vector<GrayImage>& images, double exposure_ms, double saturation_dn) {
  ExposedBlocks out{exposure_ms, {}};
  const double n = kBlock * kBlock * static_cast<double>(images.size());
  for (int y = 0; y + kBlock <= images[0].height; y += kBlock)
    for (int x = 0; x + kBlock <= images[0].width; x += kBlock) {
      double sum = 0.0;
      for (const GrayImage& image : images)
        for (int v = y; v < y + kBlock; ++v)
          for (int u = x; u < x + kBlock; ++u) {
            const auto value = static_cast<double>(image(u, v));
            sum += value > 0.0 && value < saturation_dn ? value : std::numeric_limits<double>::quiet_NaN();
          }
      out.level_dn.push_back(sum / n);
    }
  return out;
}

std::optional<ResponseFit> fit_response(Images images, double black_level_dn, const std::string& where) {
  std::erase_if(images, [](const ExposedBlocks& image) {
    return std::ranges::all_of(image.level_dn, [](double level) { return std::isnan(level); });
  });
  if (images.size() < kFewestExposures) return std::nullopt;
  std::ranges::sort(images, {}, &ExposedBlocks::exposure_ms);
  const Kneed all = fit_kneed(images, black_level_dn, images);
  for (std::size_t p = 0; p + 1 < all.model.x.size(); ++p)
    if (!(all.model.slope(p) > 0.0))
      throw UserError(ExitCode::input, where,
                      fmt::format("gray values do not rise with the exposure near {:.4g} ms", all.model.x[p]),
                      "check the exposures of the series");
  ResponseFit out;
  out.response = response_of(all.model);
  const std::vector<double> value = numbers_of(all, black_level_dn, out.response),
                            sigma = jackknife(images, black_level_dn, out.response);
  out.dn_per_ms = {value[0], sigma[0]};
  out.delay_ms = {value[1], sigma[1]};
  out.knee_dn = {value[2], sigma[2]};
  out.knee_slope_ratio = {value[3], sigma[3]};
  out.corner_sigma_dn.assign(sigma.begin() + 4, sigma.end());
  out.has_knee = std::abs(value[3] - 1.0) > kKneeSigmas * sigma[3];
  predict_held_out(images, black_level_dn, out);
  return out;
}

}  // namespace fringetwin::calib
