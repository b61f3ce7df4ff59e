// SPDX-License-Identifier: Apache-2.0
// States by how much the method itself moves a fit (a pixel averages over its area, and a curved surface is
// not where its average is), and which part of a fit's standard errors is noise: a twin's noise-free points
// go in, found at the same pixels.
#pragma once
#include "measure/fit/fit_types.hpp"
#include "measure/points/points.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure {

/// Fills bias and bias_vectors of each usable fit of a sphere, plane or cylinder, and its standard errors for
/// noise and for form, and raises the fit's own to that for noise where blocks happen to scatter less
/// (docs/metrics/geometry.md, "Method bias"): one linear step -(J^T J)^-1 J^T d over the
/// points the fit used, d the distance of the noise-free point of the same pixel from the nominal surface.
/// `cloud`: the points that were fitted; `noise_free`: the twin's own. Nothing is stated where more than one
/// point in twenty has no noise-free one near the nominal surface. With twin.measure.correct_pixel_area the
/// bias is taken off.
void state_method_bias(const Twin& twin, const PointCloud& noise_free, const PointCloud& cloud,
                       std::vector<ObjectFit>& fits);

}  // namespace fringetwin::measure
