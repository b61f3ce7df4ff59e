// SPDX-License-Identifier: Apache-2.0
// Depths are smoothed as inverse depth 1/z over the pixel grid, in which a plane is linear whatever its tilt;
// vertices stay on the rays of their pixels.
#include "measure/surface.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "measure/fit/robust.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

constexpr double kSteepest = 6.0;        ///< depth over lateral step of neighbours on one surface
constexpr double kFilledFraction = 0.7;  ///< of the window that must be known to fill a missing pixel
constexpr int kQuadraticPoints = 10;     ///< fewest points for a quadratic, else a plane
constexpr int kPlanePoints = 5;

struct Offset {
  int dx, dy;
  double length;  ///< px
};

/// Returns the offsets of the pixels within this radius.
std::vector<Offset> disc(double radius_px) {
  std::vector<Offset> offsets;
  const int r = static_cast<int>(std::floor(radius_px));
  for (int dy = -r; dy <= r; ++dy)
    for (int dx = -r; dx <= r; ++dx)
      if (dx * dx + dy * dy <= radius_px * radius_px) offsets.push_back({dx, dy, std::hypot(dx, dy)});
  return offsets;
}

struct DepthMap {
  ImageD z_mm;  ///< depth along the optical axis, NaN = unknown
  ImageF sigma_mm;
  double step = 0.0;  ///< lateral step to the next pixel per mm of depth
  /// Returns whether the two depths, `pixels` apart, may lie on one surface.
  bool joined(double z0, double z1, double pixels, double sigma) const {
    return std::abs(z0 - z1) <= kSteepest * pixels * step * z0 + 6.0 * sigma;
  }
};

/// Returns the value at the centre of a weighted polynomial fit to (dx, dy, value); NaN when underdetermined.
template <int Terms>
double fit_at_centre(const std::vector<Offset>& at, const std::vector<double>& value, RobustLoss loss,
                     double smallest_scale) {
  using Vector = Eigen::Matrix<double, Terms, 1>;
  using Matrix = Eigen::Matrix<double, Terms, Terms>;
  const auto row = [](const Offset& o) {
    Vector v;
    const double x = o.dx, y = o.dy;
    if constexpr (Terms == 6)
      v << 1.0, x, y, x * x, x * y, y * y;
    else
      v << 1.0, x, y;
    return v;
  };
  std::vector<double> weight(at.size(), 1.0), residual(at.size());
  Vector solution = Vector::Zero();
  const int passes = loss == RobustLoss::none ? 1 : 3;
  for (int pass = 0; pass < passes; ++pass) {
    Matrix a = Matrix::Zero();
    Vector b = Vector::Zero();
    for (std::size_t k = 0; k < at.size(); ++k) {
      const Vector v = row(at[k]);
      a.noalias() += weight[k] * v * v.transpose();
      b += weight[k] * value[k] * v;
    }
    const Eigen::LDLT<Matrix> ldlt(a);
    if (ldlt.info() != Eigen::Success || !(ldlt.rcond() > 1e-8)) return std::nan("");
    solution = ldlt.solve(b);
    for (std::size_t k = 0; k < at.size(); ++k) residual[k] = value[k] - row(at[k]).dot(solution);
    std::vector<double> size = residual;
    const double scale = std::max(mad_sigma(size), smallest_scale);
    for (std::size_t k = 0; k < at.size(); ++k) weight[k] = robust_weight(loss, residual[k] / scale);
  }
  return solution[0];
}

/// Sorts the points into the camera's pixels as depths.
DepthMap make_depth_map(const Camera& camera, const PointCloud& cloud) {
  const int width = camera.lens.width(), height = camera.lens.height();
  DepthMap map{ImageD(width, height, std::nan("")), ImageF(width, height, 0.0f)};
  const Image<int> grid = point_grid(cloud, width, height);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const int k = grid.data[i];
    if (k < 0) continue;
    map.z_mm.data[i] = (camera.T_cam_world * cloud.p_world_mm[k]).z();
    if (!cloud.sigma_mm.empty()) map.sigma_mm.data[i] = cloud.sigma_mm[k];
  }
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
  const auto a = camera.lens.unproject({cx, cy}), b = camera.lens.unproject({cx + 1, cy});
  map.step = a && b ? (*a - *b).norm() : 1e-3;
  return map;
}

