// SPDX-License-Identifier: Apache-2.0
#include "render/base/cosine_series.hpp"

#include <cmath>

namespace fringetwin::render {

double CosineSeries::operator()(double t_rad) const {
  const double c = std::cos(t_rad);
  double b1 = 0.0, b2 = 0.0;
  for (std::size_t k = a.size(); k-- > 1;) {
    const double b0 = a[k] + 2.0 * c * b1 - b2;
    b2 = b1;
    b1 = b0;
  }
  return a.empty() ? 0.0 : a[0] + c * b1 - b2;
}

}  // namespace fringetwin::render
