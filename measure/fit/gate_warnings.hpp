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

/// Returns whether the points of a fit lie about its object's nominal surface, in the middle of the gate, and
/// not all over it as those of a surface that passes through. Asks up to 300 of them for their distance,
/// which is all that a right twin costs. False without points.
bool points_gather_about(const Object& object, double gate_mm, const PointCloud& cloud, const ObjectFit& fit);

/// Returns a sentence for each [[measure.fit]] of the twin whose gate leaves out more of its object than a
/// right twin does; none where an object is "measured", which has no nominal surface. Things that the twin
/// lacks, and surfaces that it continues beyond their end, raise none. `fits`: the rows that fit_objects()
/// made of the cloud.
std::vector<std::string> gate_warnings(const Twin& twin, const PointCloud& cloud,
                                       const std::vector<ObjectFit>& fits);

}  // namespace fringetwin::measure
