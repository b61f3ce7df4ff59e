// SPDX-License-Identifier: Apache-2.0
// | tolerance      | unit | origin                                                                     |
// |----------------|------|----------------------------------------------------------------------------|
// | 1e-12, 1e-13   | 1    | rounding of sums of some hundred terms; relative to the largest value       |
// | 5              | sigma| of a mean of squares of n draws, fixed seeds                                |
// | facet_error_mm | mm   | rms distance of the facets: the bound that the size of the mesh is made from |
// | 0.05 of it     | mm   | mean distance: next order of the sag, and equal shares of unequal triangles |
#include "study/uncertain/sphere_form.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>

#include "render/base/quadrature.hpp"

namespace fringetwin::study::sphere_form_test {
namespace {

using Eigen::Vector3d;
constexpr double pi = std::numbers::pi;

std::size_t count(int degree) { return static_cast<std::size_t>((degree + 1) * (degree + 1)); }

/// One harmonic.
SphereForm unit(int degree, std::size_t which) {
  std::vector<double> c(count(degree));
  c[which] = 1.0;
  return {degree, std::move(c)};
}

struct Node {
  Vector3d n;
  double weight;
};
/// Exact for products of harmonics up to `degree`.
std::vector<Node> sphere_nodes(int degree) {
  std::vector<Node> out;
  const render::GaussRule& rule = render::gauss_rule(degree + 1);
  const int around = 2 * degree + 1;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i)
    for (int k = 0; k < around; ++k) {
      const double z = rule.nodes[i], s = std::sqrt(1.0 - z * z), phi = 2.0 * pi * k / around;
      out.push_back({{s * std::cos(phi), s * std::sin(phi), z}, rule.weights[i] * 2.0 * pi / around});
    }
  return out;
}

TEST(SphereForm, HarmonicsAreOrthonormal) {
  constexpr int degree = 12;
  const std::vector<Node> nodes = sphere_nodes(degree);
  std::vector<std::vector<double>> y;
  for (std::size_t i = 0; i < count(degree); ++i) {
    const SphereForm form = unit(degree, i);
    y.emplace_back();
    for (const Node& node : nodes) y.back().push_back(form.at(node.n));
  }
  double worst = 0.0;
  for (std::size_t i = 0; i < y.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = i == j ? -1.0 : 0.0;
      for (std::size_t k = 0; k < nodes.size(); ++k) sum += nodes[k].weight * y[i][k] * y[j][k];
      worst = std::max(worst, std::abs(sum));
    }
  EXPECT_LT(worst, 1e-12);
}

TEST(SphereForm, HarmonicsAreThoseOfTheStandardLibrary) {
  constexpr int degree = FormSpread::kMostDegree;
  for (const double theta : {1e-3, 0.4, 1.5, 2.9, pi - 1e-3})
    for (const double phi : {0.0, 0.7, 4.0}) {
      const Vector3d n(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
      for (int l = 0; l <= degree; l += 3)
        for (int m = -l; m <= l; ++m) {
          const auto um = static_cast<unsigned>(std::abs(m));
          const double sign = um % 2 == 0 ? 1.0 : -1.0;  // Condon and Shortley's, which is left out here
          const double p = sign * std::sph_legendre(static_cast<unsigned>(l), um, theta);
          const double want = m == 0  ? p
                              : m > 0 ? std::sqrt(2.0) * p * std::cos(m * phi)
                                      : std::sqrt(2.0) * p * std::sin(-m * phi);
          EXPECT_NEAR(unit(degree, static_cast<std::size_t>(l * l + l + m)).at(n), want, 1e-13 * (1 + l * l))
              << l << " " << m << " " << theta;
        }
    }
}

// The mean square of normal harmonics is a sum of squares: sigma of sum w chi2_k/k is sqrt(2 sum w^2/k).
TEST(SphereForm, RmsIsTheOneAskedForInEqualPartsOfTheDegrees) {
  const FormSpread spread{0.0035, 2, 12};
  const std::vector<Node> nodes = sphere_nodes(12);
  constexpr int n = 400;
  double mean2 = 0.0;
  for (std::uint64_t seed = 1; seed <= n; ++seed) {
    const SphereForm form = SphereForm::draw(spread, seed);
    for (const Node& node : nodes) mean2 += node.weight * form.at(node.n) * form.at(node.n) / (4.0 * pi * n);
  }
  double spread2 = 0.0;
  for (int l = 2; l <= 12; ++l) spread2 += 2.0 / (11.0 * 11.0 * (2.0 * l + 1.0));
  EXPECT_NEAR(mean2 / (0.0035 * 0.0035), 1.0, 5.0 * std::sqrt(spread2 / n));

  for (const int l : {2, 12}) {
    double part = 0.0;  // of one degree, by projection
    std::vector<SphereForm> y;
    for (int m = -l; m <= l; ++m) y.push_back(unit(12, static_cast<std::size_t>(l * l + l + m)));
    constexpr int few = 40;
    for (std::uint64_t seed = 1; seed <= few; ++seed) {
      const SphereForm form = SphereForm::draw(spread, seed);
      for (const SphereForm& harmonic : y) {
        double c = 0.0;
        for (const Node& node : nodes) c += node.weight * form.at(node.n) * harmonic.at(node.n);
        part += c * c / (4.0 * pi * few);
      }
    }
    EXPECT_NEAR(11.0 * part / (0.0035 * 0.0035), 1.0, 5.0 * std::sqrt(2.0 / (few * (2.0 * l + 1.0)))) << l;
  }
}

TEST(SphereForm, ADrawIsItsSeed) {
  const Vector3d n = Vector3d(1, 2, 3).normalized();
  EXPECT_EQ(SphereForm::draw({0.01, 2, 6}, 5).at(n), SphereForm::draw({0.01, 2, 6}, 5).at(n));
  EXPECT_NE(SphereForm::draw({0.01, 2, 6}, 5).at(n), SphereForm::draw({0.01, 2, 6}, 6).at(n));
  // More degrees: the old ones stay, with a smaller share.
  const double low = SphereForm::draw({0.01, 2, 2}, 5).at(n), both = SphereForm::draw({0.01, 2, 3}, 5).at(n),
               high = SphereForm::draw({0.01, 3, 3}, 5).at(n);
  EXPECT_NEAR(both, (low + high) / std::sqrt(2.0), 1e-16);
}

struct Facets {
  double mean = 0.0, rms = 0.0;  ///< outside the surface, mm
};
Facets facets(const Mesh& mesh, double radius, const SphereForm& form) {
  double area = 0.0, sum = 0.0, square = 0.0;
  for (const auto& t : mesh.triangles) {
    const auto v = [&](int k) {
      return mesh.vertices_mm[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])].cast<double>();
    };
    const Vector3d a = v(0), b = v(1), c = v(2), normal = (b - a).cross(c - a);
    EXPECT_GT(normal.dot(a), 0.0) << "outward winding";
    // Dunavant's rule of degree 4
    for (const auto& [near, weight] :
         {std::pair{0.091576213509771, 0.109951743655322}, {0.445948490915965, 0.223381589678011}})
      for (int corner = 0; corner < 3; ++corner) {
        Vector3d share = Vector3d::Constant(near);
        share[corner] = 1.0 - 2.0 * near;
        const Vector3d p = share[0] * a + share[1] * b + share[2] * c;
        const double off = p.norm() - radius - form.at(p.normalized()), w = weight * normal.norm();
        area += w;
        sum += w * off;
        square += w * off * off;
      }
  }
  return {sum / area, std::sqrt(square / area)};
}

