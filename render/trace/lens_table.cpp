// SPDX-License-Identifier: Apache-2.0
#include "render/trace/lens_table.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::render {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTolerancePx = 1e-6, kProjectorTolerancePx = 1e-5;
constexpr double kCoarsestPx = 32.0, kFinestPx = 1.0;
// Above the first error the user is warned (3e-5 rad at a pitch of 13 px), above the second nothing is
// rendered.
constexpr double kNoticedErrorPx = 1e-4, kRefusedErrorPx = 1e-2;
// So many nodes beyond the lens's domain get a value: as far as the stencil of a point inside can reach.
constexpr int kNodesBeyond = 4;

// A regular grid of 3-vectors over a rectangle, interpolated by 4-point Lagrange polynomials exactly
// as in shaders/camera.glsl.
struct NodeGrid {
  Vector2d first, spacing;
  int nx = 0, ny = 0;
  std::vector<Vector3d> values;

  Vector2d node(int i, int j) const { return first + Vector2d(i * spacing.x(), j * spacing.y()); }

  static Eigen::Vector4d weights(double s) {
    return {(-s * s * s + 3 * s * s - 2 * s) / 6, (s * s * s - 2 * s * s - s + 2) / 2,
            (-s * s * s + s * s + 2 * s) / 2, (s * s * s - s) / 6};
  }
  Vector3d operator()(const Vector2d& q) const {
    const Vector2d g = (q - first).cwiseQuotient(spacing);
    const int i = std::clamp(static_cast<int>(std::floor(g.x())), 1, nx - 3);
    const int j = std::clamp(static_cast<int>(std::floor(g.y())), 1, ny - 3);
    const Eigen::Vector4d wx = weights(g.x() - i), wy = weights(g.y() - j);
    Vector3d sum = Vector3d::Zero();
    for (int b = 0; b < 4; ++b)
      for (int a = 0; a < 4; ++a) sum += wy[b] * wx[a] * values[(j - 1 + b) * nx + i - 1 + a];
    return sum;
  }
};

// Makes a grid over [lo, hi] with about `wanted` spacing (at least 4 nodes each way).
template <class F>
NodeGrid make_grid(const Vector2d& lo, const Vector2d& hi, double wanted, F f) {
  NodeGrid grid;
  const Vector2d size = hi - lo;
  grid.nx = std::max(4, static_cast<int>(std::ceil(size.x() / wanted)) + 1);
  grid.ny = std::max(4, static_cast<int>(std::ceil(size.y() / wanted)) + 1);
  grid.first = lo;
  grid.spacing = size.cwiseQuotient(Vector2d(grid.nx - 1, grid.ny - 1));
  grid.values.resize(static_cast<std::size_t>(grid.nx) * grid.ny);
#pragma omp parallel for schedule(dynamic)
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i) grid.values[j * grid.nx + i] = f(grid.node(i, j));
  return grid;
}

// Returns the next value of the cubic (fewer than four: of the parabola, the line, the constant) through the
// values before it.
Vector3d extrapolate(const std::vector<Vector3d>& before) {
  switch (before.size()) {
    case 1:
      return before[0];
    case 2:
      return 2.0 * before[0] - before[1];
    case 3:
      return 3.0 * (before[0] - before[1]) + before[2];
    default:
      return 4.0 * (before[0] + before[2]) - 6.0 * before[1] - before[3];
  }
}

// Gives values to nodes outside the lens's domain: they continue the polynomials of those inside, so that
// points inside, whose stencils reach them, are interpolated as well as others. Farther ones stay NaN: no
// light there.
void continue_beyond_domain(NodeGrid* grid) {
  for (int ring = 0; ring < kNodesBeyond; ++ring) {
    const std::vector<Vector3d> known = grid->values;
    const auto value = [&](int i, int j) -> const Vector3d* {
      if (i < 0 || j < 0 || i >= grid->nx || j >= grid->ny) return nullptr;
      const Vector3d& v = known[j * grid->nx + i];
      return v.allFinite() ? &v : nullptr;
    };
    bool changed = false;
    for (int j = 0; j < grid->ny; ++j)
      for (int i = 0; i < grid->nx; ++i) {
        if (value(i, j)) continue;
        Vector3d sum = Vector3d::Zero();
        std::size_t most = 1;
        int n = 0;
        for (const auto& [di, dj] :
             {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}) {
          std::vector<Vector3d> before;
          for (int k = 1; k <= 4; ++k) {
            const Vector3d* v = value(i + k * di, j + k * dj);
            if (!v) break;
            before.push_back(*v);
          }
          if (before.size() < most) continue;
          if (before.size() > most) {  // a better order: forget the others
            most = before.size();
            sum.setZero();
            n = 0;
          }
          sum += extrapolate(before);
          ++n;
        }
        if (n == 0) continue;
        grid->values[j * grid->nx + i] = sum / n;
        changed = true;
      }
    if (!changed) return;
  }
}

