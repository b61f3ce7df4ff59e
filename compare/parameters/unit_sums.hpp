// SPDX-License-Identifier: Apache-2.0
// Renders fringes of a full swing for samples, so that what any wave of their pitches brings is known without
// another rendering.
#pragma once
#include <memory>
#include <vector>

#include "compare/parameters/grid_view.hpp"
#include "render/renderer.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Of each fringe: the irradiance of its cosine and of its sine in each pixel of the samples, one after the
/// other, per unit of the pattern.
using UnitSums = std::vector<std::vector<float>>;

/// Returns those of the pitches of a twin of render::showing_fringes(), from one rendering of so many points
/// per pixel, at rest and without exposures.
std::shared_ptr<const UnitSums> render_unit_sums(render::Renderer& renderer, Twin view,
                                                 const GridSamples& samples, int points);

/// Adds cosine times the cosines and sine times the sines of one fringe to the k-th image of the samples.
void add_sums(const GridSamples& samples, const std::vector<float>& sums, std::size_t k, double cosine,
              double sine, std::vector<float>& irradiance);

}  // namespace fringetwin::compare
