// SPDX-License-Identifier: Apache-2.0
// A shape that is built from a measurement: nothing nominal to fit or to measure a distance from.
#include "measure/fit/shape_fits.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::measure {

void fit_shape(const MeasuredShape&, const Gated& points, ObjectFit& row) {
  row.n = points.p_mm.size();
  row.warning = "the object is built from a measurement: it has no nominal surface to fit";
}

double distance_mm(const MeasuredShape&, const Eigen::Vector3d&) { return kNaN; }

bool name_numbers(const MeasuredShape&, ObjectFit&) { return false; }

std::vector<std::string> fit_keys(const MeasuredShape&) { return {}; }

std::string form_indicator(const MeasuredShape&) { return ""; }

std::optional<Shape> fitted_shape(const MeasuredShape&, const ObjectFit&) { return std::nullopt; }

Marks marks_mm(const MeasuredShape&, const Eigen::Vector3d&) { return Marks::Zero(); }

}  // namespace fringetwin::measure
