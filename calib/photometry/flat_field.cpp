// SPDX-License-Identifier: Apache-2.0
#include "calib/photometry/flat_field.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::calib {
namespace {

constexpr int kTileColumns = 32;
constexpr double kHuber = 1.345;

struct FlatCell {
  double x = 0.0, y = 0.0, s = 0.0, value = 0.0;
};

std::vector<FlatCell> cell_means(const ImageF& flat, double black_dn, double saturation_dn,
                                 const SensorPlaces& places) {
  const int w = flat.width, h = flat.height;
  const int side = std::max(1, w / kTileColumns);
  std::vector<FlatCell> cells;
  for (int y0 = 0; y0 + side <= h; y0 += side)
    for (int x0 = 0; x0 + side <= w; x0 += side) {
      FlatCell c;
      bool clipped = false;
      for (int y = y0; y < y0 + side; ++y)
        for (int x = x0; x < x0 + side; ++x) {
          const auto v = static_cast<double>(flat(x, y));
          clipped = clipped || v >= saturation_dn;
          c.value += v - black_dn;
          c.s += places.s(x, y);
        }
      if (clipped) continue;
      const double n = 1.0 * side * side;
      c.value /= n, c.s /= n;
      c.x = places.x(x0 + 0.5 * (side - 1));
      c.y = places.y(y0 + 0.5 * (side - 1));
      cells.push_back(c);
    }
  return cells;
}

struct Solution {
  Eigen::VectorXd p;  // level, gx, gy, a1...
  Eigen::MatrixXd covariance;
  double chi2 = 0.0, rms = 0.0;
};

/// Gauss-Newton with Huber weights; the model is nearly linear.
std::optional<Solution> solve(const std::vector<FlatCell>& cells, int terms) {
  const int m = 3 + terms;
  Solution out;
  out.p = Eigen::VectorXd::Zero(m);
  std::vector<double> values;
  for (const FlatCell& c : cells) values.push_back(c.value);
  out.p[0] = upper_median(values);
  if (!(out.p[0] > 0.0)) return std::nullopt;
  double scale = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 30; ++iteration) {
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(m, m);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(m);
    std::vector<double> size;
    out.chi2 = out.rms = 0.0;
    double n = 0.0;
    for (const FlatCell& c : cells) {
      const double tilt = 1.0 + out.p[1] * c.x + out.p[2] * c.y;
      double fall = 1.0, power = 1.0;
      Eigen::VectorXd J(m);
      for (int k = 0; k < terms; ++k) {
        power *= c.s;
        fall += out.p[3 + k] * power;
        J[3 + k] = out.p[0] * tilt * power;
      }
      J[0] = tilt * fall;
      J[1] = out.p[0] * c.x * fall;
      J[2] = out.p[0] * c.y * fall;
      const double r = c.value - out.p[0] * tilt * fall;
      const double w = std::abs(r) <= kHuber * scale ? 1.0 : kHuber * scale / std::abs(r);
      N += w * J * J.transpose();
      g += w * r * J;
      out.chi2 += w * r * r;
      out.rms += r * r;
      n += w;
      size.push_back(std::abs(r));
    }
    scale = std::max(mad_sigma(size), 1e-9 * out.p[0]);
    const SymmetricFactor factor(N);
    const Eigen::VectorXd step = factor.solve(g);
    if (!step.allFinite()) return std::nullopt;
    out.p += step;
    out.covariance = factor.inverse() * (out.chi2 / std::max(1.0, n - m));
    if (step.norm() <= 1e-10 * out.p.norm()) break;
  }
  out.rms = std::sqrt(out.rms / static_cast<double>(cells.size())) / out.p[0];
  return out;
}

}  // namespace

SensorPlaces::SensorPlaces(int width, int height, const std::optional<MosaicChannel>& channel)
    : middle_x(0.5 * (width - 1)),
      middle_y(0.5 * (height - 1)),
      half_width(0.5 * width),
      half_height(0.5 * height) {
  if (!channel) return;
  const Eigen::Vector2d size_px = channel->sensor_px.cast<double>(),
                        middle = image_place_px(*channel, 0.5 * (size_px - Eigen::Vector2d::Ones()));
  middle_x = middle.x(), middle_y = middle.y();
  half_width = 0.25 * size_px.x(), half_height = 0.25 * size_px.y();  // its pixels are half as large
}

double SensorPlaces::s(double x_px, double y_px) const {
  const double dx = x_px - middle_x, dy = y_px - middle_y;
  return (dx * dx + dy * dy) / (half_width * half_width + half_height * half_height);
}

ImageD light_of(const FlatField& field, int width, int height) {
  ImageD out(width, height);
  const SensorPlaces places(width, height, field.channel);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double s = places.s(x, y);
      const double tilt = 1.0 + field.gradient_x.value * places.x(x) + field.gradient_y.value * places.y(y);
      out(x, y) = field.level_dn.value * tilt *
                  (1.0 + s * (field.a[0].value + s * (field.a[1].value + s * field.a[2].value)));
    }
  return out;
}

FlatField fit_flat_field(const ImageF& flat, double black_level_dn, double saturation_dn,
                         const std::string& where, const std::optional<MosaicChannel>& channel) {
  const std::vector<FlatCell> cells =
      cell_means(flat, black_level_dn, saturation_dn, {flat.width, flat.height, channel});
  if (cells.size() < 50)
    throw UserError(ExitCode::input, where,
                    fmt::format("only {} cells of the flat image are usable", cells.size()),
                    "it is saturated or too small; expose it lower");
  // The fewest terms: one more must take away a fifth of the squares.
  std::optional<Solution> best;
  int terms = 0;
  for (int t = 1; t <= 3; ++t) {
    const auto next = solve(cells, t);
    if (!next || (best && next->chi2 > 0.8 * best->chi2)) continue;
    best = next;
    terms = t;
  }
  if (!best)
    throw UserError(ExitCode::input, where, "the flat image is dark (not above the black level)",
                    "give an image of an evenly lit surface");
  FlatField out;
  const auto estimate = [&](int i) -> Estimate { return {best->p[i], std::sqrt(best->covariance(i, i))}; };
  out.level_dn = estimate(0);
  out.gradient_x = estimate(1);
  out.gradient_y = estimate(2);
  out.terms = terms;
  for (int k = 0; k < 3; ++k) out.a[k] = k < terms ? estimate(3 + k) : Estimate{0.0, 0.0};
  for (const Estimate& a : out.a) out.corner += a.value;
  out.residual_rms = best->rms;
  out.n = cells.size();
  out.channel = channel;
  return out;
}

}  // namespace fringetwin::calib