// Returns the largest |interpolated - true| at the centres of cells, the worst places of a polynomial through
// the nodes; places outside the lens's domain do not count. Stops above `enough`.
template <class F>
double grid_error(const NodeGrid& grid, F f, double scale, double enough) {
  double worst = 0.0;
#pragma omp parallel for schedule(dynamic) reduction(max : worst)
  for (int j = 0; j < grid.ny - 1; ++j) {
    if (worst > enough) continue;
    for (int i = 0; i < grid.nx - 1; ++i) {
      const Vector2d q = grid.node(i, j) + 0.5 * grid.spacing;
      const Vector3d truth = f(q);
      if (!truth.allFinite()) continue;
      const double error = (grid(q) - truth).norm() * scale;
      worst = std::isfinite(error) ? std::max(worst, error) : std::numeric_limits<double>::infinity();
    }
  }
  return worst;
}

// Returns the coarsest grid over [lo, hi] that meets the tolerance; warns or throws where the finest does
// not.
template <class F>
NodeGrid refine_grid(const Lens& lens, const Vector2d& lo, const Vector2d& hi, double units_per_px, F value,
                     double error_scale, double tolerance, double* max_error_px, double* spacing_px) {
  for (double spacing = kCoarsestPx;; spacing *= 0.5) {
    NodeGrid grid = make_grid(lo, hi, spacing * units_per_px, value);
    continue_beyond_domain(&grid);
    const bool last = spacing <= kFinestPx;
    const double enough = last ? std::numeric_limits<double>::infinity() : tolerance;
    *max_error_px = grid_error(grid, value, error_scale, enough);
    *spacing_px = spacing;
    if (*max_error_px > tolerance && !last) continue;
    const std::string where = "lens " + lens.model();
    if (!(*max_error_px <= kRefusedErrorPx))
      throw UserError(ExitCode::usage, where,
                      fmt::format("it is too rough to render: a grid of {} px leaves {:.2g} px of error",
                                  kFinestPx, *max_error_px),
                      "recalibrate with fewer knots or distortion terms");
    if (*max_error_px > kNoticedErrorPx)
      warn(fmt::format("{}: rays are interpolated to {:.1e} px only", where, *max_error_px));
    return grid;
  }
}

Vector3d nan3() { return Vector3d::Constant(kNaN); }

// Converts a grid to what the shaders read.
void pack(const NodeGrid& grid, gpu::vec4* header, gpu::uvec4* n, std::vector<gpu::vec4>* nodes) {
  *header = {static_cast<float>(grid.first.x()), static_cast<float>(grid.first.y()),
             static_cast<float>(1.0 / grid.spacing.x()), static_cast<float>(1.0 / grid.spacing.y())};
  *n = {static_cast<gpu::uint>(grid.nx), static_cast<gpu::uint>(grid.ny), 0, 0};
  nodes->reserve(grid.values.size());
  for (const Vector3d& v : grid.values)
    nodes->push_back({static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), 0.0F});
}

// Finds for each block of pixels a cone that holds the rays of all its pixels.
void add_block_cones(const Lens& lens, LensTable* table) {
  table->blocks_x = (lens.width() + BLOCK_WIDTH - 1) / BLOCK_WIDTH;
  table->blocks_y = (lens.height() + BLOCK_HEIGHT - 1) / BLOCK_HEIGHT;
  table->block_cones.resize(static_cast<std::size_t>(table->blocks_x) * table->blocks_y);
#pragma omp parallel for schedule(dynamic)
  for (int by = 0; by < table->blocks_y; ++by)
    for (int bx = 0; bx < table->blocks_x; ++bx) {
      const Vector2d lo(bx * BLOCK_WIDTH - 0.5, by * BLOCK_HEIGHT - 0.5);
      const Vector2d hi(std::min((bx + 1) * BLOCK_WIDTH, lens.width()) - 0.5,
                        std::min((by + 1) * BLOCK_HEIGHT, lens.height()) - 0.5);
      const auto center = lens.unproject(0.5 * (lo + hi));
      double angle = center ? 0.0 : 4.0;  // unknown: never culled
      const Vector3d c = center.value_or(Vector3d::UnitZ());
      for (const Vector2d& corner : {lo, hi, Vector2d(lo.x(), hi.y()), Vector2d(hi.x(), lo.y())}) {
        const auto d = lens.unproject(corner);
        angle = d ? std::max(angle, std::atan2(c.cross(*d).norm(), c.dot(*d))) : 4.0;
      }
      // 10 % for the curvature of the block's outline under distortion.
      table->block_cones[by * table->blocks_x + bx] = {c.x(), c.y(), c.z(), 1.1 * angle};
    }
}

