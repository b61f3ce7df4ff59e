// SPDX-License-Identifier: Apache-2.0
// Says where a fit speaks for too little of its object: the points that lie where the camera sees the object
// in the twin are mostly outside the gate, or the gate cuts through them (docs/metrics/measure.md, "Points
// within the gate").
#pragma once
#include <string>
#include <vector>

#include "measure/fit/fit_types.hpp"
#include "measure/points/points.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure {

/// Returns a sentence for each [[measure.fit]] of the twin whose gate leaves out more of its object than a
/// right twin does; none where an object is "measured", which has no nominal surface. `fits`: the rows that
/// fit_objects() made of the cloud.
std::vector<std::string> gate_warnings(const Twin& twin, const PointCloud& cloud,
                                       const std::vector<ObjectFit>& fits);

}  // namespace fringetwin::measure
