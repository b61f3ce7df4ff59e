// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "calib/solve/seed.hpp"
#include "twin/base/out_of_memory.hpp"

namespace fringetwin::calib {

namespace {

constexpr double kLargestTan = 3.7;  // tan 75 degrees

Pose to_pose(const cv::Mat& r, const cv::Mat& t) {
  RotTrans rt;
  for (int i = 0; i < 3; ++i) {
    rt[i] = r.at<double>(i);
    rt[3 + i] = t.at<double>(i);
  }
  return pose_from_rt(rt);
}

/// Returns the rms distance between the board's points, projected to x/z and y/z, and `seen`; infinite when a
/// point lies behind the device.
double rms_of(const Pose& T, const std::vector<cv::Point3d>& board, const std::vector<cv::Point2d>& seen) {
  double sum = 0.0;
  for (std::size_t i = 0; i < board.size(); ++i) {
    const Eigen::Vector3d p = T * Eigen::Vector3d(board[i].x, board[i].y, board[i].z);
    if (p.z() <= 0.0) return INFINITY;
    sum += std::pow(p.x() / p.z() - seen[i].x, 2) + std::pow(p.y() / p.z() - seen[i].y, 2);
  }
  return std::sqrt(sum / static_cast<double>(board.size()));
}

}  // namespace

std::optional<BoardPose> board_pose(const Board& board, const std::vector<Corner>& corners,
                                    const MrcalModel& model, const std::vector<double>& intrinsics) {
  std::vector<cv::Point3d> on_board;
  std::vector<cv::Point2d> seen;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!corners[i].seen()) continue;
    Eigen::Vector3d v;
    if (!model.unproject(intrinsics, corners[i].q_px, &v) || v.z() <= 0.0) continue;
    if (v.head<2>().norm() > kLargestTan * v.z()) continue;
    const Eigen::Vector3d p = board.point_mm(i);
    on_board.emplace_back(p.x(), p.y(), p.z());
    seen.emplace_back(v.x() / v.z(), v.y() / v.z());
  }
  if (on_board.size() < 4) return std::nullopt;
  std::vector<cv::Mat> r, t;
  try {
    cv::solvePnPGeneric(on_board, seen, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), r, t, false,
                        cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception& fault) {  // corners on one line
    if (fault.code == cv::Error::StsNoMem) throw OutOfMemory("OpenCV");
    return std::nullopt;
  }
  std::optional<BoardPose> best;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const Pose T = to_pose(r[i], t[i]);
    const double rms = rms_of(T, on_board, seen);
    if (std::isfinite(rms) && (!best || rms < best->rms_normalized)) best = BoardPose{T, rms};
  }
  return best;
}

}  // namespace fringetwin::calib