bool same_lens(const Lens& a, const Lens& b) {
  return a.model() == b.model() && a.intrinsics() == b.intrinsics() && a.width() == b.width() &&
         a.height() == b.height();
}

}  // namespace

LensTable make_lens_table(const Lens& lens) {
  LensTable table;
  add_block_cones(lens, &table);
  double fx = 1.0, fy = 1.0, cx = 0.0, cy = 0.0;
  double px_per_unit = lens.intrinsics().at(0);
  if (lens.is_perspective()) {
    fx = lens.intrinsics()[0];
    fy = lens.intrinsics()[1];
    cx = lens.intrinsics()[2];
    cy = lens.intrinsics()[3];
    px_per_unit = std::max(fx, fy);
    if (lens.model() == "LENSMODEL_PINHOLE" || lens.opencv_distortion().isZero(0.0)) {
      table.camera = {1.0 / fx, 1.0 / fy, cx, cy};
      return table;
    }
    table.kind = CAMERA_PERSPECTIVE;
  } else {
    table.kind = CAMERA_GENERAL;
  }
  table.camera = {1.0 / fx, 1.0 / fy, cx, cy};
  const auto value = [&](const Vector2d& q) -> Vector3d {
    const auto d = lens.unproject(q);
    if (!d) return nan3();
    if (!lens.is_perspective()) return *d;
    return {d->x() / d->z() - (q.x() - cx) / fx, d->y() / d->z() - (q.y() - cy) / fy, 0.0};
  };
  const Vector2d lo(-0.5, -0.5), hi(lens.width() - 0.5, lens.height() - 0.5);
  const NodeGrid grid = refine_grid(lens, lo, hi, 1.0, value, px_per_unit, kTolerancePx, &table.max_error_px,
                                    &table.spacing_px);
  pack(grid, &table.grid, &table.grid_n, &table.nodes);
  return table;
}

const LensTable& LensTableStore::get(const Lens& lens) {
  for (const auto& [known, table] : tables_)
    if (same_lens(known, lens)) return *table;
  tables_.emplace_back(lens, std::make_unique<LensTable>(make_lens_table(lens)));
  return *tables_.back().second;
}

ProjectorTable make_projector_table(const Lens& lens) {
  ProjectorTable table;
  const double w = lens.width(), h = lens.height();
  // The table is of the residual over the pinhole that fits at the image's centre.
  Vector2d lo = Vector2d::Constant(std::numeric_limits<double>::infinity()), hi = -lo;
  constexpr int kBorderPoints = 64;
  for (int i = 0; i <= kBorderPoints; ++i) {
    const double s = static_cast<double>(i) / kBorderPoints;
    for (const Vector2d& q : {Vector2d(s * w - 0.5, -0.5), Vector2d(s * w - 0.5, h - 0.5),
                              Vector2d(-0.5, s * h - 0.5), Vector2d(w - 0.5, s * h - 0.5)}) {
      const auto d = lens.unproject(q);
      if (!d || d->z() < 0.1 * d->norm())
        throw UserError(
            ExitCode::usage, "projector.model",
            "a " + lens.model() + " projector that reaches 84 degrees from its axis cannot be rendered",
            "use a perspective model (LENSMODEL_OPENCV8) or a narrower image");
      const Vector2d a(d->x() / d->z(), d->y() / d->z());
      lo = lo.cwiseMin(a);
      hi = hi.cwiseMax(a);
    }
  }
  const Vector2d margin = 0.02 * (hi - lo);
  lo -= margin;
  hi += margin;
  Eigen::Matrix<double, 2, 3> jacobian;
  const Vector2d middle = 0.5 * (lo + hi);
  const auto q_middle = lens.project(Vector3d(middle.x(), middle.y(), 1.0), &jacobian);
  FT_CHECK(q_middle.has_value(), "projector lens has no image of its own axis");
  table.fx = jacobian(0, 0);
  table.fy = jacobian(1, 1);
  table.cx = q_middle->x() - table.fx * middle.x();
  table.cy = q_middle->y() - table.fy * middle.y();
  const auto value = [&](const Vector2d& a) -> Vector3d {
    const auto q = lens.project(Vector3d(a.x(), a.y(), 1.0));
    if (!q) return nan3();
    return {q->x() - table.cx - table.fx * a.x(), q->y() - table.cy - table.fy * a.y(), 0.0};
  };
  const double px = 1.0 / std::max(table.fx, table.fy);
  double spacing_px = 0.0;
  const NodeGrid grid =
      refine_grid(lens, lo, hi, px, value, 1.0, kProjectorTolerancePx, &table.max_error_px, &spacing_px);
  pack(grid, &table.grid, &table.grid_n, &table.nodes);
  return table;
}

}  // namespace fringetwin::render
