// SPDX-License-Identifier: Apache-2.0
// Rigs, meshes and schoolbook formulas (single precision) of the hard cases.
#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "render/reference/reference.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing {

// ---- rigs

/// Pinhole camera (principal point at the centre pixel) at the origin and a pinhole projector
/// `baseline_mm` to its right, axes parallel; vertical fringes of 13/14/15 px.
Twin bench_rig(double camera_f_px = 1000.0, int width = 201, int height = 181, double baseline_mm = 40.0);
/// All lengths of the rig times k (cameras and projector; not the objects): the same images at k times
/// the size.
Twin scaled(Twin rig, double k);
/// Every camera with a lens `factor` times as long, its image centred on a world point.
Twin zoomed(Twin rig, const Eigen::Vector3d& point_world_mm, double factor, int width, int height);
/// The world's origin elsewhere: T_new_old maps old world points to new ones. Spheres and planes move along.
Twin moved(Twin twin, const Pose& T_new_old);

// ---- meshes

/// Height field z = height(x, y) over a grid of nx x ny cells with two triangles each.
Mesh height_field(double x0, double y0, double dx, double dy, int nx, int ny,
                  const std::function<double(double, double)>& height);
/// A mesh whose vertices lie on the rays through the pixels (x, y) = offset + integer of a pinhole
/// camera at the origin, in the object frame of `T_cam_object`: every pixel's centre ray meets a vertex
/// (offset 0) or an edge (offset 0.5), to the rounding of the vertices.
Mesh aimed_sheet(const Lens& lens, const Eigen::Vector2d& offset_px, double z_mm, double bump_mm,
                 const Pose& T_cam_object);
MeshShape as_shape(Mesh mesh, const Pose& T_world_object = {}, bool smooth = false);
Pose random_pose(unsigned seed, const Eigen::Vector3d& translation_mm);

// ---- schoolbook, single precision

/// -b - sqrt(b^2 - 4ac) over 2a.
std::optional<float> schoolbook_sphere(const Eigen::Vector3f& o, const Eigen::Vector3f& d,
                                       const Eigen::Vector3f& center, float radius);
/// Moeller and Trumbore, J. Graphics Tools 2(1), 1997: edges from the first vertex of each triangle.
std::optional<float> moeller_trumbore(const Eigen::Vector3f& o, const Eigen::Vector3f& d,
                                      const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                                      const Eigen::Vector3f& c);
/// Consistent edge functions in space, d . (b - a) x (b + a), as in Embree's robust mode: the sign of an edge
/// is the same for both its triangles, but the signs around a vertex need not fit together.
bool pluecker_edges(const Eigen::Vector3f& o, const Eigen::Vector3f& d, const Eigen::Vector3f& a,
                    const Eigen::Vector3f& b, const Eigen::Vector3f& c);
/// The test of shaders/mesh.glsl in the same single precision (after Woop, Benthin and Wald, JCGT 2(1),
/// 2013).
bool projected_edges(const Eigen::Vector3f& o, const Eigen::Vector3f& d, const Eigen::Vector3f& a,
                     const Eigen::Vector3f& b, const Eigen::Vector3f& c);

// ---- measuring

/// Rms and maximum phase error at the finest pitch over pixel centres of a block, where `hit` gives the
/// distance along the unit ray (world origin = camera centre) instead of the renderer.
struct PointError {
  int n = 0, missed = 0;
  double rms_rad = 0.0, max_rad = 0.0;
};
PointError point_error(
    const render::Reference& reference, std::size_t camera, const PixelBlock& block,
    const std::function<std::optional<double>(const Eigen::Vector3d& direction_world)>& hit);

/// One line for docs/HARD_CASES.md.
void report(const std::string& what, const std::string& schoolbook, const std::string& ours);

}  // namespace fringetwin::testing
