// SPDX-License-Identifier: Apache-2.0
// Triangulates: decoded cameras become points in the world frame, mm.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "measure/decode/decode.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure {

/// Structure of arrays; all vectors have the same length.
struct PointCloud {
  std::vector<Eigen::Vector3d> p_world_mm;
  std::vector<Eigen::Vector3f> normal_world;  ///< unit, towards the first camera; NaN when unknown
  std::vector<Eigen::Vector2f> q_cam_px;      ///< source pixel in the first camera
  std::vector<float> sigma_mm;                ///< standard deviation along the viewing ray (phase noise)
  std::size_t size() const { return p_world_mm.size(); }
};

/// Returns the index of the point of each pixel, -1 where there is none. Points outside the image are left
/// out.
inline Image<int> point_grid(const PointCloud& cloud, int width_px, int height_px) {
  Image<int> grid(width_px, height_px, -1);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const long x = std::lround(cloud.q_cam_px[i].x()), y = std::lround(cloud.q_cam_px[i].y());
    if (x < 0 || y < 0 || x >= width_px || y >= height_px) continue;
    grid(static_cast<int>(x), static_cast<int>(y)) = static_cast<int>(i);
  }
  return grid;
}

struct TriangulationSummary {
  std::size_t n_candidates = 0;  ///< valid pixels of the first camera that were tried
  std::size_t n_points = 0;
  /// Nothing of that coordinate in the second image, or a place that does not see the pixel's surface
  /// (hidden_matches.hpp).
  std::size_t n_no_match = 0;
  std::size_t n_ambiguous = 0;  ///< several matches; decided by the neighbours, else not among n_points
  std::size_t n_rejected = 0;   ///< no convergence, depth jump, absurd angle or sigma, isolated
  /// Of n_rejected: those whose rays meet with too large a sigma alone, and those isolated among such.
  std::size_t n_too_uncertain = 0;
  std::size_t n_mixed = 0;       ///< border pixels of the cameras used that were not tried (mixed_pixels.hpp)
  double match_s = 0.0;          ///< wall time of finding the depths: stereo match, or projector intersection
  double residual_rms_px = 0.0;  ///< disagreement of the two directions; 0 with one direction
};

/// Returns how many pixels have a match: each has a point or was rejected. With a projector all candidates.
inline std::size_t matched_pixels(const TriangulationSummary& summary) {
  return summary.n_candidates - summary.n_no_match;
}
/// Returns how many pixels with a match tell whether the rays meet: what is too uncertain tells nothing.
inline std::size_t judged_pixels(const TriangulationSummary& summary) {
  return matched_pixels(summary) - summary.n_too_uncertain;
}
/// Returns how many of them were rejected: their rays give no point.
inline std::size_t missing_pixels(const TriangulationSummary& summary) {
  return summary.n_rejected - summary.n_too_uncertain;
}
/// Returns the share of the judged pixels that were rejected; 0 without any.
inline double rejected_share(const TriangulationSummary& summary) {
  const std::size_t judged = judged_pixels(summary);
  return judged == 0 ? 0.0 : static_cast<double>(missing_pixels(summary)) / static_cast<double>(judged);
}
/// What a few pixels say is an accident: noise that looks like fringes has matches, too.
inline constexpr std::size_t kFewestJudgedPixels = 500;
/// Returns whether more than half were, of enough to tell: of right twins a few percent are, at steps of the
/// depth and where the rays hardly cross, and neither noise nor steps do more.
inline bool mostly_rejected(const TriangulationSummary& summary) {
  return judged_pixels(summary) >= kFewestJudgedPixels && rejected_share(summary) > 0.5;
}

/// Triangulates two cameras: left pixel <-> right sub-pixel position of equal absolute coordinate on the
/// epipolar curve of the DISTORTED right image (bicubic interpolation of the coordinate map, Newton along the
/// curve), then the midpoint-free two-ray triangulation. Cameras 0 and 1 of the twin.
PointCloud triangulate_stereo(const Twin& twin, const CameraDecode& left, const CameraDecode& right,
                              TriangulationSummary* summary = nullptr);
/// Triangulates a camera and the projector: camera ray x projector column surface (distorted projector),
/// least squares when both directions.
PointCloud triangulate_projector(const Twin& twin, std::size_t camera, const CameraDecode& decode,
                                 TriangulationSummary* summary = nullptr);

/// Estimates normals by local plane fits over the source-pixel grid.
void estimate_normals(PointCloud& cloud, int width_px, int height_px, const Eigen::Vector3d& viewer_mm);

}  // namespace fringetwin::measure
