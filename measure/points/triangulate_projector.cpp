// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <utility>

#include "measure/points/depth_solver.hpp"
#include "measure/points/point_rows.hpp"
#include "measure/points/points.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/stopwatch.hpp"

namespace fringetwin::measure {
namespace {

/// Light cannot come from outside the projector's image; this margin allows for calibration errors.
constexpr double kOutsideImageFraction = 0.05;
constexpr double kMostRelativeSigma = 0.05;

struct Setup {
  const Camera& camera;
  const Projector& projector;
  Pose T_proj_cam;
  const DirectionDecode* directions[2] = {nullptr, nullptr};
  int axes[2] = {0, 1};
  int count = 0;
};

/// Returns the depth at which the ray meets the plane of one projector coordinate, lens distortion taken at
/// the image's middle: a start for Newton.
double start_depth(const Setup& setup, const Eigen::Vector3d& d_cam, double coordinate_px) {
  const Lens& lens = setup.projector.lens;
  const int axis = setup.axes[0];
  Eigen::Vector2d q(0.5 * (lens.width() - 1), 0.5 * (lens.height() - 1));
  q[axis] = coordinate_px;
  const auto ray = lens.unproject(q);
  if (!ray) return -1.0;
  const double slope = (*ray)[axis] / ray->z();
  const Eigen::Vector3d d = setup.T_proj_cam.rotation * d_cam;
  const Eigen::Vector3d& t = setup.T_proj_cam.translation_mm;
  return (slope * t.z() - t[axis]) / (d[axis] - slope * d.z());
}

bool inside_projector(const Lens& lens, const Eigen::Vector2d& q) {
  const double mx = kOutsideImageFraction * lens.width(), my = kOutsideImageFraction * lens.height();
  return q.x() >= -0.5 - mx && q.y() >= -0.5 - my && q.x() <= lens.width() - 0.5 + mx &&
         q.y() <= lens.height() - 0.5 + my;
}

void triangulate_row(const Setup& setup, int y, PointRow& row) {
  double last_depth = -1.0;
  const int width = setup.directions[0]->coordinate_px.width;
  for (int x = 0; x < width; ++x) {
    CoordinateTarget targets[2];
    bool valid = true;
    for (int k = 0; k < setup.count; ++k) {
      targets[k].coordinate_px = setup.directions[k]->coordinate_px(x, y);
      targets[k].sigma_px = coordinate_sigma(*setup.directions[k], x, y);
      valid &= std::isfinite(targets[k].coordinate_px);
    }
    if (!valid) continue;
    ++row.summary.n_candidates;
    const Eigen::Vector2d pixel(x, y);
    const auto d = setup.camera.lens.unproject(pixel);
    DepthSolution solution;
    bool solved = false;
    // the neighbour's depth, else the plane of the coordinate
    for (const bool warm : {true, false}) {
      if (!d || solved) break;
      const double start = warm ? last_depth : start_depth(setup, *d, targets[0].coordinate_px);
      if (!(start > 0.0)) continue;
      solved = solve_depth_in_projector(setup.projector.lens, setup.T_proj_cam, *d, setup.axes, targets,
                                        setup.count, start, solution) == SolveStatus::ok;
    }
    const bool meets = solved && inside_projector(setup.projector.lens, solution.q_px);
    const bool is_certain = solution.sigma_mm <= kMostRelativeSigma * solution.depth_mm;
    if (!meets || !is_certain) {
      ++row.summary.n_rejected;
      row.summary.n_too_uncertain += meets ? 1 : 0;
      continue;
    }
    last_depth = solution.depth_mm;
    row.add(pixel, solution.depth_mm * *d, solution.sigma_mm, solution.residual_px);
  }
}

}  // namespace

PointCloud triangulate_projector(const Twin& twin, std::size_t camera, const CameraDecode& decode,
                                 TriangulationSummary* summary) {
  FT_CHECK(camera < twin.cameras.size(), "camera index");
  if (!twin.projector)
    throw UserError(ExitCode::usage, twin.file.string(),
                    "triangulation with the projector needs a [projector]",
                    "give its model, or use two cameras and triangulate = \"stereo\"");
  const Camera& cam = twin.cameras[camera];
  Setup setup{cam, *twin.projector, twin.projector->T_proj_world * cam.T_cam_world.inverse()};
  for (const Axis axis : {Axis::x, Axis::y})
    if (const DirectionDecode* direction = decode.direction(axis)) {
      setup.directions[setup.count] = direction;
      setup.axes[setup.count++] = axis == Axis::x ? 0 : 1;
    }
  if (setup.count == 0)
    throw UserError(ExitCode::usage, twin.file.string(), "no fringe direction was decoded",
                    "check [fringes]");
  std::vector<PointRow> rows(decode.height());
  const Stopwatch watch;
#pragma omp parallel for schedule(dynamic, 8)
  for (int y = 0; y < decode.height(); ++y) triangulate_row(setup, y, rows[y]);
  const double match_s = watch.elapsed().wall_s;
  PointCloud cloud = join_rows(std::move(rows), cam.T_cam_world.inverse(), summary);
  if (summary) summary->match_s = match_s;
  return cloud;
}

}  // namespace fringetwin::measure
