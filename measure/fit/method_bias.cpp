// SPDX-License-Identifier: Apache-2.0
#include "measure/fit/method_bias.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "measure/fit/block_covariance.hpp"
#include "measure/fit/object_fits.hpp"
#include "measure/fit/shape_fits.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::measure {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostTerms = 5;
constexpr double kFewestKnown = 0.95;  ///< share of the points used that must have a noise-free one
/// Two neighbouring points of two cameras share pixels of the second image: alone each has the noise of one
/// pixel and (733/945)^2 of the other's, in a sum both count in full (docs/metrics/study.md, "Theory").
constexpr double kSharedPixels = 1.117;

using Derivatives = std::array<double, kMostTerms>;  ///< of a point's distance by the terms

// ---- the terms in which a fit errs: their keys (three of a vector have the same), the derivatives of a
// point's distance from the fitted surface by them, and the fit without its bias

std::vector<std::string> terms(const SphereShape&) {
  return {"center_mm", "center_mm", "center_mm", "radius_mm"};
}
std::vector<std::string> terms(const PlaneShape&) { return {"offset_mm", "tilt_rad_0", "tilt_rad_1"}; }
std::vector<std::string> terms(const CylinderShape&) {
  return {"axis_shift_mm_0", "axis_shift_mm_1", "axis_rad_0", "axis_rad_1", "radius_mm"};
}
std::vector<std::string> terms(const MeshShape&) { return {}; }
std::vector<std::string> terms(const MeasuredShape&) { return {}; }

Derivatives derivatives(const SphereShape&, const ObjectFit& fit, const Vector3d& p_mm) {
  const Vector3d out = (p_mm - fit.vectors.at("center_mm")).normalized();
  return {-out.x(), -out.y(), -out.z(), -1.0};
}
Derivatives derivatives(const PlaneShape&, const ObjectFit& fit, const Vector3d& p_mm) {
  const Vector3d d_mm = p_mm - fit.vectors.at("point_mm");
  return {-1.0, -d_mm.dot(fit.vectors.at("tilt_direction_0")), -d_mm.dot(fit.vectors.at("tilt_direction_1"))};
}
Derivatives derivatives(const CylinderShape&, const ObjectFit& fit, const Vector3d& p_mm) {
  const Vector3d d_mm = p_mm - fit.vectors.at("point_mm"), &axis = fit.vectors.at("axis");
  const double along_mm = axis.dot(d_mm);
  const Vector3d out = (d_mm - along_mm * axis).normalized();
  const double way_0 = out.dot(fit.vectors.at("tilt_direction_0")),
               way_1 = out.dot(fit.vectors.at("tilt_direction_1"));
  return {-way_0, -way_1, -along_mm * way_0, -along_mm * way_1, -1.0};
}
Derivatives derivatives(const MeshShape&, const ObjectFit&, const Vector3d&) { return {}; }
Derivatives derivatives(const MeasuredShape&, const ObjectFit&, const Vector3d&) { return {}; }

/// Returns the vector across a fit's normal or axis whose parts along its two directions these are.
Vector3d across(const ObjectFit& fit, double way_0, double way_1) {
  return way_0 * fit.vectors.at("tilt_direction_0") + way_1 * fit.vectors.at("tilt_direction_1");
}

void take_off(const SphereShape&, const Eigen::VectorXd& bias, ObjectFit& fit) {
  fit.vectors["center_mm"] -= bias.head<3>();
  fit.numbers["radius_mm"] -= bias[3];
}
void take_off(const PlaneShape&, const Eigen::VectorXd& bias, ObjectFit& fit) {
  Vector3d& normal = fit.vectors["normal"];
  fit.vectors["point_mm"] -= bias[0] * normal;
  normal = (normal + across(fit, bias[1], bias[2])).normalized();
}
void take_off(const CylinderShape&, const Eigen::VectorXd& bias, ObjectFit& fit) {
  fit.vectors["point_mm"] -= across(fit, bias[0], bias[1]);
  fit.vectors["axis"] = (fit.vectors["axis"] - across(fit, bias[2], bias[3])).normalized();
  fit.numbers["radius_mm"] -= bias[4];
}
void take_off(const MeshShape&, const Eigen::VectorXd&, ObjectFit&) {}
void take_off(const MeasuredShape&, const Eigen::VectorXd&, ObjectFit&) {}

