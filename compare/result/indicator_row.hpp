// SPDX-License-Identifier: Apache-2.0
// One geometry indicator (docs/METRICS.md, "Indicators").
#pragma once
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace fringetwin::compare {

struct Indicator {
  /// sphere_form, sphere_form_95, sphere_size, plane_flatness, plane_flatness_95, sphere_spacing
  std::string name;
  std::vector<std::string> objects;  ///< two for a spacing
  struct Value {
    double mm = std::numeric_limits<double>::quiet_NaN(), sigma_mm = mm;
  };
  Value simulated, real;

  double difference_mm() const { return simulated.mm - real.mm; }
  /// NaN where a sigma is unknown.
  double z() const {
    const double sigma = std::hypot(simulated.sigma_mm, real.sigma_mm);
    return sigma > 0.0 ? difference_mm() / sigma : std::numeric_limits<double>::quiet_NaN();
  }
};

}  // namespace fringetwin::compare
