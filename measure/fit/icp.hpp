// SPDX-License-Identifier: Apache-2.0
// Runs PCL's iterative closest point, whose heavy headers stay in icp.cpp.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "twin/lens/pose.hpp"
#include "twin/mesh/mesh.hpp"

namespace fringetwin::measure {

/// Samples of a mesh with normals, about 100,000 spread by area, and their search tree.
class IcpTarget {
 public:
  explicit IcpTarget(const Mesh& mesh);
  ~IcpTarget();
  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

enum class IcpKind { point_to_point, point_to_plane };

/// Returns T_object_world refined from `start`; pairs farther than max_distance_mm are ignored. Returns
/// `start` where ICP finds too few pairs or no finite solution.
Pose run_icp(IcpKind kind, const std::vector<Eigen::Vector3d>& p_world_mm, const IcpTarget& target,
             const Pose& start, double max_distance_mm);

}  // namespace fringetwin::measure