/// Returns the smoothed depth at a pixel, from a fit to the inverse depths of its surroundings on the same
/// surface. A pixel without a depth gets one when enough of its surroundings have one, else NaN. `at` and
/// `inverse_depth` are working memory.
double smoothed_depth(const DepthMap& map, const std::vector<Offset>& offsets, int x, int y,
                      std::vector<Offset>& at, std::vector<double>& inverse_depth) {
  double centre = map.z_mm(x, y), sigma = static_cast<double>(map.sigma_mm(x, y));
  const bool missing = !std::isfinite(centre);
  const auto inside = [&](int i, int j) {
    return i >= 0 && j >= 0 && i < map.z_mm.width && j < map.z_mm.height;
  };
  if (missing) {
    std::vector<double> around;
    for (const Offset& o : offsets)
      if (inside(x + o.dx, y + o.dy) && std::isfinite(map.z_mm(x + o.dx, y + o.dy)))
        around.push_back(map.z_mm(x + o.dx, y + o.dy));
    if (static_cast<double>(around.size()) < kFilledFraction * static_cast<double>(offsets.size()))
      return std::nan("");
    centre = upper_median(around);
  }
  at.clear();
  inverse_depth.clear();
  for (const Offset& o : offsets) {
    const int i = x + o.dx, j = y + o.dy;
    if (!inside(i, j)) continue;
    const double z = map.z_mm(i, j);
    if (missing) sigma = static_cast<double>(map.sigma_mm(std::clamp(i, 0, map.z_mm.width - 1), j));
    if (!std::isfinite(z) || !map.joined(centre, z, std::max(o.length, 1.0), sigma)) continue;
    at.push_back(o);
    inverse_depth.push_back(1.0 / z);
  }
  if (missing && static_cast<double>(at.size()) < kFilledFraction * static_cast<double>(offsets.size()))
    return std::nan("");
  const double rounding = 1e-12 / centre;
  double fitted = std::nan("");
  if (at.size() >= kQuadraticPoints)
    fitted = fit_at_centre<6>(at, inverse_depth, RobustLoss::tukey, rounding);
  if (!std::isfinite(fitted) && at.size() >= kPlanePoints)
    fitted = fit_at_centre<3>(at, inverse_depth, RobustLoss::none, rounding);
  // With too few neighbours to smooth, the depth stays as measured.
  if (!std::isfinite(fitted) || !(fitted > 0.0)) return missing ? std::nan("") : centre;
  return 1.0 / fitted;
}

DepthMap smooth(const DepthMap& map, double smoothing_px) {
  DepthMap out = map;
  const std::vector<Offset> offsets = disc(smoothing_px);
  if (offsets.size() < 2) return out;
#pragma omp parallel
  {
    std::vector<Offset> at;
    std::vector<double> inverse_depth;
#pragma omp for schedule(dynamic, 8)
    for (int y = 0; y < map.z_mm.height; ++y)
      for (int x = 0; x < map.z_mm.width; ++x)
        out.z_mm(x, y) = smoothed_depth(map, offsets, x, y, at, inverse_depth);
  }
  return out;
}

