// SPDX-License-Identifier: Apache-2.0
#include "twin/shape/sphere.hpp"

namespace fringetwin {

std::vector<Motion<SphereShape>> motions(const SphereShape& sphere) {
  std::vector<Motion<SphereShape>> out;
  for (int i = 0; i < 3; ++i)
    out.push_back({std::string("center_mm.") + "xyz"[i], "mm", sphere.center_mm[i],
                   [i](SphereShape& s, double d) { s.center_mm[i] += d; }});
  return out;
}

std::vector<PlaceKey> place_keys(const SphereShape& sphere) {
  const Eigen::Vector3d& c = sphere.center_mm;
  return {{"center_mm", {c.begin(), c.end()}}};
}

}  // namespace fringetwin
