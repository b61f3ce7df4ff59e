// SPDX-License-Identifier: Apache-2.0
#include "calib/solve/circle_bias.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "calib/board/board_plane.hpp"

namespace fringetwin::calib {
namespace {

/// Holds a node of the quadrature over the unit disc.
struct Node {
  double x, y, weight;
};

/// Returns the nodes of Gauss-Legendre in the squared radius times equally spaced angles: exact for
/// polynomials of degree 5 over the unit disc.
const std::array<Node, 24>& disc_nodes() {
  static const auto nodes = [] {
    std::array<Node, 24> out{};
    constexpr int kAngles = 8;
    const double half = 0.5 * std::sqrt(0.6);
    const std::array<std::array<double, 2>, 3> radial{
        {{0.5 - half, 5.0 / 18.0}, {0.5, 8.0 / 18.0}, {0.5 + half, 5.0 / 18.0}}};
    std::size_t k = 0;
    for (const auto& [squared, weight] : radial)
      for (int a = 0; a < kAngles; ++a) {
        const double angle = 2.0 * M_PI * (a + 0.5) / kAngles;
        out[k++] = {std::sqrt(squared) * std::cos(angle), std::sqrt(squared) * std::sin(angle),
                    weight / kAngles};
      }
    return out;
  }();
  return nodes;
}

std::vector<Lens> lenses_of(const MrcalProblem& p, const Observations& o) {
  std::vector<Lens> lenses;
  for (std::size_t d = 0; d < p.intrinsics.size(); ++d)
    lenses.emplace_back(p.lensmodel, p.intrinsics[d],
                        Eigen::Vector2i(p.imagersizes[d][0], p.imagersizes[d][1]), o.devices[d].name);
  return lenses;
}

/// Computes the corrections of one frame's corners from the lenses of the devices and their poses in it.
class Frame {
 public:
  Frame(const MrcalProblem& p, const Observations& o, const std::vector<Lens>& lenses, int frame,
        double radius_mm)
      : o_(o), lenses_(lenses), frame_(frame), radius_mm_(radius_mm), warp_mm_(p.warp_m / kMetresPerMm) {
    for (std::size_t d = 0; d < lenses.size(); ++d)
      T_device_board_.push_back(T_device_ref(p, static_cast<int>(d)) * T_ref_board(p, frame));
  }

  /// Returns by how much the observed position of a circle lies off the projection of its centre, px. A
  /// camera observes the centroid of the circle's image. A projector observes nothing: its position was read
  /// where the cameras saw the centroid, so the mean of the cameras' errors on the board is projected into
  /// it. nullopt where a lens does not project the circle, or no camera saw it.
  std::optional<Eigen::Vector2d> bias(int device, std::size_t corner) const {
    const Eigen::Vector3d center = o_.board.point_mm(corner, warp_mm_);
    const auto middle = lens(device).project(pose(device) * center);
    if (!middle) return std::nullopt;
    if (!o_.devices[device].is_projector) {
      const auto centroid = disc_centroid_px(lens(device), pose(device), center, radius_mm_);
      if (!centroid) return std::nullopt;
      return Eigen::Vector2d(*centroid - *middle);
    }
    const auto of_projector = board_gradient(lens(device), pose(device), center);
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weight = 0.0;
    for (std::size_t c = 0; c < o_.devices.size(); ++c) {
      const View* view = o_.find(static_cast<int>(c), frame_);
      if (o_.devices[c].is_projector || !view || !view->corners[corner].seen()) continue;
      const auto read = on_board_at_centroid(static_cast<int>(c), center);
      const auto q = read ? lens(device).project(pose(device) * *read) : std::nullopt;
      const auto of_camera = board_gradient(lens(static_cast<int>(c)), pose(static_cast<int>(c)), center);
      if (!q || !of_projector || !of_camera) continue;
      // The weights of mean_of_cameras(): a camera's noise reaches the projector by this Jacobian.
      const double w = 1.0 / (*of_projector * of_camera->inverse()).squaredNorm();
      sum += w * (*q - *middle);
      weight += w;
    }
    if (!(weight > 0.0)) return std::nullopt;
    return Eigen::Vector2d(sum / weight);
  }

 private:
  const Lens& lens(int device) const { return lenses_[device]; }
  const Pose& pose(int device) const { return T_device_board_[device]; }

  /// Returns the point of the board that a camera sees at the centroid of a circle's image.
  std::optional<Eigen::Vector3d> on_board_at_centroid(int camera, const Eigen::Vector3d& center) const {
    const auto centroid = disc_centroid_px(lens(camera), pose(camera), center, radius_mm_);
    const auto ray = centroid ? lens(camera).unproject(*centroid) : std::nullopt;
    if (!ray) return std::nullopt;
    const Pose T_board_device = pose(camera).inverse();
    const Eigen::Vector3d along = T_board_device.rotation * *ray, from = T_board_device.translation_mm;
    if (!(std::abs(along.z()) > 1e-9)) return std::nullopt;
    return Eigen::Vector3d(from + along * ((center.z() - from.z()) / along.z()));
  }

  const Observations& o_;
  const std::vector<Lens>& lenses_;
  int frame_;
  double radius_mm_;
  Eigen::Vector2d warp_mm_;
  std::vector<Pose> T_device_board_;
};

}  // namespace

std::optional<Eigen::Vector2d> disc_centroid_px(const Lens& lens, const Pose& T_device_board,
                                                const Eigen::Vector3d& center_mm, double radius_mm) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double area = 0.0;
  for (const Node& node : disc_nodes()) {
    const Eigen::Vector3d p = center_mm + radius_mm * Eigen::Vector3d(node.x, node.y, 0.0);
    Eigen::Vector2d q;
    const auto dq_dboard = board_gradient(lens, T_device_board, p, &q);
    if (!dq_dboard) return std::nullopt;
    const double share = node.weight * std::abs(dq_dboard->determinant());
    sum += share * q;
    area += share;
  }
  if (!(area > 0.0)) return std::nullopt;
  return Eigen::Vector2d(sum / area);
}

std::vector<Eigen::Vector3d> circle_centres(const MrcalProblem& p, const Observations& o,
                                            double diameter_mm) {
  const std::vector<Lens> lenses = lenses_of(p, o);
  const std::size_t per_view = p.corners_per_view();
  std::vector<Eigen::Vector3d> corners = solver_corners(o);
  for (std::size_t v = 0; v < o.views.size(); ++v) {
    const Frame frame(p, o, lenses, o.views[v].frame, 0.5 * diameter_mm);
    for (std::size_t i = 0; i < per_view; ++i) {
      Eigen::Vector3d& corner = corners[v * per_view + i];
      if (corner.z() <= 0.0) continue;
      if (const auto bias = frame.bias(o.views[v].device, i)) corner.head<2>() -= *bias;
    }
  }
  return corners;
}

}  // namespace fringetwin::calib
