// SPDX-License-Identifier: Apache-2.0
// Makes the corners that the paper's rig sees of boards, with noise. For *_test.cpp only.
#pragma once
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <random>
#include <vector>

#include "calib/board/corners_vnl.hpp"
#include "calib/solve/calibration.hpp"
#include "calib/solve/triangulate.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing {

struct TrueRig {
  std::vector<Lens> lenses;
  std::vector<Pose> T_device_ref;
  calib::Board board{10, 8, 12.0};
  Eigen::Vector2d warp_mm{0.15, -0.10};
};

inline TrueRig true_paper_rig() {
  const Twin twin = testing::paper_rig();
  TrueRig rig;
  for (const Camera& c : twin.cameras) {
    rig.lenses.push_back(c.lens);
    rig.T_device_ref.push_back(c.T_cam_world);
  }
  rig.lenses.push_back(twin.projector->lens);
  rig.T_device_ref.push_back(twin.projector->T_proj_world);
  return rig;
}

struct BoardDraw {
  int n_boards = 25;
  double sigma_px = 0.1;
  double least_z_mm = 230.0, largest_z_mm = 330.0;
  double largest_tilt_rad = 0.6, largest_roll_rad = 0.5;
  int least_corners = 80;  ///< seen in every device; fewer = partial views
};

/// Corners of boards at random poses, seen by all devices, with Gaussian noise; `poses`: of the boards.
inline calib::Observations draw_observations(const TrueRig& rig, std::mt19937_64& random,
                                             const BoardDraw& draw = {}, std::vector<Pose>* poses = nullptr) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::normal_distribution<double> noise(0.0, draw.sigma_px);
  calib::Observations o;
  o.board = rig.board;
  const char* names[] = {"left", "right", "projector"};
  for (std::size_t d = 0; d < rig.lenses.size(); ++d)
    o.devices.push_back({names[d], {rig.lenses[d].width(), rig.lenses[d].height()}, 2000.0, 1.0});
  const Eigen::Vector3d middle(0.5 * rig.board.width_mm(), 0.5 * rig.board.height_mm(), 0.0);
  while (static_cast<int>(o.frames.size()) < draw.n_boards) {
    const double z = draw.least_z_mm + (draw.largest_z_mm - draw.least_z_mm) * 0.5 * (unit(random) + 1.0);
    const Eigen::Vector3d center(0.15 * z * unit(random), 0.1 * z * unit(random), z);
    const Eigen::Matrix3d R =
        (Eigen::AngleAxisd(draw.largest_tilt_rad * unit(random), Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(0.35 + draw.largest_tilt_rad * unit(random), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(draw.largest_roll_rad * unit(random), Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
    const Pose T_ref_board{R, center - R * middle};
    std::vector<calib::View> views;
    for (std::size_t d = 0; d < rig.lenses.size(); ++d) {
      calib::View view{static_cast<int>(d), static_cast<int>(o.frames.size()), "", {}};
      for (std::size_t i = 0; i < rig.board.corners(); ++i) {
        const auto q =
            rig.lenses[d].project(rig.T_device_ref[d] * (T_ref_board * rig.board.point_mm(i, rig.warp_mm)));
        calib::Corner c;
        if (q && q->x() > 0 && q->y() > 0 && q->x() < rig.lenses[d].width() - 1 &&
            q->y() < rig.lenses[d].height() - 1)
          c = {*q + Eigen::Vector2d(noise(random), noise(random)), 1.0};
        view.corners.push_back(c);
      }
      if (view.n_seen() >= draw.least_corners) views.push_back(view);
    }
    if (views.size() < rig.lenses.size()) continue;
    if (poses) poses->push_back(T_ref_board);
    o.frames.push_back(std::to_string(o.frames.size()));
    o.views.insert(o.views.end(), views.begin(), views.end());
  }
  return o;
}

/// Returns the weight of what a camera reads of the projector at a place of the board: 1 / (projector px per
/// camera px)^2.
inline double reading_weight(const TrueRig& rig, std::size_t camera, const Pose& T_ref_board,
                             const Eigen::Vector3d& p_board_mm) {
  const auto gradient = [&](std::size_t d) -> Eigen::Matrix2d {
    const Pose T = rig.T_device_ref[d] * T_ref_board;
    Eigen::Matrix2d g;
    constexpr double kStepMm = 1e-3;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector3d step = kStepMm * Eigen::Vector3d::Unit(axis);
      g.col(axis) = (*rig.lenses[d].project(T * (p_board_mm + step)) -
                     *rig.lenses[d].project(T * (p_board_mm - step))) /
                    (2.0 * kStepMm);
    }
    return g;
  };
  return 1.0 / (gradient(2) * gradient(camera).inverse()).squaredNorm();
}

/// Returns points of the volume that all devices see.
inline std::vector<Eigen::Vector3d> volume(const TrueRig& rig) {
  std::vector<Eigen::Vector3d> points;
  for (const double z : {250.0, 280.0, 310.0})
    for (int i = -3; i <= 3; ++i)
      for (int j = -3; j <= 3; ++j) {
        const Eigen::Vector3d p(12.0 * i, 10.0 * j, z);
        bool seen = true;
        for (std::size_t d = 0; d < 3; ++d) {
          const auto q = rig.lenses[d].project(rig.T_device_ref[d] * p);
          seen = seen && q && q->minCoeff() > 0.0 && q->x() < rig.lenses[d].width() - 1 &&
                 q->y() < rig.lenses[d].height() - 1;
        }
        if (seen) points.push_back(p);
      }
  return points;
}

/// Returns the rms error of the shape that devices 0 and `other` measure, when the pixels are the true rig's.
inline double shape_error_mm(const TrueRig& rig, const calib::Calibration& c, std::size_t other) {
  const std::vector<Eigen::Vector3d> truth = volume(rig);
  std::vector<Eigen::Vector3d> measured;
  for (const auto& p : truth) {
    std::vector<Eigen::Vector2d> q;
    for (const std::size_t d : {std::size_t{0}, other})
      q.push_back(*rig.lenses[d].project(rig.T_device_ref[d] * p));
    measured.push_back(*calib::triangulate({c.lens(0), c.lens(static_cast<int>(other))},
                                           {Pose{}, c.devices[other].T_device_ref}, q, p));
  }
  return calib::aligned_rms_mm(measured, truth);
}

/// Returns the corners of each image, as a corners file names them: "left-007.png".
inline std::vector<calib::ImageCorners> image_corners(const calib::Observations& seen) {
  std::vector<calib::ImageCorners> images;
  for (const calib::View& view : seen.views)
    images.push_back({seen.devices[static_cast<std::size_t>(view.device)].name + "-" +
                          seen.frames[static_cast<std::size_t>(view.frame)] + ".png",
                      view.corners, 0});
  return images;
}

}  // namespace fringetwin::testing