TEST(FormMesh, FacetsLieOnTheSurfaceOnAverage) {
  struct Case {
    double radius_mm, rms_mm;
  };
  for (const Case& c : {Case{19.065, 0.0035}, {19.0, 0.02}, {50.0, 0.01}}) {
    const FormSpread spread{c.rms_mm, 2, 12};
    const double bound = facet_error_mm(c.radius_mm, spread);
    EXPECT_LE(bound, std::max(0.05 * c.rms_mm, 1e-4));
    for (const SphereForm& form : {SphereForm(0, {0.0}), SphereForm::draw(spread, 3)}) {
      const auto mesh = form_mesh(c.radius_mm, spread, form);
      EXPECT_LT(mesh->triangles.size(), 200'000u) << "larger hierarchies would be kept on the disk";
      EXPECT_EQ(2 * mesh->vertices_mm.size(), mesh->triangles.size() + 4) << "a closed surface";
      const Facets f = facets(*mesh, c.radius_mm, form);
      EXPECT_LT(f.rms, bound) << c.radius_mm;
      EXPECT_GT(f.rms, 0.5 * bound) << c.radius_mm;
      EXPECT_LT(std::abs(f.mean), 0.05 * bound) << c.radius_mm;
    }
  }
}

}  // namespace
}  // namespace fringetwin::study::sphere_form_test
