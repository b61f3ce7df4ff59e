// SPDX-License-Identifier: Apache-2.0
#include "calib/solve/shared_noise.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "calib/board/board_plane.hpp"

namespace fringetwin::calib {
namespace {

/// A smaller share than this is what chance makes of some thousand independent residuals.
constexpr double kLeastShare = 0.1;

/// A camera's corner and how the projector's corner of the same place moves with it.
struct Link {
  std::size_t camera_corner = 0, projector_corner = 0;  ///< as in MrcalProblem::corners
  Eigen::Matrix2d dprojector_dcamera;                   ///< times the camera's share of the mean
};

class Links {
 public:
  explicit Links(const Calibration& c) : c_(c) {
    for (std::size_t d = 0; d < c.devices.size(); ++d) lenses_.push_back(c.lens(static_cast<int>(d)));
    for (std::size_t v = 0; v < c.observations.views.size(); ++v)
      if (is_projector(v))
        for (std::size_t i = 0; i < c.problem.corners_per_view(); ++i) add(v, i);
  }
  const std::vector<Link>& all() const { return links_; }

 private:
  bool is_projector(std::size_t view) const {
    return c_.observations.devices[c_.observations.views[view].device].is_projector;
  }
  std::size_t corner(std::size_t view, std::size_t i) const {
    return view * c_.problem.corners_per_view() + i;
  }
  bool is_used(std::size_t corner) const { return c_.problem.corners[corner].z() > 0.0; }

  /// Returns by how many px a view's picture of a place moves for each mm that the place moves on the board.
  std::optional<Eigen::Matrix2d> gradient(std::size_t view, std::size_t i) const {
    const View& v = c_.observations.views[view];
    const Pose T = T_device_ref(c_.problem, v.device) * T_ref_board(c_.problem, v.frame);
    return board_gradient(lenses_[v.device], T, c_.observations.board.point_mm(i, c_.warp_mm));
  }

  void add(std::size_t projector_view, std::size_t i) {
    if (!is_used(corner(projector_view, i))) return;
    const auto of_projector = gradient(projector_view, i);
    if (!of_projector) return;
    std::vector<Link> found;
    const int frame = c_.observations.views[projector_view].frame;
    for (std::size_t v = 0; v < c_.observations.views.size(); ++v) {
      if (c_.observations.views[v].frame != frame || is_projector(v) || !is_used(corner(v, i))) continue;
      const auto of_camera = gradient(v, i);
      if (!of_camera || !(std::abs(of_camera->determinant()) > 0.0)) continue;
      found.push_back(
          {corner(v, i), corner(projector_view, i), Eigen::Matrix2d(*of_projector * of_camera->inverse())});
    }
    // Readings are averaged by what they inherit (mean_of_cameras()).
    double sum = 0.0;
    for (const Link& link : found) sum += 1.0 / link.dprojector_dcamera.squaredNorm();
    for (Link& link : found) {
      link.dprojector_dcamera /= link.dprojector_dcamera.squaredNorm() * sum;
      links_.push_back(link);
    }
  }

  const Calibration& c_;
  std::vector<Lens> lenses_;
  std::vector<Link> links_;
};

struct Mean {
  double sum = 0.0, n = 0.0;
  void add(double value) { sum += value, n += 1.0; }
  double root() const { return n > 0.0 ? std::sqrt(sum / n) : 0.0; }
};

}  // namespace

SharedNoise shared_noise(const Calibration& c, const Eigen::VectorXd& residuals) {
  SharedNoise out;
  const std::vector<Link> links = Links(c).all();
  if (links.empty()) return out;
  const auto& corners = c.problem.corners;
  const auto residual = [&](std::size_t k) -> Eigen::Vector2d {
    return residuals.segment<2>(static_cast<Eigen::Index>(2 * k)) / corners[k].z();
  };
  // Per projector corner: what the cameras' residuals move it by.
  std::vector<Eigen::Vector2d> inherited(corners.size(), Eigen::Vector2d::Zero());
  std::vector<char> is_inheriting(corners.size(), 0);
  for (const Link& link : links) {
    inherited[link.projector_corner] += link.dprojector_dcamera * residual(link.camera_corner);
    is_inheriting[link.projector_corner] = 1;
  }
  double both = 0.0, own = 0.0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    if (!is_inheriting[k]) continue;
    const double weight = corners[k].z() * corners[k].z();
    both += weight * inherited[k].dot(residual(k));
    own += weight * inherited[k].squaredNorm();
  }
  out.share = own > 0.0 ? std::clamp(both / own, 0.0, 1.0) : 0.0;
  if (out.share < kLeastShare) {
    out.share = 0.0;
    return out;
  }

  Mean camera, projector;
  const std::size_t per_view = c.problem.corners_per_view();
  std::vector<char> of_projector(corners.size(), 0);
  for (std::size_t k = 0; k < corners.size(); ++k) {
    if (corners[k].z() <= 0.0) continue;
    const auto d = static_cast<std::size_t>(c.observations.views[k / per_view].device);
    of_projector[k] = c.observations.devices[d].is_projector;
    const Eigen::Vector2d r = corners[k].z() * (residual(k) - out.share * inherited[k]);
    for (const double value : r) (of_projector[k] ? projector : camera).add(value * value);
  }
  out.camera_sigma_px = camera.root();
  out.projector_sigma_px = projector.root();

  std::vector<Eigen::Triplet<double>> entries;
  const auto index = [](std::size_t corner, int axis) { return static_cast<int>(2 * corner) + axis; };
  for (std::size_t k = 0; k < corners.size(); ++k)
    for (int axis = 0; axis < 2 && corners[k].z() > 0.0; ++axis)
      entries.emplace_back(index(k, axis), index(k, axis),
                           of_projector[k] ? out.projector_sigma_px : out.camera_sigma_px);
  for (const Link& link : links) {
    // A camera's unit noise is camera_sigma_px / weight pixels.
    const double scale = out.share * out.camera_sigma_px * corners[link.projector_corner].z() /
                         corners[link.camera_corner].z();
    for (int row = 0; row < 2; ++row)
      for (int column = 0; column < 2; ++column)
        entries.emplace_back(index(link.projector_corner, row), index(link.camera_corner, column),
                             scale * link.dprojector_dcamera(row, column));
  }
  out.factor.resize(residuals.size(), static_cast<Eigen::Index>(2 * corners.size()));
  out.factor.setFromTriplets(entries.begin(), entries.end());
  return out;
}

}  // namespace fringetwin::calib
