// SPDX-License-Identifier: Apache-2.0
#include "compare/geometry/published_sigma.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "compare/result/fit_keys.hpp"

namespace fringetwin::compare {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using measure::ObjectFit;

constexpr std::size_t kParameters = 4;

/// Returns the standard errors of center and radius, from s^2 (J^T J)^-1 with s^2 = n rms^2 / (n - 4); NaN
/// when the points determine no sphere.
Vector4d sphere_sigma_mm(const measure::PointCloud& cloud, const std::vector<std::size_t>& index,
                         const Vector3d& center_mm, double rms_mm) {
  const Vector4d unknown = Vector4d::Constant(kNaN);
  if (index.size() <= kParameters) return unknown;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  for (const std::size_t i : index) {
    Vector4d row;  // of |p - center| - radius, up to its sign
    row << (cloud.p_world_mm[i] - center_mm).normalized(), 1.0;
    normal += row * row.transpose();
  }
  const Eigen::LLT<Eigen::Matrix4d> factor(normal);
  if (factor.info() != Eigen::Success) return unknown;
  const auto n = static_cast<double>(index.size());
  const Vector4d variance = factor.solve(Eigen::Matrix4d::Identity()).diagonal();
  return rms_mm * std::sqrt(n / (n - static_cast<double>(kParameters))) * variance.cwiseSqrt();
}

void estimate_radius(const ObjectFit& s, double real_sigma_mm, FitRow& row) {
  const double sigma_mm = std::hypot(value_or(s.numbers, "radius_sigma_mm", kNaN), real_sigma_mm);
  const auto difference = row.difference.find("radius_mm");
  if (row.z.contains("radius_mm") || difference == row.difference.end() || !(sigma_mm > 0.0)) return;
  row.real_sigma_estimated["radius_sigma_mm"] = real_sigma_mm;
  row.z_estimated["radius_mm"] = difference->second / sigma_mm;
}

void estimate_center(const ObjectFit& s, const Vector3d& real_sigma_mm, FitRow& row) {
  const auto sigma_s = s.vectors.find("center_sigma_mm");
  const auto difference = row.difference_vectors.find("center_mm");
  if (row.z_vectors.contains("center_mm") || sigma_s == s.vectors.end() ||
      difference == row.difference_vectors.end())
    return;
  Vector3d z;
  for (int i = 0; i < 3; ++i) z[i] = difference->second[i] / std::hypot(sigma_s->second[i], real_sigma_mm[i]);
  if (!z.allFinite()) return;
  row.real_sigma_estimated_vectors["center_sigma_mm"] = real_sigma_mm;
  row.z_estimated_vectors["center_mm"] = z;
}

}  // namespace

void estimate_published_z(const measure::PointCloud& simulated, FitRow& row) {
  if (row.kind != "sphere" || !row.simulated || !row.real || !row.simulated->usable) return;
  const double rms_mm = value_or(row.real->numbers, "rms_mm", kNaN);
  const auto center = row.simulated->vectors.find("center_mm");
  if (!(rms_mm > 0.0) || center == row.simulated->vectors.end()) return;
  const Vector4d sigma_mm = sphere_sigma_mm(simulated, row.simulated->index, center->second, rms_mm);
  estimate_radius(*row.simulated, sigma_mm[3], row);
  estimate_center(*row.simulated, sigma_mm.head<3>(), row);
}

}  // namespace fringetwin::compare
