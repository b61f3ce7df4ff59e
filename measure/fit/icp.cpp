// SPDX-License-Identifier: Apache-2.0
#include "measure/fit/icp.hpp"

#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/transformation_estimation_point_to_plane_lls.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "twin/lens/linear.hpp"

namespace fringetwin::measure {
namespace {

using Cloud = pcl::PointCloud<pcl::PointNormal>;
constexpr std::size_t kSamples = 100000;
constexpr float kLargestEntry = 1e5f;    ///< mm: no sane step moves farther
constexpr int kIterations[] = {12, 15};  ///< point to point, point to plane

/// Where the surface leaves a direction free (a plane slides in itself) the 6x6 system is singular and PCL's
/// next search would abort on NaN: then stay.
class PointToPlane
    : public pcl::registration::TransformationEstimationPointToPlaneLLS<pcl::PointNormal, pcl::PointNormal> {
 public:
  using Base = pcl::registration::TransformationEstimationPointToPlaneLLS<pcl::PointNormal, pcl::PointNormal>;
  using Base::estimateRigidTransformation;
  void estimateRigidTransformation(const Cloud& source, const Cloud& target,
                                   const pcl::Correspondences& correspondences,
                                   Matrix4& transform) const override {
    Base::estimateRigidTransformation(source, target, correspondences, transform);
    if (!transform.allFinite() || transform.cwiseAbs().maxCoeff() > kLargestEntry) transform.setIdentity();
  }
};

pcl::PointNormal make_point(const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
  pcl::PointNormal q;
  q.getVector3fMap() = p.cast<float>();
  q.getNormalVector3fMap() = n.cast<float>();
  return q;
}

}  // namespace

struct IcpTarget::Impl {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< keeps the float coordinates small
  Cloud::Ptr cloud{new Cloud};
  pcl::search::KdTree<pcl::PointNormal>::Ptr tree{new pcl::search::KdTree<pcl::PointNormal>};
};

IcpTarget::IcpTarget(const Mesh& mesh) : impl_(std::make_unique<Impl>()) {
  std::vector<double> area(mesh.triangles.size());
  double total = 0.0;
  const auto corner = [&](std::size_t i, int k) -> Eigen::Vector3d {
    return mesh.vertices_mm[mesh.triangles[i][k]].cast<double>();
  };
  for (std::size_t i = 0; i < area.size(); ++i) {
    area[i] = 0.5 * (corner(i, 1) - corner(i, 0)).cross(corner(i, 2) - corner(i, 0)).norm();
    total += area[i];
  }
  for (const auto& v : mesh.vertices_mm) impl_->origin += v.cast<double>();
  impl_->origin /= static_cast<double>(mesh.vertices_mm.size());
  std::mt19937_64 random(41);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  double carried = 0.0;
  for (std::size_t i = 0; i < area.size(); ++i) {
    carried += area[i] / total * static_cast<double>(kSamples);
    const Eigen::Vector3d a = corner(i, 0), b = corner(i, 1), c = corner(i, 2);
    const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
    for (; carried >= 1.0; carried -= 1.0) {
      const double root = std::sqrt(uniform(random)), v = uniform(random);
      const Eigen::Vector3d p = (1 - root) * a + root * (1 - v) * b + root * v * c;
      impl_->cloud->push_back(make_point(p - impl_->origin, normal));
    }
  }
  if (impl_->cloud->empty()) impl_->cloud->push_back(make_point(-impl_->origin, Eigen::Vector3d::UnitZ()));
  impl_->tree->setInputCloud(impl_->cloud);
}

IcpTarget::~IcpTarget() = default;

Pose run_icp(IcpKind kind, const std::vector<Eigen::Vector3d>& p_world_mm, const IcpTarget& target,
             const Pose& start, double max_distance_mm) {
  const IcpTarget::Impl& impl = target.impl();
  Cloud::Ptr source(new Cloud);
  for (const Eigen::Vector3d& p : p_world_mm)
    source->push_back(make_point(start * p - impl.origin, Eigen::Vector3d::UnitZ()));
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // failures are returned, not printed
  pcl::IterativeClosestPoint<pcl::PointNormal, pcl::PointNormal> icp;
  if (kind == IcpKind::point_to_plane) icp.setTransformationEstimation(pcl::make_shared<PointToPlane>());
  icp.setInputSource(source);
  icp.setInputTarget(impl.cloud);
  icp.setSearchMethodTarget(impl.tree, true);
  icp.setMaxCorrespondenceDistance(max_distance_mm);
  icp.setMaximumIterations(kIterations[kind == IcpKind::point_to_plane]);
  icp.setTransformationEpsilon(1e-10);
  icp.setEuclideanFitnessEpsilon(1e-10);
  Cloud aligned;
  icp.align(aligned);
  const Eigen::Matrix4d m = icp.getFinalTransformation().cast<double>();
  if (!icp.hasConverged() || !m.allFinite()) return start;
  // float rounding leaves the rotation slightly skew: take the nearest proper one
  const Eigen::Matrix3d R = nearest_rotation(m.topLeftCorner<3, 3>());
  if (R.determinant() < 0.0) return start;
  const Eigen::Vector3d t = m.topRightCorner<3, 1>();
  return Pose{R, impl.origin + t - R * impl.origin} * start;
}

}  // namespace fringetwin::measure