// ---- sums over the points used ------------------------------------------------------------------------

/// One point that the fit used: how far it is from the fitted surface, and its noise-free one from the
/// nominal surface.
struct UsedPoint {
  Derivatives row;
  double measured_mm, noise_free_mm;
  Eigen::Vector2f q_px;
};

/// Returns the nominal surface without bounds, its normal on the fitted one's side; nullopt where it is no
/// formula.
std::optional<Shape> nominal_surface(const Object& object, const ObjectFit& fit) {
  const std::optional<ObjectFit> nominal = nominal_fit(object);
  if (!nominal) return std::nullopt;
  std::optional<Shape> shape =
      std::visit([&](const auto& s) { return fitted_shape(s, *nominal); }, object.shape);
  if (auto* plane = shape ? std::get_if<PlaneShape>(&*shape) : nullptr)
    if (plane->normal.dot(fit.vectors.at("normal")) < 0.0) plane->normal = -plane->normal;
  return shape;
}

std::vector<UsedPoint> used_points(const Object& object, double gate_mm, const Shape& nominal,
                                   const PointCloud& noise_free, const Image<int>& noise_free_at,
                                   const PointCloud& cloud, const ObjectFit& fit) {
  const Object unbounded{object.name, nominal, {}};
  std::vector<UsedPoint> used;
  for (std::size_t k = 0; k < fit.index.size(); ++k) {
    const std::size_t i = fit.index[k];
    const Eigen::Vector2f q = cloud.q_cam_px[i];
    const int j = noise_free_at(static_cast<int>(std::lround(q.x())), static_cast<int>(std::lround(q.y())));
    if (j < 0) continue;
    const double d_mm = surface_distance_mm(unbounded, noise_free.p_world_mm[j]);
    if (!(std::abs(d_mm) <= gate_mm)) continue;
    used.push_back(
        {std::visit([&](const auto& s) { return derivatives(s, fit, cloud.p_world_mm[i]); }, object.shape),
         static_cast<double>(fit.deviation_mm[k]), d_mm, q});
  }
  return used;
}

/// Returns (J^T J)^-1; empty where it is singular.
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& jtj) {
  const Eigen::VectorXd unit = jtj.diagonal().cwiseSqrt().cwiseInverse();
  if (!unit.allFinite()) return {};
  const SymmetricFactor factor(scaled_both_sides(jtj, unit));
  if (!(factor.rcond() > 1e-13)) return {};
  return scaled_both_sides(factor.inverse(), unit);
}

/// Returns the standard errors that the noise gives the terms: from the residuals less those that the
/// noise-free points leave at the same place. That of independent residuals, times `shared`, but where the
/// jackknife over G blocks is larger by twice what that scatters by, 1/sqrt(2 G).
Eigen::VectorXd noise_sigma(const std::vector<UsedPoint>& used, const Eigen::MatrixXd& inverse,
                            const Eigen::VectorXd& bias, double shared) {
  const auto m = static_cast<int>(bias.size());
  std::vector<Eigen::Vector2f> q_px;
  for (const UsedPoint& point : used) q_px.push_back(point.q_px);
  const std::vector<int> block = image_blocks(q_px);
  std::map<int, BlockSum> blocks;
  double sum_sq = 0.0;
  for (std::size_t k = 0; k < used.size(); ++k) {
    const Eigen::Map<const Eigen::VectorXd> row(used[k].row.data(), m);
    const double noise_mm = used[k].measured_mm - used[k].noise_free_mm - row.dot(bias);
    sum_sq += noise_mm * noise_mm;
    blocks.try_emplace(block[k], m).first->second.add(row.data(), noise_mm);
  }
  const Eigen::MatrixXd independent = sum_sq / (static_cast<double>(used.size()) - m) * inverse;
  const Eigen::VectorXd jackknife = block_covariance(blocks, independent).diagonal().cwiseSqrt(),
                        alone = shared * independent.diagonal().cwiseSqrt();
  const double correlated = 1.0 + std::sqrt(2.0 / static_cast<double>(blocks.size()));
  return (jackknife.array() > correlated * alone.array()).select(jackknife, alone);
}