/// Adds the triangles of one pixel cell, counter-clockwise for the viewer: the normals face the camera.
void add_cell(const DepthMap& map, const Image<int>& vertex, int x, int y,
              std::vector<std::array<int, 3>>& triangles) {
  struct Corner {
    int id, x, y;
  };
  const Corner corners[4] = {{vertex(x, y), x, y},
                             {vertex(x, y + 1), x, y + 1},
                             {vertex(x + 1, y + 1), x + 1, y + 1},
                             {vertex(x + 1, y), x + 1, y}};
  const auto joined = [&](int i, int j) {
    const Corner &a = corners[i], &b = corners[j];
    return map.joined(map.z_mm(a.x, a.y), map.z_mm(b.x, b.y), std::hypot(a.x - b.x, a.y - b.y), 0.0);
  };
  const auto add = [&](int i, int j, int k) {
    if (corners[i].id < 0 || corners[j].id < 0 || corners[k].id < 0) return false;
    if (!joined(i, j) || !joined(j, k) || !joined(k, i)) return false;
    triangles.push_back({corners[i].id, corners[j].id, corners[k].id});
    return true;
  };
  const auto height = [&](int i) { return map.z_mm(corners[i].x, corners[i].y); };
  // the diagonal with the smaller depth difference follows creases; NaN compares false
  const bool diagonal_02 = !(std::abs(height(1) - height(3)) < std::abs(height(0) - height(2)));
  const bool first = diagonal_02 ? add(0, 1, 2) : add(0, 1, 3);
  const bool second = diagonal_02 ? add(0, 2, 3) : add(1, 2, 3);
  if (first || second) return;
  if (diagonal_02)  // three corners may be left along the other diagonal
    add(0, 1, 3) || add(1, 2, 3);
  else
    add(0, 1, 2) || add(0, 2, 3);
}

}  // namespace

std::shared_ptr<const Mesh> build_surface(const Twin& twin, std::size_t camera, const PointCloud& cloud,
                                          double smoothing_px) {
  FT_CHECK(camera < twin.cameras.size(), "camera index");
  if (!(smoothing_px >= 0.0) || smoothing_px > 50.0)
    throw UserError(ExitCode::usage, twin.file.string(), "smoothing_px must lie between 0 and 50");
  const Camera& cam = twin.cameras[camera];
  const DepthMap map = smooth(make_depth_map(cam, cloud), smoothing_px);
  const int width = map.z_mm.width, height = map.z_mm.height;
  auto mesh = std::make_shared<Mesh>();
  Image<int> vertex(width, height, -1);
  const Pose T_world_cam = cam.T_cam_world.inverse();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!std::isfinite(map.z_mm(x, y))) continue;
      const auto ray = cam.lens.unproject({static_cast<double>(x), static_cast<double>(y)});
      if (!ray || !(ray->z() > 0.0)) continue;
      vertex(x, y) = static_cast<int>(mesh->vertices_mm.size());
      mesh->vertices_mm.push_back((T_world_cam * (*ray * (map.z_mm(x, y) / ray->z()))).cast<float>());
    }
  for (int y = 0; y + 1 < height; ++y)
    for (int x = 0; x + 1 < width; ++x) add_cell(map, vertex, x, y, mesh->triangles);
  if (mesh->triangles.empty())
    throw UserError(ExitCode::input, twin.file.string(),
                    "the measured depth map has no two neighbouring points",
                    "check that the captures belong to this twin");
  mesh->vertex_normals = compute_vertex_normals(*mesh);
  return mesh;
}

double smoothing_leverage(double smoothing_px) {
  const std::vector<Offset> offsets = disc(smoothing_px);
  if (offsets.size() < static_cast<std::size_t>(kPlanePoints)) return 1.0;
  const bool quadratic = offsets.size() >= static_cast<std::size_t>(kQuadraticPoints);
  if (!quadratic) return 1.0 / static_cast<double>(offsets.size());  // a plane's centre is the mean
  double n = 0.0, xx = 0.0, xxxx = 0.0, xxyy = 0.0;
  for (const Offset& o : offsets) {
    const double x2 = o.dx * o.dx, y2 = o.dy * o.dy;
    n += 1.0, xx += x2, xxxx += x2 * x2, xxyy += x2 * y2;
  }
  // of 1, x^2 and y^2; the odd terms and xy are orthogonal to them
  Eigen::Matrix3d normal;
  normal << n, xx, xx, xx, xxxx, xxyy, xx, xxyy, xxxx;
  return normal.inverse()(0, 0);
}

}  // namespace fringetwin::measure
