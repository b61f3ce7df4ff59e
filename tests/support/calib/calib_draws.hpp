// SPDX-License-Identifier: Apache-2.0
// Makes many calibrations of the paper's rig (25 boards), each from its own draw of the corners' noise, and
// checks whether what comes out scatters as a covariance says. For *_test.cpp only.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "calib/solve/calibrate.hpp"
#include "tests/support/calib/calib_rig.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::testing {

/// The two ways in which the projector's corners come about.
enum class ProjectorCorners { measured_by_itself, read_at_the_cameras_corners };

class CalibrationDraws {
 public:
  explicit CalibrationDraws(ProjectorCorners kind) : kind_(kind) {
    BoardDraw draw;
    draw.sigma_px = 0.0;
    exact_ = draw_observations(rig_, random_, draw, &boards_);
    exact_.devices[2].is_projector = true;
    calib::CalibrateOptions options;
    options.regularize = options.reject_outliers = false;
    options.estimate_sigmas = kind == ProjectorCorners::read_at_the_cameras_corners;
    first_ = calib::calibrate(noisy(), options);
  }
  const TrueRig& rig() const { return rig_; }
  /// Solved from the first draw, with the estimates of covariance that a user gets.
  const calib::Calibration& first() const { return first_; }

  calib::Calibration next() {
    calib::Calibration c = first_;
    calib::Observations o = noisy();
    for (std::size_t d = 0; d < 3; ++d) o.devices[d].sigma_px = first_.observations.devices[d].sigma_px;
    calib::Seed truth{c.problem.lensmodel, {}, rig_.T_device_ref, boards_};
    for (const Lens& lens : rig_.lenses) truth.intrinsics.push_back(lens.intrinsics());
    c.problem = calib::make_problem(o, truth);
    c.problem.warp_m = calib::kMetresPerMm * rig_.warp_mm;
    c.problem.regularize = false;
    mrcal_solve(c.problem);
    for (std::size_t d = 0; d < 3; ++d) {
      c.devices[d].intrinsics = c.problem.intrinsics[d];
      c.devices[d].T_device_ref = calib::T_device_ref(c.problem, static_cast<int>(d));
    }
    return c;
  }

  /// Returns where the boards of this calibration carry a point: what turns and shifts the whole rig is no
  /// error.
  Eigen::Vector3d carried_mm(const calib::Calibration& c, const Eigen::Vector3d& p_mm) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t f = 0; f < boards_.size(); ++f)
      sum += calib::T_ref_board(c.problem, static_cast<int>(f)) * (boards_[f].inverse() * p_mm);
    return sum / static_cast<double>(boards_.size());
  }

  /// Points whose pixels are the true ones, as this calibration's first and `other` device put them.
  std::vector<Eigen::Vector3d> measured_mm(const calib::Calibration& c, int other,
                                           const std::vector<Eigen::Vector3d>& p_mm) const {
    const std::vector<Lens> lenses{c.lens(0), c.lens(other)};
    const auto k = static_cast<std::size_t>(other);
    const std::vector<Pose> poses{Pose{}, c.devices[k].T_device_ref};
    std::vector<Eigen::Vector3d> out;
    for (const auto& p : p_mm)
      out.push_back(*calib::triangulate(
          lenses, poses, {*rig_.lenses[0].project(p), *rig_.lenses[k].project(rig_.T_device_ref[k] * p)}, p));
    return out;
  }

 private:
  calib::Observations noisy() {
    std::normal_distribution<double> camera(0.0, 0.1), own(0.0, 0.02);
    calib::Observations o = exact_;
    for (calib::View& view : o.views)
      if (view.device < 2 || kind_ == ProjectorCorners::measured_by_itself)
        for (calib::Corner& c : view.corners) c.q_px += Eigen::Vector2d(camera(random_), camera(random_));
    if (kind_ == ProjectorCorners::measured_by_itself) return o;
    for (calib::View& view : o.views) {
      if (view.device != 2) continue;
      for (std::size_t i = 0; i < view.corners.size(); ++i) {
        Eigen::Vector2d read = Eigen::Vector2d::Zero();
        double weight = 0.0;
        for (int d = 0; d < 2; ++d) {
          const double w =
              reading_weight(rig_, static_cast<std::size_t>(d), boards_[static_cast<std::size_t>(view.frame)],
                             rig_.board.point_mm(i, rig_.warp_mm));
          read += w * projected_at(d, view.frame, i, o.find(d, view.frame)->corners[i].q_px);
          weight += w;
        }
        view.corners[i].q_px = read / weight + Eigen::Vector2d(own(random_), own(random_));
        view.corners[i].weight = std::min(1.0, std::sqrt(weight));
      }
    }
    return o;
  }

  /// The projector's pixel on the board where a camera's pixel sees it.
  Eigen::Vector2d projected_at(int camera, int frame, std::size_t corner, const Eigen::Vector2d& q) const {
    const auto k = static_cast<std::size_t>(camera);
    const Pose& T_world_board = boards_[static_cast<std::size_t>(frame)];
    const Pose back = (rig_.T_device_ref[k] * T_world_board).inverse();
    const Eigen::Vector3d along = back.rotation * *rig_.lenses[k].unproject(q);
    const double z = rig_.board.point_mm(corner, rig_.warp_mm).z();
    const Eigen::Vector3d p = back.translation_mm + along * ((z - back.translation_mm.z()) / along.z());
    return *rig_.lenses[2].project(rig_.T_device_ref[2] * (T_world_board * p));
  }

  ProjectorCorners kind_;
  TrueRig rig_ = true_paper_rig();
  std::mt19937_64 random_{77};
  std::vector<Pose> boards_;
  calib::Observations exact_;
  calib::Calibration first_;
};

/// Deviations that should have this covariance.
struct Scatter {
  Eigen::MatrixXd covariance;
  double chi2 = 0.0, n = 0.0;
  int draws = 0;
  Eigen::VectorXd sum_sq;
  explicit Scatter(const Eigen::MatrixXd& m) : covariance(m), sum_sq(Eigen::VectorXd::Zero(m.rows())) {}
  void add(const Eigen::VectorXd& v) {
    const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
    const Eigen::VectorXd scaled = scale.asDiagonal() * v;
    chi2 += scaled.dot(Eigen::VectorXd(solve_symmetric(correlation, scaled)));
    n += static_cast<double>(v.size());
    ++draws;
    sum_sq += v.cwiseAbs2();
  }
  void expect_as_predicted(const char* what) const {
    const double per_number = chi2 / n;
    std::printf("%s: chi2 %.1f of %.0f numbers; rms / sigma", what, chi2, n);
    EXPECT_NEAR(per_number, 1.0, 3.0 * std::sqrt(2.0 / n) + 0.03) << what;
    for (Eigen::Index i = 0; i < sum_sq.size(); ++i) {
      const double ratio = std::sqrt(sum_sq[i] / draws / covariance(i, i));
      std::printf(" %.2f", ratio);
      if (sum_sq.size() <= 4) {
        EXPECT_NEAR(ratio, 1.0, 3.0 / std::sqrt(2.0 * draws)) << what << " " << i;
      }
    }
    std::printf("\n");
  }
};

}  // namespace fringetwin::testing
