// SPDX-License-Identifier: Apache-2.0
#include "study/uncertain/sphere_form.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "study/plan/random_draws.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

using Eigen::Vector3d;

/// rms of facet_error is this times radius / frequency^2: sqrt(1/60)/4 L^2/r over an equilateral triangle of
/// side L, of which 20 frequency^2 cover the sphere, and some more because they differ in size (tested).
constexpr double kFacetFactor = 0.055;
/// Facets below 1/20 of the form or 0.1 um, whichever is larger; at most 196,020 triangles. Two edges a
/// radian for each degree leave 1/50 of the highest degree.
constexpr double kShareOfForm = 0.05, kLeastFacetErrorMm = 1e-4;
constexpr int kMostFrequency = 99;

int frequency(double radius_mm, const FormSpread& spread) {
  const double error_mm = std::max(kShareOfForm * spread.rms_mm, kLeastFacetErrorMm);
  return std::clamp(static_cast<int>(std::ceil(std::sqrt(kFacetFactor * radius_mm / error_mm))),
                    2 * spread.high, kMostFrequency);
}

std::size_t index(int l, int m) { return static_cast<std::size_t>(l * l + l + m); }

const std::array<Vector3d, 12>& icosahedron() {
  static const std::array<Vector3d, 12> corners = [] {
    const double g = std::numbers::phi;
    std::array<Vector3d, 12> c = {Vector3d{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                  {0, -1, g},         {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                  {g, 0, -1},         {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
    for (Vector3d& v : c) v.normalize();
    return c;
  }();
  return corners;
}
constexpr int kFaces[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                               {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                               {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                               {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};

/// Directions and triangles of the icosahedron whose edges are cut into `f` parts.
struct Geodesic {
  std::vector<Vector3d> directions;
  std::vector<std::array<int, 3>> triangles;

  explicit Geodesic(int f) {
    std::vector<int> row(static_cast<std::size_t>((f + 1) * (f + 2) / 2));
    const auto at = [&](int i, int j) {  // i from the first corner, j to the side
      return row[i * (i + 1) / 2 + j];
    };
    for (const auto& face : kFaces) {
      for (int i = 0; i <= f; ++i)
        for (int j = 0; j <= i; ++j)
          row[i * (i + 1) / 2 + j] = vertex({{{face[0], f - i}, {face[1], i - j}, {face[2], j}}});
      for (int i = 0; i < f; ++i)
        for (int j = 0; j <= i; ++j) {
          triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
          if (j < i) triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }
  }

 private:
  using Weights = std::array<std::pair<int, int>, 3>;  // corner of the icosahedron, weight

  /// The same number for the same place on another face.
  int vertex(Weights w) {
    std::ranges::sort(w);
    for (auto& [corner, weight] : w)
      if (weight == 0) corner = -1;
    std::ranges::sort(w);
    const auto [it, is_new] = known_.try_emplace(w, static_cast<int>(directions.size()));
    if (is_new) {
      Vector3d sum = Vector3d::Zero();
      for (const auto& [corner, weight] : w)
        if (corner >= 0) sum += weight * icosahedron()[corner];
      directions.push_back(sum.normalized());
    }
    return it->second;
  }
  std::map<Weights, int> known_;
};

}  // namespace

SphereForm::SphereForm(int degree, std::vector<double> coefficients)
    : degree_(degree), c_(std::move(coefficients)), a_(c_.size()), b_(c_.size()) {
  FT_CHECK(degree >= 0 && c_.size() == index(degree + 1, -degree - 1), "coefficients of all degrees");
  for (int m = 0; m <= degree; ++m)
    for (int l = m + 1; l <= degree; ++l) {
      const double d = static_cast<double>((l - m) * (l + m)), l2 = static_cast<double>(l * l);
      a_[index(l, m)] = std::sqrt((4.0 * l2 - 1.0) / d);
      const double below = static_cast<double>((l - 1) * (l - 1));
      b_[index(l, m)] = std::sqrt((below - static_cast<double>(m * m)) / (4.0 * below - 1.0));
    }
}

SphereForm SphereForm::draw(const FormSpread& s, std::uint64_t seed) {
  FT_CHECK(0 <= s.low && s.low <= s.high, "degrees");
  std::vector<double> c(index(s.high + 1, -s.high - 1));
  for (int l = s.low; l <= s.high; ++l) {
    // Mean of h^2 over the sphere: sum of c^2 / 4 pi; 2 l + 1 of them, high - low + 1 degrees.
    const double sigma =
        s.rms_mm * std::sqrt(4.0 * std::numbers::pi / ((s.high - s.low + 1.0) * (2.0 * l + 1.0)));
    for (int m = -l; m <= l; ++m) {
      const std::size_t i = index(l, m);
      c[i] = sigma * normal_quantile(unit_draw(seed, DrawStream::form, 0, static_cast<std::uint32_t>(i)));
    }
  }
  return {s.high, std::move(c)};
}

/// Holmes and Featherstone 2002: normalised P_lm over l for each m, without its factor sin^m theta, which
/// goes to cos and sin of m phi.
double SphereForm::at(const Vector3d& n) const {
  double sum = 0.0, re = std::numbers::sqrt2, im = 0.0;  // sqrt(2) (x + i y)^m
  double sectoral = 0.5 / std::sqrt(std::numbers::pi);
  for (int m = 0; m <= degree_; ++m) {
    double last = 0.0, p = sectoral;
    for (int l = m;;) {
      sum += m == 0 ? p * c_[index(l, 0)] : p * (c_[index(l, m)] * re + c_[index(l, -m)] * im);
      if (++l > degree_) break;
      const double next = a_[index(l, m)] * (n.z() * p - b_[index(l, m)] * last);
      last = p;
      p = next;
    }
    sectoral *= std::sqrt((2.0 * m + 3.0) / (2.0 * m + 2.0));
    const double turned = re * n.x() - im * n.y();
    im = re * n.y() + im * n.x();
    re = turned;
  }
  return sum;
}

double facet_error_mm(double radius_mm, const FormSpread& spread) {
  const int f = frequency(radius_mm, spread);
  return kFacetFactor * radius_mm / (f * f);
}

std::shared_ptr<const Mesh> form_mesh(double radius_mm, const FormSpread& spread, const SphereForm& form) {
  const Geodesic sphere(frequency(radius_mm, spread));
  const std::vector<Vector3d>& n = sphere.directions;
  // A facet with corners on a sphere lies sum of its squared sides / (24 r) inside on average.
  std::vector<double> inside(n.size()), count(n.size());
  for (const auto& t : sphere.triangles) {
    double sides = 0.0;
    for (std::size_t k = 0; k < 3; ++k) sides += (n[t[k]] - n[t[(k + 1) % 3]]).squaredNorm();
    for (const int v : t) {
      inside[v] += radius_mm * sides / 24.0;
      count[v] += 1.0;
    }
  }
  auto mesh = std::make_shared<Mesh>();
  mesh->triangles = sphere.triangles;
  mesh->vertices_mm.reserve(n.size());
  for (std::size_t i = 0; i < n.size(); ++i)
    mesh->vertices_mm.push_back(((radius_mm + form.at(n[i]) + inside[i] / count[i]) * n[i]).cast<float>());
  return mesh;
}

}  // namespace fringetwin::study
