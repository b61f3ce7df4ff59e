// SPDX-License-Identifier: Apache-2.0
#include "measure/points/epipolar_table.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

constexpr int kGridPx = 16;           ///< spacing of the coarse ray grid: for starts only
constexpr int kMostBinsPerStep = 24;  ///< longer steps are depth jumps
constexpr double kSamePlacePx = 3.0;  ///< candidates closer than this start the same search
constexpr int kMostValueBins = 1 << 14;

}  // namespace

EpipolarTable::EpipolarTable(const Lens& lens, const Pose& T_cam1_cam0, const CoordinateMap& map)
    : map_(map.image()) {
  const Pose T_cam0_cam1 = T_cam1_cam0.inverse();
  rotation_cam0_cam1_ = T_cam0_cam1.rotation;
  center1_cam0_mm_ = T_cam0_cam1.translation_mm;
  const Eigen::Vector3d baseline = center1_cam0_mm_.normalized();
  // angles are counted from the plane that holds camera 1's optical axis
  const Eigen::Vector3d forward = rotation_cam0_cam1_.col(2);
  const Eigen::Vector3d across = forward - baseline * baseline.dot(forward);
  e1_ = across.norm() > 1e-6 ? Eigen::Vector3d(across.normalized()) : baseline.unitOrthogonal();
  e2_ = baseline.cross(e1_);
  // image motion of camera 1 when the depth along a ray of camera 0 grows: J(q) * baseline
  Eigen::Matrix<double, 2, 3> J = Eigen::Matrix<double, 2, 3>::Zero();
  lens.project(Eigen::Vector3d::UnitZ(), &J);
  const Eigen::Vector2d motion = J * T_cam1_cam0.translation_mm;
  if (std::abs(motion.y()) > std::abs(motion.x())) std::swap(step_x_, step_y_);
  set_coarse_rays(lens);
  set_bins();
}

double EpipolarTable::angle(const Eigen::Vector3d& d_cam0) const {
  return std::atan2(d_cam0.dot(e2_), d_cam0.dot(e1_));
}