/// Returns the key of a part of a term's standard error: "tilt_rad_0", "noise" -> "tilt_noise_sigma_rad_0".
std::string part_key(const std::string& term, const std::string& part) {
  return std::string(term).insert(std::min(term.rfind("_mm"), term.rfind("_rad")),
                                  (part.empty() ? "" : "_" + part) + "_sigma");
}

/// Writes the values of the terms under their keys, as `key` makes them of a term's.
template <class Key>
void write(const std::vector<std::string>& terms, const Eigen::VectorXd& values, const Key& key,
           std::map<std::string, double>& numbers, std::map<std::string, Vector3d>& vectors) {
  for (std::size_t k = 0; k < terms.size(); ++k)
    if (k + 1 < terms.size() && terms[k + 1] == terms[k]) {
      vectors[key(terms[k])] = values.segment<3>(static_cast<Eigen::Index>(k));
      k += 2;
    } else {
      numbers[key(terms[k])] = values[static_cast<Eigen::Index>(k)];
    }
}

/// Returns the standard errors that the fit has itself.
Eigen::VectorXd all_sigma(const std::vector<std::string>& terms, const ObjectFit& fit) {
  Eigen::VectorXd out(terms.size());
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const std::string key = part_key(terms[k], "");
    const auto number = fit.numbers.find(key);
    out[static_cast<Eigen::Index>(k)] =
        number != fit.numbers.end() ? number->second : fit.vectors.at(key)[static_cast<Eigen::Index>(k)];
  }
  return out;
}

void state_one(const Object& object, double gate_mm, bool correct, double shared,
               const PointCloud& noise_free, const Image<int>& noise_free_at, const PointCloud& cloud,
               ObjectFit& fit) {
  const std::vector<std::string> names =
      std::visit([](const auto& shape) { return terms(shape); }, object.shape);
  const std::optional<Shape> nominal = nominal_surface(object, fit);
  if (names.empty() || !nominal) return;
  const std::vector<UsedPoint> used =
      used_points(object, gate_mm, *nominal, noise_free, noise_free_at, cloud, fit);
  const auto m = static_cast<int>(names.size());
  if (used.size() <= names.size() ||
      static_cast<double>(used.size()) < kFewestKnown * static_cast<double>(fit.index.size()))
    return;
  BlockSum sum(m);
  for (const UsedPoint& point : used) sum.add(point.row.data(), point.noise_free_mm);
  const Eigen::MatrixXd inverse = inverse_of(sum.jtj);
  if (inverse.size() == 0) return;
  const Eigen::VectorXd bias = -(inverse * sum.jtr), noise = noise_sigma(used, inverse, bias, shared);
  const Eigen::VectorXd all = all_sigma(names, fit);
  write(
      names, bias, [](const std::string& term) { return term; }, fit.bias, fit.bias_vectors);
  const auto put_sigma = [&](const std::string& part, const Eigen::VectorXd& sigma) {
    write(
        names, sigma, [&part](const std::string& term) { return part_key(term, part); }, fit.numbers,
        fit.vectors);
  };
  put_sigma("noise", noise);
  put_sigma("form", (all.array().square() - noise.array().square()).max(0.0).sqrt());
  put_sigma("", all.cwiseMax(noise));
  if (correct) std::visit([&](const auto& shape) { take_off(shape, bias, fit); }, object.shape);
}

}  // namespace

void state_method_bias(const Twin& twin, const PointCloud& noise_free, const PointCloud& cloud,
                       std::vector<ObjectFit>& fits) {
  const Lens& lens = twin.cameras.front().lens;
  const Image<int> noise_free_at = point_grid(noise_free, lens.width(), lens.height());
  const double shared = twin.triangulate() == Triangulate::stereo ? kSharedPixels : 1.0;
  for (std::size_t k = 0; k < fits.size(); ++k)
    if (const Object* object = twin.find_object(fits[k].object); object && fits[k].usable)
      state_one(*object, twin.measure.fits[k].gate_mm, twin.measure.correct_pixel_area, shared, noise_free,
                noise_free_at, cloud, fits[k]);
}

}  // namespace fringetwin::measure
