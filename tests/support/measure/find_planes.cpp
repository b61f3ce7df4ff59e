// SPDX-License-Identifier: Apache-2.0
#include "tests/support/measure/find_planes.hpp"

#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace fringetwin::testing {
namespace {

constexpr std::size_t kRansacPoints = 20000;
constexpr int kRefinements = 5;

struct PlaneModel {
  Eigen::Vector3d point_mm, normal;
};

/// RANSAC on a random subset (fixed seed; PCL's own generator has a fixed seed, too).
bool ransac_plane(const std::vector<Eigen::Vector3d>& p_mm, const std::vector<std::size_t>& candidates,
                  double threshold_mm, std::mt19937_64& random, PlaneModel& plane) {
  std::vector<std::size_t> subset;
  std::sample(candidates.begin(), candidates.end(), std::back_inserter(subset), kRansacPoints, random);
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (const std::size_t i : subset) origin += p_mm[i];
  origin /= static_cast<double>(subset.size());
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (const std::size_t i : subset) {
    const Eigen::Vector3f q = (p_mm[i] - origin).cast<float>();
    cloud->push_back(pcl::PointXYZ(q.x(), q.y(), q.z()));
  }
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // failures are returned, not printed
  pcl::SACSegmentation<pcl::PointXYZ> segmentation;
  segmentation.setModelType(pcl::SACMODEL_PLANE);
  segmentation.setMethodType(pcl::SAC_RANSAC);
  segmentation.setDistanceThreshold(threshold_mm);
  segmentation.setMaxIterations(2000);
  segmentation.setProbability(0.9999);
  segmentation.setInputCloud(cloud);
  pcl::PointIndices inliers;
  pcl::ModelCoefficients coefficients;
  segmentation.segment(inliers, coefficients);
  if (inliers.indices.size() < 3 || coefficients.values.size() != 4) return false;
  const auto& c = coefficients.values;
  const Eigen::Vector3d normal(c[0], c[1], c[2]);
  const double length = normal.norm();
  if (!(length > 0.0)) return false;
  plane.normal = normal / length;
  plane.point_mm = origin - plane.normal * (static_cast<double>(c[3]) / length);
  return true;
}

std::vector<std::size_t> near_plane(const std::vector<Eigen::Vector3d>& p_mm,
                                    const std::vector<std::size_t>& candidates, const PlaneModel& plane,
                                    double threshold_mm) {
  std::vector<std::size_t> near;
  for (const std::size_t i : candidates)
    if (std::abs(plane.normal.dot(p_mm[i] - plane.point_mm)) <= threshold_mm) near.push_back(i);
  return near;
}

}  // namespace

std::vector<measure::PlaneFit> find_planes(const std::vector<Eigen::Vector3d>& p_mm, int count,
                                           double threshold_mm,
                                           std::vector<std::vector<std::size_t>>* inliers) {
  std::vector<measure::PlaneFit> planes;
  if (inliers) inliers->clear();
  std::vector<std::size_t> candidates(p_mm.size());
  std::iota(candidates.begin(), candidates.end(), std::size_t{0});
  std::mt19937_64 random(30);
  while (static_cast<int>(planes.size()) < count && candidates.size() >= 3) {
    PlaneModel model;
    if (!ransac_plane(p_mm, candidates, threshold_mm, random, model)) break;
    measure::PlaneFit fit;
    std::vector<std::size_t> near = near_plane(p_mm, candidates, model, threshold_mm);
    for (int k = 0; k < kRefinements; ++k) {
      std::vector<Eigen::Vector3d> points;
      points.reserve(near.size());
      for (const std::size_t i : near) points.push_back(p_mm[i]);
      fit = measure::fit_plane(points, {});
      if (!fit.usable) break;
      std::vector<std::size_t> again = near_plane(p_mm, candidates, {fit.point_mm, fit.normal}, threshold_mm);
      const bool stable = again == near;
      if (stable || k + 1 == kRefinements) break;  // fit and `near` stay a pair
      near = std::move(again);
    }
    if (!fit.usable) break;
    std::vector<std::size_t> rest;
    std::set_difference(candidates.begin(), candidates.end(), near.begin(), near.end(),
                        std::back_inserter(rest));
    candidates = std::move(rest);
    planes.push_back(fit);
    if (inliers) inliers->push_back(std::move(near));
  }
  return planes;
}

}  // namespace fringetwin::testing