void EpipolarTable::set_coarse_rays(const Lens& lens) {
  grid_width_ = (map_.width - 2) / kGridPx + 2;
  grid_height_ = (map_.height - 2) / kGridPx + 2;
  grid_rays_.assign(static_cast<std::size_t>(grid_width_) * grid_height_,
                    Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  for (int j = 0; j < grid_height_; ++j)
    for (int i = 0; i < grid_width_; ++i)
      if (const auto d = lens.unproject({static_cast<double>(i * kGridPx), static_cast<double>(j * kGridPx)}))
        grid_rays_[static_cast<std::size_t>(j) * grid_width_ + i] = rotation_cam0_cam1_ * *d;
  for (const Eigen::Vector3d& ray : grid_rays_) grid_angles_.push_back(angle(ray));
}

Eigen::Vector3d EpipolarTable::coarse_ray_cam0(double x, double y) const {
  const double u = x / kGridPx, v = y / kGridPx;
  const int i = std::clamp(static_cast<int>(u), 0, grid_width_ - 2);
  const int j = std::clamp(static_cast<int>(v), 0, grid_height_ - 2);
  const Eigen::Vector3d* row = &grid_rays_[static_cast<std::size_t>(j) * grid_width_ + i];
  const double a = u - i, b = v - j;
  return (1 - b) * ((1 - a) * row[0] + a * row[1]) +
         b * ((1 - a) * row[grid_width_] + a * row[grid_width_ + 1]);
}

double EpipolarTable::coarse_angle(int x, int y) const {
  const int i = std::min(x / kGridPx, grid_width_ - 2), j = std::min(y / kGridPx, grid_height_ - 2);
  const double* row = &grid_angles_[static_cast<std::size_t>(j) * grid_width_ + i];
  const double a = static_cast<double>(x) / kGridPx - i, b = static_cast<double>(y) / kGridPx - j;
  return (1 - b) * ((1 - a) * row[0] + a * row[1]) +
         b * ((1 - a) * row[grid_width_] + a * row[grid_width_ + 1]);
}

/// visit(pixel, angle bin, first value bin, last value bin)
template <class Visit>
void EpipolarTable::visit_steps(Visit visit) const {
  for (int y = 0; y + step_y_ < map_.height; ++y)
    for (int x = 0; x + step_x_ < map_.width; ++x) {
      const double a = map_(x, y), b = map_(x + step_x_, y + step_y_);
      if (!std::isfinite(a + b)) continue;
      const double position = (coarse_angle(x, y) - angle_low_) / angle_width_;
      if (!(position >= 0.0 && position < angle_bins_)) continue;
      const int low = static_cast<int>((std::min(a, b) - value_low_) / value_width_);
      const int high = static_cast<int>((std::max(a, b) - value_low_) / value_width_);
      if (high - low > kMostBinsPerStep) continue;
      visit(map_.index(x, y), static_cast<int>(position), low, high);
    }
}

void EpipolarTable::set_bins() {
  double angle_high = -std::numeric_limits<double>::infinity();
  angle_low_ = std::numeric_limits<double>::infinity();
  for (const double a : grid_angles_) {
    if (!std::isfinite(a)) continue;
    angle_low_ = std::min(angle_low_, a);
    angle_high = std::max(angle_high, a);
  }
  double value_high = -std::numeric_limits<double>::infinity();
  value_low_ = std::numeric_limits<double>::infinity();
  std::vector<double> steps;
  for (int y = 0; y + step_y_ < map_.height; ++y)
    for (int x = 0; x + step_x_ < map_.width; ++x) {
      const double a = map_(x, y), b = map_(x + step_x_, y + step_y_);
      for (const double value : {a, b}) {  // a step into the last column ends there
        if (!std::isfinite(value)) continue;
        value_low_ = std::min(value_low_, value);
        value_high = std::max(value_high, value);
      }
      if (!std::isfinite(a)) continue;
      const double d = std::abs(b - a);
      if ((x + 5 * y) % 16 == 0 && std::isfinite(d)) steps.push_back(d);
    }
  if (!(angle_high > angle_low_) || !(value_high >= value_low_) || steps.empty()) return;
  angle_bins_ = step_x_ ? map_.height : map_.width;
  angle_width_ = (angle_high - angle_low_) / angle_bins_ * (1.0 + 1e-12);
  value_width_ = std::max({upper_median(steps), (value_high - value_low_) / (kMostValueBins - 1), 1e-9});
  value_bins_ = static_cast<int>((value_high - value_low_) / value_width_) + 1;

  const auto bin = [&](int a, int v) { return static_cast<std::size_t>(a) * value_bins_ + v; };
  first_.assign(static_cast<std::size_t>(angle_bins_) * value_bins_ + 1, 0);
  visit_steps([&](std::size_t, int a, int low, int high) {
    for (int v = low; v <= high; ++v) ++first_[bin(a, v) + 1];
  });
  for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
  pixels_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  visit_steps([&](std::size_t pixel, int a, int low, int high) {
    for (int v = low; v <= high; ++v) pixels_[next[bin(a, v)]++] = static_cast<std::uint32_t>(pixel);
  });
}

int EpipolarTable::collect(int angle_bin, int value_bin, const Eigen::Vector3d& d_cam0, double coordinate_px,
                           Eigen::Vector2d* places, double* depth_mm, int count) const {
  const std::size_t bin = static_cast<std::size_t>(angle_bin) * value_bins_ + value_bin;
  for (std::uint32_t k = first_[bin]; k < first_[bin + 1] && count < kMostCandidates; ++k) {
    const std::size_t pixel = pixels_[k];
    const int x = static_cast<int>(pixel % map_.width), y = static_cast<int>(pixel / map_.width);
    const double a = map_.data[pixel], b = map_(x + step_x_, y + step_y_);
    const double t = a == b ? 0.5 : std::clamp((coordinate_px - a) / (b - a), 0.0, 1.0);
    const Eigen::Vector2d place(x + t * step_x_, y + t * step_y_);
    bool known = false;
    for (int i = 0; i < count; ++i) known |= (places[i] - place).squaredNorm() < kSamePlacePx * kSamePlacePx;
    if (known) continue;
    // depth on the ray of camera 0 nearest to the ray of camera 1
    const Eigen::Vector3d e = coarse_ray_cam0(place.x(), place.y()).normalized();
    const double cosine = d_cam0.dot(e), denominator = 1.0 - cosine * cosine;
    const double depth = (d_cam0.dot(center1_cam0_mm_) - cosine * e.dot(center1_cam0_mm_)) / denominator;
    if (!(depth > 0.0) || !std::isfinite(depth)) continue;
    places[count] = place;
    depth_mm[count++] = depth;
  }
  return count;
}

int EpipolarTable::candidates(const Eigen::Vector3d& d_cam0, double coordinate_px, double* depth_mm) const {
  if (pixels_.empty()) return 0;
  const double angle_position = (angle(d_cam0) - angle_low_) / angle_width_;
  const double value_position = (coordinate_px - value_low_) / value_width_;
  if (!(angle_position > -1.0 && angle_position < angle_bins_ + 1.0)) return 0;
  if (!(value_position > -1.0 && value_position < value_bins_ + 1.0)) return 0;
  const int a = static_cast<int>(std::floor(angle_position)),
            v = static_cast<int>(std::floor(value_position));
  Eigen::Vector2d places[kMostCandidates];
  int count = 0;
  static constexpr int kAround[5][2] = {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (const auto& [da, dv] : kAround) {
    if (a + da < 0 || a + da >= angle_bins_ || v + dv < 0 || v + dv >= value_bins_) continue;
    count = collect(a + da, v + dv, d_cam0, coordinate_px, places, depth_mm, count);
    if (count > 0) break;
  }
  return count;
}

}  // namespace fringetwin::measure
